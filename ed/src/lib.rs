//! Exact event-driven dynamics of inelastic hard disks.

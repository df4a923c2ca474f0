//! How the system's allocator is used: what the memory of a run is does not depend on what was freed before.
#![allow(
    unsafe_code,
    reason = "the allocator of the system has no safe interface"
)]

/// Gives large blocks back to the system as soon as they are freed.
///
/// The GNU allocator keeps blocks of up to 32 MiB once it has seen one freed, for each thread by itself. A checkpoint is made of such
/// blocks, so that with several threads the peak of the process was twice what is used at any time.
pub fn return_large_blocks() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        /// \[bytes\]
        const LARGE: libc::c_int = 1 << 20;
        // SAFETY: it is called before any thread is started, and changes only where blocks come from. Where it is refused, blocks
        // are kept.
        unsafe {
            libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE);
            libc::mallopt(libc::M_TRIM_THRESHOLD, LARGE);
        }
    }
}

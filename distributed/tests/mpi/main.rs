//! The program over several processes: against one process, and against kills, full disks and
//! processes that hang.

mod cases;
mod decomposed;
mod kills;
mod support;

//! The program over several processes: against one process, and against kills, full disks and
//! processes that hang.

mod cases;
mod ensembles;
mod frontier;
mod kills;
mod one_gas;
mod support;

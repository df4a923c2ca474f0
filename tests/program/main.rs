//! The program and its library as a whole. One program for all tests, so that it is linked once and
//! its tests run side by side.

mod book;
mod cases;
mod chambers;
mod command_line;
mod figures;
mod folders;
mod formats;
mod frontier;
mod fuzz;
mod init;
mod join;
mod literature;
mod memory;
mod plausibility;
mod release;
mod reproduce;
mod resume;
mod starts;
mod steady_states;
#[path = "../support/mod.rs"]
mod support;
mod units;
mod words;

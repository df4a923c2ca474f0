//! Pieces of a run that are done elsewhere: the same tables, whoever did them, and after processes were lost.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use stosszahl_case::CaseFile;
use stosszahl_model::Interrupt;
use stosszahl_results::Existing;
use stosszahl_study::crew::{Crew, Hand, Work, assist, run_among};
use stosszahl_study::{Options, format, run_case};

const CASE: &str = r#"
format = 2
title = "a sweep"
replicas = 3
[gas]
number = 100
restitution = 0.9
[box]
packing_fraction = 0.2
[start]
equilibration = 4
[run]
until = 2
samples = 4
[engine.ed]
[engine.dsmc-boltzmann]
[measure.impact_parameters]
[[sweep]]
"gas.restitution" = [0.8, 0.9]
"#;

fn case() -> CaseFile {
    let read = format().from_text(Path::new("crew.toml"), CASE, &[]);
    read.unwrap_or_else(|error| panic!("{error}"))
}

fn options<'a>(folder: &Path, stop: &'a Interrupt) -> Options<'a> {
    Options {
        out: Some(folder.to_owned()),
        existing: Existing::Refuse,
        threads: Some(1),
        force_memory: false,
        stop,
        progress: &(),
        commit: "",
    }
}

/// All tables, and whether checkpoints are left.
fn tables(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(one) = folders.pop() {
        for entry in fs::read_dir(one).expect("a folder").flatten() {
            let path = entry.path();
            let name = path.strip_prefix(folder).expect("inside");
            let name = name.to_string_lossy().into_owned();
            assert!(
                path.extension().is_none_or(|end| end != "snapshot"),
                "{name} is left"
            );
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "csv") {
                all.insert(name, fs::read(&path).expect("a table"));
            }
        }
    }
    all
}

/// Other "processes" are threads that plan the case for themselves and send bytes.
struct Others<'a> {
    count: usize,
    folder: &'a Path,
    /// Every so many orders are lost after half of them was done.
    lose: usize,
    taken: AtomicUsize,
    done: AtomicUsize,
}

impl Others<'_> {
    fn help(&self, work: &dyn Work, hand: &dyn Hand) {
        while let Some(order) = work.next() {
            let number = 1 + self.taken.fetch_add(1, Ordering::Relaxed);
            let record = hand.work(&order);
            if self.lose > 0 && number.is_multiple_of(self.lose) {
                work.put_back(&order);
                continue;
            }
            self.done.fetch_add(1, Ordering::Relaxed);
            work.take(&order, &record);
            // A second record of the same piece changes nothing.
            work.take(&order, &record);
        }
    }
}

impl Crew for Others<'_> {
    fn work(&self, work: &dyn Work, _slots: usize, here: &(dyn Fn(&[u8]) + Sync)) {
        thread::scope(|scope| {
            for _ in 0..self.count {
                scope.spawn(|| {
                    let (file, stop) = (case(), Interrupt::default());
                    assist(&file, &options(self.folder, &stop), |hand| {
                        self.help(work, hand);
                    })
                });
            }
            if self.count == 0 {
                while let Some(order) = work.next() {
                    here(&order);
                }
            }
        });
    }
}

#[test]
fn tables_are_the_same_bytes_whoever_does_the_pieces() {
    let scratch = tempfile::tempdir().expect("a folder");
    let stop = Interrupt::default();
    let alone = scratch.path().join("alone");
    run_case(&case(), &options(&alone, &stop)).expect("a run");
    let wanted = tables(&alone);
    assert!(wanted.len() > 6, "{:?}", wanted.keys());
    for (count, lose) in [(0, 0), (1, 0), (3, 0), (2, 2)] {
        let folder = scratch.path().join(format!("{count}-{lose}"));
        let others = Others {
            count,
            folder: &folder,
            lose,
            taken: AtomicUsize::new(0),
            done: AtomicUsize::new(0),
        };
        let file = case();
        run_among(&file, &options(&folder, &stop), &others).expect("a run");
        let done = others.done.into_inner();
        assert_eq!(done, if count > 0 { 6 } else { 0 });
        let lost = others.taken.into_inner() - done;
        // Every second of the orders, until six are done.
        assert_eq!(lost, if lose > 0 { 5 } else { 0 });
        assert!(tables(&folder) == wanted, "{count} others, {lose}");
    }
}

/// A process that does not see the results folder says so, and the run ends.
#[test]
fn a_folder_that_another_process_does_not_see_ends_the_run() {
    struct Blind<'a>(&'a Path);
    impl Crew for Blind<'_> {
        fn work(&self, work: &dyn Work, _slots: usize, _here: &(dyn Fn(&[u8]) + Sync)) {
            let order = work.next().expect("an order");
            let place = order.windows(12).position(|word| word == b"results-here");
            let mut sent = order.clone();
            let place = place.expect("the folder");
            sent[place..place + 12].copy_from_slice(b"results-gone");
            let (file, stop) = (case(), Interrupt::default());
            let record = assist(&file, &options(self.0, &stop), |hand| hand.work(&sent));
            work.take(&order, &record.expect("a record"));
            assert!(work.is_finished() && work.next().is_none());
        }
    }
    let scratch = tempfile::tempdir().expect("a folder");
    let stop = Interrupt::default();
    let folder = scratch.path().join("results-here");
    let error = run_among(&case(), &options(&folder, &stop), &Blind(&folder));
    let text = error.expect_err("an error").to_string();
    assert!(
        text.contains("all processes of a run need its results folder"),
        "{text}"
    );
}

//! A whole frontier and a whole pilot of a small gas.

use std::fs;
use std::path::{Path, PathBuf};

use stosszahl_case::CaseFile;
use stosszahl_model::Interrupt;
use stosszahl_results::{Existing, Manifest};

use super::{Frontier, FrontierError, Kind, Options, frontier};

const CASE: &str = "format = 2\ntitle = \"A small gas\"\nseed = 3\nreplicas = 1\n[gas]\nnumber = 100\nrestitution = 0.8\n\
                    [box]\npacking_fraction = 0.25\n[run]\nuntil = 1\n[engine.ed]\n[engine.dsmc-contact-point]\n";

fn case(more: &str) -> CaseFile {
    let text = CASE.to_owned() + more;
    crate::format()
        .from_text(Path::new("small.toml"), &text, &[])
        .expect("a case")
}

fn measured(folder: PathBuf, cache: PathBuf, threads: usize) -> Result<Frontier, FrontierError> {
    let options = Options {
        kinds: vec![Kind::Energy],
        target: 0.2,
        budget: 0.3,
        folder,
        cache,
        threads,
        tests: 1,
        force: true,
        tell: &|_| {},
        interrupt: &Interrupt::default(),
        crew: None,
    };
    frontier(&case(""), &options)
}

/// A table without the columns that timings decide.
fn untimed(path: &Path) -> Vec<String> {
    let text = fs::read_to_string(path).expect("a table");
    // The last three columns are the two times and whether a row is on the front.
    let cut = |line: &str| line.rsplitn(4, ',').last().map(str::to_owned);
    text.lines().filter_map(cut).collect()
}

/// Two sweeps of a case give the same tables but for timings, whatever the threads, and whether the reference is made or
/// found; a reference that was changed is refused.
#[test]
fn sweeps_repeat_and_changed_references_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
    let one = measured(first.clone(), first.clone(), 1).expect("a frontier");
    assert!(
        one.conclusions
            .iter()
            .any(|one| one.starts_with("Exact dynamics: ")),
        "{one:?}"
    );
    let two = measured(second.clone(), first.clone(), 2).expect("a frontier");
    let table = untimed(&first.join("frontier.csv"));
    assert!(table.len() > 50, "{}", table.len());
    assert_eq!(table, untimed(&second.join("frontier.csv")));
    let [a, b] = [&first, &second].map(|out| fs::read(out.join("orders.csv")).expect("orders"));
    assert_eq!(a, b);
    assert!(!two.figure.rows.is_empty() && first.join("recommendation.md").exists());
    // The gas is smaller than growing waves of shear: theory knows its energy, the ensemble the rest.
    assert!(
        two.provenance.contains("(0 made now)"),
        "{}",
        two.provenance
    );
    let files = fs::read_dir(&first).expect("files");
    let mut paths = files.map(|entry| entry.expect("a file").path());
    let kept = paths.find(|path| path.extension().is_some_and(|end| end == "snapshot"));
    let kept = kept.expect("a kept reference");
    let mut bytes = fs::read(&kept).expect("bytes");
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    fs::write(&kept, bytes).expect("written");
    let error = measured(second, first, 2).expect_err("a changed reference");
    assert!(
        error.is_refusal() && error.to_string().contains("remove the file"),
        "{error}"
    );
}

/// A pilot chooses simulators and steps, the same for any number of threads, and says why; a gas without theory is refused.
#[test]
fn accuracy_is_chosen_by_a_pilot() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = case("[accuracy]\ntarget = \"20%\"\n");
    let runs = [1, 2].map(|threads| {
        let out = folder.path().join(threads.to_string());
        let options = crate::Options {
            out: Some(out.clone()),
            existing: Existing::Refuse,
            threads: Some(threads),
            force_memory: true,
            stop: &Interrupt::default(),
            progress: &(),
            commit: "",
        };
        crate::run_case(&file, &options).expect("a run");
        let manifest = Manifest::read(&out).expect("read").expect("a manifest");
        (
            manifest.choices,
            fs::read(out.join("energy.csv")).expect("a table"),
        )
    });
    assert_eq!(runs[0], runs[1]);
    let words = runs[0].0.concat();
    assert!(words.starts_with("dsmc-contact-point: "), "{words}");
    assert!(words.contains("sure to be within 20 %"), "{words}");
    let driven = case("[accuracy]\ntarget = \"20%\"\n[drive]\nheating = 1\ninterval = 0.1\n");
    let refused = crate::check(&driven)
        .err()
        .expect("a driven gas has no such theory");
    assert!(refused.to_string().contains("a driven gas"), "{refused}");
}

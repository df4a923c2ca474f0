//! The program as a user runs it: results, refusals, threads, folders.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::process::{Child, Command, Stdio};

use crate::support::program::{
    COOLING, Columns, INFLOW, MIXTURE, SMALL, TestFolder, WALLS, assert_same, bundled_names, files,
    manifest,
};

/// Disks from `start.csv`.
const FROM_FILE: &str = "format = 2
title = \"disks from a file\"
seed = 5
replicas = 3
[gas]
restitution = 0.8
[box]
[start]
placement = \"file\"
file = \"start.csv\"
[run]
until = 2
[engine.ed]
[engine.dsmc-enskog]
[measure.snapshots]
times = [2]
";

/// Returns a start of 225 disks of two sizes on a grid.
fn start_file() -> String {
    let mut start = "# box: 30 30\nx,y,radius,mass\n".to_owned();
    for i in 0..225 {
        let (radius, mass) = if i % 2 == 0 {
            (0.5, 1.0)
        } else {
            (0.25, 0.125)
        };
        let (x, y) = (2 * (i % 15) + 1, 2 * (i / 15) + 1);
        writeln!(start, "{x},{y},{radius},{mass}").expect("a string");
    }
    start
}

#[test]
fn a_comparison_gives_tables_and_a_report() {
    let work = TestFolder::new(COOLING);
    let said = work.done("run case.toml");
    assert!(
        said.out.contains("ED (exact)") && said.out.contains("DSMC free volume"),
        "{}",
        said.out
    );
    let results = work.path("results/case");
    let header = |name: &str| {
        let text = work.text(&format!("results/case/{name}.csv"));
        text.lines().next().unwrap_or_default().to_owned()
    };
    for line in "\
        energy engine,time,collisions_per_particle,collisions_per_particle_se,energy_ratio,energy_ratio_se,energy_ratio_theory,\
        temperature,temperature_se,temperature_theory,fourth_cumulant,fourth_cumulant_se,replicas\n\
        comparison engine_a,engine_b,time,energy_ratio_a,energy_ratio_b,energy_ratio_a_over_b,\
        energy_ratio_a_over_b_se,energy_ratio_a_over_b_low,energy_ratio_a_over_b_high,z,verdict,replicas\n\
        structure_factor engine,time,mode_number,structure_factor,structure_factor_se,modes\n\
        pair_correlation engine,time,r_over_d,g,g_se\n\
        impact_parameter engine,window_start,window_end,bin_low,bin_high,count,density,density_se,density_theory\n\
        impact_parameter_summary engine,window_start,window_end,collisions,slope,slope_se,mean_b_over_d,\
        trend_p_value,shape_p_value,over_dispersion,chi_squared,degrees_of_freedom,verdict,replicas"
        .lines()
    {
        let (table, columns) = line.split_once(' ').expect("a table and its columns");
        assert_eq!(header(table), columns, "{table}");
    }
    // All engines begin with the same energy and the same disks.
    let energy = Columns::read(&results, "energy");
    let starts = energy
        .numbers("time")
        .into_iter()
        .zip(energy.numbers("energy_ratio"));
    assert_eq!(starts.filter(|&start| start == (0.0, 1.0)).count(), 3);
    let manifest = manifest(&results);
    assert_eq!((manifest.seed, manifest.replicas), (5, 3));
    assert_eq!(manifest.engines.len(), 3);
    assert_eq!(manifest.case_text, COOLING);
}

#[test]
fn results_are_neither_overwritten_nor_mistaken() {
    let work = TestFolder::new(COOLING);
    work.done("run case.toml --until 1");
    // A finished run is not resumed as another run.
    let said = work.done("run case.toml --until 1 --resume");
    assert!(
        said.err.contains("complete") || said.out.contains("complete"),
        "{}",
        said.err
    );
    work.refused(
        "run case.toml --resume --seed 6 --until 1",
        &["another run", "seed"],
    );
    for (set, key) in [
        ("title=other", "title"),
        ("verdict.tolerance=0.2", "verdict.tolerance"),
    ] {
        let line = format!("run case.toml --until 1 --resume --set {set}");
        work.refused(&line, &["results/case", key]);
    }
    // Existing results are not overwritten, and other files are not replaced.
    work.refused("run case.toml", &["--force"]);
    fs::create_dir(work.path("diary")).expect("a folder");
    work.write("diary/today", "dear");
    work.refused("run case.toml --force --out diary", &["diary"]);
    assert_eq!(work.text("diary/today"), "dear");
    work.refused(
        "run case.toml --resume --out nowhere",
        &["nothing to resume"],
    );
    // Files that a user put next to the results are not lost either, of any name, nor is the case
    // itself.
    let own = [
        "notes.txt",
        "species.csv",
        "checks.csv",
        "snapshots/mine.xyz",
    ];
    for name in own {
        work.write(&format!("results/case/{name}"), "dear");
    }
    work.write("results/case/case.toml", COOLING);
    work.refused(
        "run results/case/case.toml --force --until 1 --out results/case",
        &["would be replaced"],
    );
    work.done("run case.toml --force --until 1 --seed 6");
    for name in own {
        assert_eq!(work.text(&format!("results/case/{name}")), "dear", "{name}");
    }
    assert_eq!(manifest(&work.path("results/case")).seed, 6);
}

/// A finished run is not changed unnoticed by other windows, which show the same fields
/// differently.
#[test]
fn windows_of_a_finished_run_are_not_changed_unnoticed() {
    let work = TestFolder::new(WALLS);
    let line = "run case.toml --replicas 1";
    work.done(line);
    let before = files(&work.path("results/case"));
    work.refused(
        &format!("{line} --resume --set measure.fields.windows=[[0,2]]"),
        &["results/case", "measure.fields.windows"],
    );
    assert_eq!(before, files(&work.path("results/case")));
    let said = work.done(&format!("{line} --resume --set run.checkpoint_seconds=5"));
    assert!(said.out.contains("complete"), "{}", said.out);
}

#[test]
fn threads_do_not_change_a_byte() {
    for (name, case) in SMALL {
        let work = TestFolder::new(case);
        for threads in ["1", "2", "3"] {
            work.done(&format!(
                "run case.toml --threads {threads} --out {threads}"
            ));
        }
        assert_same(&work.path("1"), &work.path("2"));
        assert_same(&work.path("1"), &work.path("3"));
        if name == "mixture" {
            work.done("run case.toml --seed 99 --out other");
            assert_ne!(files(&work.path("1")), files(&work.path("other")));
        }
    }
}

/// Cases that are wrong in one way each: the text that is replaced, its replacement, and the words
/// of the message.
#[rustfmt::skip]
const BAD: &[(&str, &str, &str, &[&str])] = &[
    (COOLING, "format = 2", "format = 3", &["format = 3", "format 2"]),
    (COOLING, "seed = 5", "seed = -5", &["seed = -5", "from 0 to"]),
    (COOLING, "number = 400", "nmber = 400", &["gas.nmber", "number"]),
    (COOLING, "number = 400", "number = [", &["case.toml:"]),
    (COOLING, "packing_fraction = 0.25", "packing_fraction = 0.95", &["box.packing_fraction", "0.9069"]),
    (COOLING, "until = 10", "until = 0", &["run.until", "above 0"]),
    (COOLING, "times = [10]", "times = [11]", &["measure.snapshots.times", "11"]),
    (COOLING, "times = [10]", "times = [10]\n[measure.contacts]\nwindows = [0, 1]", &["measure.contacts.windows", "[[start, end], ...]"]),
    (COOLING, "[measure.snapshots]", "[measure.snapshot]", &["measure.snapshot", "snapshots"]),
    (COOLING, "[measure.snapshots]", "[measure.fields]", &["measure.fields"]),
    (MIXTURE, "restitution = 0.8", "restitution = 1.8", &["gas.restitution = 1.8", "from 0 to 1"]),
    (MIXTURE, "volume = 2e4", "volume = 1e300", &["case.toml:"]),
    (MIXTURE, "volume = 2e4", "volume = 100\npair_correlation = \"enskog\"", &["gas.volume = 100", "less than all"]),
    (MIXTURE, "particles = 20", "particles = 0", &["measure.time_averaged_displacement.particles"]),
    (WALLS, "number = 60", "number = 600", &["case.toml"]),
    (WALLS, "right = \"specular\"", "right = \"open\"", &["walls.right", "ed"]),
    (WALLS, "amplitude = 0.2", "amplitude = 15", &["walls.bottom.vibration.amplitude"]),
    (WALLS, "radius = 2 }", "radius = 12 }", &["obstacle.1"]),
    (WALLS, "samples = 40", "samples = 41", &["run.samples", "10"]),
    (WALLS, "[[0, 4]]", "[[0, 40]]", &["measure.fields.windows"]),
    (INFLOW, "size = [24, 12]", "size = [6, 4]", &["box.size", "at most 0.9069", "1.963"]),
    (INFLOW, "[0.4]", "[2.5]", &["inflow.1.number_density", "1.963", "at most 0.9069"]),
    (WALLS, "sliding = [0.5, 0]", "sliding = [0.5, 1]", &["walls.top.sliding"]),
];

#[test]
fn bad_cases_leave_nothing_behind() {
    for (good, from, to, says) in BAD {
        assert!(good.contains(from), "{from}");
        let work = TestFolder::new(&good.replacen(from, to, 1));
        work.refused("run case.toml", says);
        assert!(!work.path("results").exists(), "{to}");
        work.refused("check case.toml", says);
    }
    let work = TestFolder::new(COOLING);
    for (line, says) in [
        ("run absent.toml", "absent.toml"),
        ("run .", "folder"),
        ("run case.toml --set gas.packing=0.2", "gas.packing"),
        ("run case.toml --set run.until", "key=value"),
        ("run case.toml --set species.7.number=3", "species"),
        (
            "run case.toml --set measure.energy.bins=3",
            "measure.energy has no keys",
        ),
        ("run case.toml --threads 0", "threads"),
        ("run case.toml --replicas 1.5", "1e3"),
        ("run case.toml --seed 1e30", "1e3"),
        ("run case.toml --threads 100000", "100000"),
        ("run case.toml --threads 1025", "1024"),
        ("report nowhere", "nowhere"),
        ("report .", "."),
    ] {
        work.refused(line, &[says]);
        assert!(!work.path("results").exists(), "{line}");
    }
}

/// A report without tables is refused: the lost tables are named.
#[test]
fn a_report_without_tables_is_refused() {
    let work = TestFolder::new(COOLING);
    work.done("run case.toml --out out --replicas 1 --until 1");
    let tables = fs::read_dir(work.path("out")).expect("results").flatten();
    let tables = tables.map(|entry| entry.path());
    let tables: Vec<_> = tables
        .filter(|path| path.extension().is_some_and(|end| end == "csv"))
        .collect();
    assert!(tables.len() > 2);
    for table in tables {
        fs::remove_file(table).expect("removed");
    }
    let said = work.say("report out");
    assert_eq!(said.code, Some(1), "{}", said.err);
    assert!(said.err.contains("energy.csv"), "{}", said.err);
    assert!(said.err.contains("missing"), "{}", said.err);
}

/// A pipe in the place of a file of results is refused at once.
#[cfg(unix)]
#[test]
fn a_pipe_is_no_file_of_results() {
    let work = TestFolder::new(COOLING);
    work.done("run case.toml --out out --replicas 1 --until 1");
    for name in ["energy.csv", "manifest.json"] {
        let path = work.path("out").join(name);
        fs::remove_file(&path).expect("removed");
        let made = Command::new("mkfifo").arg(&path).status();
        assert!(made.expect("mkfifo").success());
        let said = work.say("report out");
        assert_eq!(said.code, Some(1), "{}", said.err);
        assert!(said.err.contains(name), "{}", said.err);
        assert!(said.err.contains("expected a file"), "{}", said.err);
    }
}

/// Whole numbers are written as in cases.
#[test]
fn options_take_whole_numbers_with_exponents() {
    let work = TestFolder::new(COOLING);
    work.done("run case.toml --out plain --replicas 2 --seed 1000 --until 1 --threads 1");
    work.done("run case.toml --out short --replicas 2e0 --seed 1e3 --until 1 --threads 1e0");
    let energy = |out: &str| fs::read(work.path(out).join("energy.csv")).expect("a table");
    assert_eq!(energy("plain"), energy("short"));
}

/// Start files that are damaged, or do not fit the case, are named.
#[test]
fn bad_start_files_are_named() {
    for (start, fragments) in [
        (
            "# box: 10 10\nx,y\n1,1\n1.5,1\n",
            &["start.csv", "0 and 1", "overlap"][..],
        ),
        (
            "# box: 10 10\nx,y\n1,1\nNaN,1\n",
            &["start.csv:4", "NaN", "finite"],
        ),
        (
            "# box: 10 10\nx,y\n1,1\nwest,1\n",
            &["start.csv:4", "west", "finite"],
        ),
        ("# box: 10\nx,y\n1,1\n", &["start.csv:1", "# box: Lx Ly"]),
        (
            "# box: 0.5 10\nx,y\n0.2,1\n0.2,5\n",
            &["0 and 0", "overlap"],
        ),
        ("# box: 10 10\nx,y\n0.2,1\n", &["at least two"]),
        ("# box: 10 10\nx,y\n1,1\n31.2,1\n", &["0 and 1", "overlap"]),
        (
            "# box: 10 10\nx,y,radius\n1,1,-1\n",
            &["start.csv:3", "radius", "above zero"],
        ),
        ("# box: 10 10\nx,y\n", &["start.csv", "at least one"]),
        ("", &["start.csv:1", "# box: Lx Ly"]),
    ] {
        let work = TestFolder::new(FROM_FILE);
        work.write("start.csv", start);
        work.refused("run case.toml", fragments);
        assert!(!work.path("results").exists(), "{start}");
    }
    // A gas cannot be given a lattice that does not fit, nor a box narrower than a disk.
    let work = TestFolder::new(COOLING);
    for set in ["box.packing_fraction=0.9", "box.aspect_ratio=1e-9"] {
        let line = format!("run case.toml --set {set} --set start.placement=hexagonal");
        work.refused(&line, &["is refused", "the rule"]);
        assert!(!work.path("results").exists());
    }
}

/// A mixture from a file, also with a mark of byte order and as other systems end lines; the end of
/// one run is a start for another.
#[test]
fn a_start_from_a_file_runs_in_both_engines() {
    let work = TestFolder::new(FROM_FILE);
    work.write("start.csv", start_file());
    work.done("run case.toml --out first");
    work.write(
        "start.csv",
        format!("\u{feff}{}", start_file().replace('\n', "\r\n")),
    );
    work.done("run case.toml --out second");
    assert_same(&work.path("first"), &work.path("second"));
    let again = FROM_FILE
        .replace("start.csv", "first/snapshots/ed-0.xyz")
        .replace("[run]", "velocities = \"file\"\nequilibration = 0\n[run]");
    work.write("again.toml", again);
    let said = work.done("run again.toml --replicas 1");
    assert!(!said.out.contains("equilibr"), "{}", said.out);
    // A start file of equal velocities has no temperature, and rounding gives it none: of ten times
    // 0.1, the mean is another.
    let mean: f64 = [0.1 * 0.1; 10].iter().sum();
    assert!(mean != 0.1);
    let mut still = "# box: 30 30\nx,y,vx,vy\n".to_owned();
    for i in 0..10 {
        writeln!(still, "{},5,0.1,0.3", 2 * i + 1).expect("a string");
    }
    work.write("start.csv", still);
    work.write(
        "still.toml",
        FROM_FILE.replace("[run]", "velocities = \"file\"\n[run]"),
    );
    work.refused(
        "run still.toml --replicas 1",
        &["start.csv", "temperature", "rounding"],
    );
}

/// A gas in which nothing ever collides ends like any other.
#[test]
fn parallel_flight_is_no_endless_preparation() {
    let own = "velocities = \"file\"\nequilibration = 10\n[run]";
    let work = TestFolder::new(&FROM_FILE.replace("[run]", own));
    work.write(
        "start.csv",
        "# box: 10 10\nx,y,vx,vy\n1,1,1,0\n4,5,-1,0\n7,9,0,0\n",
    );
    let said = work.done("run case.toml --replicas 1");
    assert!(said.out.contains("equilibr"), "{}", said.out);
}

/// A changed start file makes another run, which a stopped run does not resume.
#[test]
fn a_changed_start_file_is_another_run() {
    let work = TestFolder::new(FROM_FILE);
    work.write("start.csv", start_file());
    work.done("run case.toml --out out");
    fs::remove_file(work.path("out/manifest.json")).expect("removed");
    work.write(
        "start.csv",
        start_file().replace("# box: 30 30", "# box: 31 30"),
    );
    work.refused(
        "run case.toml --out out --resume",
        &["another run", "files"],
    );
    work.write("start.csv", start_file());
    work.done("run case.toml --out out --resume");
}

/// A collapse ends the run with an error that names the cluster; the state stays, readable by
/// others, and tables are made of what other replicas have.
#[test]
fn a_collapse_keeps_the_state() {
    let work = TestFolder::new(
        "format = 2\ntitle = \"Collapse\"\nseed = 1\nreplicas = 1\n[gas]\nnumber = 1000\nrestitution = 0.1\n\
         [box]\npacking_fraction = 0.5\n[run]\nuntil = 100\n[engine.ed]\n",
    );
    let said = work.say("run case.toml --out out");
    assert_eq!(said.code, Some(1), "{}", said.err);
    assert!(
        said.err.contains("inelastic collapse at time"),
        "{}",
        said.err
    );
    assert!(said.err.contains("stopped.xyz"), "{}", said.err);
    let state = work.text("out/snapshots/replica-0-ed.stopped.xyz");
    assert_eq!(state.lines().count(), 1002);
    // Results of the failed run are replaced as a whole.
    work.done("run case.toml --out out --force --until 0.01");
    assert!(!work.path("out/snapshots/replica-0-ed.stopped.xyz").exists());
}

#[test]
fn any_key_can_be_set_and_what_is_said_is_what_was_run() {
    let work = TestFolder::new(MIXTURE);
    work.done(
        "run case.toml --out out --set species.2.number=40 --set title=shorter --until 1e1 \
         --set measure.time_averaged_displacement.particles=5",
    );
    let manifest = manifest(&work.path("out"));
    assert_eq!(manifest.title, "shorter");
    assert_eq!(manifest.case["species"][1]["number"], 40);
    assert_eq!(manifest.case["run"]["until"], 10.0);
    let species = Columns::read(&work.path("out"), "species");
    assert!(species.numbers("time").iter().all(|&time| time <= 10.0));
    assert_eq!(species.numbers("particles")[1], 40.0);
    assert!(work.text("out/report.html").contains("shorter"));
}

#[test]
fn check_schema_and_help_teach() {
    let work = TestFolder::new(COOLING);
    let said = work.done("check case.toml").out;
    for word in [
        "mean free path",
        "Haff time",
        "cell",
        "memory",
        "collisions",
    ] {
        assert!(said.contains(word), "{word} in {said}");
    }
    assert!(!work.path("results").exists());
    let schema: serde_json::Value = serde_json::from_str(&work.done("schema").out).expect("JSON");
    for key in ["gas", "box", "measure"] {
        assert!(schema["properties"][key].is_object(), "{key}");
    }
    assert!(schema["properties"]["measure"]["properties"]["impact_parameters"].is_object());
    assert!(work.done("--help").out.contains("cases/quick.toml"));
    assert!(work.done("run --help").out.contains("--resume"));
}

/// A case may come through a pipe.
#[cfg(unix)]
#[test]
fn a_case_is_read_from_a_pipe() {
    let work = TestFolder::new("");
    let mut child = work.command("check /dev/stdin");
    let child = child.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
    let mut child = child.expect("the program starts");
    let mut pipe = child.stdin.take().expect("a pipe");
    pipe.write_all(COOLING.as_bytes()).expect("written");
    drop(pipe);
    let output = child.wait_with_output().expect("an end");
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stdout).contains("Haff time"));
}

#[cfg(unix)]
#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let work = TestFolder::new(COOLING);
    // A file in place of the folder fails for any user.
    work.write("file", "");
    work.refused("run case.toml --out file/results", &["file/results"]);
    work.refused("run case.toml --out file", &["file"]);
    #[cfg(target_os = "linux")]
    work.refused("run case.toml --out /proc/stosszahl", &["/proc/stosszahl"]);
    // A schema cannot be written to a full device.
    if let Ok(full) = fs::OpenOptions::new().write(true).open("/dev/full") {
        let code = work
            .command("schema")
            .stdout(full)
            .stderr(Stdio::null())
            .status();
        assert_ne!(code.expect("the program starts").code(), Some(0));
    }
}

/// Bundled cases are listed with their questions, printed, and run by name; each has a question,
/// and a file of the same name takes precedence.
#[test]
fn bundled_cases_are_known_by_name() {
    let work = TestFolder::new(COOLING);
    let list = work.done("cases").out;
    assert_eq!(list.lines().count(), bundled_names().len());
    assert!(
        list.lines().all(|line| line.trim_end().ends_with('?')),
        "{list}"
    );
    let text = work.done("cases quick").out;
    assert!(text.contains("format = 2"));
    let said = work.done("check quick --until 1").out;
    assert!(said.contains("Free cooling of 2500 disks"), "{said}");
    work.refused("cases quik", &["quik", "stosszahl cases"]);
    work.write("quick", "format = 2\nno_key = 1\n");
    work.refused("check quick", &["no_key"]);
}

/// At the end of a run the first conclusions are printed; on request all conclusions, the place of
/// the report alone, or JSON.
#[test]
fn a_run_says_as_much_as_is_asked_for() {
    let work = TestFolder::new(COOLING);
    let first = work.done("run case.toml").out;
    let verdicts = manifest(&work.path("results/case")).verdicts;
    let all = work.done("run case.toml --force --verbose").out;
    let quiet = work.done("run case.toml --force --quiet").out;
    let json = work.done("run case.toml --force --json").out;
    assert_eq!(quiet.lines().count(), 1);
    assert!(quiet.contains("report.html"));
    // At most four conclusions, how many more there are, and where the report is.
    assert!((2..=6).contains(&first.lines().count()), "{first}");
    assert!(first.contains(" with --verbose"), "{first}");
    assert!(all.lines().count() > verdicts.len(), "{all}");
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let told = &json["points"][0]["verdicts"];
    assert_eq!(told, &serde_json::to_value(&verdicts).expect("JSON"));
    work.refused("run case.toml --quiet --verbose", &["--quiet", "--verbose"]);
    // A path with bytes that are not text.
    #[cfg(target_os = "linux")]
    {
        use std::os::unix::ffi::OsStrExt as _;
        let odd = std::ffi::OsStr::from_bytes(b"out\xff");
        let mut command = work.command("run case.toml --until 1 --json --out");
        let output = command.arg(odd).output().expect("the program starts");
        assert!(output.status.success(), "{output:?}");
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(json["points"][0]["folder"], "out\u{fffd}");
    }
}

/// Starts the program and waits until it has its folder, which it locks before it marks it.
fn begun(work: &TestFolder, line: &str, out: &str) -> Child {
    let mut child = work.command(line);
    let child = child.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let mut child = child.expect("the program starts");
    while !work.path(out).join("run.json").exists() {
        let ended = child.try_wait().expect("a state").is_some();
        assert!(!ended, "the run ended before it began");
        std::thread::yield_now();
    }
    child
}

/// While one process writes into a folder, another is refused; the first ends as if it had been
/// alone.
#[test]
fn two_processes_do_not_share_a_folder() {
    let work = TestFolder::new(COOLING);
    let long = "run case.toml --out out --set run.until=1e6 --replicas 1";
    let mut first = begun(&work, long, "out");
    for mode in ["--resume", "--force"] {
        let second = work.say(&format!("{long} {mode}"));
        assert_eq!(second.code, Some(2), "{mode}: {}", second.err);
        assert!(
            second.err.contains("another process"),
            "{mode}: {}",
            second.err
        );
    }
    first.kill().expect("killed");
    first.wait().expect("ended");
    // The lock ends with its process.
    work.done("run case.toml --out out --force --until 1");
}

/// A run that reaches its time limit is kept, and resumes to the same bytes.
#[test]
fn a_run_ends_at_its_time_limit_and_goes_on() {
    let work = TestFolder::new(COOLING);
    let case = "run case.toml --set gas.number=3000 --until 30 --out";
    let ended = work.say(&format!("{case} pieces --stop-after 50ms"));
    // The end of the run, if this thread sleeps for longer than the run takes.
    assert!(
        matches!(ended.code, Some(75 | 0)),
        "{:?}: {}",
        ended.code,
        ended.err
    );
    work.done(&format!("{case} pieces --resume"));
    work.done(&format!("{case} whole"));
    assert_same(&work.path("whole"), &work.path("pieces"));
    work.refused("run case.toml --stop-after soon", &["--stop-after"]);
}

/// An interrupted run is kept, and resumes to the same bytes.
#[cfg(unix)]
#[test]
fn an_interrupt_is_heard_and_the_run_goes_on() {
    let work = TestFolder::new(COOLING);
    let case = "run case.toml --set gas.number=3000 --until 30 --out";
    let mut child = begun(&work, &format!("{case} pieces"), "pieces");
    let sent = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(sent.expect("kill").success());
    // End of the run, which a fast machine may reach before the signal.
    let code = child.wait().expect("an end").code();
    assert!(matches!(code, Some(130 | 0)), "{code:?}");
    work.done(&format!("{case} pieces --resume"));
    work.done(&format!("{case} whole"));
    assert_same(&work.path("whole"), &work.path("pieces"));
}

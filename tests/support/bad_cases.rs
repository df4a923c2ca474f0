//! Case files that are wrong in one way each, and what the error has to say.

/// A case file that is refused.
pub struct BadCase {
    /// What is wrong.
    pub name: &'static str,
    /// The file, or what replaces it.
    pub content: Content,
    /// Overrides, as after `--set`.
    pub overrides: &'static [&'static str],
    /// Texts that the message has to contain.
    pub says: &'static [&'static str],
    /// Line that the message has to name; none if it concerns the file as a whole or an override.
    pub line: Option<usize>,
}

/// What stands where the case file should be.
pub enum Content {
    /// The good case with one line replaced by another text.
    Replace(&'static str, &'static str),
    /// The good case with a text after it.
    Append(&'static str),
    /// Something else altogether.
    Bytes(&'static [u8]),
    /// No file.
    Absent,
    /// A directory.
    Directory,
}

/// A good case. Its lines are counted in the table below.
pub const GOOD: &str = "\
# Is this case read?
format = 1
title = \"a test\"
units = \"reduced\"
seed = 7
replicas = 4

[gas]
disks = 100
packing_fraction = 0.25
restitution = 0.8
temperature = 1.0

[box]
aspect_ratio = 1.0
boundary = \"periodic\"

[start]
placement = \"disordered\"
velocities = \"maxwellian\"
collisions_per_particle = 10

[run]
until = 40
first_sample = 0.1
samples_per_decade = 12

[engine.ed]
contact_time = 0.0

[engine.dsmc-enskog]
cell_size = 2.0
neighbourhood = 2

[measure]
impact_windows = [[0, 1], [1, 5]]
structure_times = [0, 10, 20]

[verdict]
false_alarm = 0.01
";

impl BadCase {
    /// The bytes of the file; none if there is no file.
    pub fn bytes(&self) -> Option<Vec<u8>> {
        match self.content {
            Content::Replace(from, to) => {
                assert_eq!(
                    GOOD.matches(from).count(),
                    1,
                    "{}: {from:?} stands once",
                    self.name
                );
                Some(GOOD.replace(from, to).into_bytes())
            }
            Content::Append(end) => Some(format!("{GOOD}{end}").into_bytes()),
            Content::Bytes(bytes) => Some(bytes.to_vec()),
            Content::Absent | Content::Directory => None,
        }
    }
}

const fn replace(
    name: &'static str,
    from: &'static str,
    to: &'static str,
    line: usize,
    says: &'static [&'static str],
) -> BadCase {
    BadCase {
        name,
        content: Content::Replace(from, to),
        overrides: &[],
        says,
        line: Some(line),
    }
}

const fn append(
    name: &'static str,
    end: &'static str,
    line: usize,
    says: &'static [&'static str],
) -> BadCase {
    BadCase {
        name,
        content: Content::Append(end),
        overrides: &[],
        says,
        line: Some(line),
    }
}

const fn bytes(
    name: &'static str,
    content: &'static [u8],
    line: Option<usize>,
    says: &'static [&'static str],
) -> BadCase {
    BadCase {
        name,
        content: Content::Bytes(content),
        overrides: &[],
        says,
        line,
    }
}

const fn set(
    name: &'static str,
    overrides: &'static [&'static str],
    says: &'static [&'static str],
) -> BadCase {
    BadCase {
        name,
        content: Content::Append(""),
        overrides,
        says,
        line: None,
    }
}

/// The table.
pub const BAD_CASES: &[BadCase] = &[
    // Files.
    BadCase {
        name: "absent",
        content: Content::Absent,
        overrides: &[],
        says: &["absent.toml", "cannot be read", "No such file"],
        line: None,
    },
    BadCase {
        name: "directory",
        content: Content::Directory,
        overrides: &[],
        says: &["directory.toml", "this is a directory", "one TOML file"],
        line: None,
    },
    bytes("empty", b"", Some(1), &["format is missing", "the only format is 1"]),
    bytes("not UTF-8", b"format = 1\ntitle = \"M\xfcller\"\n", Some(2), &["0xfc", "not UTF-8"]),
    bytes("binary", b"\x7fELF\x02\x01\x00\x00", Some(1), &["not TOML"]),
    // Syntax.
    replace("open string", "title = \"a test\"", "title = \"a test", 3, &["not TOML"]),
    replace("no value", "seed = 7", "seed =", 5, &["not TOML"]),
    replace("duplicate key", "disks = 100", "disks = 100\ndisks = 200", 10, &["duplicate key", "`disks`"]),
    append("duplicate table", "[gas]\nmass = 2\n", 41, &["duplicate key", "gas"]),
    replace("open table", "[gas]", "[gas", 8, &["not TOML"]),
    // Format.
    replace("other format", "format = 1", "format = 2", 2, &["format = 2", "only format is 1"]),
    replace("format as text", "format = 1", "format = \"1\"", 2, &["format = \"1\"", "only format is 1"]),
    replace("no format", "format = 1", "", 1, &["format is missing", "the only format is 1"]),
    // Keys.
    replace(
        "misspelt key",
        "restitution = 0.8",
        "restitutoin = 0.8",
        11,
        &["unknown key gas.restitutoin", "did you mean restitution?", "packing_fraction", "diameter"],
    ),
    replace("strange key", "disks = 100", "colour = 3\ndisks = 100", 9, &["unknown key gas.colour", "disks, "]),
    replace("misspelt table", "[verdict]", "[verdikt]", 39, &["unknown key verdikt", "did you mean verdict?"]),
    append("unknown engine", "[engine.dsmc-enskoog]\n", 41, &["engine.dsmc-enskoog", "did you mean dsmc-enskog?"]),
    append("key of another table", "until = 3\n", 41, &["verdict.until", "did you mean run.until?", "false_alarm"]),
    append("root key at the end", "replicas = 3\n", 41, &["verdict.replicas", "did you mean replicas, which stands"]),
    append(
        "neighbourhood for Boltzmann",
        "[engine.dsmc-boltzmann]\nneighbourhood = 2\n",
        42,
        &["unknown key engine.dsmc-boltzmann.neighbourhood", "displacement"],
    ),
    append(
        "contact value for Boltzmann",
        "[engine.dsmc-boltzmann]\nlargest_contact_value = 2\n",
        42,
        &["unknown key engine.dsmc-boltzmann.largest_contact_value"],
    ),
    append(
        "neighbourhood for free volume",
        "[engine.dsmc-free-volume]\nneighbourhood = \"mean\"\n",
        42,
        &["unknown key engine.dsmc-free-volume.neighbourhood", "largest_contact_value"],
    ),
    replace("no title", "title = \"a test\"", "", 1, &["title is missing", "a text"]),
    replace("no restitution", "restitution = 0.8", "", 8, &["gas.restitution is missing", "0 to 1"]),
    replace("no disks", "disks = 100", "", 8, &["gas.disks is missing", "2 to 1000000000"]),
    replace("no packing fraction", "packing_fraction = 0.25", "", 8, &["gas.packing_fraction is missing", "0.9069"]),
    replace("no end", "until = 40", "", 23, &["run.until is missing", "above 0"]),
    bytes(
        "no gas",
        b"format = 1\ntitle = \"t\"\n[run]\nuntil = 1\n[engine.ed]\n",
        Some(1),
        &["gas is missing", "restitution"],
    ),
    bytes(
        "no engine table",
        b"format = 1\ntitle = \"t\"\n[gas]\ndisks = 9\npacking_fraction = 0.1\nrestitution = 1\n[run]\nuntil = 1\n",
        Some(1),
        &["engine is missing", "[engine.ed]", "[engine.dsmc-enskog]"],
    ),
    bytes(
        "empty engine table",
        b"format = 1\ntitle = \"t\"\n[gas]\ndisks = 9\npacking_fraction = 0.1\nrestitution = 1\n[engine]\n[run]\nuntil = 1\n",
        Some(7),
        &["engine = {}", "at least one engine", "[engine.ed]"],
    ),
    // Types.
    replace("text for a number", "packing_fraction = 0.25", "packing_fraction = \"dense\"", 10, &["gas.packing_fraction = \"dense\"", "0.9069"]),
    replace("fraction of a disk", "disks = 100", "disks = 100.5", 9, &["gas.disks = 100.5", "whole number"]),
    replace("disks as a float", "disks = 100", "disks = 1e4", 9, &["gas.disks = 10000.0", "whole number"]),
    replace("number for text", "title = \"a test\"", "title = 1998", 3, &["title = 1998", "a text"]),
    replace("date for a number", "until = 40", "until = 1998-07-06", 24, &["run.until = 1998-07-06", "units of t0"]),
    replace("number for a table", "[verdict]\nfalse_alarm = 0.01", "[[verdict]]", 39, &["verdict = [{}]", "false_alarm"]),
    replace("list for a number", "replicas = 4", "replicas = [4, 5]", 6, &["replicas = [4, 5]", "whole number"]),
    replace("one table for sweeps", "[verdict]\nfalse_alarm = 0.01", "[sweep]\n\"gas.mass\" = [1]", 39, &["sweep = { ", "[[sweep]]"]),
    replace("number too large", "seed = 7", "seed = 99999999999999999999", 5, &["seed = 99999999999999999999", "9223372036854775807"]),
    // Not finite.
    replace("nan", "restitution = 0.8", "restitution = nan", 11, &["gas.restitution = nan", "0 to 1"]),
    replace("infinity", "until = 40", "until = inf", 24, &["run.until = inf", "above 0"]),
    replace("negative infinity", "contact_time = 0.0", "contact_time = -inf", 29, &["engine.ed.contact_time = -inf", "at least 0"]),
    replace("beyond the largest float", "until = 40", "until = 1e999", 24, &["run.until = inf", "above 0"]),
    replace("nan in a list", "structure_times = [0, 10, 20]", "structure_times = [0, nan]", 37, &["measure.structure_times[1] = nan", "time before zero"]),
    // Ranges.
    replace("packing beyond close", "packing_fraction = 0.25", "packing_fraction = 1.2", 10, &["gas.packing_fraction = 1.2 is not allowed", "a packing fraction lies above 0 and at most 0.9069 (close packing)", "10 | packing_fraction = 1.2"]),
    replace("no packing", "packing_fraction = 0.25", "packing_fraction = 0.0", 10, &["gas.packing_fraction = 0.0", "above 0"]),
    BadCase {
        name: "square beyond touching",
        content: Content::Replace("packing_fraction = 0.25", "packing_fraction = 0.8"),
        overrides: &["start.placement=square"],
        says: &["gas.packing_fraction = 0.8", "at most 0.7854"],
        line: Some(10),
    },
    replace("restitution above one", "restitution = 0.8", "restitution = 1.1", 11, &["gas.restitution = 1.1", "from 0 to 1", "viscoelastic"]),
    replace("weak viscoelastic", "restitution = 0.8", "restitution = { viscoelastic = 0 }", 11, &["gas.restitution.viscoelastic = 0", "above 0"]),
    replace("unknown law", "restitution = 0.8", "restitution = { plastic = 1 }", 11, &["unknown key gas.restitution.plastic", "viscoelastic"]),
    replace("empty law", "restitution = 0.8", "restitution = {}", 11, &["gas.restitution.viscoelastic is missing", "above 0"]),
    replace("no replica", "replicas = 4", "replicas = 0", 6, &["replicas = 0", "1 to 1000000"]),
    replace("negative seed", "seed = 7", "seed = -7", 5, &["seed = -7", "from 0"]),
    replace("cold gas", "temperature = 1.0", "temperature = -1", 12, &["gas.temperature = -1", "above 0"]),
    replace("flat box", "aspect_ratio = 1.0", "aspect_ratio = 0", 15, &["box.aspect_ratio = 0", "above 0"]),
    replace("walls", "boundary = \"periodic\"", "boundary = \"wall\"", 16, &["box.boundary = \"wall\"", "\"periodic\""]),
    replace("misspelt placement", "placement = \"disordered\"", "placement = \"hexagnal\"\nfile = \"a.csv\"", 19, &["start.placement = \"hexagnal\"", "did you mean \"hexagonal\"?", "\"square\""]),
    replace("no time", "until = 40", "until = 0", 24, &["run.until = 0", "above 0"]),
    replace("negative contact time", "contact_time = 0.0", "contact_time = -1e-3", 29, &["engine.ed.contact_time = -0.001", "at least 0"]),
    replace("broken collision limit", "contact_time = 0.0", "collision_limit = 1.5", 29, &["engine.ed.collision_limit = 1.5", "whole number"]),
    replace("no cell", "cell_size = 2.0", "cell_size = 0", 32, &["engine.dsmc-enskog.cell_size = 0", "above 0"]),
    replace("too many simulators", "cell_size = 2.0", "simulators_per_disk = 1001", 32, &["simulators_per_disk = 1001", "1 to 1000"]),
    replace("wide neighbourhood", "neighbourhood = 2", "neighbourhood = 51", 33, &["neighbourhood = 51", "0 to 50", "\"mean\""]),
    replace("misspelt neighbourhood", "neighbourhood = 2", "neighbourhood = \"men\"", 33, &["neighbourhood = \"men\"", "did you mean \"mean\"?"]),
    replace("low contact value", "cell_size = 2.0", "largest_contact_value = 0.5", 32, &["largest_contact_value = 0.5", "from 1 to 1000000000"]),
    replace("certain alarm", "false_alarm = 0.01", "false_alarm = 0.5", 40, &["verdict.false_alarm = 0.5", "below 0.5"]),
    append("too few bins", "[[sweep]]\n\"measure.impact_bins\" = [1]\n", 42, &["measure.impact_bins = 1", "2 to 1000"]),
    // Relations.
    replace("temperature and speed", "temperature = 1.0", "temperature = 1.0\nrms_speed = 2", 13, &["gas.rms_speed = 2", "gas.temperature is given too"]),
    replace("SI without a diameter", "units = \"reduced\"", "units = \"si\"", 8, &["gas.diameter is missing", "units = \"si\""]),
    replace("late first sample", "first_sample = 0.1", "first_sample = 40", 25, &["run.first_sample = 40", "below run.until", "run.until = 40"]),
    replace("file without a placement", "placement = \"disordered\"", "file = \"a.csv\"", 19, &["start.file = \"a.csv\"", "placement = \"file\""]),
    replace("velocities without a file", "velocities = \"maxwellian\"", "velocities = \"file\"", 20, &["start.velocities = \"file\"", "placement = \"file\""]),
    replace("count beside a file", "placement = \"disordered\"", "placement = \"file\"\nfile = \"a.csv\"", 9, &["gas.disks = 100", "left out"]),
    bytes(
        "placement without a file",
        b"format = 1\ntitle = \"t\"\n[gas]\nrestitution = 1\n[start]\nplacement = \"file\"\n[run]\nuntil = 1\n[engine.ed]\n",
        Some(5),
        &["start.file is missing", ".csv or .xyz"],
    ),
    bytes(
        "start file that is absent",
        b"format = 1\ntitle = \"t\"\n[gas]\nrestitution = 1\n[start]\nplacement = \"file\"\nfile = \"none.csv\"\n[run]\nuntil = 1\n[engine.ed]\n",
        Some(7),
        &["start.file = \"none.csv\"", "there is no file"],
    ),
    bytes(
        "start file of another kind",
        b"format = 1\ntitle = \"t\"\n[gas]\nrestitution = 1\n[start]\nplacement = \"file\"\nfile = \"start.h5\"\n[run]\nuntil = 1\n[engine.ed]\n",
        Some(7),
        &["start.file = \"start.h5\"", ".csv or .xyz"],
    ),
    replace("early giving up", "collisions_per_particle = 10", "collisions_per_particle = 10\nmost_collisions_per_particle = 5", 22, &["start.most_collisions_per_particle = 5", "at least start.collisions_per_particle = 10"]),
    replace("time before zero", "structure_times = [0, 10, 20]", "structure_times = [0, -10, 20]", 37, &["measure.structure_times[1] = -10", "time before zero"]),
    replace("time after the end", "structure_times = [0, 10, 20]", "structure_times = [\n  0,\n  50,\n]", 39, &["measure.structure_times[1] = 50", "run.until = 40"]),
    replace("window backwards", "[[0, 1], [1, 5]]", "[[0, 1], [5, 1]]", 36, &["measure.impact_windows[1] = [5, 1]", "start < end"]),
    replace("window after the end", "[[0, 1], [1, 5]]", "[[0, 1], [1, 50]]", 36, &["measure.impact_windows[1] = [1, 50]", "run.until = 40"]),
    replace("window of one", "[[0, 1], [1, 5]]", "[[0, 1], [5]]", 36, &["measure.impact_windows[1] = [5]", "[start, end]"]),
    replace("window before zero", "[[0, 1], [1, 5]]", "[[-1, 1]]", 36, &["measure.impact_windows[0][0] = -1", "0 <= start"]),
    replace("no window", "[[0, 1], [1, 5]]", "[]", 36, &["measure.impact_windows = []", "[start, end]"]),
    replace("displacements not asked for", "structure_times = [0, 10, 20]", "displacement_start = 1", 37, &["measure.displacement_start = 1", "mean_squared_displacement is true"]),
    replace("late displacements", "structure_times = [0, 10, 20]", "mean_squared_displacement = true\ndisplacement_start = 40", 38, &["measure.displacement_start = 40", "run.until - run.first_sample = 39.9"]),
    append("drive without an interval", "[drive]\nheating = 2\n", 41, &["drive.interval is missing", "below run.until"]),
    append("drive that cools", "[drive]\nheating = -2\ninterval = 0.1\n", 42, &["drive.heating = -2", "above 0"]),
    append("drive of nan", "[drive]\nheating = nan\ninterval = 0.1\n", 42, &["drive.heating = nan", "above 0"]),
    append("drive without kicks", "[drive]\nheating = 2\ninterval = 40\n", 43, &["drive.interval = 40", "run.until = 40"]),
    append("endless kicks", "[drive]\nheating = 2\ninterval = 1e-9\n", 43, &["drive.interval = 1e-9", "1000000000 kicks"]),
    append("misspelt heating", "[drive]\nheatin = 2\ninterval = 1\n", 42, &["unknown key drive.heatin", "did you mean heating?"]),
    // Species of disks.
    append("shares that are not all", "[[gas.species]]\nshare = 0.5\ndiameter = 1\nmass = 1\n", 41, &["gas.species = [", "add up to 1"]),
    append("a diameter below zero", "[[gas.species]]\nshare = 1\ndiameter = -1\nmass = 1\n", 43, &["gas.species[0].diameter = -1", "above 0"]),
    append("species without a mass", "[[gas.species]]\nshare = 1\ndiameter = 1\n", 41, &["gas.species[0].mass is missing", "above 0"]),
    append("misspelt share", "[[gas.species]]\nshares = 1\ndiameter = 1\nmass = 1\n", 42, &["unknown key gas.species[0].shares", "did you mean share?"]),
    // Kinds.
    replace("unknown kind", "title = \"a test\"", "title = \"a test\"\nkind = \"pared\"", 4, &["kind = \"pared\"", "did you mean \"paired\"?", "the kind of a case is one of"]),
    replace("kind of another type", "title = \"a test\"", "title = \"a test\"\nkind = 3", 4, &["kind = 3", "without this key it is \"paired\""]),
    set("override of the kind", &["kind=paired"], &["--set kind=paired", "any key but format, kind"]),
    // Sweeps.
    append("bad value in a sweep", "[[sweep]]\n\"gas.mass\" = [1, 2]\n\"gas.packing_fraction\" = [0.1, 1.2]\n", 43, &["gas.packing_fraction = 1.2", "0.9069"]),
    append("unknown key in a sweep", "[[sweep]]\n\"gas.masss\" = [1]\n", 42, &["unknown key gas.masss", "did you mean mass?"]),
    append("number for a sweep", "[[sweep]]\n\"gas.mass\" = 3\n", 42, &["sweep[0].\"gas.mass\" = 3", "a list of at least one value"]),
    append("empty list in a sweep", "[[sweep]]\n\"gas.mass\" = []\n", 42, &["sweep[0].\"gas.mass\" = []", "at least one value"]),
    append("unquoted key in a sweep", "[[sweep]]\ngas.mass = [1]\n", 42, &["sweep[0].gas = { mass = [1] }", "quoted dotted keys"]),
    append("empty sweep", "[[sweep]]\n", 41, &["sweep[0] = {}", "dotted keys"]),
    append("sweep of the format", "[[sweep]]\n\"format\" = [1]\n", 42, &["sweep[0].format = [1]", "any key but format"]),
    append("sweep of a key and its table", "[[sweep]]\n\"gas\" = [{}]\n\"gas.mass\" = [1]\n", 43, &["sweep[0].\"gas.mass\" = [1]", "already sweeps gas"]),
    append(
        "endless sweep",
        "[[sweep]]\nseed = [1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,18,19,20,21,22,23,24,25,26,27,28,29,30]\n\"gas.mass\" = [1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,18,19,20]\n\"gas.diameter\" = [1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,18,19,20]\n",
        42,
        &["sweep[0].seed", "at most 10000 points"],
    ),
    // Overrides.
    set("bad override", &["gas.packing_fraction=1.2"], &["--set gas.packing_fraction=1.2: gas.packing_fraction = 1.2", "0.9069"]),
    set("unknown override", &["gas.packing=0.2"], &["--set gas.packing=0.2: unknown key gas.packing", "packing_fraction"]),
    set("override without a value", &["run.until"], &["--set run.until", "key=value"]),
    set("override that is nan", &["run.until=nan"], &["--set run.until=nan: run.until = nan", "above 0"]),
    set("override with a word", &["run.until=long"], &["run.until = \"long\"", "above 0"]),
    set("second override", &["run.until=50", "replicas=-1"], &["--set replicas=-1: replicas = -1", "1 to 1000000"]),
    set("override of the format", &["format=2"], &["--set format=2", "any key but format"]),
    set("override of a whole table", &["gas=5"], &["--set gas=5: gas = 5", "a table with the keys"]),
];

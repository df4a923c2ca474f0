//! Two gases on either side of a body inside cells: no collision crosses it, and cells that cannot
//! tell both sides apart are refused.

use std::fmt::Write as _;

use crate::support::program::{TestFolder, manifest};

/// Case of two chambers between elastic walls; a body and engines follow.
const CHAMBERS: &str = "format = 2\ntitle = \"two chambers\"\nreplicas = 1\n[gas]\nrestitution = 1\n[box]\n[walls]\n\
     bottom = \"specular\"\ntop = \"specular\"\n[start]\nplacement = \"file\"\nfile = \"start.csv\"\nvelocities = \"file\"\n\
     [run]\nuntil = 5\nsamples = 40\n[measure.snapshots]\ntimes = [5]\n";

/// Exact disks and all schemes that go with obstacles, in cells one diameter wide.
const ENGINES: [(&str, &str); 4] = [
    ("ed", ""),
    (
        "dsmc-boltzmann",
        "cell_size = 1\nsimulators_per_particle = 4\n",
    ),
    (
        "dsmc-free-volume",
        "cell_size = 1\nsimulators_per_particle = 4\ndisplacement = false\n",
    ),
    (
        "dsmc-enskog",
        "cell_size = 1\nsimulators_per_particle = 4\ndisplacement = false\n",
    ),
];

/// Temperatures below and above the partition.
const TEMPERATURES: [f64; 2] = [10.0, 0.1];

/// A partition across a box of 20 x 20, bent or straight.
struct Partition {
    /// Height at both ends \[length\].
    at: f64,
    /// Thickness of a solid; 0 for a line \[length\].
    thickness: f64,
    /// Bend upwards at x = 7, and downwards at x = 13 \[length\].
    bend: f64,
}

impl Partition {
    fn corners(&self) -> [[f64; 2]; 4] {
        let corner = |x, bends: f64| [x, self.at + bends * self.bend];
        [
            corner(0.0, 0.0),
            corner(7.0, 1.0),
            corner(13.0, -1.0),
            corner(20.0, 0.0),
        ]
    }

    /// Returns the height of the lower side at x.
    fn height(&self, x: f64) -> f64 {
        let corners = self.corners();
        let pairs = corners.iter().zip(&corners[1..]);
        let mut heights = pairs
            .filter(|([x0, _], [x1, _])| (*x0..=*x1).contains(&x))
            .map(|([x0, y0], [x1, y1])| y0 + (y1 - y0) * (x - x0) / (x1 - x0));
        heights.next().expect("a place in the box")
    }

    /// Returns the side of a position, 0 below or 1 above, that is at least `room` away from the
    /// partition along y; `None` if it is nearer.
    fn side(&self, [x, y]: [f64; 2], room: f64) -> Option<usize> {
        let height = self.height(x);
        let below = (y < height - room).then_some(0);
        below.or((y > height + self.thickness + room).then_some(1))
    }

    fn table(&self) -> String {
        let corners = self.corners();
        if self.thickness == 0.0 {
            return format!("[[obstacle]]\npolyline = {corners:?}\n");
        }
        let above = corners.iter().rev();
        let above = above.map(|[x, y]| [*x, y + self.thickness]);
        let all: Vec<[f64; 2]> = corners.into_iter().chain(above).collect();
        format!("[[obstacle]]\npolygon = {all:?}\n")
    }

    /// Returns a start file of disks on a grid, with one speed on each side, and their number on
    /// each side.
    fn start(&self) -> (String, [usize; 2]) {
        let mut text = "# box: 20 20\nx,y,vx,vy\n".to_owned();
        let mut counts = [0; 2];
        for number in (0_u32..256).filter(|number| (number % 16 + number / 16) % 2 == 0) {
            let [x, y] = [number % 16, number / 16].map(|step| 1.25 * f64::from(step) + 0.625);
            // Room of 0.7 along y, of which the steepest part leaves 0.9 across it.
            let Some(side) = self.side([x, y], 0.7) else {
                continue;
            };
            counts[side] += 1;
            // Directions without a pattern.
            let angle = f64::from(number * number % 101);
            let speed = (2.0 * TEMPERATURES[side]).sqrt();
            let (vx, vy) = (speed * angle.cos(), speed * angle.sin());
            writeln!(text, "{x},{y},{vx},{vy}").expect("a string");
        }
        (text, counts)
    }
}

/// Both sides keep their particles and their temperature, by Monte Carlo as by exact disks,
/// wherever the partition cuts the cells. The tolerance is rounding: each of at most 1e5 collisions
/// and rebounds changes an energy by some 1e-16.
#[test]
fn chambers_keep_their_temperatures() {
    for (at, thickness, bend) in [
        (10.0, 0.0, 0.0),
        (9.87, 0.0, 0.0),
        (10.5, 0.0, 1.3),
        (9.0, 2.0, 0.0),
        (9.31, 2.0, 0.0),
        (8.5, 2.0, 1.3),
    ] {
        let partition = Partition {
            at,
            thickness,
            bend,
        };
        let mut case = format!("{CHAMBERS}{}", partition.table());
        for (engine, more) in ENGINES {
            write!(case, "[engine.{engine}]\n{more}").expect("a string");
        }
        let work = TestFolder::new(&case);
        let (start, counts) = partition.start();
        assert!(counts.iter().all(|count| *count > 30), "{counts:?}");
        work.write("start.csv", start);
        work.done("run case.toml --out out");
        let manifest = manifest(&work.path("out"));
        for (engine, _) in ENGINES {
            let name = format!("{engine} {at} {thickness} {bend}");
            let cost = manifest.engines.iter().find(|one| one.engine == engine);
            let collisions = cost.expect("an engine").collisions;
            assert!(collisions > 200, "{name}: {collisions} collisions");
            let text = work.text(&format!("out/snapshots/{engine}-0.xyz"));
            let (mut found, mut energies) = ([0; 2], [0.0; 2]);
            for row in text.lines().skip(2) {
                let numbers = row.split_whitespace().map(str::parse);
                let row: Vec<f64> = numbers.map(|one| one.expect("a number")).collect();
                let side = partition.side([row[1], row[2]], 0.0);
                let side = side.unwrap_or_else(|| panic!("{name}: {row:?} in the partition"));
                found[side] += 1;
                energies[side] += 0.5 * (row[4] * row[4] + row[5] * row[5]);
            }
            let each = if engine == "ed" { 1 } else { 4 };
            for side in 0..2 {
                assert_eq!(found[side], each * counts[side], "{name} {side}");
                let temperature = energies[side] / found[side] as f64;
                let off = temperature / TEMPERATURES[side] - 1.0;
                assert!(off.abs() < 1e-10, "{name} {side}: {temperature}");
            }
        }
    }
}

/// A comb of 300 teeth in one cell is refused; the message names sufficient cells in the units of
/// the case, and a run with them succeeds.
#[test]
fn cells_that_cannot_tell_sides_apart_are_refused() {
    let tooth = |tooth: u32| {
        let x = 41.0 + 0.06 * f64::from(tooth);
        [x, if tooth.is_multiple_of(2) { 23.0 } else { 27.0 }]
    };
    let teeth: Vec<[f64; 2]> = (0..300).map(tooth).collect();
    let work = TestFolder::new(&format!(
        "format = 2\ntitle = \"a comb\"\nreplicas = 1\n[gas]\nnumber = 50\ndiameter = 2\nrestitution = 1\n[box]\nsize = [120, 80]\n\
         [[obstacle]]\npolyline = {teeth:?}\n[run]\nuntil = 1\nsamples = 40\n[engine.dsmc-boltzmann]\ncell_size = 40\n"
    ));
    let words = [
        "is refused (cells 40 wide: edges of obstacles cut the cell at (40, 0) into more than 256 parts)",
        "the rule: cells of at most 10, where partners on different sides of a body can be told apart",
    ];
    for command in [
        "check case.toml --no-timing",
        "check case.toml",
        "run case.toml --out out",
    ] {
        work.refused(command, &words);
    }
    work.done("run case.toml --out out --set engine.dsmc-boltzmann.cell_size=10");
}

//! The command `init`: templates of new case files, with a comment on every line.

use std::fmt::Write as _;

use crate::arguments::{InitArguments, Template};

/// Returns the text of a new case file for the given arguments.
pub fn text(arguments: &InitArguments) -> String {
    let restitution = arguments.restitution.first().copied().unwrap_or(1.0);
    let mut text = head(arguments);
    let body = match arguments.kind {
        Template::Comparison => format!(
            r"
[gas]
number = {number:<17} # disks; diameter and mass are 1, and the temperature of the start is 1
restitution = {restitution:<12?} # of a collision: 1 is elastic

[box]
packing_fraction = {packing:<7?} # share of the area that disks fill; the box is periodic and square

[run]
until = {until:<18?} # in units of Haff's cooling time; of the mean free time where nothing is lost
samples_per_decade = 12    # times at which the gas is looked at, in equal factors

# Engines: all start from the same state, and each is compared with each. docs/engines.md has a table of all.
[engine.ed]                # exact, event-driven

[engine.dsmc-contact-point] # Monte Carlo with the rate and the pressure of Enskog's theory
simulators_per_particle = 4 # more have smaller errors, and cost as much more

# What is measured without being asked for: energy, impact parameters, structure, pair correlation, snapshots.
[measure.impact_parameters]
bins = 20                  # of b/d from 0 to 1
",
            number = arguments.number,
            packing = arguments.packing_fraction,
            until = arguments.until,
        ),
        Template::Homogeneous => format!(
            r#"
[gas]
dimension = 3              # spheres; 2 for disks
number = {number:<17} # particles; diameter and mass are 1, and the temperature of the start is 1
volume = {volume:<17?} # filled to {packing}
restitution = {restitution:<12?} # of a collision: 1 is elastic
pair_correlation = "enskog"   # collisions as frequent as at this density; "dilute" for the Boltzmann equation

[run]
until = {until:<18?} # in the unit of time of the case
first_sample = {first:<11?} # the first look at the gas; others follow in equal factors
samples_per_decade = 10
"#,
            number = arguments.number,
            // Of spheres of diameter one: N pi / 6 / V.
            volume =
                arguments.number as f64 * std::f64::consts::PI / 6.0 / arguments.packing_fraction,
            packing = arguments.packing_fraction,
            until = arguments.until,
            first = arguments.until / 100.0,
        ),
        Template::Channel => {
            // The channel is twice as long as wide.
            let area =
                arguments.number as f64 * std::f64::consts::FRAC_PI_4 / arguments.packing_fraction;
            let width = (0.5 * area).sqrt();
            format!(
                r"
[gas]
number = {number:<17} # disks; diameter and mass are 1, and the temperature of the start is 1
restitution = {restitution:<12?} # of a collision: 1 is elastic

[box]
size = [{length:.3}, {width:.3}] # periodic along the first axis

[walls.bottom]             # a wall that gives disks its temperature
temperature = 1.0
[walls.top]
temperature = 1.0

[gravity]
acceleration = [0.005, 0.0] # drives the flow along the channel

[run]
until = {until:<18?} # in the unit of time of the case
samples = 200              # at equal intervals; the last quarter is taken for the steady state

[engine.ed]                # exact, event-driven

[engine.dsmc-contact-point] # Monte Carlo with the rate and the pressure of Enskog's theory
simulators_per_particle = 4

[measure.fields]           # density, velocity and temperature across the channel
cells = [1, 20]
",
                number = arguments.number,
                length = 2.0 * width,
                until = arguments.until,
            )
        }
    };
    text.push_str(&body);
    if arguments.restitution.len() > 1 {
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "\n[[sweep]]                  # a run for each value; or {{ from = 0.6, to = 0.9, points = 4 }}\n\"gas.restitution\" = {:?}\n",
            arguments.restitution
        );
    }
    text
}

fn head(arguments: &InitArguments) -> String {
    let about = match arguments.kind {
        Template::Comparison => "Where does Monte Carlo depart from exact disks?",
        Template::Homogeneous => "Does a gas without positions cool as kinetic theory says?",
        Template::Channel => "Which profile has a gas that is driven along a channel?",
    };
    let question = match arguments.kind {
        Template::Comparison => {
            "question = { measure = \"energy\" } # the headline; or measure = \"impact_parameters\", column = \"slope\"\n"
        }
        _ => "",
    };
    format!(
        r"# {about}
# `stosszahl check` says what this case means, `stosszahl run` runs it; docs/case-file.md has all keys.
format = 2                 # version of the case format
seed = 1                   # the same seed gives the same bytes
replicas = {:<15} # independent runs; their spread makes the errors
{question}",
        arguments.replicas
    )
}

//! Unit names of a case in SI: `m`, `kg`, `s` and `J` in place of `length`, `mass`, `time` and
//! `energy`.

use std::borrow::Cow;

use stosszahl_case::format::{TimeUnit, UnitsSpec};

use super::data::CasePlan;

impl CasePlan {
    /// Returns the unit of a column of the case's tables. Times in tables are in the unit of
    /// `run.time_unit`, which is the second only for `case`.
    pub fn table_unit(&self, unit: &str) -> Cow<'static, str> {
        let second = (self.clock.time_unit == TimeUnit::Case).then_some("s");
        self.unit(unit, second)
    }

    /// Returns the unit of a derived quantity of the case. Its times are in seconds for any
    /// `run.time_unit`.
    pub(super) fn derived_unit(&self, unit: &str) -> Cow<'static, str> {
        if unit == "unit of time" {
            return self.table_unit(unit);
        }
        self.unit(unit, Some("s"))
    }

    /// Returns the SI unit for a unit in words, if the case is in SI; `second` is the unit of time,
    /// if given.
    fn unit(&self, unit: &str, second: Option<&'static str>) -> Cow<'static, str> {
        if self.case.units != UnitsSpec::Si {
            return unit.to_owned().into();
        }
        let time = second.unwrap_or("time");
        match unit {
            "unit of time" => return second.unwrap_or("unit of time").into(),
            // Of other times than seconds it is the speed of the case all the same.
            "speed" | "sqrt(energy/mass)" => return "m/s".into(),
            _ => {}
        }
        let words = [
            ("length", "m"),
            ("mass", "kg"),
            ("energy", "J"),
            ("time", time),
        ];
        let named = words.iter().fold(unit.to_owned(), |unit, (word, name)| {
            unit.replace(word, name)
        });
        named
            .replace("^-D", &format!("^-{}", self.gas.dimension))
            .replace("^D", &format!("^{}", self.gas.dimension))
            .into()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check;

    /// All units of tables and quantities have names in SI, with times in seconds or in units of
    /// Haff's time.
    #[test]
    fn units_have_names_in_si() {
        let plan = |units: &str, time: &str| {
            let text = format!(
                "format = 2\ntitle = \"units\"\nunits = \"{units}\"\n[gas]\nnumber = 10\ndiameter = 1e-3\nmass = 1e-6\n\
                 temperature = 1e-9\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n[run]\ntime_unit = \"{time}\"\n\
                 until = 1\n[engine.ed]\n"
            );
            let file = check::format().from_text(Path::new("case.toml"), &text, &[]);
            CasePlan::new(&file.expect("a case").points[0].case, Path::new("")).expect("a plan")
        };
        let all = [
            ("", ""),
            ("1", "1"),
            ("length", "m"),
            ("1/length^D", "1/m^2"),
            ("length^-D", "m^-2"),
            ("length^2", "m^2"),
            ("mass", "kg"),
            ("energy/length^D", "J/m^2"),
            ("energy/length", "J/m"),
            ("energy/time", "J/s"),
            ("speed", "m/s"),
            ("sqrt(energy/mass)", "m/s"),
            ("1/time", "1/s"),
            ("unit of time", "s"),
        ];
        let [si, cooling, reduced] = [
            plan("si", "case"),
            plan("si", "haff"),
            plan("reduced", "case"),
        ];
        for (written, named) in all {
            assert_eq!(si.table_unit(written), named);
            assert_eq!(reduced.table_unit(written), written);
            let is_time = written.contains("time");
            assert_eq!(
                cooling.table_unit(written).contains("time"),
                is_time,
                "{written}"
            );
        }
        assert_eq!(cooling.derived_unit("time"), "s");
        assert_eq!(cooling.table_unit("energy/time"), "J/time");
        let speed = si
            .derived()
            .into_iter()
            .find(|one| one.name == "thermal_speed");
        let speed = speed.expect("a thermal speed");
        // sqrt(T/m), rounded once or twice.
        assert!(
            (speed.value / 1e-3_f64.sqrt() - 1.0).abs() < 1e-15,
            "{}",
            speed.value
        );
        assert_eq!(speed.unit, "m/s");
    }
}

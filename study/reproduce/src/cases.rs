//! Reads the case files of a paper's runs and overwrites the keys that the paper sets.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use stosszahl_case::paper::PaperRunSpec;
use stosszahl_case::{CaseError, CaseFile, PaperFile};
use stosszahl_study::format;
use toml::Value;

/// Reads the case file of one run of a paper and overwrites the keys that the paper sets.
pub(crate) fn read_case(
    file: &PaperFile,
    name: &str,
    quick: bool,
    bundled: &dyn Fn(&str) -> Option<String>,
) -> Result<CaseFile, CaseError> {
    let run: &PaperRunSpec = &file.paper.run[name];
    let mut settings = run.set.clone();
    if quick {
        settings.extend(run.quick.clone());
    }
    let overrides: Vec<String> = settings
        .iter()
        .map(|(key, value)| format!("{key}={}", inline(value)))
        .collect();
    let is_file = Path::new(&run.case)
        .extension()
        .is_some_and(|ending| ending == "toml");
    let read = if is_file {
        let folder = file.path.parent().unwrap_or(Path::new(""));
        format().read(&folder.join(&run.case), &overrides)
    } else {
        let Some(text) = bundled(&run.case) else {
            let allowed = "a bundled case, or a file NAME.toml beside the paper";
            return Err(file.refuse(&format!("run.{name}.case"), allowed));
        };
        let path = PathBuf::from(format!("{}.toml", run.case));
        format().from_text(&path, &text, &overrides)
    };
    // Settings of the paper are written in the paper file.
    read.map_err(|error| match error.refusal() {
        Some(refusal) if refusal.argument.is_some() => {
            let set = |keys: &BTreeMap<String, Value>| {
                keys.keys().any(|key| refusal.key.starts_with(key.as_str()))
            };
            let part = if quick && set(&run.quick) {
                "quick"
            } else {
                "set"
            };
            file.refuse(&format!("run.{name}.{part}"), error.to_string())
        }
        _ => error,
    })
}

/// Formats a TOML value on one line.
fn inline(value: &Value) -> String {
    match value {
        // Exponent form: the TOML writer would write 1e300 with three hundred zeros.
        Value::Float(number) => format!("{number:?}"),
        Value::Array(all) => {
            let all: Vec<String> = all.iter().map(inline).collect();
            format!("[{}]", all.join(", "))
        }
        Value::Table(all) => {
            let all: Vec<String> = all
                .iter()
                .map(|(key, value)| format!("{key} = {}", inline(value)))
                .collect();
            format!("{{ {} }}", all.join(", "))
        }
        other => other.to_string(),
    }
}

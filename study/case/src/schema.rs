//! JSON Schema of case files, and the check of a case against it.
//!
//! Types, ranges and words are checked against the schema that is published, and messages are made
//! from it, so the types in [`crate::format`] are their only source. A general validator would
//! report JSON pointers and take no 4000.0 for 4000.

use std::sync::OnceLock;

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use serde_json::{Value as Json, json};
use toml::Value;

use crate::error::{Fault, Problem, nearest};
use crate::format::Case;
use crate::origin::{KeyPath, OUTSIDE, below, dotted};
use crate::renamed::new_name;

/// Smallest magnitude of a number in a case other than 0; with the largest, it keeps squares and
/// cubes in range.
const SMALLEST: f64 = 1e-100;
const LARGEST: f64 = 1e100;

/// Case format: its schema, including the measurements that a program offers.
#[derive(Debug)]
pub struct Format {
    json: Json,
}

impl Format {
    /// Creates the case format with measurements, given by name and the schema of their options
    /// (see [`schema_of`]).
    pub fn new(measures: &[(&str, Schema)]) -> Self {
        let mut json = schema_of::<Case>().to_value();
        json["title"] = Json::from("stosszahl case");
        json["properties"]["format"]["const"] = Json::from(2);
        let measure = &mut json["properties"]["measure"];
        if measures.is_empty() {
            measure["additionalProperties"] = json!({"type": "object"});
        } else {
            measure["additionalProperties"] = Json::from(false);
            for (name, schema) in measures {
                let mut schema = schema.clone().to_value();
                without_null(&mut schema);
                measure["properties"][*name] = schema;
            }
        }
        Self { json }
    }

    /// Returns the case format without measurements: options of measurements are not checked.
    pub fn plain() -> &'static Self {
        static PLAIN: OnceLock<Format> = OnceLock::new();
        PLAIN.get_or_init(|| Self::new(&[]))
    }

    /// Creates the format of another kind of TOML file, from the schema of its type.
    pub(crate) fn of_type(schema: Schema) -> Self {
        Self {
            json: schema.to_value(),
        }
    }

    /// Returns the JSON Schema of the format.
    pub fn json(&self) -> &Json {
        &self.json
    }

    /// Checks a case against the schema: every key is known, has the right type and lies in its
    /// range, and none is missing. Whole numbers that were written as 4000.0 become whole.
    pub(crate) fn check(&self, table: &mut toml::Table) -> Result<(), Problem> {
        let mut value = Value::Table(std::mem::take(table));
        self.check_within(&self.json, &mut value, &[])?;
        if let Value::Table(checked) = value {
            *table = checked;
        }
        Ok(())
    }

    /// Checks one top-level entry of a case against the schema.
    pub(crate) fn check_part(&self, key: &str, value: &mut Value) -> Result<(), Problem> {
        self.check_within(&self.json["properties"][key], value, &[key.to_owned()])
    }

    /// Returns the type that the schema gives to a key; `None` for an unknown key.
    pub(crate) fn type_of(&self, key: &[String]) -> Option<&str> {
        let mut schema = &self.json;
        for step in key {
            let inside = alternatives(schema).into_iter();
            let found = inside
                .flat_map(|choice| [&choice["properties"][step], &choice["items"]])
                .find(|choice| choice.is_object());
            schema = found.unwrap_or(&Json::Null);
        }
        schema["type"].as_str()
    }

    fn check_within(
        &self,
        schema: &Json,
        value: &mut Value,
        key: &[String],
    ) -> Result<(), Problem> {
        if schema.is_boolean() {
            return Ok(());
        }
        let refuse = |value: &Value, suggestion: Option<String>| {
            let mut problem = Problem::bad(key, value, describe(schema));
            problem.suggestion = suggestion;
            Err(problem)
        };
        let fitting: Vec<&Json> = alternatives(schema)
            .into_iter()
            .filter(|choice| has_type(choice, value))
            .collect();
        let Some(&first) = fitting.first() else {
            let is_list = |choice: &&Json| choice["items"]["type"] == "object";
            if value.is_table() && alternatives(schema).iter().any(is_list) {
                return refuse(value, Some(format!("[[{}]]", dotted(key))));
            }
            let words = alternatives(schema).into_iter().flat_map(words).next();
            let text = value.as_str().unwrap_or_default();
            let close = words.and_then(|_| nearest(text, all_words(schema)));
            return refuse(value, close.map(|word| format!("\"{word}\"")));
        };
        match value {
            Value::String(text) => {
                let words: Vec<&str> = fitting.iter().flat_map(|choice| words(choice)).collect();
                if !words.is_empty() && !words.contains(&text.as_str()) {
                    let close = nearest(text, words).map(|word| format!("\"{word}\""));
                    return refuse(value, close);
                }
                // Titles and names reach terminals.
                if text.chars().any(|one| one.is_control() && one != '\n') {
                    let allowed = "text without control characters";
                    return Err(Problem::bad(key, value, allowed));
                }
                let least = first["minLength"].as_u64().unwrap_or(0);
                if (text.trim().chars().count() as u64) < least {
                    return refuse(value, None);
                }
            }
            Value::Integer(number) if !in_range(first, *number as f64) => {
                return refuse(value, None);
            }
            Value::Float(number) => {
                let size = number.abs();
                let sane = size == 0.0 || (SMALLEST..=LARGEST).contains(&size);
                if !sane {
                    let allowed =
                        format!("numbers are 0 or have a size from {SMALLEST:e} to {LARGEST:e}");
                    return Err(Problem::bad(key, value, allowed));
                }
                if !in_range(first, *number) {
                    return refuse(value, None);
                }
                if first["type"] == "integer" {
                    *value = Value::Integer(*number as i64);
                }
            }
            Value::Array(list) => {
                let least = first["minItems"].as_u64().unwrap_or(0);
                let most = first["maxItems"].as_u64().unwrap_or(u64::MAX);
                if !(least..=most).contains(&(list.len() as u64)) {
                    return refuse(value, None);
                }
                for (index, value) in list.iter_mut().enumerate() {
                    self.check_within(
                        &first["items"],
                        value,
                        &below(key, (index + 1).to_string()),
                    )?;
                }
            }
            Value::Table(table) => {
                // Of several kinds of tables, the one that knows most of the keys; the first of
                // equals.
                let known = |choice: &&Json| {
                    let keys = choice["properties"].as_object();
                    let is_known =
                        |name: &&String| keys.is_some_and(|keys| keys.contains_key(*name));
                    table.keys().filter(is_known).count()
                };
                let best = fitting.iter().copied().rev().max_by_key(known);
                self.table(best.unwrap_or(first), table, key)?;
            }
            _ => {}
        }
        Ok(())
    }

    fn table(&self, schema: &Json, table: &mut toml::Table, key: &[String]) -> Result<(), Problem> {
        let known = schema["properties"].as_object();
        let others = &schema["additionalProperties"];
        for name in table.keys() {
            let is_known = known.is_some_and(|known| known.contains_key(name));
            if !is_known && *others == Json::Bool(false) {
                let names = || known.into_iter().flat_map(|known| known.keys());
                let allowed = names().cloned().collect();
                let close = nearest(name, names().map(String::as_str)).map(str::to_owned);
                let mut problem = Problem::new(&below(key, name), Fault::UnknownKey { allowed });
                let inside = || {
                    let path = shallowest_path(schema, name)?;
                    Some(dotted(&[key, &path[..]].concat()))
                };
                let renamed = new_name(&below(key, name)).map(str::to_owned);
                problem.suggestion =
                    (renamed.or(close).or_else(inside)).or_else(|| self.full_key_of(name));
                return Err(problem);
            }
        }
        for (name, value) in table.iter_mut() {
            let schema = known.and_then(|known| known.get(name)).unwrap_or(others);
            self.check_within(schema, value, &below(key, name))?;
        }
        let required = schema["required"].as_array().into_iter().flatten();
        for name in required.filter_map(Json::as_str) {
            if !table.contains_key(name) {
                let allowed = describe(&schema["properties"][name]);
                return Err(Problem::missing(&below(key, name), allowed));
            }
        }
        Ok(())
    }

    /// Returns the full name of the least deep key with the given last name; `None` if no table has
    /// one.
    fn full_key_of(&self, name: &str) -> Option<String> {
        let found = shallowest_path(&self.json, name)?;
        Some(match &found[..] {
            [alone] => format!("{alone}{OUTSIDE}"),
            _ => dotted(&found),
        })
    }
}

/// Returns the path of the least deep key with a given last name.
fn shallowest_path(schema: &Json, name: &str) -> Option<KeyPath> {
    /// Largest depth of a key inside tables of tables, such as those of engines and measurements.
    const DEPTH: usize = 3;
    (1..=DEPTH).find_map(|depth| path_to(schema, name, depth))
}

/// Returns a path with `depth` steps to a key of the given name, through tables and lists of
/// tables.
fn path_to(schema: &Json, name: &str, depth: usize) -> Option<KeyPath> {
    let tables = [&schema["properties"], &schema["items"]["properties"]];
    let mut inside = tables.into_iter().filter_map(Json::as_object);
    if depth == 1 {
        return inside
            .any(|keys| keys.contains_key(name))
            .then(|| vec![name.to_owned()]);
    }
    inside.flatten().find_map(|(key, below)| {
        let mut path = path_to(below, name, depth - 1)?;
        path.insert(0, key.clone());
        Some(path)
    })
}

/// Returns the JSON Schema of case files, without measurements.
pub fn schema() -> Json {
    Format::plain().json().clone()
}

/// Returns the JSON Schema of a type, without references and without null, which TOML cannot
/// express.
pub fn schema_of<T: JsonSchema>() -> Schema {
    let settings = SchemaSettings::draft2020_12().with(|all| all.inline_subschemas = true);
    let mut schema = settings.into_generator().into_root_schema_for::<T>();
    remove_null(schema.ensure_object());
    schema
}

/// Removes null from all schemas in a value.
fn without_null(schema: &mut Json) {
    match schema {
        Json::Object(keys) => remove_null(keys),
        Json::Array(items) => items.iter_mut().for_each(without_null),
        _ => {}
    }
}

/// Removes null from a schema and all schemas in it.
fn remove_null(keys: &mut serde_json::Map<String, Json>) {
    if keys.get("default").is_some_and(Json::is_null) {
        keys.remove("default");
    }
    if let Some(types) = keys.get_mut("type").and_then(Json::as_array_mut) {
        types.retain(|kind| kind != "null");
        if let [kind] = &types[..] {
            let kind = kind.clone();
            keys.insert("type".to_owned(), kind);
        }
    }
    if let Some(choices) = keys.get_mut("anyOf").and_then(Json::as_array_mut) {
        choices.retain(|choice| choice["type"] != "null");
    }
    if let Some(choices) = keys.get_mut("enum").and_then(Json::as_array_mut) {
        choices.retain(|choice| !choice.is_null());
    }
    keys.values_mut().for_each(without_null);
}

/// Returns the alternatives of a schema (`anyOf` and the like); the schema itself if there are
/// none.
fn alternatives(schema: &Json) -> Vec<&Json> {
    let listed = schema.get("anyOf").or_else(|| schema.get("oneOf"));
    match listed.and_then(Json::as_array) {
        Some(list) => list.iter().flat_map(alternatives).collect(),
        None => vec![schema],
    }
}

/// Returns true if a value has the type that a schema requires.
fn has_type(schema: &Json, value: &Value) -> bool {
    /// Largest number up to which every whole number is an exact `f64`, 2^53.
    const EXACT: f64 = 9_007_199_254_740_992.0;
    match schema["type"].as_str() {
        Some("object") => value.is_table(),
        Some("array") => value.is_array(),
        Some("string") => value.is_str(),
        Some("boolean") => value.is_bool(),
        Some("integer") => match value {
            Value::Float(number) => number.fract() == 0.0 && number.abs() <= EXACT,
            _ => value.is_integer(),
        },
        Some("number") => value.is_integer() || value.is_float(),
        _ => true,
    }
}

/// Returns the words that a schema allows; empty if it does not list words.
fn words(schema: &Json) -> Vec<&str> {
    let listed = schema["enum"].as_array().into_iter().flatten();
    let all = listed.chain(schema.get("const"));
    all.filter_map(Json::as_str).collect()
}

fn all_words(schema: &Json) -> Vec<&str> {
    alternatives(schema).into_iter().flat_map(words).collect()
}

/// Returns true if a number lies in the range that a schema allows.
fn in_range(schema: &Json, number: f64) -> bool {
    let limit = |key: &str| schema[key].as_f64();
    limit("minimum").is_none_or(|least| number >= least)
        && limit("exclusiveMinimum").is_none_or(|least| number > least)
        && limit("maximum").is_none_or(|most| number <= most)
        && limit("exclusiveMaximum").is_none_or(|most| number < most)
        && limit("const").is_none_or(|only| number == only)
}

/// Describes the values that a schema allows, with the first sentence of its description in
/// parentheses.
fn describe(schema: &Json) -> String {
    let text = schema["description"].as_str().unwrap_or_default();
    let text = text.replace('\n', " ");
    let first = text.split(". ").next().unwrap_or_default();
    let first = first.trim_end_matches('.');
    if first.is_empty() {
        allowed(schema)
    } else {
        format!("{} ({first})", allowed(schema))
    }
}

/// Describes the values that a schema allows: words, type and range.
fn allowed(schema: &Json) -> String {
    let words = all_words(schema);
    let mut parts = Vec::new();
    if !words.is_empty() {
        let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
        parts.push(quoted.join(", "));
    }
    for choice in alternatives(schema) {
        parts.push(match choice["type"].as_str() {
            Some("integer") => format!("a whole number{}", format_range(choice)),
            Some("number") => format!("a number{}", format_range(choice)),
            Some("boolean") => "true or false".to_owned(),
            Some("string") if words.is_empty() => "a text".to_owned(),
            Some("array") => list(choice),
            Some("object") => match choice["properties"].as_object() {
                Some(keys) => {
                    let keys: Vec<&str> = keys.keys().map(String::as_str).collect();
                    format!("a table with the keys {}", keys.join(", "))
                }
                None => "a table".to_owned(),
            },
            _ => continue,
        });
    }
    parts.join(", or ")
}

fn list(schema: &Json) -> String {
    let count = |key: &str| schema[key].as_u64();
    let length = match (count("minItems"), count("maxItems")) {
        (Some(least), Some(most)) if least == most => format!(" of {least}"),
        (Some(least), Some(most)) => format!(" of {least} to {most}"),
        (Some(least), None) => format!(" of at least {least}"),
        (None, Some(most)) => format!(" of at most {most}"),
        (None, None) => String::new(),
    };
    let each = allowed(&schema["items"]);
    if each.is_empty() {
        format!("a list{length}")
    } else {
        format!("a list{length}, each {each}")
    }
}

/// Formats a limit of a range with few digits.
fn format_limit(limit: f64) -> String {
    if limit != 0.0 && limit.abs() < 1e-4 {
        format!("{limit:e}")
    } else {
        format!("{limit}")
    }
}

/// Formats the range that a schema gives to a number.
fn format_range(schema: &Json) -> String {
    let limit = |key: &str| {
        let number = schema.get(key)?;
        let number = number.as_u64().map_or_else(
            || number.as_f64().map(format_limit),
            |whole| Some(whole.to_string()),
        )?;
        Some(number)
    };
    if let Some(only) = limit("const") {
        return format!(", {only}");
    }
    let least = limit("minimum");
    let above = limit("exclusiveMinimum").map(|least| format!(" above {least}"));
    let most = limit("maximum");
    let below = limit("exclusiveMaximum").map(|most| format!(" below {most}"));
    match (least, above, most, below) {
        (Some(least), _, Some(most), _) => format!(" from {least} to {most}"),
        (Some(least), _, None, None) => format!(" of at least {least}"),
        (None, Some(above), Some(most), _) => format!("{above} and at most {most}"),
        (least, above, most, below) => {
            let parts = [
                least.map(|least| format!(" of at least {least}")),
                above,
                most.map(|most| format!(" of at most {most}")),
                below,
            ];
            parts.into_iter().flatten().collect::<Vec<_>>().join(" and")
        }
    }
}

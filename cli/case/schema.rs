//! The JSON Schema of a kind of case file, and the check of a case against it.
//!
//! Types and ranges are checked against the very schema that is published, so the two cannot drift apart.
//! A general validator was not taken: it would report JSON pointers, where a reader of TOML needs the key, the
//! value and one sentence on what is allowed.

use std::sync::OnceLock;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::Value as Json;
use toml::Value;

use super::error::Problem;
use super::locate::KeyPath;
use super::nearest::nearest;
use super::written::Written;

/// The JSON Schema of one kind of case file, with descriptions, defaults and ranges.
///
/// `x-allowed` holds the sentence that an error message gives for a key.
#[derive(Debug)]
pub struct Schema {
    json: Json,
}

/// The schema of the paired case.
pub fn schema() -> Json {
    shared().json().clone()
}

/// The schema of the paired case, built once.
pub(super) fn shared() -> &'static Schema {
    static SCHEMA: OnceLock<Schema> = OnceLock::new();
    SCHEMA.get_or_init(Schema::of::<Written>)
}

/// The sentence on what is allowed for a dotted key of the paired case.
pub(super) fn sentence(dotted: &str) -> String {
    shared().sentence(dotted)
}

impl Schema {
    /// The schema of a case as it is written.
    pub fn of<W: JsonSchema>() -> Self {
        let settings = SchemaSettings::draft2020_12().with(|all| all.inline_subschemas = true);
        let mut json = settings
            .into_generator()
            .into_root_schema_for::<W>()
            .to_value();
        remove_null(&mut json);
        json["title"] = Json::from("stosszahl case");
        Self { json }
    }

    /// The schema itself.
    pub fn json(&self) -> &Json {
        &self.json
    }

    /// Checks that every key is known, has the right type and lies in its range, and that none is missing.
    pub(super) fn check(&self, table: &toml::Table) -> Result<(), Problem> {
        let value = Value::Table(table.clone());
        // A misspelt key explains a missing one, so all keys are compared first.
        self.known(&self.json, &value, &KeyPath::default())?;
        within(&self.json, &value, &KeyPath::default(), None)
    }

    /// Checks one part of a case, such as its sweeps, against its part of the schema.
    pub(super) fn check_part(&self, key: &str, value: &Value) -> Result<(), Problem> {
        within(
            &self.json["properties"][key],
            value,
            &KeyPath::of(key),
            None,
        )
    }

    /// Checks that every key is known.
    fn known(&self, schema: &Json, value: &Value, path: &KeyPath) -> Result<(), Problem> {
        let Some(schema) = alternatives(schema)
            .into_iter()
            .find(|choice| has_type(choice, value))
        else {
            return Ok(());
        };
        if let (Value::Array(list), Some(items)) = (value, schema.get("items")) {
            for (i, value) in list.iter().enumerate() {
                self.known(items, value, &path.element(i))?;
            }
        }
        if let (Value::Table(table), Some(keys)) = (value, schema["properties"].as_object()) {
            for (key, value) in table {
                let path = path.key(key);
                let Some(schema) = keys.get(key) else {
                    let allowed: Vec<String> = keys.keys().cloned().collect();
                    let close = nearest(key, keys.keys().map(String::as_str)).map(str::to_owned);
                    let suggestion = close.or_else(|| self.elsewhere(key));
                    return Err(Problem::Unknown {
                        key: path,
                        allowed,
                        suggestion,
                    });
                };
                self.known(schema, value, &path)?;
            }
        }
        Ok(())
    }

    /// The full name of a key that belongs into another table.
    fn elsewhere(&self, key: &str) -> Option<String> {
        let keys = self.json["properties"].as_object()?;
        if keys.contains_key(key) {
            return Some(format!("{key}, which stands before the first [table]"));
        }
        keys.iter()
            .find(|(_, table)| table["properties"].get(key).is_some())
            .map(|(table, _)| format!("{table}.{key}"))
    }

    /// The sentence on what is allowed for a dotted key; lists are looked into.
    pub fn sentence(&self, dotted: &str) -> String {
        let mut schema = &self.json;
        for key in dotted.split('.') {
            let inside = alternatives(schema).into_iter();
            let holder = inside
                .flat_map(|choice| [choice, &choice["items"]])
                .find(|choice| choice["properties"][key].is_object());
            schema = holder.map_or(&Json::Null, |choice| &choice["properties"][key]);
        }
        allowed(schema)
    }
}

/// Takes null out of a schema: TOML cannot write it.
fn remove_null(schema: &mut Json) {
    match schema {
        Json::Object(keys) => {
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
            keys.values_mut().for_each(remove_null);
        }
        Json::Array(items) => items.iter_mut().for_each(remove_null),
        _ => {}
    }
}

/// The alternatives of a schema; a schema without any is its own only one.
fn alternatives(schema: &Json) -> Vec<&Json> {
    let listed = schema
        .get("anyOf")
        .or_else(|| schema.get("oneOf"))
        .and_then(Json::as_array);
    listed.map_or_else(
        || vec![schema],
        |list| list.iter().flat_map(alternatives).collect(),
    )
}

/// Whether a value has the type that a schema asks for.
fn has_type(schema: &Json, value: &Value) -> bool {
    match schema["type"].as_str() {
        Some("object") => value.is_table(),
        Some("array") => value.is_array(),
        Some("string") => value.is_str(),
        Some("boolean") => value.is_bool(),
        Some("integer") => value.is_integer(),
        Some("number") => value.is_integer() || value.is_float(),
        _ => true,
    }
}

/// Checks types, ranges and missing keys. `sentence` says what is allowed around here.
fn within(
    schema: &Json,
    value: &Value,
    path: &KeyPath,
    sentence: Option<&str>,
) -> Result<(), Problem> {
    let sentence = schema["x-allowed"].as_str().or(sentence);
    let choices = alternatives(schema);
    let refuse = |suggestion: Option<String>| {
        let allowed = sentence.map_or_else(|| describe(schema), str::to_owned);
        Err(Problem::Bad {
            key: path.clone(),
            value: written(value),
            allowed,
            suggestion,
        })
    };
    let fitting: Vec<&Json> = choices
        .into_iter()
        .filter(|choice| has_type(choice, value))
        .collect();
    let Some(&first) = fitting.first() else {
        return refuse(None);
    };
    match value {
        Value::String(text) => {
            let words: Vec<&str> = fitting.iter().flat_map(|choice| words(choice)).collect();
            if !words.is_empty() && !words.contains(&text.as_str()) {
                return refuse(nearest(text, words).map(|word| format!("\"{word}\"")));
            }
            let least = schema["minLength"].as_u64().unwrap_or(0);
            if (text.trim().chars().count() as u64) < least {
                return refuse(None);
            }
        }
        Value::Integer(number) => {
            if !(in_range(schema, *number as f64) && in_range(first, *number as f64)) {
                return refuse(None);
            }
        }
        Value::Float(number) => {
            if !(number.is_finite() && in_range(schema, *number) && in_range(first, *number)) {
                return refuse(None);
            }
        }
        Value::Array(list) => {
            let least = first["minItems"].as_u64().unwrap_or(0);
            let most = first["maxItems"].as_u64().unwrap_or(u64::MAX);
            if !(least..=most).contains(&(list.len() as u64)) {
                return refuse(None);
            }
            for (i, value) in list.iter().enumerate() {
                within(&first["items"], value, &path.element(i), sentence)?;
            }
        }
        Value::Table(table) => {
            let keys = &first["properties"];
            for (key, value) in table {
                let schema = keys.get(key).unwrap_or(&first["additionalProperties"]);
                // The sentence of a table is about the table, not about its keys, unless it has no schema.
                let sentence = if keys.is_object() { None } else { sentence };
                within(schema, value, &path.key(key), sentence)?;
            }
            let required = first["required"]
                .as_array()
                .into_iter()
                .flatten()
                .filter_map(Json::as_str);
            for key in required {
                if !table.contains_key(key) {
                    return Err(Problem::Missing {
                        key: path.key(key),
                        allowed: allowed(&keys[key]),
                    });
                }
            }
        }
        Value::Boolean(_) | Value::Datetime(_) => {}
    }
    Ok(())
}

/// The words that a schema allows; none if it allows any.
fn words(schema: &Json) -> Vec<&str> {
    let listed = schema["enum"].as_array().into_iter().flatten();
    listed
        .chain(schema.get("const"))
        .filter_map(Json::as_str)
        .collect()
}

/// Whether a number lies in the range of a schema.
fn in_range(schema: &Json, number: f64) -> bool {
    let limit = |key: &str| schema[key].as_f64();
    limit("minimum").is_none_or(|least| number >= least)
        && limit("exclusiveMinimum").is_none_or(|least| number > least)
        && limit("maximum").is_none_or(|most| number <= most)
        && limit("exclusiveMaximum").is_none_or(|most| number < most)
        && limit("const").is_none_or(|only| number == only)
}

/// What a schema allows, in a sentence.
fn allowed(schema: &Json) -> String {
    schema["x-allowed"]
        .as_str()
        .map_or_else(|| describe(schema), str::to_owned)
}

/// What a schema allows where it has no sentence of its own: the keys of a table, or the description.
fn describe(schema: &Json) -> String {
    for choice in alternatives(schema) {
        if let Some(keys) = choice["properties"].as_object() {
            let keys: Vec<&str> = keys.keys().map(String::as_str).collect();
            return format!("this is a table with the keys {}", keys.join(", "));
        }
    }
    let text = schema["description"]
        .as_str()
        .unwrap_or("this key has another type");
    text.replace('\n', " ")
}

/// A value as TOML on one line, cut if it is long.
pub(crate) fn written(value: &Value) -> String {
    /// Letters of a value that are shown.
    const WIDTH: usize = 60;
    let all = inline(value, WIDTH);
    if all.chars().nth(WIDTH).is_none() {
        return all;
    }
    all.chars().take(WIDTH).chain("...".chars()).collect()
}

/// A value as TOML on one line, of which about `width` letters are wanted.
fn inline(value: &Value, width: usize) -> String {
    match value {
        Value::String(text) => {
            let start: String = text.chars().take(width).collect();
            format!("\"{}\"", start.escape_debug())
        }
        Value::Float(number) if number.is_nan() => "nan".to_owned(),
        // Rust writes 1e300 so, where the TOML writer would give three hundred zeros.
        Value::Float(number) => format!("{number:?}"),
        Value::Array(list) => {
            // An element has at least one letter, so more than these are never seen.
            let items: Vec<String> = list
                .iter()
                .take(width)
                .map(|value| inline(value, width))
                .collect();
            format!("[{}]", items.join(", "))
        }
        Value::Table(table) if table.is_empty() => "{}".to_owned(),
        Value::Table(table) => {
            let item = |(key, value): (&String, &Value)| {
                format!("{} = {}", KeyPath::default().key(key), inline(value, width))
            };
            let items: Vec<String> = table.iter().take(width).map(item).collect();
            format!("{{ {} }}", items.join(", "))
        }
        other => other.to_string(),
    }
}

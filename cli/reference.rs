//! Generated documentation pages: the keys of cases from their schema, the columns of tables from
//! the manifests of finished runs.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::results::{Manifest, Role, TableColumn};
use serde_json::Value;

/// Formats the head of a generated documentation page.
fn head(title: &str, command: &str) -> String {
    format!("# {title}\n\nThis page is made by `{command}`; a test compares it with the program.\n")
}

/// Generates the documentation page of all keys of a case, from the JSON Schema.
pub fn keys(schema: &Value) -> String {
    let mut page = head("All keys of a case", "stosszahl reference");
    page.push_str(
        "\nA key of a table in a list, such as `[[species]]`, has `[]` after the name of the list. Lengths, times and energies are in the units \
         of the case. [case-file.md](case-file.md) explains them with examples.\n",
    );
    let mut alone = Vec::new();
    let mut tables = String::new();
    for (name, one) in properties(schema) {
        let mut rows = Vec::new();
        add_rows(name, one, &mut rows);
        if rows.len() == 1 && rows[0].key == *name {
            alone.append(&mut rows);
            continue;
        }
        rows.retain(|row| row.key != *name);
        let _ = write!(tables, "\n## `{name}`\n\n{}\n", meaning(one));
        let (rows, shared) = merge_equal_tables(name, rows);
        if !shared.is_empty() {
            let names = shared.join("`, `");
            let _ = write!(tables, "\nNAME is one of `{names}`.\n");
        }
        table(&rows, &mut tables);
    }
    page.push_str("\n## At the top\n");
    table(&alone, &mut page);
    page + &tables
}

/// Generates the documentation page of the columns of all tables, from manifests of runs.
pub fn columns(manifests: &[Manifest]) -> String {
    let mut page = head("All columns of tables", "stosszahl reference FOLDER...");
    page.push_str("\n[results-folder.md](results-folder.md) says which measure writes which table, and what is common to all.\n");
    let mut tables: BTreeMap<&str, (&str, Vec<&TableColumn>)> = BTreeMap::new();
    for entry in manifests.iter().flat_map(|manifest| &manifest.tables) {
        let known = tables
            .entry(&entry.name)
            .or_insert((&entry.about, Vec::new()));
        for column in &entry.columns {
            if !known.1.contains(&column) {
                known.1.push(column);
            }
        }
    }
    for (name, (about, columns)) in tables {
        let _ = write!(
            page,
            "\n## `{name}.csv`\n\n{}.\n\n| column | unit | meaning |\n|---|---|---|\n",
            about.trim_end_matches('.')
        );
        for column in columns
            .iter()
            .filter(|column| column.role != Role::StandardError)
        {
            let errors = columns.iter().any(|one| {
                one.role == Role::StandardError && *one.name == format!("{}_se", column.name)
            });
            let also = if errors { " ±" } else { "" };
            let _ = writeln!(
                page,
                "| `{}`{also} | {} | {} |",
                column.name,
                cell(&column.unit),
                cell(&column.meaning)
            );
        }
    }
    page.push_str(
        "\n± stands for a further column, `NAME_se`, with the standard error over replicas.\n",
    );
    page
}

/// Row of the table of keys on a documentation page: the key and its allowed values.
#[derive(Clone, PartialEq)]
struct Row {
    key: String,
    allowed: String,
    default: String,
    meaning: String,
}

fn properties(schema: &Value) -> impl Iterator<Item = (&String, &Value)> {
    schema
        .get("properties")
        .and_then(Value::as_object)
        .into_iter()
        .flatten()
}

/// Returns the alternatives of a JSON Schema; the schema itself if there are none.
fn choices(schema: &Value) -> Vec<&Value> {
    let listed = ["anyOf", "oneOf"]
        .iter()
        .find_map(|name| schema.get(name)?.as_array());
    listed.map_or_else(
        || vec![schema],
        |all| all.iter().flat_map(choices).collect(),
    )
}

/// Appends the rows of a key and, recursively, of all keys below it.
fn add_rows(key: &str, schema: &Value, rows: &mut Vec<Row>) {
    let mut below = Vec::new();
    for one in choices(schema) {
        below.extend(properties(one).map(|(name, inner)| (format!("{key}.{name}"), inner)));
        let items = one.get("items").map(choices).unwrap_or_default();
        for item in items {
            below.extend(properties(item).map(|(name, inner)| (format!("{key}[].{name}"), inner)));
        }
    }
    let allowed: Vec<String> = choices(schema).into_iter().filter_map(allowed).collect();
    if !allowed.is_empty() || below.is_empty() {
        let default = schema
            .get("default")
            .filter(|value| !value.is_null() && *value != &Value::Object(serde_json::Map::new()));
        let row = Row {
            key: key.to_owned(),
            allowed: allowed.join(" or "),
            default: default.map_or_else(String::new, |value| format!("`{value}`")),
            meaning: meaning(schema),
        };
        // Several choices may have the same key.
        if !rows.contains(&row) {
            rows.push(row);
        }
    }
    for (name, inner) in below {
        add_rows(&name, inner, rows);
    }
}

/// Describes the values that a schema allows, in words; `None` for a table that is described key by
/// key.
fn allowed(schema: &Value) -> Option<String> {
    let number = |name: &str| {
        let limit = schema.get(name)?;
        // Large whole numbers in full, because floating point would round them.
        let whole = limit.as_u64().map(|whole| whole.to_string());
        let short = |number: f64| match number.abs() {
            size if size > 0.0 && size < 1e-4 => format!("{number:e}"),
            _ => number.to_string(),
        };
        whole.or_else(|| limit.as_f64().map(short))
    };
    if let Some(value) = schema.get("const") {
        return Some(format!("`{value}`"));
    }
    if let Some(values) = schema.get("enum").and_then(Value::as_array) {
        let all: Vec<String> = values.iter().map(|value| format!("`{value}`")).collect();
        return Some(all.join(", "));
    }
    let mut text = match schema.get("type")?.as_str()? {
        "integer" => "whole number".to_owned(),
        "number" => "number".to_owned(),
        "string" => "text".to_owned(),
        "boolean" => "`true` or `false`".to_owned(),
        "array" => {
            let item = schema.get("items").and_then(allowed);
            item.map_or("list".to_owned(), |item| format!("list: {item}"))
        }
        "object" if properties(schema).next().is_some() => return None,
        "object" => "table".to_owned(),
        _ => return None,
    };
    for (name, words) in [
        ("minimum", "from"),
        ("exclusiveMinimum", "above"),
        ("maximum", "to"),
        ("exclusiveMaximum", "below"),
    ] {
        if let Some(limit) = number(name) {
            let _ = write!(text, " {words} {limit}");
        }
    }
    Some(text)
}

fn meaning(schema: &Value) -> String {
    let text = |one: &Value| {
        one.get("description")
            .and_then(Value::as_str)
            .map(str::to_owned)
    };
    let own = text(schema);
    own.or_else(|| choices(schema).into_iter().find_map(text))
        .unwrap_or_default()
}

/// Merges the key tables of a section that have equal rows: they are written once, for `NAME`.
/// Returns all rows, and the merged names.
fn merge_equal_tables(section: &str, rows: Vec<Row>) -> (Vec<Row>, Vec<String>) {
    let name = |row: &Row| -> Option<String> {
        let rest = row.key.strip_prefix(section)?.strip_prefix('.')?;
        Some(rest.split_once('.')?.0.to_owned())
    };
    let neutral = |row: &Row, name: &str| Row {
        key: row.key.replacen(name, "NAME", 1),
        ..row.clone()
    };
    let mut tables: BTreeMap<String, Vec<Row>> = BTreeMap::new();
    for row in &rows {
        if let Some(name) = name(row) {
            let row = neutral(row, &name);
            tables.entry(name).or_default().push(row);
        }
    }
    let sharing = |own: &Vec<Row>| -> Vec<String> {
        let same = tables.iter().filter(|other| other.1 == own);
        same.map(|other| other.0.clone()).collect()
    };
    let shared = tables.values().map(sharing).max_by_key(Vec::len);
    let shared = shared.filter(|names| names.len() > 1).unwrap_or_default();
    let kept = rows.into_iter().filter_map(|row| {
        let place = name(&row).and_then(|name| shared.iter().position(|one| *one == name));
        match place {
            None => Some(row),
            Some(0) => Some(neutral(&row, &shared[0])),
            Some(_) => None,
        }
    });
    (kept.collect(), shared.clone())
}

/// Escapes text for a cell of a Markdown table.
fn cell(text: &str) -> String {
    let flat: Vec<&str> = text.split_whitespace().collect();
    flat.join(" ").replace('|', "\\|")
}

fn table(rows: &[Row], page: &mut String) {
    page.push_str("\n| key | allowed | default | meaning |\n|---|---|---|---|\n");
    for row in rows {
        let _ = writeln!(
            page,
            "| `{}` | {} | {} | {} |",
            row.key,
            cell(&row.allowed),
            cell(&row.default),
            cell(&row.meaning)
        );
    }
}

//! JSON Schema (draft 07, which editors of TOML know) of the files that the program reads and writes, and which files obey it.
//!
//! Only the words that these schemas use are understood; another one fails the test.

use serde_json::{Map, Value, json};

use crate::keys::{Key, Table};

/// Of one file.
pub struct Schema(Value);

impl Schema {
    /// `tables`: the first is the top of the file.
    pub fn of(file: &str, introduction: &str, tables: &[Table]) -> Schema {
        let (top, others) = tables.split_first().unwrap();
        let mut schema = object(top);
        schema["$schema"] = "http://json-schema.org/draft-07/schema#".into();
        schema["title"] = file.into();
        schema["description"] = plain(introduction).into();
        let definitions: Map<String, Value> = others.iter().map(|table| (table.id.clone(), object(table))).collect();
        assert_eq!(definitions.len(), others.len(), "two tables have one name");
        schema["definitions"] = definitions.into();
        Schema(schema)
    }

    /// As it is written to its file.
    pub fn text(&self) -> String {
        serde_json::to_string_pretty(&self.0).unwrap() + "\n"
    }

    /// What is wrong with a file, and where.
    pub fn faults_of_file(&self, file: &Value) -> Vec<String> {
        self.faults(&self.0, file)
    }

    /// What is wrong with a value of which a part of the schema speaks.
    pub fn faults(&self, part: &Value, value: &Value) -> Vec<String> {
        let mut faults = Vec::new();
        self.look(part, value, "", &mut faults);
        faults
    }

    fn look(&self, part: &Value, value: &Value, at: &str, faults: &mut Vec<String>) {
        for (word, said) in part.as_object().unwrap() {
            match word.as_str() {
                "$schema" | "title" | "description" | "definitions" | "examples" => {}
                "$ref" => {
                    let target = said.as_str().and_then(|target| self.0.pointer(target.strip_prefix('#')?));
                    self.look(target.unwrap_or_else(|| panic!("{said} is not defined")), value, at, faults);
                }
                "allOf" => said.as_array().unwrap().iter().for_each(|part| self.look(part, value, at, faults)),
                "anyOf" => {
                    let parts = said.as_array().unwrap();
                    if !parts.iter().any(|part| self.faults(part, value).is_empty()) {
                        faults.push(format!("{at}: {value} is nothing of what may stand there"));
                    }
                }
                "type" if !is_of_type(said.as_str().unwrap(), value) => {
                    faults.push(format!("{at}: {value} is no {said}"))
                }
                "enum" if !said.as_array().unwrap().contains(value) => {
                    faults.push(format!("{at}: {value} is none of {said}"));
                }
                "minimum" if value.as_f64() < said.as_f64() => {
                    faults.push(format!("{at}: {value} is less than {said}"))
                }
                "minItems" if value.as_array().is_some_and(|list| (list.len() as u64) < said.as_u64().unwrap()) => {
                    faults.push(format!("{at}: fewer than {said}"));
                }
                "maxItems" if value.as_array().is_some_and(|list| list.len() as u64 > said.as_u64().unwrap()) => {
                    faults.push(format!("{at}: more than {said}"));
                }
                "items" => {
                    for (index, item) in value.as_array().into_iter().flatten().enumerate() {
                        self.look(said, item, &format!("{at}/{index}"), faults);
                    }
                }
                "required" => {
                    let absent =
                        said.as_array().unwrap().iter().filter(|key| value.get(key.as_str().unwrap()).is_none());
                    faults.extend(absent.map(|key| format!("{at}: {key} is absent")));
                }
                "properties" => {
                    for (key, value) in value.as_object().into_iter().flatten() {
                        if let Some(part) = said.get(key) {
                            self.look(part, value, &format!("{at}/{key}"), faults);
                        }
                    }
                }
                "additionalProperties" => {
                    let known = |key: &str| part.get("properties").is_some_and(|known| known.get(key).is_some());
                    for (key, value) in value.as_object().into_iter().flatten().filter(|(key, _)| !known(key)) {
                        match said {
                            Value::Bool(_) => faults.push(format!("{at}/{key}: no such key")),
                            part => self.look(part, value, &format!("{at}/{key}"), faults),
                        }
                    }
                }
                "type" | "enum" | "minimum" | "minItems" | "maxItems" => {}
                other => panic!("a schema says {other}"),
            }
        }
    }
}

fn is_of_type(kind: &str, value: &Value) -> bool {
    match kind {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        _ => panic!("a schema says {kind}"),
    }
}

fn object(table: &Table) -> Value {
    let required: Vec<&str> = table.keys.iter().filter(|key| key.required).map(|key| key.name.as_str()).collect();
    let properties: Map<String, Value> = table.keys.iter().map(|key| (key.name.clone(), property(key))).collect();
    let mut object = json!({ "type": "object", "description": plain(&table.documentation), "properties": properties });
    if !required.is_empty() {
        object["required"] = json!(required);
    }
    if table.closed {
        object["additionalProperties"] = false.into();
    }
    object
}

/// With what an editor shows beside a key.
fn property(key: &Key) -> Value {
    let label = |label: &str, said: &str| match said {
        "" | "–" | "required" => String::new(),
        said => format!(" {label}: {said}."),
    };
    let description = format!("{}{}{}", key.meaning, label("Unit", &key.unit), label("Default", &key.default));
    // Of what stands beside a reference draft 07 takes no notice.
    let mut property =
        if key.schema.get("$ref").is_some() { json!({ "allOf": [key.schema] }) } else { key.schema.clone() };
    property["description"] = plain(&description).into();
    property
}

/// Without the targets of links.
fn plain(text: &str) -> String {
    let mut parts = text.split("](");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| {
        let opening = text.rfind('[').unwrap_or(text.len());
        let linked = text.get(opening + 1..).unwrap_or_default();
        format!("{}{linked}{}", &text[..opening], part.split_once(')').map_or("", |(_, rest)| rest))
    })
}

//! The JSON schema of a job file: editors that know TOML complete and check it with that.

use super::place::{COMMANDS, Form, GEOMETRY, Place, all_places, table_of};
use clap::Command;
use serde_json::{Map, Value, json};

/// The schema, from the options that there are.
pub fn schema(program: &Command) -> Value {
    let scalar = json!({ "type": ["string", "number", "boolean"] });
    let mut root = table("What a poropunch command line says; paths are taken from the file's directory");
    root["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    root["title"] = json!("poropunch.toml");
    for place in all_places(program) {
        let mut at = &mut root;
        let (last, tables) = place.path.split_last().expect("a place has a key");
        for (k, key) in tables.iter().enumerate() {
            at = child(at, key, || table(&heading(&tables[..=k])));
        }
        *child(at, last, || Value::Null) = field(&place, &scalar);
    }
    let geometry = json!({ "type": "object", "description": "Short for parameters.set with names geometry.*",
        "additionalProperties": scalar });
    *child(&mut root, GEOMETRY, || Value::Null) = geometry;
    root
}

fn heading(keys: &[String]) -> String {
    let command = COMMANDS.iter().find(|name| table_of(name) == keys);
    command.map_or_else(String::new, |name| format!("What belongs to `runner {name}` only"))
}

fn table(description: &str) -> Value {
    let mut table = json!({ "type": "object", "properties": Map::new(), "additionalProperties": false });
    if !description.is_empty() {
        table["description"] = json!(description);
    }
    table
}

fn child<'a>(table: &'a mut Value, key: &str, new: impl FnOnce() -> Value) -> &'a mut Value {
    let properties = &mut table["properties"];
    if properties.get(key).is_none() {
        properties[key] = new();
    }
    &mut properties[key]
}

fn field(place: &Place, scalar: &Value) -> Value {
    let file = json!({ "type": "object", "required": ["file"], "additionalProperties": false,
        "properties": { "file": { "type": "string" }, "blake3": { "type": "string" } } });
    let mut field = match place.form {
        Form::Flag => json!({ "type": "boolean" }),
        Form::Value if !place.values.is_empty() => json!({ "enum": place.values }),
        Form::Value => scalar.clone(),
        Form::List if place.is_path => {
            json!({ "type": ["string", "array"], "items": { "anyOf": [{ "type": "string" }, file] } })
        }
        Form::List => json!({ "type": ["string", "number", "array"], "items": scalar }),
        Form::Table => json!({ "type": ["object", "array"],
            "additionalProperties": { "anyOf": [scalar, { "type": "object", "additionalProperties": scalar }] },
            "items": { "type": "string" } }),
    };
    field["description"] = json!(place.help);
    field
}

//! What the TOML library reports, said in a scenario's words.

use super::{document::Document, error::Fault, suggest};
use std::ops::Range;

/// Keys that the format reserves for what this version does not do.
const RESERVED_KEYS: [&str; 6] = ["interfaces", "target_angle", "valence_limit", "quantity_error", "goal", "engine"];

/// Values that the format reserves likewise, each with what to use today.
const RESERVED_VALUES: [(&str, &str); 2] = [("hex", "tet"), ("fixed-trisection", "fixed")];

/// How to write `expect.<name>.tolerance`.
const TOLERANCE: &str = "for example tolerance = { relative = 0.01 } or { absolute = 1e-3 }";

/// How to write the table that asks for a key.
const EXAMPLES: [(&[&str], &str); 8] = [
    (&["youngs_modulus", "poissons_ratio"], "youngs_modulus = 210e9, poissons_ratio = 0.3"),
    (&["normal", "offset"], "plane = { normal = [0, 1, 0], offset = -10 }"),
    (&["min", "max"], "box = { min = [0, 0, 0], max = [1, 1, 1] }"),
    (&["center"], "sphere = { center = [0, 0, 0], radius = 1 }"),
    (&["point", "axis", "radius"], "cylinder = { point = [0, 0, 0], axis = [0, 0, 1], radius = 1 }"),
    (&["direction", "angle"], "normal = { direction = [0, 0, 1], angle = 5 }"),
    (&["size", "cells"], "box = { size = [4, 1, 1], cells = [8, 2, 2] }"),
    (
        &["source", "steps", "label", "cells", "milliseconds", "error"],
        "source = \"...\", steps = [{ label = \"base\", cells = 2799, milliseconds = 491, error = 0.08 }]",
    ),
];

/// The fault behind an error of the typed stage.
pub(super) fn fault(error: &toml::de::Error, document: &Document<'_>) -> Fault {
    let span = error.span().unwrap_or(0..0);
    let message = error.message();
    let words: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let key = document.key(&span).unwrap_or_default();
    match (message, &words[..]) {
        (m, [given, accepted @ ..]) if m.starts_with("unknown field") => unknown_key(span, &key, given, accepted),
        (m, [given, accepted @ ..]) if m.starts_with("unknown variant") => unknown_value(span, &key, given, accepted),
        (m, [name, ..]) if m.starts_with("missing field") => missing(span, &key, name),
        (m, _) if m.starts_with("invalid") || m.starts_with("wanted") => wrong_type(span, &key, m),
        _ => Fault::new(span, format!("is not valid: {message}"), "here"),
    }
}

fn unknown_key(span: Range<usize>, key: &str, given: &str, accepted: &[&str]) -> Fault {
    let table = match key.rsplit_once('.') {
        Some((table, _)) => format!("`{table}`"),
        None => "a scenario".to_owned(),
    };
    let help = suggest::help(given, "its keys", accepted);
    if RESERVED_KEYS.contains(&given) {
        return Fault::new(span, "is not available in this version", "not available").help(help);
    }
    Fault::new(span, format!("is not a key of {table}"), "unknown key").help(help)
}

fn unknown_value(span: Range<usize>, key: &str, given: &str, accepted: &[&str]) -> Fault {
    let help = suggest::help(given, "available", accepted);
    let help = if last(key) == "fix" { format!("{help}; for example fix = [\"x\", \"y\", \"z\"]") } else { help };
    match RESERVED_VALUES.iter().find(|(value, instead)| *value == given && accepted.contains(instead)) {
        Some((_, instead)) => {
            let problem = format!("is {given:?}, which is not available in this version: use {instead:?}");
            Fault::new(span, problem, "not available").help(help)
        }
        None => Fault::new(span, format!("is {given:?}, which is not one of its values"), "unknown value").help(help),
    }
}

fn missing(span: Range<usize>, key: &str, name: &str) -> Fault {
    let fault = Fault::new(span, format!("lacks `{name}`"), format!("`{name}` is missing here"));
    // `cells` is a key of two tables.
    let fits = |example: &str| key.starts_with("published") == example.starts_with("source");
    match EXAMPLES.iter().find(|(names, example)| names.contains(&name) && fits(example)) {
        Some((_, example)) => fault.help(format!("for example {example}")),
        None => fault,
    }
}

fn wrong_type(span: Range<usize>, key: &str, message: &str) -> Fault {
    // "invalid type: string "a", expected i64"
    let (got, expected) = match message.rsplit_once(", expected ") {
        Some((got, expected)) => (got.split_once(": ").map_or(got, |(_, got)| got), expected),
        None => ("another type", "string"),
    };
    let (got, expected) = (plain(got), plain(expected));
    let fault = Fault::new(span, format!("must be {expected}, but is {got}"), format!("expected {expected}"));
    match key.split_once('.') {
        Some(("supports", _)) if last(key) == "displacement" => {
            fault.help("for example displacement = { z = 1.0 }: directions that are left out stay free")
        }
        Some(("expect", _)) if last(key) == "tolerance" => fault.help(TOLERANCE),
        Some((group @ ("materials" | "supports" | "loads" | "quantities" | "probes" | "expect"), name))
            if expected == "a table" && !name.contains('.') =>
        {
            fault.help(format!("each of the {group} has a table of its own: write [{group}.<name>] above its keys"))
        }
        _ => fault,
    }
}

/// The last name of a key, without the index in an array.
fn last(key: &str) -> &str {
    let name = key.rsplit_once('.').map_or(key, |(_, name)| name);
    name.split_once('[').map_or(name, |(name, _)| name)
}

/// TOML's word for a type of Rust or serde.
fn plain(name: &str) -> String {
    match name {
        "f64" => "a number".to_owned(),
        "i64" => "an integer".to_owned(),
        "u32" => "an integer from 0".to_owned(),
        "string" | "a string" | "string or table" => "a string".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a sequence" | "sequence" => "an array".to_owned(),
        "map" | "a map" => "a table".to_owned(),
        "another type" => "of another type".to_owned(),
        _ => {
            let number = name.strip_prefix("floating point ").or_else(|| name.strip_prefix("integer "));
            let value = number.or_else(|| name.strip_prefix("boolean ")).map(|v| v.replace('`', ""));
            value.unwrap_or_else(|| match name.strip_prefix("string ") {
                Some(text) => format!("the string {text}"),
                None => name.to_owned(),
            })
        }
    }
}

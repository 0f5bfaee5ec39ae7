//! Numbers that may be expressions in x, y and z.

use super::error::Fault;
use super::numbers::{Checked, outside};
use super::spanned::Spanned;
use super::suggest;
use crate::field::{Expression, Field, NAMES, VectorField};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, de};
use std::{fmt, ops::Range};

/// A number, or the text of an expression.
#[derive(Debug, JsonSchema)]
#[schemars(untagged)]
pub(super) enum RawField {
    Number(f64),
    Text(String),
}

impl<'de> Deserialize<'de> for RawField {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FieldVisitor)
    }
}

struct FieldVisitor;

impl de::Visitor<'_> for FieldVisitor {
    type Value = RawField;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or an expression such as \"2*x\"")
    }

    fn visit_f64<E>(self, value: f64) -> Result<RawField, E> {
        Ok(RawField::Number(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<RawField, E> {
        Ok(RawField::Number(value as f64))
    }

    fn visit_str<E>(self, text: &str) -> Result<RawField, E> {
        Ok(RawField::Text(text.to_owned()))
    }
}

/// A scalar field as written.
pub(super) type Scalar = Spanned<RawField>;
/// Three of them, once checked.
pub(super) type Vector = Spanned<Vec<Scalar>>;

/// A finite number, or an expression. Whether that is finite where it is needed shows on the mesh.
pub(super) fn field(raw: &Scalar) -> Checked<Field> {
    let field = match raw.get_ref() {
        RawField::Number(value) => Field::Constant(*value),
        RawField::Text(text) => Expression::parse(text)
            .map_err(|error| {
                let span = inside(&raw.span(), text, &error.span);
                let fault = Fault::new(span, format!("is no expression: {}", error.problem), "here");
                match &error.unknown {
                    Some(name) => fault.help(suggest::help(name, "an expression may name", &NAMES)),
                    None => fault.help("for example \"1e3*sin(pi*x)\" or \"-9.81*(z - 2)^2\""),
                }
            })?
            .into(),
    };
    match field.constant() {
        Some(value) if !value.is_finite() => Err(outside(raw.span(), &value, "finite")),
        _ => Ok(field),
    }
}

/// Three fields.
pub(super) fn vector_field(raw: &Vector) -> Checked<VectorField> {
    match &raw.get_ref()[..] {
        [x, y, z] => Ok(VectorField([field(x)?, field(y)?, field(z)?])),
        given => Err(Fault::new(raw.span(), format!("has {} components, but must have 3", given.len()), "x, y, z")),
    }
}

/// The place of a part of a string in the document; the whole string if escapes make places differ.
fn inside(string: &Range<usize>, text: &str, part: &Range<usize>) -> Range<usize> {
    let plain = string.len() == text.len() + 2 && !part.is_empty();
    if plain { string.start + 1 + part.start..string.start + 1 + part.end } else { string.clone() }
}

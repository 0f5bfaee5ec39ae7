//! Fields over space that a scenario prescribes: numbers, expressions in x, y and z, or functions of known solutions.

mod expression;
mod parse;

pub use expression::Expression;
pub use parse::{NAMES, ParseError};

use glam::DVec3;
use std::fmt;
use std::sync::Arc;

/// A scalar field.
#[derive(Debug, Clone, PartialEq)]
pub enum Field {
    /// The same number everywhere.
    Constant(f64),
    /// An expression of the position.
    Expression(Expression),
    /// A function that the program brings.
    Function(Function),
}

/// A function of the position with a name that people read. Functions of one name are the same.
#[derive(Clone)]
pub struct Function {
    name: String,
    at: Arc<dyn Fn(DVec3) -> f64 + Send + Sync>,
}

impl Function {
    /// Names a function.
    pub fn new(name: &str, at: impl Fn(DVec3) -> f64 + Send + Sync + 'static) -> Self {
        Self { name: name.to_owned(), at: Arc::new(at) }
    }
}

impl fmt::Debug for Function {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

impl PartialEq for Function {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Field {
    /// Zero everywhere.
    pub const ZERO: Self = Self::Constant(0.0);

    /// Its value at a position; NaN or infinite where an expression is not defined.
    #[must_use]
    pub fn at(&self, x: DVec3) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Expression(expression) => expression.at(x),
            Self::Function(function) => (function.at)(x),
        }
    }

    /// Its value, if it is the same everywhere.
    #[must_use]
    pub fn constant(&self) -> Option<f64> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Expression(_) | Self::Function(_) => None,
        }
    }
}

impl From<f64> for Field {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}

impl From<Expression> for Field {
    /// An expression without x, y and z is a number.
    fn from(expression: Expression) -> Self {
        if expression.is_constant() { Self::Constant(expression.at(DVec3::ZERO)) } else { Self::Expression(expression) }
    }
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Constant(value) => write!(f, "{value}"),
            Self::Expression(expression) => write!(f, "{expression}"),
            Self::Function(function) => f.write_str(&function.name),
        }
    }
}

impl serde::Serialize for Field {
    /// A number, the text of an expression, or the name of a function.
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Constant(value) => serializer.serialize_f64(*value),
            Self::Expression(_) | Self::Function(_) => serializer.collect_str(self),
        }
    }
}

/// A vector field, by components.
#[derive(Debug, Clone, PartialEq)]
pub struct VectorField(pub [Field; 3]);

impl VectorField {
    /// Its value at a position.
    #[must_use]
    pub fn at(&self, x: DVec3) -> DVec3 {
        let [fx, fy, fz] = &self.0;
        DVec3::new(fx.at(x), fy.at(x), fz.at(x))
    }

    /// Its value, if it is the same everywhere.
    #[must_use]
    pub fn constant(&self) -> Option<DVec3> {
        let [x, y, z] = &self.0;
        Some(DVec3::new(x.constant()?, y.constant()?, z.constant()?))
    }
}

impl From<DVec3> for VectorField {
    fn from(v: DVec3) -> Self {
        Self(v.to_array().map(Field::Constant))
    }
}

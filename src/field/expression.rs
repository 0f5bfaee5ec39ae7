//! Expressions in x, y and z, kept in postfix order: evaluation is a loop over a small stack.

use super::parse::{self, ParseError};
use glam::DVec3;
use smallvec::SmallVec;
use std::fmt;

/// A function of two numbers.
pub(super) type Binary = fn(f64, f64) -> f64;

/// A step of an evaluation.
#[derive(Debug, Clone, Copy)]
pub(super) enum Op {
    Number(f64),
    /// 0, 1, 2 for x, y, z.
    Coordinate(usize),
    Unary(fn(f64) -> f64),
    Binary(Binary),
}

/// An expression such as `1e3*sin(pi*x)`, parsed once.
///
/// It has numbers, `x`, `y`, `z`, `pi`, `e`, the operators `+ - * / ^` and functions ([`super::NAMES`]), with the
/// precedence of mathematics: `-x^2` is `-(x^2)`, and `2^3^2` is `2^(3^2)`.
#[derive(Clone)]
pub struct Expression {
    text: String,
    /// Postfix; each operation finds its operands on the stack.
    ops: Vec<Op>,
}

impl Expression {
    /// Parses a text.
    ///
    /// # Errors
    /// [`ParseError`] with the place in the text.
    pub fn parse(text: &str) -> Result<Self, ParseError> {
        Ok(Self { text: text.to_owned(), ops: parse::parse(text)? })
    }

    /// Its value at a position; NaN or infinite where it is not defined.
    #[must_use]
    pub fn at(&self, x: DVec3) -> f64 {
        let mut stack: SmallVec<[f64; 16]> = SmallVec::new();
        // The parser leaves two operands for each binary operation and one for each unary one.
        let pop = |stack: &mut SmallVec<[f64; 16]>| stack.pop().unwrap_or(f64::NAN);
        for op in &self.ops {
            let value = match *op {
                Op::Number(value) => value,
                Op::Coordinate(c) => x[c],
                Op::Unary(f) => f(pop(&mut stack)),
                Op::Binary(f) => {
                    let (right, left) = (pop(&mut stack), pop(&mut stack));
                    f(left, right)
                }
            };
            stack.push(value);
        }
        pop(&mut stack)
    }

    /// Whether it names none of x, y, z.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        !self.ops.iter().any(|op| matches!(op, Op::Coordinate(_)))
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl fmt::Debug for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.text)
    }
}

impl PartialEq for Expression {
    /// The same text: equal functions may still be written in different ways.
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn value(text: &str) -> f64 {
        Expression::parse(text).unwrap_or_else(|e| panic!("{text}: {e}")).at(DVec3::new(3.0, 2.0, 0.5))
    }

    #[test]
    fn precedence_is_that_of_mathematics() {
        for (text, expected) in [
            ("-x^2", -9.0),
            ("2^3^2", 512.0),
            ("2^-x", 0.125),
            ("2^-y^2", 0.0625),
            ("2*-x^2", -18.0),
            ("2 - -x^2", 11.0),
            ("12/x/y", 2.0),
            ("1-x-2", -4.0),
            ("x-2*y", -1.0),
            ("(x-2)*y", 2.0),
            ("--x", 3.0),
            ("+x", 3.0),
            ("1e3*sin(pi*z)", 1e3),
            ("1.5E-3 + .5 + 5.", 5.5015),
            ("max(x, min(y, 7))", 3.0),
            ("atan2(0, -1)", std::f64::consts::PI),
            ("ln(e^x)", 3.0),
            ("sqrt(x*x)^y", 9.0),
            ("abs(-x) + sign(-y)", 2.0),
        ] {
            assert!((value(text) - expected).abs() < 1e-12, "{text} = {}, not {expected}", value(text));
        }
    }

    #[test]
    fn what_is_not_an_expression_is_refused_where_it_is_wrong() {
        for (text, at) in [
            ("", 0..0),
            ("  ", 2..2),
            ("2x", 1..2),
            ("x y", 2..3),
            ("x**2", 2..3),
            ("sin x", 4..5),
            ("sin", 3..3),
            ("1e", 1..2),
            ("1..2", 2..4),
            ("(x", 2..2),
            ("x)", 1..2),
            ("max(x)", 5..6),
            ("sin(x, y)", 5..6),
            ("x + ü", 4..6),
            ("x(2)", 1..2),
            ("foo(x)", 0..3),
            ("1 + r", 4..5),
            ("x,y", 1..2),
        ] {
            let error = Expression::parse(text).expect_err(text);
            assert_eq!(error.span, at, "{text}: {error}");
        }
        assert_eq!(Expression::parse("sine(x)").unwrap_err().unknown.as_deref(), Some("sine"));
    }

    #[test]
    fn a_deep_expression_is_refused_and_a_long_one_is_not() {
        let deep = "(".repeat(100_000) + "x" + &")".repeat(100_000);
        assert!(Expression::parse(&deep).unwrap_err().to_string().contains("nested"));
        assert!(Expression::parse(&("-".repeat(100_000) + "x")).is_err());
        assert!(Expression::parse(&("2^".repeat(100_000) + "x")).is_err());
        assert_eq!(value(&("x+".repeat(10_000) + "x")), 30_003.0);
    }

    proptest! {
        #[test]
        fn any_text_is_parsed_or_refused_at_a_place_of_its_own(text in "[-+*/^(),.0-9a-z ü]{0,20}") {
            if let Err(error) = Expression::parse(&text) {
                prop_assert!(text.get(error.span.clone()).is_some(), "{:?}", error);
            }
        }

        #[test]
        fn a_polynomial_has_its_values(a in -9.0..9.0_f64, b in -9.0..9.0_f64, x in -2.0..2.0_f64) {
            let e = Expression::parse(&format!("{a}*x^3 - {b}*x*y + z/2")).unwrap();
            let expected = a * x.powi(3) - b * x * 0.7 + 0.1;
            prop_assert!((e.at(DVec3::new(x, 0.7, 0.2)) - expected).abs() < 1e-12);
        }
    }
}

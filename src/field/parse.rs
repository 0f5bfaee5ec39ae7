//! From the text of an expression to postfix operations, by precedence climbing.

use super::expression::{Binary, Op};
use std::ops::Range;

/// Why a text is no expression.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{problem}")]
pub struct ParseError {
    /// Bytes of the text.
    pub span: Range<usize>,
    /// What is wrong, such as "`)` is missing".
    pub problem: String,
    /// The name that is not one of [`NAMES`], if that is the fault.
    pub unknown: Option<String>,
}

/// Everything that an expression may name.
pub const NAMES: [&str; 25] = [
    "x", "y", "z", "pi", "e", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "ln",
    "log10", "sqrt", "abs", "sign", "floor", "atan2", "hypot", "min", "max",
];

/// Parentheses, signs and powers inside each other: far more than anybody writes, far less than the stack holds.
const MAX_DEPTH: usize = 100;

/// Binding strengths, from weak to strong: sum, product, sign, power.
const SUM: u8 = 1;
const PRODUCT: u8 = 2;
const SIGN: u8 = 3;
const POWER: u8 = 4;

/// The postfix operations of a text.
pub(super) fn parse(text: &str) -> Result<Vec<Op>, ParseError> {
    let mut parser = Parser { text, at: 0, depth: 0, ops: Vec::new() };
    parser.expression(SUM)?;
    match parser.peek() {
        None => Ok(parser.ops),
        Some(')') => Err(parser.here("this `)` closes nothing")),
        Some(_) => Err(parser.here("an operator (+ - * / ^) is missing before this")),
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    ops: Vec<Op>,
}

impl Parser<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    /// The next character that is no space.
    fn peek(&mut self) -> Option<char> {
        self.at += self.rest().len() - self.rest().trim_start().len();
        self.rest().chars().next()
    }

    /// Takes the character if it is the next one.
    fn take(&mut self, c: char) -> bool {
        let found = self.peek() == Some(c);
        if found {
            self.at += c.len_utf8();
        }
        found
    }

    /// The longest start of the rest whose characters are wanted.
    fn word(&self, wanted: impl Fn(char) -> bool) -> &str {
        let rest = self.rest();
        &rest[..rest.find(|c| !wanted(c)).unwrap_or(rest.len())]
    }

    /// A fault at what comes next: a number or name, a character, or the end.
    fn here(&mut self, problem: &str) -> ParseError {
        let first = self.peek().map_or(0, char::len_utf8);
        let length = self.word(|c| c.is_ascii_alphanumeric() || c == '.').len().max(first);
        ParseError { span: self.at..self.at + length, problem: problem.to_owned(), unknown: None }
    }

    /// An expression of operators that bind at least as strongly as `least`.
    fn expression(&mut self, least: u8) -> Result<(), ParseError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(self.here(&format!("it is nested more than {MAX_DEPTH} deep")));
        }
        self.operand()?;
        while let Some((strength, f)) = self.peek().and_then(operator).filter(|(strength, _)| *strength >= least) {
            self.at += 1;
            // Powers group from the right, the others from the left.
            self.expression(if strength == POWER { SIGN } else { strength + 1 })?;
            self.ops.push(Op::Binary(f));
        }
        self.depth -= 1;
        Ok(())
    }

    fn operand(&mut self) -> Result<(), ParseError> {
        match self.peek() {
            Some('+') => {
                self.at += 1;
                self.expression(SIGN)
            }
            Some('-') => {
                self.at += 1;
                self.expression(SIGN)?;
                self.ops.push(Op::Unary(|x| -x));
                Ok(())
            }
            Some('(') => {
                self.at += 1;
                self.expression(SUM)?;
                self.close()
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() || c == '_' => self.name(),
            None => Err(self.here("it ends where a number, a name or `(` is needed")),
            Some(_) => Err(self.here("here a number, a name or `(` is needed")),
        }
    }

    fn close(&mut self) -> Result<(), ParseError> {
        if self.take(')') { Ok(()) } else { Err(self.here("`)` is missing here")) }
    }

    fn number(&mut self) -> Result<(), ParseError> {
        let digits = |c: char| c.is_ascii_digit();
        let start = self.at;
        self.at += self.word(digits).len();
        if self.rest().starts_with('.') {
            self.at += 1;
            self.at += self.word(digits).len();
        }
        if let Some(exponent) = self.rest().strip_prefix(['e', 'E']) {
            let unsigned = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
            let length = unsigned.find(|c: char| !c.is_ascii_digit()).unwrap_or(unsigned.len());
            if length > 0 {
                self.at += 1 + exponent.len() - unsigned.len() + length;
            }
        }
        let value = self.text[start..self.at].parse();
        let fault = ParseError { span: start..self.at, problem: "this is no number".to_owned(), unknown: None };
        self.ops.push(Op::Number(value.map_err(|_| fault)?));
        Ok(())
    }

    fn name(&mut self) -> Result<(), ParseError> {
        let start = self.at;
        let name = self.word(|c| c.is_ascii_alphanumeric() || c == '_').to_owned();
        self.at += name.len();
        if let Some(value) = value(&name) {
            self.ops.push(value);
            return Ok(());
        }
        let Some((function, arguments)) = function(&name) else {
            let problem = format!("`{name}` is unknown");
            return Err(ParseError { span: start..self.at, problem, unknown: Some(name) });
        };
        if !self.take('(') {
            return Err(self.here(&format!("`(` is missing after `{name}`")));
        }
        for argument in 0..arguments {
            if argument > 0 && !self.take(',') {
                return Err(self.here(&format!("`{name}` takes {arguments} numbers: `,` is missing")));
            }
            self.expression(SUM)?;
        }
        if self.peek() == Some(',') {
            let plural = if arguments == 1 { "number" } else { "numbers" };
            return Err(self.here(&format!("`{name}` takes {arguments} {plural}")));
        }
        self.ops.push(function);
        self.close()
    }
}

/// An infix operator and its strength.
fn operator(c: char) -> Option<(u8, Binary)> {
    Some(match c {
        '+' => (SUM, |a, b| a + b),
        '-' => (SUM, |a, b| a - b),
        '*' => (PRODUCT, |a, b| a * b),
        '/' => (PRODUCT, |a, b| a / b),
        '^' => (POWER, f64::powf),
        _ => return None,
    })
}

/// A coordinate or a constant.
fn value(name: &str) -> Option<Op> {
    Some(match name {
        "x" => Op::Coordinate(0),
        "y" => Op::Coordinate(1),
        "z" => Op::Coordinate(2),
        "pi" => Op::Number(std::f64::consts::PI),
        "e" => Op::Number(std::f64::consts::E),
        _ => return None,
    })
}

/// A function and the number of its arguments.
fn function(name: &str) -> Option<(Op, usize)> {
    let unary: fn(f64) -> f64 = match name {
        "sin" => f64::sin,
        "cos" => f64::cos,
        "tan" => f64::tan,
        "asin" => f64::asin,
        "acos" => f64::acos,
        "atan" => f64::atan,
        "sinh" => f64::sinh,
        "cosh" => f64::cosh,
        "tanh" => f64::tanh,
        "exp" => f64::exp,
        "ln" => f64::ln,
        "log10" => f64::log10,
        "sqrt" => f64::sqrt,
        "abs" => f64::abs,
        "sign" => |x| if x == 0.0 { 0.0 } else { x.signum() },
        "floor" => f64::floor,
        _ => {
            let binary: Binary = match name {
                "atan2" => f64::atan2,
                "hypot" => f64::hypot,
                // Unlike f64::min, these hide no NaN.
                "min" => |a, b| if a < b || a.is_nan() { a } else { b },
                "max" => |a, b| if a > b || a.is_nan() { a } else { b },
                _ => return None,
            };
            return Some((Op::Binary(binary), 2));
        }
    };
    Some((Op::Unary(unary), 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_in_the_list_is_known() {
        assert!(NAMES.iter().all(|name| value(name).is_some() || function(name).is_some()));
    }
}

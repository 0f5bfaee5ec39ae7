//! Ranges of numbers.

use super::error::Fault;
use super::raw::{Integer, Number, Vector};
use glam::DVec3;
use std::ops::{Range, RangeInclusive};

pub(super) type Checked<T> = Result<T, Fault>;

/// A number that is neither NaN nor infinite.
pub(super) fn finite(x: &Number) -> Checked<f64> {
    within(x, "finite", f64::is_finite)
}

/// A positive finite number.
pub(super) fn positive(x: &Number) -> Checked<f64> {
    within(x, "a positive finite number", |x| x.is_finite() && x > 0.0)
}

/// A finite number that is not negative.
pub(super) fn not_negative(x: &Number) -> Checked<f64> {
    within(x, "a finite number from 0", |x| x.is_finite() && x >= 0.0)
}

/// A number that satisfies `allowed`, which `range` describes.
pub(super) fn within(x: &Number, range: &str, allowed: impl Fn(f64) -> bool) -> Checked<f64> {
    let value = *x.get_ref();
    if allowed(value) { Ok(value) } else { Err(outside(x.span(), &value, range)) }
}

/// An integer in a range.
pub(super) fn integer(x: &Integer, range: RangeInclusive<i64>) -> Checked<usize> {
    let value = *x.get_ref();
    let limits = match *range.end() {
        i64::MAX => format!("an integer from {}", range.start()),
        end => format!("an integer from {} to {end}", range.start()),
    };
    let inside = usize::try_from(value).ok().filter(|_| range.contains(&value));
    inside.ok_or_else(|| outside(x.span(), &value, &limits))
}

/// A fault that says what a value is and what it has to be.
pub(super) fn outside(span: Range<usize>, value: &impl std::fmt::Display, range: &str) -> Fault {
    Fault::new(span, format!("is {value}, but must be {range}"), format!("must be {range}"))
}

/// Three finite numbers.
pub(super) fn vector(v: &Vector) -> Checked<DVec3> {
    let values = v.get_ref();
    let [x, y, z] = values[..] else {
        return Err(Fault::new(v.span(), format!("has {} numbers, but must have 3", values.len()), "x, y, z"));
    };
    let vector = DVec3::new(x, y, z);
    if vector.is_finite() { Ok(vector) } else { Err(outside(v.span(), &format!("{values:?}"), "finite")) }
}

/// Three finite numbers that are not all zero.
pub(super) fn direction(v: &Vector) -> Checked<DVec3> {
    let vector = vector(v)?;
    if vector.length() > 0.0 { Ok(vector) } else { Err(outside(v.span(), &"zero", "a direction, not all zero")) }
}

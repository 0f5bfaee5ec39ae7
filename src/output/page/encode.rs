//! Numbers as compressed text: codes of 16 bits, differences, planes of bytes, deflate, base64.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::DeflateEncoder;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::io::{self, Write as _};

/// The code of a value that is not known; the largest value has the code before.
const UNKNOWN: u16 = u16::MAX;

/// How an array is found among the bytes of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Section {
    name: Cow<'static, str>,
    /// `q16` (codes of values), `u32` or `u8`.
    kind: Cow<'static, str>,
    /// Entries of an array, `width` numbers each.
    rows: usize,
    width: usize,
    /// The values of the codes 0 and 65534, of each component.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    limits: Vec<[f64; 2]>,
}

/// The arrays of a step.
#[derive(Debug, Default)]
pub(super) struct Sections {
    pub list: Vec<Section>,
    bytes: Vec<u8>,
}

impl Sections {
    /// Values, given row by row, each component between limits of its own.
    pub(super) fn values(&mut self, name: &'static str, width: usize, values: &[f64]) {
        let of = |c: usize| values.iter().skip(c).step_by(width).copied();
        let mut limits = Vec::new();
        for c in 0..width {
            let known = of(c).filter(|x| x.is_finite());
            let (lo, hi) = known.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)));
            let [lo, hi] = if lo <= hi { [lo, hi] } else { [0.0, 0.0] };
            let codes: Vec<u16> = of(c).map(|x| code(x, lo, hi)).collect();
            let differences = || codes.iter().scan(0_u16, |last, x| Some(x.wrapping_sub(std::mem::replace(last, *x))));
            self.bytes.extend(differences().map(|d| d as u8));
            self.bytes.extend(differences().map(|d| (d >> 8) as u8));
            limits.push([lo, hi]);
        }
        self.list.push(Section {
            name: name.into(),
            kind: "q16".into(),
            rows: values.len() / width.max(1),
            width,
            limits,
        });
    }

    /// Indices, given row by row.
    pub(super) fn indices(&mut self, name: &'static str, width: usize, indices: &[u32]) {
        for c in 0..width {
            let of = indices.iter().skip(c).step_by(width);
            let differences: Vec<u32> = of
                .scan(0_u32, |last, x| {
                    let d = x.wrapping_sub(std::mem::replace(last, *x)).cast_signed();
                    Some(((d << 1) ^ (d >> 31)).cast_unsigned())
                })
                .collect();
            for byte in 0..4 {
                self.bytes.extend(differences.iter().map(|d| (d >> (8 * byte)) as u8));
            }
        }
        self.list.push(Section {
            name: name.into(),
            kind: "u32".into(),
            rows: indices.len() / width.max(1),
            width,
            limits: Vec::new(),
        });
    }

    pub(super) fn bytes(&mut self, name: &'static str, bytes: &[u8]) {
        self.bytes.extend(bytes);
        self.list.push(Section {
            name: name.into(),
            kind: "u8".into(),
            rows: bytes.len(),
            width: 1,
            limits: Vec::new(),
        });
    }

    /// All arrays, compressed, as text.
    pub(super) fn text(&self) -> io::Result<String> {
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(&self.bytes)?;
        Ok(STANDARD.encode(encoder.finish()?))
    }
}

fn code(x: f64, lo: f64, hi: f64) -> u16 {
    let most = f64::from(UNKNOWN - 1);
    match x {
        x if !x.is_finite() => UNKNOWN,
        _ if hi == lo => 0,
        // Halves first, as the difference of the limits may overflow.
        x => ((x / 2.0 - lo / 2.0) / (hi / 2.0 - lo / 2.0) * most).round() as u16,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_nearest_and_mark_what_is_not_known() {
        assert_eq!([-1.0, 3.0, 1.0, f64::NAN].map(|x| code(x, -1.0, 3.0)), [0, 65534, 32767, 65535]);
        assert_eq!(code(2.0, 2.0, 2.0), 0);
        let (lo, hi) = (-0.3, 1.7);
        for i in 0..1000 {
            let x = lo + (hi - lo) * f64::from(i) / 999.0;
            let back = lo + (hi - lo) * f64::from(code(x, lo, hi)) / 65534.0;
            assert!((back - x).abs() <= (hi - lo) / 65534.0 / 2.0 * (1.0 + 1e-9));
        }
    }

    #[test]
    fn differences_run_along_a_component() {
        let mut sections = Sections::default();
        sections.indices("faces", 2, &[5, 9, 3, 700]);
        // Zigzag of 5, -2, then of 9, 691; four planes of bytes each.
        assert_eq!(sections.bytes, [10, 3, 0, 0, 0, 0, 0, 0, 18, 102, 0, 5, 0, 0, 0, 0]);
    }
}

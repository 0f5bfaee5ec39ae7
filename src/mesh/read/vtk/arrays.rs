//! Numbers of the types that VTK files hold.

/// A type of number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Type {
    kind: Kind,
    /// Bytes of a number.
    pub(super) size: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Signed,
    Unsigned,
    Float,
}

impl Type {
    /// The type of a name of either format; `None` for bits and strings.
    pub(super) fn named(name: &str) -> Option<Self> {
        use Kind::{Float, Signed, Unsigned};
        let (kind, size) = match name.to_ascii_lowercase().as_str() {
            "char" | "signed_char" | "vtktypeint8" | "int8" => (Signed, 1),
            "unsigned_char" | "vtktypeuint8" | "uint8" => (Unsigned, 1),
            "short" | "vtktypeint16" | "int16" => (Signed, 2),
            "unsigned_short" | "vtktypeuint16" | "uint16" => (Unsigned, 2),
            // Legacy files write ids with 32 bits.
            "int" | "vtkidtype" | "vtktypeint32" | "int32" => (Signed, 4),
            "unsigned_int" | "vtktypeuint32" | "uint32" => (Unsigned, 4),
            "long" | "vtktypeint64" | "int64" => (Signed, 8),
            "unsigned_long" | "vtktypeuint64" | "uint64" => (Unsigned, 8),
            "float" | "vtktypefloat32" | "float32" => (Float, 4),
            "double" | "vtktypefloat64" | "float64" => (Float, 8),
            _ => return None,
        };
        Some(Self { kind, size })
    }

    /// The numbers of a binary array; a rest that is no whole number is left out. Whole numbers are exact below 2^53.
    pub(super) fn numbers(self, bytes: &[u8], big_endian: bool) -> Vec<f64> {
        let number = |bytes: &[u8]| {
            let mut little = [0; 8];
            for (i, byte) in little.iter_mut().take(self.size).enumerate() {
                *byte = bytes[if big_endian { self.size - 1 - i } else { i }];
            }
            let word = u64::from_le_bytes(little);
            let unused = 64 - 8 * self.size as u32;
            match self.kind {
                Kind::Unsigned => word as f64,
                Kind::Signed => (((word << unused) as i64) >> unused) as f64,
                Kind::Float if self.size == 4 => f64::from(f32::from_bits(word as u32)),
                Kind::Float => f64::from_bits(word),
            }
        };
        bytes.chunks_exact(self.size).map(number).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_in_both_orders_of_bytes() {
        let check = |name: &str, little: &[u8], big: &[u8], value: f64| {
            let kind = Type::named(name).unwrap();
            assert_eq!((kind.numbers(little, false), kind.numbers(big, true)), (vec![value], vec![value]), "{name}");
        };
        check("Int8", &(-3_i8).to_le_bytes(), &(-3_i8).to_be_bytes(), -3.0);
        check("unsigned_short", &65_000_u16.to_le_bytes(), &65_000_u16.to_be_bytes(), 65_000.0);
        check("int", &(-70_000_i32).to_le_bytes(), &(-70_000_i32).to_be_bytes(), -70_000.0);
        check("vtktypeint64", &(-5_000_000_000_i64).to_le_bytes(), &(-5_000_000_000_i64).to_be_bytes(), -5e9);
        check("float", &0.1_f32.to_le_bytes(), &0.1_f32.to_be_bytes(), f64::from(0.1_f32));
        check("Float64", &0.1_f64.to_le_bytes(), &0.1_f64.to_be_bytes(), 0.1);
    }
}

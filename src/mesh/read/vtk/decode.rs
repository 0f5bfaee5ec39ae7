//! The bytes of arrays in XML files: raw or in base64, in compressed blocks or not.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use std::io::Read;

/// How a file compresses its arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compressor {
    None,
    Zlib,
    Lz4,
}

/// How a file encodes its arrays.
#[derive(Debug, Clone, Copy)]
pub(super) struct Encoding {
    pub(super) big_endian: bool,
    /// Bytes of a number of the header before each array, 4 or 8.
    pub(super) header_bytes: usize,
    pub(super) compressor: Compressor,
}

/// Bytes to be taken from the front.
pub(super) struct Encoded<'a> {
    rest: &'a [u8],
    /// Whether they are in base64, and what of it is decoded but not taken.
    base64: bool,
    decoded: Vec<u8>,
}

/// Larger blocks than so many times their compressed size cannot come of either method.
const LARGEST_RATIO: usize = 1100;

/// More bytes than nothing takes when it is compressed.
const EMPTY: usize = 16;

const CUT_OFF: &str = "the array is cut off";

impl<'a> Encoded<'a> {
    pub(super) fn new(bytes: &'a [u8], base64: bool) -> Self {
        Self { rest: bytes, base64, decoded: Vec::new() }
    }

    fn take(&mut self, count: usize) -> Result<Vec<u8>, String> {
        if !self.base64 {
            let taken = self.rest.get(..count).ok_or(CUT_OFF)?;
            self.rest = &self.rest[count..];
            return Ok(taken.to_vec());
        }
        while self.decoded.len() < count {
            if self.rest.len() < 4 {
                return Err(CUT_OFF.to_owned());
            }
            // Header and data may be encoded one by one: signs of padding end a piece.
            let wanted = (count - self.decoded.len()).div_ceil(3).saturating_mul(4).min(self.rest.len() / 4 * 4);
            let piece = self.rest[..wanted].iter().position(|&c| c == b'=').map_or(wanted, |i| i / 4 * 4 + 4);
            let bytes =
                BASE64_STANDARD.decode(&self.rest[..piece]).map_err(|e| format!("its base64 is damaged: {e}"))?;
            self.decoded.extend(bytes);
            self.rest = &self.rest[piece..];
        }
        let rest = self.decoded.split_off(count);
        Ok(std::mem::replace(&mut self.decoded, rest))
    }

    /// A number of the header.
    fn size(&mut self, encoding: Encoding) -> Result<usize, String> {
        let mut bytes = self.take(encoding.header_bytes)?;
        if encoding.big_endian {
            bytes.reverse();
        }
        let size = bytes.iter().rev().fold(0_u64, |size, &byte| size << 8 | u64::from(byte));
        usize::try_from(size).map_err(|_| CUT_OFF.to_owned())
    }

    /// The bytes of an array: its size and its bytes, or the sizes of its compressed blocks and the blocks.
    pub(super) fn array(&mut self, encoding: Encoding) -> Result<Vec<u8>, String> {
        let first = self.size(encoding)?;
        if encoding.compressor == Compressor::None {
            return self.take(first);
        }
        let (block, last) = (self.size(encoding)?, self.size(encoding)?);
        if first > self.rest.len() {
            return Err(CUT_OFF.to_owned());
        }
        let sizes = (0..first).map(|_| self.size(encoding)).collect::<Result<Vec<_>, _>>()?;
        let damaged = |i: usize| format!("block {i} cannot be decompressed");
        let mut bytes = Vec::new();
        for (i, size) in sizes.into_iter().enumerate() {
            let is_last = i + 1 == first;
            let whole = if is_last && last > 0 { last } else { block };
            // Of an array that fills its blocks some writers add a block of nothing.
            if is_last && last == 0 && size < EMPTY {
                let piece = self.take(size)?;
                if decompress(&piece, 0, encoding.compressor).is_none() {
                    let whole = whole.min(LARGEST_RATIO * EMPTY);
                    bytes.extend(decompress(&piece, whole, encoding.compressor).ok_or_else(|| damaged(i))?);
                }
                continue;
            }
            if whole > LARGEST_RATIO.saturating_mul(size).saturating_add(1000) {
                return Err(format!("block {i} of {size} bytes cannot hold {whole} bytes"));
            }
            let decompressed = decompress(&self.take(size)?, whole, encoding.compressor);
            bytes.extend(decompressed.ok_or_else(|| damaged(i))?);
        }
        Ok(bytes)
    }
}

fn decompress(bytes: &[u8], size: usize, compressor: Compressor) -> Option<Vec<u8>> {
    let mut out = Vec::new();
    match compressor {
        Compressor::None => return None,
        Compressor::Lz4 => out = lz4_flex::block::decompress(bytes, size).ok()?,
        // One byte more than announced tells a wrong size.
        Compressor::Zlib => {
            let decoder = flate2::read::ZlibDecoder::new(bytes);
            decoder.take(size as u64 + 1).read_to_end(&mut out).ok()?;
        }
    }
    (out.len() == size).then_some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    /// An array of 64 bytes in blocks of 32, with one more block of nothing or without.
    fn array(compressor: Compressor, empty: bool) -> Vec<u8> {
        let compress = |bytes: &[u8]| match compressor {
            Compressor::Zlib => {
                let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
                encoder.write_all(bytes).unwrap();
                encoder.finish().unwrap()
            }
            _ => lz4_flex::block::compress(bytes),
        };
        let mut blocks = vec![compress(&[7; 32]), compress(&[8; 32])];
        blocks.extend(empty.then(|| compress(&[])));
        let header = [blocks.len() as u32, 32, 0].into_iter().chain(blocks.iter().map(|b| b.len() as u32));
        header.flat_map(u32::to_le_bytes).chain(blocks.concat()).collect()
    }

    #[test]
    fn an_array_that_fills_its_blocks_may_end_with_nothing() {
        for compressor in [Compressor::Zlib, Compressor::Lz4] {
            let encoding = Encoding { big_endian: false, header_bytes: 4, compressor };
            for empty in [false, true] {
                let bytes = array(compressor, empty);
                let read = Encoded::new(&bytes, false).array(encoding).unwrap();
                assert_eq!(read, [[7; 32], [8; 32]].concat(), "{compressor:?}, {empty}");
            }
        }
    }
}

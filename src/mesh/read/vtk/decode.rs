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
        let mut bytes = Vec::new();
        for (i, size) in sizes.into_iter().enumerate() {
            let whole = if i + 1 == first && last > 0 { last } else { block };
            if whole > LARGEST_RATIO.saturating_mul(size).saturating_add(1000) {
                return Err(format!("block {i} of {size} bytes cannot hold {whole} bytes"));
            }
            let decompressed = decompress(&self.take(size)?, whole, encoding.compressor);
            bytes.extend(decompressed.ok_or_else(|| format!("block {i} cannot be decompressed"))?);
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

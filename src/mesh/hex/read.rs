//! Hexahedra from files.

pub use crate::mesh::read::hexes::{HexFile, read, read_with};

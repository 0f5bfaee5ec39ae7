//! The commands for smooth tetrahedral/octahedral subdivision.

mod subdivide;

pub use subdivide::{TetOctReport, TetOctSubdivision, subdivide_tet_oct};

//! The commands for smooth tetrahedral/octahedral subdivision.

mod deform;
mod moves;
mod page;
mod smoothness;
mod subdivide;

pub use deform::{DeformError, DeformReport, deform};
pub use smoothness::{EdgeRecord, FaceRecord, FailedVertex, Smoothness, SmoothnessReport, VertexRecord, smoothness};
pub(super) use subdivide::check_count;
pub use subdivide::{TetOctReport, TetOctSubdivision, subdivide_tet_oct};

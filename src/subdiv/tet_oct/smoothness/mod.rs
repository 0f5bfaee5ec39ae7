//! How smooth the limit of subdivision is: appendix A of Schaefer, Hakenberg and Warren (2004), by machine.
//!
//! Inside a tetrahedron of the control mesh the mesh becomes uniform, and split and smoothing together are the linear split
//! convolved with itself: the limit is twice continuously differentiable. Around faces, edges and vertices the mesh looks the same at
//! all scales; the matrices that take control values around such a place to those at half the scale decide how smooth the limit is
//! there (Levin and Levin 2003, Reif 1995).

mod edge;
mod face;
mod map;
mod reference;
mod spectrum;
mod spheres;
mod vertex;

pub use edge::{EdgeAnalysis, analyse_edge};
pub use face::{FaceAnalysis, Patch, analyse_face};
pub use map::{Annulus, CharacteristicMap};
pub use spheres::{Sphere, random_sphere, spheres};
pub use vertex::{VertexAnalysis, analyse_vertex};

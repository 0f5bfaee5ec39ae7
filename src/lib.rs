//! Subsolid: finite-element simulation of linear-elastic solids represented by subdivision.
//!
//! One mesh is the model, the analysis mesh and the picture. Data flows one way: scenario, mesh, elements, error
//! estimate, subdivision, mesh again, output. Each stage is a function from values to values.

pub mod adapt;
pub mod error;
pub mod fem;
pub mod field;
pub mod limit;
pub mod mesh;
pub mod output;
pub mod pipeline;
pub mod scenario;
pub mod subdiv;

pub use error::Error;

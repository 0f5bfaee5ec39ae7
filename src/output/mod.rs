//! What people and other programs read: VTK files, reports, tables, plots.
//!
//! Sees meshes, and fields as plain slices. Every file is written through [`atomic::write_atomic`]; the same values give
//! the same bytes.

pub mod atomic;
pub mod book;
pub mod compare;
pub mod csv;
pub mod elements;
mod error;
mod field_data;
pub mod frames;
mod hex_cells;
pub mod hex_mesh;
pub mod hex_vtk;
pub mod options;
pub mod page;
pub mod picture;
pub mod plot;
pub mod progress;
pub mod pvd;
pub mod report;
pub mod shape;
pub mod table;
pub mod variants;
pub mod vtk;

pub use error::OutputError;

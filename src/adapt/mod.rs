//! Where to refine: a solution in, an error per cell, then a selection of cells out. Knows no splitting.

mod error;
mod estimate;
mod grow;
mod hessians;
mod mark;
pub mod options;

pub use error::AdaptError;
pub use estimate::{CellErrors, Recovered, estimate};
pub use grow::grow;
pub use mark::{mark, mark_values};

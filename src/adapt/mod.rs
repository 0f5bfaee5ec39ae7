//! Where to refine: a solution in, an error per cell, then a selection of cells out. Knows no splitting.

pub mod options;

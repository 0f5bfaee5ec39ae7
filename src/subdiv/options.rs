//! Choices of the subdivision schemes, plain data.

use serde::{Deserialize, Serialize};

/// How cells are refined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// Tetrahedral sqrt(3) subdivision, Burkhart, Hamann and Umlauf 2010.
    Sqrt3,
    /// One cell into eight, the inner octahedron cut along its shortest diagonal; all cells at once.
    Red,
}

/// What happens to the boundary surface (scheme sqrt(3) only; red refinement always keeps it).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Boundary {
    /// The polyhedral surface is kept exactly; boundary edges are halved.
    Fixed,
    /// The surface is smoothed by Kobbelt's rule for triangular sqrt(3) subdivision; creases and corners stay.
    Approximating,
}

/// Parameters of [`super::refine`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// The scheme.
    pub scheme: Scheme,
    /// The boundary rule.
    pub boundary: Boundary,
    /// Passes of interior optimisation (edge removal and smoothing) in each step; the paper's scheme needs at least 1.
    pub passes: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { scheme: Scheme::Sqrt3, boundary: Boundary::Fixed, passes: 3 }
    }
}

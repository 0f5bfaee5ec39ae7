//! Choices of estimation and marking, plain data.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the error is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Estimator {
    /// Superconvergent patch recovery, Zienkiewicz and Zhu 1992.
    Spr,
    /// Volume-weighted averaging of the stress at each vertex.
    Averaging,
}

/// Which cells are selected.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Marking {
    /// The smallest set that holds this fraction of the squared error (Doerfler).
    Doerfler(f64),
    /// Cells whose error is at least this fraction of the largest.
    Maximum(f64),
    /// This fraction of the cells, the worst.
    Fraction(f64),
    /// Cells whose error (energy norm) is above this value.
    Threshold(f64),
    /// The worst, so many that the tolerance that is asked for is forecast to be reached in the least time; at most those
    /// that hold this fraction of the squared error.
    LookAhead(f64),
}

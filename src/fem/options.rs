//! Choices of the solvers, plain data.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the linear system is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Direct for small systems, else conjugate gradients; direct again where these converge slowly, as long as its
    /// memory forecast stays below [`SolverOptions::direct_memory_limit`].
    Auto,
    /// Sparse Cholesky with a nested-dissection ordering.
    Direct,
    /// Conjugate gradients, preconditioned on two levels: 3x3 diagonal blocks, and rigid motions of aggregates of nodes.
    Cg,
}

/// Parameters of [`super::solve`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolverOptions {
    /// The method.
    pub method: Method,
    /// Bound on the true residual |b - K u| / |b|.
    pub tolerance: f64,
    /// Bytes that the Cholesky factor may take under [`Method::Auto`].
    pub direct_memory_limit: u64,
}

impl Default for SolverOptions {
    fn default() -> Self {
        Self { method: Method::Auto, tolerance: 1e-8, direct_memory_limit: 2 << 30 }
    }
}

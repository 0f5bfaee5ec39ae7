//! Elements compared: what each gives for what it costs.

use super::table::{count, short};
use serde::Serialize;

/// One element on one mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElementRow {
    /// The element's word in scenarios.
    pub element: String,
    /// Refinement step.
    pub step: usize,
    /// Cells.
    pub cells: usize,
    /// Degrees of freedom not prescribed by supports.
    pub free_dofs: usize,
    /// Numbers stored in the matrix of these.
    pub nonzeros: usize,
    /// Distinct tables of functions.
    pub tables: usize,
    /// Largest length of the displacement.
    pub max_displacement: f64,
    /// Work of the loads.
    pub compliance: f64,
    /// Estimated relative error in the energy norm.
    pub relative_error: f64,
    /// The true one, where an exact solution is given.
    pub true_relative_error: Option<f64>,
    /// Largest over smallest eigenvalue of the matrix.
    pub condition: f64,
    /// That of the matrix scaled to a unit diagonal.
    pub scaled_condition: f64,
    /// Iterations of plain conjugate gradients to a relative residual of 1e-8.
    pub iterations: usize,
    /// Those with the diagonal as preconditioner.
    pub scaled_iterations: usize,
    /// Wall time of assembly.
    pub assemble_seconds: f64,
    /// Wall time of the program's own solver.
    pub solve_seconds: f64,
    /// Wall time of refinement, assembly, solution and estimate on this mesh.
    pub seconds: f64,
    /// Values of the quantities asked for.
    #[serde(serialize_with = "super::report::as_map")]
    pub quantities: Vec<(String, f64)>,
}

/// A comparison of elements: `compare.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Elements {
    /// All rows, by element and step.
    pub rows: Vec<ElementRow>,
}

/// What a curve shows: its name, and the number.
type Measure = (&'static str, fn(&ElementRow) -> f64);

/// What is drawn against [`COSTS`].
pub const RESULTS: [Measure; 4] = [
    ("largest displacement", |r| r.max_displacement),
    ("compliance", |r| r.compliance),
    ("condition number", |r| r.condition),
    ("CG iterations", |r| r.iterations as f64),
];

/// What it is drawn against.
pub const COSTS: [Measure; 4] = [
    ("unknowns", |r| r.free_dofs as f64),
    ("cells", |r| r.cells as f64),
    ("nonzeros", |r| r.nonzeros as f64),
    ("seconds", |r| r.seconds),
];

/// The cells of the table of a comparison, with its heads.
#[must_use]
pub fn table(rows: &[ElementRow]) -> (Vec<&'static str>, Vec<Vec<String>>) {
    let known = rows.iter().any(|r| r.true_relative_error.is_some());
    let error = if known { "true error %" } else { "est. error %" };
    let heads = vec!["element", "cells", "unknowns", "max disp.", "compliance", error, "condition", "CG", "s"];
    let row = |r: &ElementRow| {
        vec![
            r.element.clone(),
            count(r.cells),
            count(r.free_dofs),
            short(r.max_displacement, 5),
            short(r.compliance, 6),
            short(100.0 * r.true_relative_error.unwrap_or(r.relative_error), 3),
            format!("{:.1e}", r.condition),
            count(r.iterations),
            short(r.seconds, 2),
        ]
    };
    (heads, rows.iter().map(row).collect())
}

//! Choices of the output and figures to print beside its own, plain data.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the arrays of VTK files are compressed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Compression {
    /// Not at all.
    None,
    /// LZ4: faster to write than no compression, because less is written.
    #[default]
    Lz4,
    /// Zlib: smaller files, slower.
    Zlib,
}

/// The cells that show hexahedral elements in VTK files.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum HexCells {
    /// Lagrange cells of the elements' degree: points hold the fields' values.
    #[default]
    Lagrange,
    /// Bezier cells where Catmull-Clark elements are polynomials, Lagrange cells elsewhere: points of Bezier cells hold
    /// coefficients.
    Bezier,
    /// Linear cells, as many a direction as the elements' degree, for programs that know no others.
    Linear,
}

/// A field of the solution in VTK files, by its name there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FieldName {
    /// At points.
    Displacement,
    /// At points the recovered one, in cells that of the element.
    Stress,
    /// In cells.
    VonMises,
    /// In cells.
    ErrorIndicator,
    /// In cells: those selected for the next step.
    Marked,
}

impl FieldName {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Displacement, Self::Stress, Self::VonMises, Self::ErrorIndicator, Self::Marked];
}

/// Figures from a publication, printed beside ours.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// Where they are from.
    pub source: String,
    /// One entry a mesh.
    pub steps: Vec<PublishedStep>,
}

/// A published simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct PublishedStep {
    /// The row of ours it is printed beside: `base`, `adaptive 1`, `global 1`, ...
    pub label: String,
    /// Cells of the mesh.
    pub cells: usize,
    /// Computation time.
    pub milliseconds: f64,
    /// Average normalised error.
    pub error: f64,
}

/// What the numbers of a scenario are meant in, as declared: echoed beside results, never converted.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Units {
    /// Of lengths and displacements.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<String>,
    /// Of forces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<String>,
    /// Of stresses, moduli and tractions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stress: Option<String>,
    /// Of energies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<String>,
    /// Of masses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<String>,
    /// Of times, in accelerations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
}

impl Units {
    /// The declared ones with what they measure.
    #[must_use]
    pub fn declared(&self) -> Vec<(&'static str, &str)> {
        let Self { length, force, stress, energy, mass, time } = self;
        let all = [
            ("length", length),
            ("force", force),
            ("stress", stress),
            ("energy", energy),
            ("mass", mass),
            ("time", time),
        ];
        all.into_iter().filter_map(|(name, unit)| Some((name, unit.as_deref()?))).collect()
    }

    /// Whether none is declared.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.declared().is_empty()
    }
}

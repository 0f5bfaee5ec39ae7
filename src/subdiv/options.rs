//! Choices of the subdivision schemes, plain data.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How cells are refined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// Tetrahedral sqrt(3) subdivision, Burkhart, Hamann and Umlauf 2010.
    Sqrt3,
    /// One cell into eight, the inner octahedron cut along its shortest diagonal; all cells at once.
    Red,
    /// Longest-edge bisection, Rivara and Levin 1992: a step cuts each selected cell in two at its longest edge, and the
    /// cells that must be cut with it. Of all cells it makes twice as many on a regular mesh, and more on others.
    LongestEdge,
}

/// Which masks a Catmull-Clark solid has inside. They agree where four cells meet at each edge.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CatmullClark {
    /// Multilinear splitting and averaging, Bajaj, Schaefer, Warren and Xu 2002.
    #[default]
    Bajaj,
    /// As printed in Burkhart, Hamann and Umlauf 2011, after Joy and MacCracken 1996. Along edges where other than four cells
    /// meet, the rules of its edges and vertices do not agree: a straight prism does not stay uniform along its axis.
    Printed,
}

/// Analysis on the solid that smooth tetrahedral/octahedral subdivision makes of the mesh, which is its control mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Smooth {
    /// Steps of subdivision.
    pub steps: usize,
    /// How its octahedra are cut.
    pub octahedra: Octahedra,
    /// What the unknowns are.
    pub basis: SmoothBasis,
}

/// How octahedra are cut into four-node cells.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Octahedra {
    /// Into four around the shortest diagonal.
    #[default]
    Diagonal,
    /// Into eight around the centroid.
    Centroid,
}

/// What the unknowns of an analysis on a smooth solid are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SmoothBasis {
    /// Displacements of the control points: smooth functions, by Galerkin's method.
    #[default]
    Control,
    /// Displacements of all nodes of the subdivided mesh.
    Nodes,
}

/// What happens to the boundary and to the interfaces between regions (scheme sqrt(3) only; the others always keep them).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Boundary {
    /// The polyhedral surface is kept; boundary edges are halved. (In [`Mode::Best`] vertices slide on parts that are flat
    /// to 3e-4 radians, so tilts that rounding in a mesh file has made are evened out.)
    Fixed,
    /// The surface is smoothed by Kobbelt's rule for triangular sqrt(3) subdivision; creases and corners stay.
    Approximating,
    /// The surface is refined smoothly through all its vertices by the rule of Labsik and Greiner 2000; creases and corners
    /// stay.
    Interpolating,
}

/// With which operations a refined mesh is optimised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// Those of the paper: edge removal and smoothing of interior vertices.
    Paper,
    /// All there are, towards the [`Objective`].
    Best,
}

/// What the operations of [`Mode::Paper`] call a good cell (Burkhart, Hamann and Umlauf 2010, section 2.3). All grow with
/// the quality.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum QualityMeasure {
    /// The smallest sine of the dihedral angles: small for angles near 0 and near 180 degrees.
    #[default]
    MinSine,
    /// The smallest dihedral angle.
    MinDihedral,
    /// The smallest solid angle.
    MinSolidAngle,
    /// The shortest over the longest edge; blind to flat cells with edges of like length.
    EdgeRatio,
}

/// What optimisation in [`Mode::Best`] is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Objective {
    /// Large dihedral angles: for meshes as such.
    Quality,
    /// A small interpolation error of the displacement: for analysis.
    Error,
}

/// Target angle in degrees of the repair before an error-driven stage.
const REPAIR_ANGLE: f64 = 28.0;

/// Cells whose smallest angle is below this are repaired at any price, in degrees: before an error-driven stage, which keeps
/// cells above the same angle, and so many degrees below the target elsewhere.
const REPAIR_BELOW_ERROR: f64 = 15.0;
const REPAIR_BELOW_TARGET: f64 = 5.0;

/// Parameters of the optimisation of a refined mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optimise {
    /// The operations.
    pub mode: Mode,
    /// What they are for (in [`Mode::Best`]; the paper's operations are for the angles).
    pub objective: Objective,
    /// Whether [`Objective::Error`] looks at the directions of the second derivatives.
    pub directions: bool,
    /// What a good cell is to the paper's operations (in [`Mode::Paper`]; the others have measures of their own).
    pub measure: QualityMeasure,
    /// Passes at most.
    pub passes: usize,
    /// Dihedral angle in degrees up to which [`Objective::Quality`] improves a cell: those with no smaller sine than
    /// that of this angle are left alone.
    pub target_angle: f64,
    /// Most cells at a vertex that [`Objective::Quality`] puts up with, where it can help it.
    pub valence_limit: usize,
}

impl Optimise {
    /// The run of all operations for the dihedral angles that a step ends with, if it has one ([`Mode::Best`]).
    ///
    /// Before an error-driven stage it is a short one: that stage keeps the worst angle but does not raise it, and
    /// without repair angles sink and valences grow from step to step. It aims no higher than the `typical` smallest angle,
    /// in degrees, of the cells before the step: where cells are flat because the part is thin, larger angles cost vertices that
    /// stand across its thickness, and with them the accuracy.
    pub(crate) fn quality_run(&self, typical: impl FnOnce() -> f64) -> Option<Self> {
        match (self.mode, self.objective) {
            (Mode::Paper, _) => None,
            (Mode::Best, Objective::Quality) => Some(*self),
            (Mode::Best, Objective::Error) => {
                let target_angle = self.target_angle.min(REPAIR_ANGLE).min(typical());
                Some(Self { target_angle, passes: self.passes.min(2), ..*self })
            }
        }
    }

    /// Angle in degrees below which a cell is repaired at any price. Repairs are dear: adaptive runs with
    /// [`Objective::Error`] took twice as long where they aimed at 23 degrees, for the same error.
    pub(crate) fn repair_angle(&self) -> f64 {
        match self.objective {
            Objective::Quality => self.target_angle - REPAIR_BELOW_TARGET,
            Objective::Error => self.target_angle.min(REPAIR_BELOW_ERROR),
        }
    }

    /// True if the last stage of a step lowers the weighted interpolation error. It needs weights, so it is the caller's:
    /// [`super::optimise_error`].
    #[must_use]
    pub fn ends_in_error(&self) -> bool {
        self.mode == Mode::Best && self.objective == Objective::Error
    }
}

impl Default for Optimise {
    fn default() -> Self {
        Self {
            mode: Mode::Paper,
            objective: Objective::Quality,
            directions: true,
            measure: QualityMeasure::MinSine,
            passes: 3,
            target_angle: 32.0,
            valence_limit: 50,
        }
    }
}

/// Parameters of [`super::refine`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// The scheme.
    pub scheme: Scheme,
    /// The boundary rule.
    pub boundary: Boundary,
    /// How the refined mesh is optimised.
    pub optimise: Optimise,
    /// Whether to keep the mesh after each stage of the step, in [`super::Refined::frames`].
    pub frames: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { scheme: Scheme::Sqrt3, boundary: Boundary::Fixed, optimise: Optimise::default(), frames: false }
    }
}

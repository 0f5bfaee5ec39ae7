//! Choices of the solvers and of what is asked of a solution, plain data.

use crate::subdiv::options::CatmullClark;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The finite element.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Element {
    /// Tetrahedra with linear displacements between their vertices.
    Tet4,
    /// Tetrahedra with quadratic displacements between their vertices and the midpoints of their edges.
    #[default]
    Tet10,
}

impl Element {
    /// Its word in scenarios.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Tet4 => "tet4",
            Self::Tet10 => "tet10",
        }
    }
}

/// The finite element of a hexahedral mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HexElement {
    /// Trilinear, eight nodes.
    Hex8,
    /// Serendipity, twenty nodes.
    Hex20,
    /// Triquadratic, twenty-seven nodes.
    Hex27,
    /// The mesh is the control mesh of a Catmull-Clark solid, whose basis functions are the element's.
    CatmullClark,
    /// As before, with bubbles that lift the natural end condition at the boundary.
    CatmullClarkPlus,
}

impl HexElement {
    /// Its word in scenarios.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Hex8 => "hex8",
            Self::Hex20 => "hex20",
            Self::Hex27 => "hex27",
            Self::CatmullClark => "catmull-clark",
            Self::CatmullClarkPlus => "catmull-clark+",
        }
    }

    /// Whether it has nodes on edges.
    #[must_use]
    pub fn has_edge_nodes(self) -> bool {
        matches!(self, Self::Hex20 | Self::Hex27)
    }

    /// Whether its mesh is the control mesh of a Catmull-Clark solid.
    #[must_use]
    pub fn is_smooth(self) -> bool {
        matches!(self, Self::CatmullClark | Self::CatmullClarkPlus)
    }
}

/// How hexahedral elements are made and integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HexOptions {
    /// The masks of a Catmull-Clark solid.
    pub masks: CatmullClark,
    /// Gauss points a direction of the stiffness; what suits the element if absent.
    pub points: Option<usize>,
    /// How often cells near extraordinary edges, where functions are no polynomials, are halved for quadrature.
    pub splits: u32,
}

impl Default for HexOptions {
    fn default() -> Self {
        Self { masks: CatmullClark::default(), points: None, splits: 1 }
    }
}

/// How the linear system is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Direct for small systems, else conjugate gradients; direct again where these converge slowly or end above the tolerance,
    /// as long as its memory forecast stays below [`SolverOptions::direct_memory_limit`].
    Auto,
    /// Sparse Cholesky with a nested-dissection ordering.
    Direct,
    /// Conjugate gradients, preconditioned by smoothed-aggregation multigrid on the rigid motions.
    AmgCg,
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

/// A scalar field of a solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Field {
    /// Displacement along x.
    Ux,
    /// Displacement along y.
    Uy,
    /// Displacement along z.
    Uz,
    /// Length of the displacement.
    Displacement,
    /// Stress component XX.
    Sxx,
    /// Stress component YY.
    Syy,
    /// Stress component ZZ.
    Szz,
    /// Stress component XY.
    Sxy,
    /// Stress component YZ.
    Syz,
    /// Stress component XZ.
    Sxz,
    /// Von Mises' equivalent stress.
    VonMises,
}

impl Field {
    /// Whether it is a field of the stress, not of the displacement.
    #[must_use]
    pub fn is_stress(self) -> bool {
        !matches!(self, Self::Ux | Self::Uy | Self::Uz | Self::Displacement)
    }
}

/// What can be summed up over cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Total {
    /// Integral of half stress times strain.
    StrainEnergy,
    /// Volume.
    Volume,
    /// Integral of the density.
    Mass,
}

/// A known solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ExactSolution {
    /// On the unit cube with sliding sides, u = (sin px cos py cos pz, -2 cos px sin py cos pz, cos px cos py sin pz) with
    /// p = pi, under the body force 3 pi^2 mu u.
    SmoothCube,
    /// An eighth of a sphere of radii 1 and 2 under an inner pressure of 1 (Lame).
    LameSphere,
    /// A quarter of a plate of half edge 4 with a hole of radius 1, in plane strain, its outer sides under the tractions of
    /// an infinite plate in tension 1 along x (Kirsch).
    Kirsch,
    /// The L-prism in plane strain with the displacement of its opening mode, r^0.5445 at the re-entrant edge, whose faces
    /// are free (Williams).
    LPrism,
    /// u = (x^2 + 2xy - z^2, y^2 - xz + 3yz, xy + z^2 - 2x^2) on any body: ten-node cells represent it.
    QuadraticPatch,
    /// A quarter of a tube of radii 1 and 2 under an inner pressure of 1, in plane strain (Lame).
    LameCylinder,
    /// A beam of length 8 and height 2 in plane strain with the resultant 1 of a parabolic shear traction at its end x = 8
    /// (Timoshenko and Goodier).
    Timoshenko,
}

//! Why supports, loads and materials do not fit a mesh.

use crate::fem::FemError;
use crate::mesh::MeshError;
use glam::DVec3;

/// Why a scenario and its mesh do not make a well-posed model.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ModelError {
    /// Cells without a material.
    #[error("no material for {regions}")]
    #[diagnostic(help("{help}"))]
    NoMaterial {
        /// The regions with their numbers of cells.
        regions: String,
        /// What to add.
        help: String,
    },
    /// A material for a region that does not exist.
    #[error("{place}: material `{material}` fills region `{region}`, which the mesh does not have")]
    #[diagnostic(help("{help}"))]
    UnknownRegion {
        /// Where the material is written.
        place: String,
        /// Its name.
        material: String,
        /// The region it asks for.
        region: String,
        /// The regions there are.
        help: String,
    },
    /// Nothing holds the body.
    #[error(
        "the scenario has no supports: the body is free to move along x, y and z and to turn about x, y and z \
         (six free motions)"
    )]
    #[diagnostic(help("add a support, for example\n[supports.clamp]\ngroup = \"x-min\"\nfix = [\"x\", \"y\", \"z\"]"))]
    NoSupports,
    /// A selector names a group that does not exist.
    #[error("{place}: {what} acts on group `{group}`, which the mesh does not have")]
    #[diagnostic(help("{help}"))]
    UnknownGroup {
        /// Where the support or load is written.
        place: String,
        /// The support or load.
        what: String,
        /// The group it asks for.
        group: String,
        /// The groups there are.
        help: String,
    },
    /// A selector matches no boundary face.
    #[error("{place}: the selector of {what} matches no boundary face")]
    #[diagnostic(help("{help}"))]
    EmptySelection {
        /// Where the support or load is written.
        place: String,
        /// The support or load.
        what: String,
        /// How far it misses, and what there is.
        help: String,
    },
    /// The faces of two selectors share no vertex.
    #[error("{place}: {what} holds where faces meet, but these share no vertex")]
    #[diagnostic(help("`meet` takes two selectors of faces that are neighbours, such as two sides of a box"))]
    NoEdge {
        /// Where the support is written.
        place: String,
        /// The support.
        what: String,
    },
    /// A sliding support is not on a plane that a coordinate axis is normal to.
    #[error("{place}: {what} slides in the plane of its faces, but {problem}")]
    #[diagnostic(help("{help}"))]
    NotSliding {
        /// Where the support is written.
        place: String,
        /// The support.
        what: String,
        /// What its faces are like.
        problem: String,
        /// What to do.
        help: &'static str,
    },
    /// A support of tetrahedra is to hold in the mean.
    #[error("{place}: {what} holds in the mean (weak = true), which is for hexahedra")]
    #[diagnostic(help("leave `weak` out: tetrahedra are held at their nodes"))]
    Weak {
        /// Where the support is written.
        place: String,
        /// The support.
        what: String,
    },
    /// A force acts at a point outside the mesh.
    #[error("{place}: the point {point} of load `{load}` lies outside the mesh")]
    #[diagnostic(help("{help}"))]
    PointOutside {
        /// Where the load is written.
        place: String,
        /// Its name.
        load: String,
        /// The point asked for.
        point: DVec3,
        /// The nearest vertex, and what the model spans.
        help: String,
    },
    /// A quantity or probe of a place that is not in the mesh.
    #[error("{place}: {what} {problem}")]
    #[diagnostic(help("{help}"))]
    Place {
        /// Where it is written.
        place: String,
        /// The quantity or probe.
        what: String,
        /// What it asks for.
        problem: String,
        /// What there is.
        help: String,
    },
    /// Gravity on a material of unknown density, or its mass.
    #[error("{place}: {what}, but {materials} no density")]
    #[diagnostic(help("add density = ... (mass per volume, in units that agree with the moduli)"))]
    NoDensity {
        /// Where the load or quantity is written.
        place: String,
        /// The load or quantity, in words.
        what: String,
        /// "material `a` has" or "materials `a`, `b` have".
        materials: String,
    },
    /// A feature that the mesh does not have.
    #[error("features.{key}: {problem}")]
    #[diagnostic(help("vertices are numbered from 0 as the point ids of step_000.vtu"))]
    Feature {
        /// `edges` or `corners`.
        key: &'static str,
        /// Which entry, and why it does not fit.
        problem: String,
    },
    /// Supports that leave the part free, or contradict each other.
    #[error("{places}: {error}")]
    #[diagnostic(help("{help}"))]
    Supports {
        /// Where they are written.
        places: String,
        /// What is wrong with them.
        error: Box<FemError>,
        /// What to do.
        help: String,
    },
    /// The mesh with its groups and corners is not sound.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Mesh(#[from] MeshError),
    /// An expression has no finite value, or a material is out of range.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Fem(#[from] FemError),
}

impl ModelError {
    /// The error, with more help if the group it asks for is one of those whose faces all lie inside the solid.
    pub(super) fn with_inner(mut self, inner_groups: &[String]) -> Self {
        if let Self::UnknownGroup { group, help, .. } = &mut self
            && inner_groups.contains(group)
        {
            *help =
                format!("group `{group}` lies inside the solid, but supports and loads act on boundary faces; {help}");
        }
        self
    }
}

//! From a scenario and a hexahedral mesh to a model.

use super::super::resolve::{Body, Found, Targets, find, with_place};
use super::super::{ModelError, loading, select};
use crate::error::Error;
use crate::fem::hexes::{HexLocator, HexSpace, check_hex_constraints, common_edges, prescribed_on_hexes};
use crate::fem::options::{HexElement, HexOptions};
use crate::fem::{self, Model};
use crate::mesh::hex::{HexMesh, HexMeshParts};
use crate::mesh::topology::sorted2;
use crate::mesh::{Crease, GroupId};
use crate::output::report::Selection;
use crate::scenario::{Hexes, MeshSource, Scenario};
use crate::subdiv::catmull_clark;
use glam::DVec3;

/// A hexahedral mesh and what is to be solved on it.
#[derive(Debug)]
pub(in super::super) struct ResolvedHexes {
    /// The mesh with a group for each support and load, and with its creases and corners.
    pub mesh: HexMesh,
    /// The element.
    pub hexes: Hexes,
    /// Materials, supports and loads on its regions and groups.
    pub model: Model,
    /// The quantities asked for, on its regions and groups.
    pub quantities: Vec<fem::Quantity>,
    /// The solution that is known.
    pub exact: Option<fem::Exact>,
    /// What each selector matched.
    pub selections: Vec<Selection>,
    /// What is allowed but deserves a word.
    pub warnings: Vec<String>,
}

impl ResolvedHexes {
    /// The functions on a mesh of the problem.
    pub fn space<'m>(&self, mesh: &'m HexMesh) -> HexSpace<'m> {
        HexSpace::new(mesh, self.hexes.element, self.hexes.options)
    }
}

/// How far beside the trilinear cells places may lie, in diagonals of a cell.
const PLAY: f64 = 0.05;

/// A body of hexahedra.
#[derive(Clone)]
struct Bricks(HexMesh);

impl Body for Bricks {
    type Mesh = HexMesh;

    const HOLDS_WEAKLY: bool = true;

    fn mesh(&self) -> &HexMesh {
        &self.0
    }

    fn with_mesh(self, mesh: HexMesh) -> Self {
        Self(mesh)
    }

    fn area(&self, faces: &[usize]) -> f64 {
        select::area(&self.0, faces.iter().copied())
    }

    /// By the trilinear cells, and with some of their size as play: what the body is between vertices only its functions tell.
    fn nearest(&self, places: &[DVec3]) -> Vec<(f64, DVec3)> {
        let space = HexSpace::new(&self.0, HexElement::Hex8, HexOptions::default());
        let locator = HexLocator::new(&space);
        let nearest = |x: &DVec3| {
            let found = locator.nearest(*x);
            let corners = self.0.cell_points(found.cell);
            let play = PLAY * corners[0].distance(corners[7]);
            let near = space.frame(found.cell, &space.table(0, &[found.at]), 0).0;
            ((found.distance - play).max(0.0), if found.distance <= play { *x } else { near })
        };
        places.iter().map(nearest).collect()
    }

    fn outside(&self, place: DVec3) -> f64 {
        self.nearest(&[place])[0].0
    }

    fn fault(&self, cells: &fem::Cells) -> Option<String> {
        let region = |r| self.0.regions().contains(&r);
        if cells.within.is_some() {
            Some("asks for a part in a box, which cuts tetrahedra only".to_owned())
        } else if cells.region.is_some_and(|r| !region(r)) {
            Some("asks for a region that holds nothing of the mesh".to_owned())
        } else {
            None
        }
    }
}

/// Resolves a scenario on its mesh.
///
/// # Errors
/// As for tetrahedra; and what the limit of subdivision does not allow.
pub(super) fn resolve(scenario: &Scenario, hexes: Hexes, mesh: HexMesh) -> Result<ResolvedHexes, Error> {
    let Found { targets, model, quantities, exact } = find(scenario, Bricks(mesh))?;
    let Targets { body: Bricks(mesh), selections, .. } = targets;
    let mesh = with_features(scenario, &model, mesh)?;
    let mesh = if hexes.element.is_smooth() {
        mesh.check_smoothable()?;
        if hexes.interpolate { catmull_clark::interpolated(mesh, hexes.options.masks)? } else { mesh }
    } else {
        mesh
    };
    let mut problem = ResolvedHexes { mesh, hexes, model, quantities, exact, selections, warnings: Vec::new() };
    problem.warnings = warnings(scenario, &problem)?;
    Ok(problem)
}

fn warnings(scenario: &Scenario, problem: &ResolvedHexes) -> Result<Vec<String>, ModelError> {
    let space = problem.space(&problem.mesh);
    let with_place = |error| with_place(scenario, error);
    let prescribed = prescribed_on_hexes(&space, &problem.model).map_err(with_place)?;
    let mut warnings = Vec::new();
    if problem.exact.is_none() {
        warnings.extend(loading::warnings(&space, &problem.model, &prescribed).map_err(with_place)?);
    }
    warnings.extend(loading::idle_supports(&problem.model, &prescribed));
    let mesh = &problem.mesh;
    if problem.hexes.element.is_smooth() && mesh.regions().windows(2).any(|w| w[0] != w[1]) {
        warnings.push(
            "the mesh has several regions: Catmull-Clark functions are smooth across interfaces, where stress and strain jump, and \
             interfaces move to the limit; trust quantities there only if refinement leaves them alone, or choose \
             analysis.element = \"hex27\""
                .to_owned(),
        );
    }
    let (without, all) = space.without_bubbles();
    if problem.hexes.element == HexElement::CatmullClarkPlus && without > 0 {
        warnings.push(format!(
            "{without} of {all} boundary vertices have no bubbles, since three cells or more meet at an edge of the boundary near them: \
             there \"catmull-clark+\" is no better than \"catmull-clark\""
        ));
    }
    if scenario.adapt.goal.is_some() {
        warnings.push("adapt.goal is for tetrahedra: on hexahedra its error is not estimated".to_owned());
    }
    Ok(warnings)
}

/// Checks that the supports stop every rigid motion of every part.
///
/// # Errors
/// [`ModelError::Supports`].
pub(super) fn check_supports(scenario: &Scenario, problem: &ResolvedHexes) -> Result<(), ModelError> {
    let space = problem.space(&problem.mesh);
    check_hex_constraints(&space, &problem.model).map_err(|error| with_place(scenario, error))
}

/// Where faces of two groups meet, as creases.
fn lines_between(mesh: &HexMesh, group: GroupId, other: GroupId) -> Vec<Crease> {
    let edges = common_edges(mesh, group, other);
    edges.into_iter().map(|e| Crease { vertices: mesh.topology().edges()[e as usize], feature: false }).collect()
}

/// The mesh with its creases and corners: where a support's faces end there is a crease, so that what it prescribes ends too.
fn with_features(scenario: &Scenario, model: &Model, mesh: HexMesh) -> Result<HexMesh, Error> {
    let tagged = &scenario.features;
    let is_held =
        |s: &&fem::Support| s.meets.is_none() && s.weakly.is_none() && s.displacement.iter().any(Option::is_some);
    let mut bounded: Vec<GroupId> = model.supports.iter().filter(is_held).map(|s| s.group).collect();
    let is_round = matches!(&scenario.mesh, MeshSource::Shape(shape) if shape.is_curved());
    // The sides of a round body are smooth however few cells go around it.
    let angle = match tagged.angle {
        None if is_round => {
            bounded.extend((0..mesh.groups().len() as u32).map(GroupId));
            180.0
        }
        _ => tagged.sharp_angle(),
    };
    let mut mesh = mesh.with_creases(angle, &bounded);
    // On a crease a line's displacement depends on its own control points only.
    let lines = model.supports.iter().filter_map(|s| Some((s.group, s.meets?)));
    let lines: Vec<Crease> = lines.flat_map(|(group, other)| lines_between(&mesh, group, other)).collect();
    if !lines.is_empty() {
        mesh = mesh.and_creases(lines);
    }
    if tagged.edges.is_empty() && tagged.corners.is_empty() {
        return Ok(mesh);
    }
    let mut parts: HexMeshParts = mesh.into_parts();
    let own = tagged.edges.iter().map(|e| Crease { vertices: sorted2(*e), feature: true });
    parts.creases.extend(own);
    parts.corners.extend(&tagged.corners);
    Ok(HexMesh::new(parts)?)
}

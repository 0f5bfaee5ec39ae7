//! What a mesh holds and what a scenario makes of it, for tables and for JSON.

use super::loading;
use super::quantities::points_inside;
use super::resolve::Resolved;
use super::select;
use crate::fem::{self, FemError, LoadKind, QuantityKind, Space};
use crate::field::{Field, VectorField};
use crate::mesh::{GroupId, Tagged as _, TetMesh};
use crate::output::report::MeshReport;
use crate::scenario::Scenario;
use glam::DVec3;
use serde::Serialize;

/// A mesh with its regions and groups.
#[derive(Debug, Serialize)]
pub(super) struct MeshDetails {
    #[serde(flatten)]
    pub report: MeshReport,
    pub regions: Vec<Region>,
    pub groups: Vec<Group>,
}

#[derive(Debug, Serialize)]
pub(super) struct Region {
    pub name: String,
    pub cells: usize,
    pub volume: f64,
}

#[derive(Debug, Serialize)]
pub(super) struct Group {
    pub name: String,
    pub faces: usize,
    pub area: f64,
}

impl MeshDetails {
    /// The first `groups` groups of a mesh, and the rest of it.
    pub(super) fn of(mesh: &TetMesh, groups: usize, seconds: f64) -> Self {
        let group = |(id, name): (GroupId, &String)| Group {
            name: name.clone(),
            faces: mesh.group_faces(id).count(),
            area: select::area(mesh, mesh.faces_of(id)),
        };
        Self {
            report: MeshReport::of(mesh, seconds),
            regions: regions(mesh),
            groups: (0..).map(GroupId).zip(&mesh.groups()[..groups]).map(group).collect(),
        }
    }
}

/// The regions with their cells and volumes.
pub(super) fn regions(mesh: &TetMesh) -> Vec<Region> {
    let empty = |name: &String| Region { name: name.clone(), cells: 0, volume: 0.0 };
    let mut regions: Vec<Region> = mesh.region_names().iter().map(empty).collect();
    for (t, region) in mesh.regions().iter().enumerate() {
        let region = &mut regions[region.0 as usize];
        region.cells += 1;
        region.volume += mesh.cell_volume(t);
    }
    regions
}

/// A support: where it acts, the displacement it prescribes, null where free, and the stiffness of its foundation.
#[derive(Debug, Serialize)]
pub(super) struct Support {
    pub name: String,
    pub faces: usize,
    pub area: f64,
    /// Vertices that are held, on the input mesh.
    pub vertices: usize,
    pub displacement: [Option<Field>; 3],
    pub spring: [f64; 3],
}

/// A load: where it acts, what, and the force that makes in total.
#[derive(Debug, Serialize)]
pub(super) struct Load {
    pub name: String,
    pub kind: &'static str,
    /// Three components, or the one number of a pressure; expressions as written.
    pub value: Vec<Field>,
    /// Where a force at a point acts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
    /// Zero for what acts on cells or at a point.
    pub faces: usize,
    pub area: f64,
    pub total_force: [f64; 3],
}

pub(super) fn supports(problem: &Resolved) -> Vec<Support> {
    let space = problem.space();
    let support = |s: &crate::fem::Support| {
        // Where faces meet there are none.
        let (faces, area) = if s.meets.is_some() { (0, 0.0) } else { extent(&space, s.group) };
        let vertices = s.nodes(&Space::linear(&problem.mesh)).len();
        let (displacement, spring) = (s.displacement.clone(), s.stiffness.to_array());
        Support { name: s.name.clone(), faces, area, vertices, displacement, spring }
    };
    problem.model.supports.iter().map(support).collect()
}

/// # Errors
/// None on the mesh of the problem, on which every expression was evaluated when it was resolved.
pub(super) fn loads(problem: &Resolved) -> Result<Vec<Load>, FemError> {
    let (space, model) = (problem.space(), &problem.model);
    let constant = |v: DVec3| VectorField::from(v).0.to_vec();
    let load = |l: &crate::fem::Load| {
        let (kind, group, value) = match &l.kind {
            LoadKind::Traction(g, t) => ("traction", Some(*g), t.0.to_vec()),
            LoadKind::Pressure(g, p) => ("pressure", Some(*g), vec![p.clone()]),
            LoadKind::Force(g, f) => ("force", Some(*g), constant(*f)),
            LoadKind::PointForce(_, f) => ("point force", None, constant(*f)),
            LoadKind::BodyForce(b) => ("body force", None, b.0.to_vec()),
            LoadKind::Gravity(a) => ("gravity", None, constant(*a)),
        };
        let point = if let LoadKind::PointForce(x, _) = l.kind { Some(x.to_array()) } else { None };
        let (faces, area) = group.map_or((0, 0.0), |g| extent(&space, g));
        let total_force = loading::total(&space, model, l)?.to_array();
        Ok(Load { name: l.name.clone(), kind, value, point, faces, area, total_force })
    };
    model.loads.iter().map(load).collect()
}

fn extent(space: &Space<'_>, group: GroupId) -> (usize, f64) {
    let faces = || space.mesh().group_faces(group);
    (faces().count(), faces().flat_map(|f| space.face_rule(f)).map(|(_, _, area)| area.length()).sum())
}

/// A quantity: what it is a number of, and of what part of the mesh.
#[derive(Debug, Serialize)]
pub(super) struct Quantity {
    pub name: String,
    pub what: String,
    /// Boundary faces that it is taken over, and their area.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub faces: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area: Option<f64>,
    /// Volume of the cells, or of their parts, that it is taken over.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume: Option<f64>,
    /// Where a value is taken.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
}

/// A probe, and how many of its points lie in the mesh.
#[derive(Debug, Serialize)]
pub(super) struct Probe {
    pub name: String,
    pub from: [f64; 3],
    pub to: [f64; 3],
    pub points: usize,
    pub inside: usize,
}

pub(super) fn quantities(problem: &Resolved) -> Vec<Quantity> {
    let mesh = &problem.mesh;
    let space = problem.space();
    let quantity = |q: &fem::Quantity| {
        let (what, over) = match q.kind {
            QuantityKind::Average(field, over) => (format!("average of {}", word(&field)), Some(over)),
            QuantityKind::Maximum(field, over) => (format!("maximum of {}", word(&field)), Some(over)),
            QuantityKind::Value(field, _) => (word(&field), None),
            QuantityKind::Total(total, cells) => (word(&total), Some(fem::Extent::Cells(cells))),
            QuantityKind::Reaction(support, c) => {
                (format!("reaction of {}, {}", problem.model.supports[support].name, ["x", "y", "z"][c]), None)
            }
        };
        let faces = if let Some(fem::Extent::Faces(group)) = over { Some(extent(&space, group)) } else { None };
        let volume = if let Some(fem::Extent::Cells(cells)) = over { Some(cells.volume(mesh)) } else { None };
        let point = if let QuantityKind::Value(_, x) = q.kind { Some(x.to_array()) } else { None };
        let (faces, area) = faces.unzip();
        Quantity { name: q.name.clone(), what, faces, area, volume, point }
    };
    problem.quantities.iter().map(quantity).collect()
}

pub(super) fn probes(scenario: &Scenario, mesh: &TetMesh) -> Vec<Probe> {
    let inside = points_inside(&scenario.probes, mesh);
    let probe = |(p, inside): (&crate::scenario::Probe, usize)| Probe {
        name: p.name.clone(),
        from: p.from.to_array(),
        to: p.to.to_array(),
        points: p.points,
        inside,
    };
    scenario.probes.iter().zip(inside).map(probe).collect()
}

/// The word or table a choice is written with in a scenario.
pub(super) fn word(choice: &impl Serialize) -> String {
    serde_json::to_string(choice).unwrap_or_default().replace(['"', '{', '}'], "").replace(':', " ")
}

//! What a mesh holds and what a scenario makes of it, for tables and for JSON.

use super::loading;
use super::resolve::Resolved;
use super::select;
use crate::fem::LoadKind;
use crate::mesh::{GroupId, TetMesh};
use crate::output::report::MeshReport;
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
            area: select::area(mesh, mesh.group_faces(id)),
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

/// A support: where it acts and the displacement it prescribes, null where free.
#[derive(Debug, Serialize)]
pub(super) struct Support {
    pub name: String,
    pub faces: usize,
    pub area: f64,
    pub displacement: [Option<f64>; 3],
}

/// A load: where it acts, what, and the force that makes in total.
#[derive(Debug, Serialize)]
pub(super) struct Load {
    pub name: String,
    pub kind: &'static str,
    /// Three components, or the one number of a pressure.
    pub value: Vec<f64>,
    /// Zero for gravity.
    pub faces: usize,
    pub area: f64,
    pub total_force: [f64; 3],
}

pub(super) fn supports(problem: &Resolved) -> Vec<Support> {
    let support = |s: &crate::fem::Support| {
        let (faces, area) = extent(&problem.mesh, s.group);
        Support { name: s.name.clone(), faces, area, displacement: s.displacement }
    };
    problem.model.supports.iter().map(support).collect()
}

pub(super) fn loads(problem: &Resolved) -> Vec<Load> {
    let (mesh, model) = (&problem.mesh, &problem.model);
    let mass = || -> f64 {
        let densities = mesh.regions().iter().map(|r| model.materials[r.0 as usize].density);
        densities.enumerate().map(|(t, density)| density * mesh.cell_volume(t)).sum()
    };
    let load = |l: &crate::fem::Load| {
        let (kind, group, value) = match l.kind {
            LoadKind::Traction(g, t) => ("traction", Some(g), t.to_array().to_vec()),
            LoadKind::Pressure(g, p) => ("pressure", Some(g), vec![p]),
            LoadKind::Force(g, f) => ("force", Some(g), f.to_array().to_vec()),
            LoadKind::Gravity(a) => ("gravity", None, a.to_array().to_vec()),
        };
        let (faces, area) = group.map_or((0, 0.0), |g| extent(mesh, g));
        let resultant = loading::effect(mesh, l.kind).1;
        let total: DVec3 = if group.is_none() { mass() * resultant } else { resultant };
        Load { name: l.name.clone(), kind, value, faces, area, total_force: total.to_array() }
    };
    model.loads.iter().map(load).collect()
}

fn extent(mesh: &TetMesh, group: GroupId) -> (usize, f64) {
    (mesh.group_faces(group).count(), select::area(mesh, mesh.group_faces(group)))
}

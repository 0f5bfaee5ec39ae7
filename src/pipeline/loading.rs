//! What supports prescribe at the vertices, and loads that do less than they seem to.

use super::{ModelError, select};
use crate::fem::{LoadKind, Model};
use crate::mesh::{GroupId, TetMesh, features::face_normal};
use glam::DVec3;

/// For each vertex and component the index of the first support that prescribes it.
pub(super) type Prescribed = Vec<[Option<usize>; 3]>;

/// Collects what supports prescribe.
///
/// # Errors
/// [`ModelError::Conflict`] if two supports prescribe different values.
pub(super) fn prescribed(mesh: &TetMesh, model: &Model) -> Result<Prescribed, ModelError> {
    let mut by: Prescribed = vec![[None; 3]; mesh.points().len()];
    for (index, support) in model.supports.iter().enumerate() {
        for v in vertices(mesh, support.group) {
            for (c, value) in support.displacement.iter().enumerate() {
                let Some(value) = *value else { continue };
                let first = *by[v as usize][c].get_or_insert(index);
                let other = &model.supports[first];
                if other.displacement[c] != Some(value) {
                    return Err(ModelError::Conflict {
                        vertex: v,
                        position: mesh.points()[v as usize],
                        axis: ['x', 'y', 'z'][c],
                        names: [other.name.clone(), support.name.clone()],
                        values: [other.displacement[c].unwrap_or(f64::NAN), value],
                    });
                }
            }
        }
    }
    Ok(by)
}

/// Loads that are zero, act on fixed vertices only, or cancel out; a model that nothing loads.
pub(super) fn warnings(mesh: &TetMesh, model: &Model, prescribed: &Prescribed) -> Vec<String> {
    let mut warnings = Vec::new();
    let (mut total, mut size) = (DVec3::ZERO, 0.0);
    for load in &model.loads {
        let (acts, resultant, magnitude) = effect(mesh, load.kind);
        total += resultant;
        size += magnitude;
        if magnitude == 0.0 {
            warnings.push(format!("load `{}` is zero", load.name));
        } else if group(load.kind).is_some_and(|g| only_fixed(mesh, g, acts, prescribed)) {
            warnings
                .push(format!("load `{}` acts on fixed vertices only: supports take it, nothing deforms", load.name));
        }
    }
    let moved = model.supports.iter().flat_map(|s| s.displacement).flatten().any(|u| u != 0.0);
    if size == 0.0 && !moved {
        warnings.push("nothing loads the model: the displacement will be zero everywhere".to_owned());
    } else if size > 0.0 && total.length() <= 1e-9 * size {
        warnings.push("the loads cancel out: their total force is zero".to_owned());
    }
    warnings
}

/// The components a load acts in, its total force (per volume for gravity) and the sum of its magnitudes.
pub(super) fn effect(mesh: &TetMesh, kind: LoadKind) -> ([bool; 3], DVec3, f64) {
    let along = |v: DVec3| v.to_array().map(|x| x != 0.0);
    match kind {
        LoadKind::Traction(g, t) => {
            let area = select::area(mesh, mesh.group_faces(g));
            (along(t), area * t, area * t.length())
        }
        LoadKind::Force(_, f) => (along(f), f, f.length()),
        LoadKind::Gravity(a) => (along(a), a, a.length()),
        LoadKind::Pressure(g, p) => {
            let normals: DVec3 = mesh.group_faces(g).map(|f| 0.5 * face_normal(mesh.points(), f.vertices)).sum();
            ([true; 3], -p * normals, p.abs() * select::area(mesh, mesh.group_faces(g)))
        }
    }
}

fn group(kind: LoadKind) -> Option<GroupId> {
    match kind {
        LoadKind::Traction(g, _) | LoadKind::Force(g, _) | LoadKind::Pressure(g, _) => Some(g),
        LoadKind::Gravity(_) => None,
    }
}

/// Whether all vertices of a group are prescribed in all components that a load acts in.
fn only_fixed(mesh: &TetMesh, group: GroupId, acts: [bool; 3], prescribed: &Prescribed) -> bool {
    vertices(mesh, group).all(|v| (0..3).all(|c| !acts[c] || prescribed[v as usize][c].is_some()))
}

fn vertices(mesh: &TetMesh, group: GroupId) -> impl Iterator<Item = u32> {
    mesh.group_faces(group).flat_map(|f| f.vertices)
}

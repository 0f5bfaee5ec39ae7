//! Whether a model makes sense on a mesh, before anything is computed.

use super::{FemError, LoadKind, Material, Model};
use crate::mesh::{GroupId, TetMesh};

/// Checks materials, values and groups.
///
/// # Errors
/// Names the region, support or load at fault.
pub(super) fn check(mesh: &TetMesh, model: &Model) -> Result<(), FemError> {
    for (index, region) in mesh.region_names().iter().enumerate() {
        let problem = match model.materials.get(index) {
            None => Some("there is none".to_owned()),
            Some(material) => material_problem(material),
        };
        if let Some(problem) = problem {
            return Err(FemError::Material { region: region.clone(), problem });
        }
    }
    for support in &model.supports {
        check_group(mesh, support.group, "support", &support.name)?;
        check_finite(support.displacement.into_iter().flatten(), "support", &support.name)?;
    }
    for load in &model.loads {
        let (group, values) = match load.kind {
            LoadKind::Traction(group, v) | LoadKind::Force(group, v) => (Some(group), v.to_array()),
            LoadKind::Pressure(group, p) => (Some(group), [p, 0.0, 0.0]),
            LoadKind::Gravity(v) => (None, v.to_array()),
        };
        check_finite(values.into_iter(), "load", &load.name)?;
        match group {
            Some(group) => check_group(mesh, group, "load", &load.name)?,
            None => check_density(mesh, model, &load.name)?,
        }
    }
    Ok(())
}

fn material_problem(material: &Material) -> Option<String> {
    let Material { youngs_modulus: e, poissons_ratio: nu, density } = *material;
    if !(e > 0.0 && e.is_finite()) {
        Some(format!("Young's modulus is {e}"))
    } else if !(nu > -1.0 && nu < 0.5) {
        Some(format!("Poisson's ratio is {nu}"))
    } else if !(density >= 0.0 && density.is_finite()) {
        Some(format!("the density is {density}"))
    } else {
        None
    }
}

fn check_group(mesh: &TetMesh, group: GroupId, what: &'static str, name: &str) -> Result<(), FemError> {
    match mesh.group_faces(group).next() {
        Some(_) => Ok(()),
        None => Err(FemError::EmptyGroup { what, name: name.to_owned() }),
    }
}

fn check_finite(values: impl Iterator<Item = f64>, what: &'static str, name: &str) -> Result<(), FemError> {
    match { values }.find(|v| !v.is_finite()) {
        Some(value) => Err(FemError::NotFinite { what, name: name.to_owned(), value }),
        None => Ok(()),
    }
}

fn check_density(mesh: &TetMesh, model: &Model, load: &str) -> Result<(), FemError> {
    let massless = mesh.region_names().iter().zip(&model.materials).find(|(_, m)| m.density == 0.0);
    match massless {
        Some((region, _)) => Err(FemError::NoDensity { load: load.to_owned(), region: region.clone() }),
        None => Ok(()),
    }
}

//! Whether a model makes sense on a mesh, before anything is computed.

use super::{FemError, LoadKind, Material, Model};
use crate::field::Field;
use crate::mesh::{GroupId, Tagged};

/// Checks materials, values and groups.
///
/// # Errors
/// Names the region, support or load at fault.
pub(super) fn check(mesh: &impl Tagged, model: &Model) -> Result<(), FemError> {
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
        for group in [support.group].into_iter().chain(support.meets) {
            check_group(mesh, group, "support", &support.name)?;
        }
        let prescribed = support.displacement.iter().flatten().filter_map(Field::constant);
        check_finite(prescribed.chain(support.stiffness.to_array()), "support", &support.name)?;
        if support.stiffness.min_element() < 0.0 {
            return Err(FemError::NegativeStiffness { support: support.name.clone(), stiffness: support.stiffness });
        }
    }
    for load in &model.loads {
        let (group, values) = match &load.kind {
            LoadKind::Traction(group, field) => (Some(*group), constants(&field.0)),
            LoadKind::Pressure(group, field) => (Some(*group), constants(std::slice::from_ref(field))),
            LoadKind::Force(group, force) => (Some(*group), force.to_array().to_vec()),
            LoadKind::PointForce(x, force) => (None, [x.to_array(), force.to_array()].concat()),
            LoadKind::BodyForce(field) => (None, constants(&field.0)),
            LoadKind::Gravity(acceleration) => (None, acceleration.to_array().to_vec()),
        };
        check_finite(values.into_iter(), "load", &load.name)?;
        if let Some(group) = group {
            check_group(mesh, group, "load", &load.name)?;
        }
        if matches!(load.kind, LoadKind::Gravity(_)) {
            check_density(mesh, model, &load.name)?;
        }
    }
    Ok(())
}

/// The values that are known before fields are evaluated.
fn constants(fields: &[Field]) -> Vec<f64> {
    fields.iter().filter_map(Field::constant).collect()
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

fn check_group(mesh: &impl Tagged, group: GroupId, what: &'static str, name: &str) -> Result<(), FemError> {
    if mesh.faces_of(group).next().is_none() {
        Err(FemError::EmptyGroup { what, name: name.to_owned() })
    } else {
        Ok(())
    }
}

fn check_finite(values: impl Iterator<Item = f64>, what: &'static str, name: &str) -> Result<(), FemError> {
    match { values }.find(|v| !v.is_finite()) {
        Some(value) => Err(FemError::NotFinite { what, name: name.to_owned(), value }),
        None => Ok(()),
    }
}

fn check_density(mesh: &impl Tagged, model: &Model, load: &str) -> Result<(), FemError> {
    let massless = mesh.region_names().iter().zip(&model.materials).find(|(_, m)| m.density == 0.0);
    match massless {
        Some((region, _)) => Err(FemError::NoDensity { load: load.to_owned(), region: region.clone() }),
        None => Ok(()),
    }
}

//! From a scenario's `[mesh]` to a mesh.

use crate::mesh::generate::{self, Curved};
use crate::mesh::read::{Edges, MeshFile, Reading, read_with};
use crate::mesh::{MeshError, TetMesh};
use crate::scenario::{MeshSource, Midside, Scenario, Shape};
use std::io::{Error as IoError, ErrorKind};
use std::path::{Path, PathBuf};

/// Environment variable that names the folder of meshes that do not lie beside their scenarios.
pub const DATA_VARIABLE: &str = "SUBSOLID_DATA";

/// Reads or generates the mesh of a scenario.
///
/// # Errors
/// [`MeshError`]: the file is in none of the places looked at, or it is not a mesh.
pub fn load(scenario: &Scenario) -> Result<MeshFile, MeshError> {
    read_or_make(&scenario.mesh, scenario.midside, scenario.merge, &scenario.directory)
}

/// As [`load`], of a scenario of any kind in the folder `beside`.
///
/// # Errors
/// As [`load`].
pub fn load_source(source: &MeshSource, midside: Midside, beside: &Path) -> Result<MeshFile, MeshError> {
    read_or_make(source, midside, false, beside)
}

fn read_or_make(source: &MeshSource, midside: Midside, merge: bool, beside: &Path) -> Result<MeshFile, MeshError> {
    match source {
        MeshSource::File(file) => {
            let edges = match midside {
                Midside::Straight => Edges::Straight,
                Midside::Curved => Edges::Curved,
            };
            read_with(&find(file, beside)?, Reading { edges, merge })
        }
        MeshSource::Box { size, cells } => {
            let mesh = generate::box_tets(*size, *cells).map_err(|e| of_key("box", e))?;
            Ok(made(straight(mesh), "generated box"))
        }
        MeshSource::Shape(shape) => {
            let body = generated(*shape).and_then(|body| match midside {
                Midside::Straight => Ok(straight(body.mesh)),
                Midside::Curved => body.unfolded(),
            });
            Ok(made(body.map_err(|e| of_key(shape.key(), e))?, "generated"))
        }
    }
}

fn straight(mesh: TetMesh) -> Curved {
    Curved { mesh, midsides: Vec::new() }
}

fn made(body: Curved, format: &'static str) -> MeshFile {
    let Curved { mesh, midsides } = body;
    MeshFile { mesh, format, midsides, notes: Vec::new(), inner_groups: Vec::new() }
}

/// The error of a generator, with the key of `[mesh]` that asked for it.
fn of_key(key: &str, error: MeshError) -> MeshError {
    match error {
        MeshError::Generator(problem) => MeshError::Generator(format!("`mesh.{key}`: {problem}")),
        other => other,
    }
}

fn generated(shape: Shape) -> Result<Curved, MeshError> {
    match shape {
        Shape::LPrism(cells) => generate::l_prism(cells).map(straight),
        Shape::Fichera(cells) => generate::fichera(cells).map(straight),
        Shape::Cylinder { radius, length, cells } => generate::cylinder(radius, length, cells),
        Shape::Tube { radii, length, cells, is_quarter } => generate::tube(radii, length, cells, is_quarter),
        Shape::SphereShell { radii, cells } => generate::sphere_shell(radii, cells),
        Shape::PlateWithHole { radius, size, thickness, cells } => {
            generate::plate_with_hole(radius, size, thickness, cells)
        }
        Shape::Le10 { cells } => generate::le10(cells),
        Shape::Prism { sides, radius, length, cells } => generate::prism(sides, radius, length, cells).map(straight),
    }
}

/// The path of a mesh file: as it is if absolute, else in the folder `beside`, then in the folder that `SUBSOLID_DATA`
/// names.
///
/// # Errors
/// [`MeshError::Unreadable`] that lists where the file was looked for.
pub fn find(file: &Path, beside: &Path) -> Result<PathBuf, MeshError> {
    let data = std::env::var_os(DATA_VARIABLE).filter(|d| !d.is_empty()).map(PathBuf::from);
    find_in(file, beside, data.as_deref())
}

fn find_in(file: &Path, beside: &Path, data: Option<&Path>) -> Result<PathBuf, MeshError> {
    // An absolute path replaces the folder it is joined to.
    let mut places = vec![beside.join(file)];
    if let Some(data) = data.filter(|_| file.is_relative()) {
        places.push(data.join(file));
    }
    if let Some(found) = places.iter().find(|p| p.is_file()) {
        return Ok(found.clone());
    }
    let list: Vec<String> = places.iter().map(|p| p.display().to_string()).collect();
    let mut help = format!("looked for {}", list.join(" and "));
    if data.is_none() && file.is_relative() {
        help += &format!("; if it lies in another folder: {DATA_VARIABLE}=<that folder> subsolid ...");
    }
    let source = if places.iter().any(|p| p.exists()) {
        IoError::new(ErrorKind::InvalidInput, "it is not a file")
    } else {
        IoError::new(ErrorKind::NotFound, "no such file")
    };
    Err(MeshError::Unreadable { what: "mesh", path: file.to_owned(), source, help })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_is_looked_for_beside_the_scenario_then_in_the_data_folder() {
        let (near, far) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let file = Path::new("part.msh");
        let error = find_in(file, near.path(), None).unwrap_err();
        let MeshError::Unreadable { help, source, .. } = error else { panic!("{error}") };
        assert!(help.contains(&near.path().join(file).display().to_string()) && help.contains(DATA_VARIABLE));
        assert_eq!(source.kind(), ErrorKind::NotFound);

        std::fs::write(far.path().join(file), "").unwrap();
        assert_eq!(find_in(file, near.path(), Some(far.path())).unwrap(), far.path().join(file));
        std::fs::write(near.path().join(file), "").unwrap();
        assert_eq!(find_in(file, near.path(), Some(far.path())).unwrap(), near.path().join(file));

        let absolute = far.path().join("other.msh");
        let MeshError::Unreadable { help, .. } = find_in(&absolute, near.path(), Some(far.path())).unwrap_err() else {
            panic!()
        };
        assert!(!help.contains(&near.path().display().to_string()), "an absolute path is not looked for elsewhere");
    }
}

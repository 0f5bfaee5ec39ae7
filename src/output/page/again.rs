//! A step read back from its `.vtu` file, to be shown again.

use super::shown::{Shown, Solved, face_places};
use crate::fem::SymTensor;
use crate::mesh::MeshError;
use crate::mesh::hex::{HexTopology, from_vtk_order};
use crate::mesh::read::{VtuArray, VtuPart, read_vtu_arrays};
use crate::mesh::topology::{boundary_cells, boundary_faces, sorted2, sorted3};
use crate::output::OutputError;
use crate::output::hex_cells::vtk_places;
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::borrow::Cow;
use std::path::Path;

/// Codes of VTK's cells.
const TETRAHEDRON: f64 = 10.0;
const TEN_NODES: f64 = 24.0;
const HEXAHEDRON: f64 = 12.0;
const LAGRANGE_HEXAHEDRON: f64 = 72.0;

/// A step of an earlier run.
#[derive(Debug)]
pub struct OldStep {
    /// Its mesh.
    pub shown: Shown<'static>,
    groups: Vec<String>,
    displacement: Vec<DVec3>,
    stress: Vec<SymTensor>,
    error: Vec<f64>,
    quality: Vec<f64>,
    level: Vec<u8>,
}

/// The arrays of a file by name.
struct File<'a> {
    path: &'a Path,
    arrays: Vec<VtuArray>,
}

impl OldStep {
    /// Reads a file that a run has written. Fields that it does not have are not known; displacements it must have.
    ///
    /// # Errors
    /// [`MeshError`] if the file cannot be read; [`OutputError::NotShown`] if its cells are none that can be shown again.
    pub fn read(path: &Path) -> Result<Result<Self, OutputError>, MeshError> {
        Ok(File { path, arrays: read_vtu_arrays(path)? }.step())
    }

    /// The number of a group of faces.
    #[must_use]
    pub fn group(&self, name: &str) -> Option<u32> {
        (0..).zip(&self.groups).find(|(_, own)| *own == name).map(|(number, _)| number)
    }

    /// Its fields.
    #[must_use]
    pub fn solved(&self) -> Solved<'_> {
        Solved {
            displacement: &self.displacement,
            stress: &self.stress,
            error: &self.error,
            quality: &self.quality,
            level: &self.level,
        }
    }
}

impl File<'_> {
    fn find(&self, part: VtuPart, name: &str) -> Option<&[f64]> {
        let found = self.arrays.iter().find(|a| a.part == part && (name.is_empty() || a.name == name));
        found.map(|a| &a.numbers[..])
    }

    fn need(&self, part: VtuPart, name: &str) -> Result<&[f64], OutputError> {
        self.find(part, name).ok_or_else(|| self.refused(&format!("it has no array {name:?}")))
    }

    fn refused(&self, why: &str) -> OutputError {
        OutputError::NotShown { path: self.path.to_owned(), why: why.to_owned() }
    }

    fn step(&self) -> Result<OldStep, OutputError> {
        let points = vectors(self.need(VtuPart::Points, "")?);
        let (kinds, cells) = (self.need(VtuPart::Cells, "types")?, self.cells(points.len())?);
        let groups = strings(self.find(VtuPart::FieldData, "group_names").unwrap_or_default());
        let kind = kinds.first().copied().unwrap_or_default();
        if kinds.iter().any(|k| *k != kind) {
            return Err(self.refused("its cells are of several kinds"));
        }
        let shown = match kind {
            TETRAHEDRON => self.tetrahedra(points, &cells, 4),
            TEN_NODES => self.tetrahedra(points, &cells, 10),
            HEXAHEDRON => self.hexahedra(points, &cells, 1),
            LAGRANGE_HEXAHEDRON => self.hexahedra(points, &cells, order_of(cells.len() / kinds.len())),
            _ => Err(self.refused("its cells hold coefficients, or are of another program")),
        }?;
        let [nodes, count] = [shown.points.len(), shown.cell_count()];
        let displacement = vectors(self.need(VtuPart::PointData, "displacement")?);
        let field = |name: &str| match self.find(VtuPart::CellData, name) {
            Some(values) => values.to_vec(),
            None => vec![f64::NAN; count],
        };
        let stress = match self.find(VtuPart::PointData, "stress") {
            Some(values) => values.as_chunks::<6>().0.to_vec(),
            None => vec![[f64::NAN; 6]; nodes],
        };
        let level = field("refinement_level").into_iter().map(|l| l as u8).collect();
        let (error, quality) = (field("error_indicator"), field("quality"));
        if displacement.len() != nodes || stress.len() != nodes || error.len() != count || quality.len() != count {
            return Err(self.refused("its arrays do not fit its mesh"));
        }
        Ok(OldStep { shown, groups, displacement, stress, error, quality, level })
    }

    /// The points of the cells, all of which have equally many.
    fn cells(&self, points: usize) -> Result<Vec<u32>, OutputError> {
        let numbers = self.need(VtuPart::Cells, "connectivity")?;
        if numbers.iter().any(|v| *v < 0.0 || *v >= points as f64) {
            return Err(self.refused("its cells name points that are not there"));
        }
        Ok(numbers.iter().map(|v| *v as u32).collect())
    }

    fn tetrahedra(&self, points: Vec<DVec3>, cells: &[u32], size: usize) -> Result<Shown<'static>, OutputError> {
        let tets: Vec<[u32; 4]> = cells.chunks_exact(size).map(|c| [c[0], c[1], c[2], c[3]]).collect();
        let corners = boundary_faces(&tets);
        let mut faces = Vec::new();
        if size == 4 {
            faces.extend(corners.iter().flatten());
        } else {
            // The order of VTK: 01, 12, 02, 03, 13, 23.
            let ends = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];
            let of_cell =
                |c: &'_ [u32]| (4..10).map(|q| (sorted2(ends[q - 4].map(|i| c[i])), c[q])).collect::<Vec<_>>();
            let middles: FxHashMap<[u32; 2], u32> = cells.chunks_exact(size).flat_map(of_cell).collect();
            for &[a, b, c] in &corners {
                faces.extend([a, b, c]);
                for side in [[a, b], [b, c], [c, a]] {
                    let middle = middles.get(&sorted2(side));
                    faces.push(*middle.ok_or_else(|| self.refused("its cells are damaged"))?);
                }
            }
        }
        let (face_patches, patches) = self.patches(&corners);
        Ok(Shown {
            points: Cow::Owned(points),
            faces,
            face_points: if size == 4 { 3 } else { 6 },
            face_cells: boundary_cells(&tets),
            face_patches,
            patches,
            cells: Cow::Owned(tets.into_flattened()),
            cell_points: 4,
        })
    }

    /// The groups that faces belong to, as far as the file tells.
    fn patches(&self, corners: &[[u32; 3]]) -> (Vec<u32>, Vec<Vec<u32>>) {
        let mut groups: FxHashMap<[u32; 3], Vec<u32>> = FxHashMap::default();
        let rows = self.find(VtuPart::FieldData, "group_faces").unwrap_or_default();
        for row in rows.as_chunks::<4>().0 {
            let [group, a, b, c] = row.map(|x| x as u32);
            groups.entry(sorted3([a, b, c])).or_default().push(group);
        }
        let mut patches: Vec<Vec<u32>> = vec![Vec::new()];
        let of_face = |face: &[u32; 3]| {
            let own = groups.get(&sorted3(*face)).cloned().unwrap_or_default();
            let known = patches.iter().position(|p| *p == own);
            known.unwrap_or_else(|| {
                patches.push(own);
                patches.len() - 1
            }) as u32
        };
        (corners.iter().map(of_face).collect(), patches)
    }

    fn hexahedra(&self, points: Vec<DVec3>, cells: &[u32], order: usize) -> Result<Shown<'static>, OutputError> {
        let (side, size) = (order + 1, (order + 1).pow(3));
        if !cells.len().is_multiple_of(size) {
            return Err(self.refused("its cells have no equal numbers of points along their sides"));
        }
        let places = vtk_places(order);
        let mut lattice = vec![0; cells.len()];
        for (own, cell) in lattice.chunks_exact_mut(size).zip(cells.chunks_exact(size)) {
            places.iter().zip(cell).for_each(|(&place, &v)| own[place] = v);
        }
        let corners: Vec<[u32; 8]> =
            cells.chunks_exact(size).map(|c| from_vtk_order(std::array::from_fn(|i| c[i]))).collect();
        let topology = HexTopology::new(points.len(), &corners).map_err(|e| self.refused(&e.to_string()))?;
        let (mut faces, mut face_cells) = (Vec::new(), Vec::new());
        for (number, _) in topology.boundary() {
            let t = topology.face_cells()[number as usize][0];
            let k = topology.cell_faces()[t as usize].iter().position(|f| *f == number).unwrap_or(0);
            faces.extend(face_places(order, k).map(|q| lattice[size * t as usize + q]));
            face_cells.push(t);
        }
        Ok(Shown {
            points: Cow::Owned(points),
            faces,
            face_points: side * side,
            face_patches: vec![0; face_cells.len()],
            patches: vec![Vec::new()],
            face_cells,
            cells: Cow::Owned(lattice),
            cell_points: size,
        })
    }
}

/// The order of a lattice of so many points.
fn order_of(points: usize) -> usize {
    (1..).find(|order| (order + 1_usize).pow(3) >= points).unwrap_or(1)
}

fn vectors(numbers: &[f64]) -> Vec<DVec3> {
    numbers.as_chunks::<3>().0.iter().map(|p| DVec3::from_array(*p)).collect()
}

/// Strings from their bytes.
fn strings(codes: &[f64]) -> Vec<String> {
    let bytes: Vec<u8> = codes.iter().map(|code| *code as u8).collect();
    let parts = bytes.split(|byte| *byte == 0).map(|text| String::from_utf8_lossy(text).into_owned());
    let mut strings: Vec<String> = parts.collect();
    // What follows the last zero.
    strings.pop();
    strings
}

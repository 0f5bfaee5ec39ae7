//! What a hexahedral mesh is, in numbers and in words.

use super::super::{select, span};
use crate::limit::Basis;
use crate::mesh::GroupId;
use crate::mesh::hex::{HexMesh, cell_volume};
use crate::output::report::{MeshCounts, QualityRecord};
use crate::output::table::{table, text};
use crate::subdiv::options::CatmullClark;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Counts and measures of a mesh.
#[derive(Debug, Serialize)]
pub struct HexReport {
    /// Counts, and the volume of the trilinear cells.
    #[serde(flatten)]
    mesh: MeshCounts,
    /// Angles and cells at a vertex.
    quality: QualityRecord,
    /// All creases, features or not.
    creases: usize,
    /// How many interior edges have each number of cells.
    edge_valences: BTreeMap<usize, usize>,
    /// What Catmull-Clark subdivision has to evaluate; none if it refuses the mesh.
    rings: Option<Rings>,
    /// Why it refuses the mesh.
    refused: Option<String>,
    /// Wall time of what made it.
    seconds: f64,
}

/// The rings of cells: what the functions of each depend on.
#[derive(Debug, Serialize)]
struct Rings {
    /// How many are different.
    distinct: usize,
    /// Cells whose functions are products of B-splines.
    regular_cells: usize,
}

impl HexReport {
    /// Describes a mesh that took `seconds` to make.
    #[must_use]
    pub fn of(mesh: &HexMesh, seconds: f64) -> Self {
        let topology = mesh.topology();
        let mut edge_valences = BTreeMap::new();
        for e in (0..topology.edges().len() as u32).filter(|&e| topology.boundary_faces_at(e).next().is_none()) {
            *edge_valences.entry(topology.edge_cells(e).len()).or_default() += 1;
        }
        let (rings, refused) = match mesh.check_smoothable() {
            Ok(()) => {
                let basis = Basis::new(mesh, CatmullClark::default(), false);
                let is_regular = |t: &usize| basis.is_regular(basis.class(*t));
                let regular_cells = (0..mesh.cells().len()).filter(is_regular).count();
                (Some(Rings { distinct: basis.classes(), regular_cells }), None)
            }
            Err(error) => (None, Some(error.to_string())),
        };
        Self {
            mesh: MeshCounts::of_hexes(mesh),
            quality: QualityRecord::of_hexes(mesh),
            creases: mesh.creases().len(),
            edge_valences,
            rings,
            refused,
            seconds,
        }
    }

    /// The numbers in a table.
    pub(in super::super) fn table(&self, mesh: &HexMesh, format: &str) -> String {
        let (counts, q) = (&self.mesh, &self.quality);
        let mut rows = table(&format!("mesh|{format}"));
        let mut row = |what: &str, value: String| {
            rows.add_row([what.to_owned(), value]);
        };
        row("hexahedra", counts.cells.to_string());
        row("vertices", counts.nodes.to_string());
        row("edges", counts.edges.to_string());
        row("boundary faces", counts.boundary_faces.to_string());
        row("creases", format!("{}, of them {} features", self.creases, counts.feature_edges));
        row("connected parts", mesh.connected_parts().1.to_string());
        row("volume", format!("{:.6}", counts.volume));
        row("bounding box", span(mesh));
        row("dihedral angles", format!("least {:.2}, average of the cells' least {:.2} degrees", q.worst, q.average));
        let valences: Vec<String> = self.edge_valences.iter().map(|(n, count)| format!("{n} at {count}")).collect();
        row("cells at interior edges", if valences.is_empty() { "none".to_owned() } else { valences.join(", ") });
        row("cells at a vertex", format!("at most {}, average {:.2}", q.max_valence, q.average_valence));
        row("Catmull-Clark", self.smooth());
        text(rows) + "\n"
    }

    /// What subdivision makes of the mesh.
    fn smooth(&self) -> String {
        match (&self.rings, &self.refused) {
            (Some(Rings { distinct, regular_cells }), _) => {
                format!("{regular_cells} cells are B-splines; {distinct} distinct rings")
            }
            (_, reason) => format!("refused: {}", reason.as_deref().unwrap_or_default()),
        }
    }

    /// A few lines.
    pub(in super::super) fn lines(&self) -> String {
        let MeshCounts { cells, nodes, feature_edges, .. } = self.mesh;
        format!(
            "{cells} cells, {nodes} vertices, {} creases ({feature_edges} features)\n{}\n",
            self.creases,
            self.smooth()
        )
    }
}

/// The regions and groups with their cells or faces, volumes and areas.
pub(in super::super) fn parts(mesh: &HexMesh) -> String {
    let mut sums = vec![(0_usize, 0.0); mesh.region_names().len()];
    for (t, region) in mesh.regions().iter().enumerate() {
        let (cells, volume) = &mut sums[region.0 as usize];
        *cells += 1;
        *volume += cell_volume(&mesh.cell_points(t));
    }
    let mut rows = table("region|cells|volume");
    for (name, (cells, volume)) in mesh.region_names().iter().zip(sums) {
        rows.add_row([name.clone(), cells.to_string(), format!("{volume:.6}")]);
    }
    let mut described = format!("\n{}\n", text(rows));
    if mesh.groups().is_empty() {
        return described + "\nno groups of boundary faces\n";
    }
    let mut rows = table("group|faces|area");
    for (id, name) in (0..).map(GroupId).zip(mesh.groups()) {
        let faces: Vec<usize> = mesh.group_faces(id).collect();
        let area = format!("{:.6}", select::area(mesh, faces.iter().copied()));
        rows.add_row([name.clone(), faces.len().to_string(), area]);
    }
    // Writing to a string cannot fail.
    let _ = write!(described, "\n{}\n", text(rows));
    described
}

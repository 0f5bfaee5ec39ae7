//! `subsolid inspect`: what a mesh file holds.

use super::describe::{self, MeshDetails, Region};
use super::hexes::{self, HexReport};
use super::{load, print, select, span, wrapped};
use crate::error::Error;
use crate::mesh::hex::read::HexFile;
use crate::mesh::read::AnyMesh;
use crate::mesh::{GroupId, Tagged as _, TetMesh, features, quality, read, topology};
use crate::output::atomic::ensure_target;
use crate::output::report::write_json;
use crate::output::table::{table, text};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What the command line says about an inspection.
#[derive(Debug, Clone)]
pub struct Inspection {
    /// The mesh file.
    pub mesh: PathBuf,
    /// Feature angle in degrees.
    pub feature_angle: f64,
    /// Print errors only.
    pub quiet: bool,
    /// File for the figures.
    pub json: Option<PathBuf>,
}

/// Reads a mesh and prints its counts, groups, regions and quality.
///
/// # Errors
/// [`Error::Mesh`] or [`Error::Hex`] if it cannot be read, [`Error::Output`] if the JSON file cannot be written.
pub fn inspect(inspection: &Inspection) -> Result<(), Error> {
    let json = &inspection.json;
    json.iter().try_for_each(|path| ensure_target(path, [&*inspection.mesh]))?;
    let start = Instant::now();
    let file = match read::read_any(&load::find(&inspection.mesh, Path::new(""))?)? {
        AnyMesh::Tets(file) => file,
        AnyMesh::Hexes(file) => return inspect_hexes(inspection, *file, start),
    };
    let mesh = features::with_creases(file.mesh, inspection.feature_angle, &[]);
    if let Some(path) = &inspection.json {
        write_json(path, &MeshDetails::of(&mesh, mesh.groups().len(), start.elapsed().as_secs_f64()))?;
    }
    if inspection.quiet {
        return Ok(());
    }
    let mut text = describe_mesh(&mesh, file.format);
    file.notes.iter().for_each(|note| text += &wrapped(&format!("note: {note}")));
    text += &describe_regions(&mesh);
    text += &describe_groups(&mesh, mesh.groups().len());
    print(&text)
}

fn inspect_hexes(inspection: &Inspection, file: HexFile, start: Instant) -> Result<(), Error> {
    let mesh = file.mesh.with_creases(inspection.feature_angle, &[]);
    let report = HexReport::of(&mesh, start.elapsed().as_secs_f64());
    if let Some(path) = &inspection.json {
        write_json(path, &report)?;
    }
    if inspection.quiet {
        return Ok(());
    }
    let mut text = report.table(&mesh, file.format);
    file.notes.iter().for_each(|note| text += &wrapped(&format!("note: {note}")));
    print(&(text + &hexes::describe::parts(&mesh)))
}

/// The measures beside the minimum dihedral angle that Burkhart, Hamann and Umlauf 2010 name.
const MEASURES: [(&str, quality::CellMeasure); 3] = [
    ("minimum sines of these", quality::min_sine),
    ("minimum solid angles, sr", quality::min_solid_angle),
    ("shortest to longest edge", quality::edge_ratio),
];

/// Counts, size and quality.
pub(super) fn describe_mesh(mesh: &TetMesh, format: &str) -> String {
    let q = quality::quality(mesh);
    let (feature_edges, length) = features::feature_count_and_length(mesh);
    let (_, parts) = mesh.connected_parts();
    let mut rows = table(&format!("mesh|{format}"));
    let mut row = |what: &str, value: String| {
        rows.add_row([what.to_owned(), value]);
    };
    row("cells", mesh.tets().len().to_string());
    row("nodes", mesh.points().len().to_string());
    row("edges", topology::edges(mesh.tets()).len().to_string());
    row("boundary faces", mesh.faces().len().to_string());
    row("feature edges", format!("{feature_edges}, total length {length:.6}"));
    row("connected parts", parts.to_string());
    row("volume", format!("{:.6}", mesh.volume()));
    row("bounding box", span(mesh));
    row(
        "minimum dihedral angles",
        format!("worst {:.2}, average {:.2}, best {:.2} degrees", q.worst, q.average, q.best),
    );
    for (name, measure) in MEASURES {
        let (worst, mean) = quality::worst_and_mean(mesh, measure);
        row(name, format!("worst {worst:.4}, average {mean:.4}"));
    }
    let above = 100.0 * q.valence_above_50;
    let valence = format!("at most {}, average {:.2}, above 50 at {above:.2} %", q.max_valence, q.average_valence);
    row("cells at a vertex", valence);
    row("inverted cells", q.inverted.to_string());
    text(rows) + "\n"
}

/// The regions with their cells and volumes.
fn describe_regions(mesh: &TetMesh) -> String {
    let mut rows = table("region|cells|volume");
    for Region { name, cells, volume } in describe::regions(mesh) {
        rows.add_row([name, cells.to_string(), format!("{volume:.6}")]);
    }
    format!("\n{}\n", text(rows))
}

/// The first `count` groups with their faces and areas.
pub(super) fn describe_groups(mesh: &TetMesh, count: usize) -> String {
    if count == 0 {
        return "\nno groups of boundary faces\n".to_owned();
    }
    let mut rows = table("group|faces|area");
    for (id, name) in (0..).map(GroupId).zip(&mesh.groups()[..count]) {
        let area = select::area(mesh, mesh.faces_of(id));
        rows.add_row([name.clone(), mesh.group_faces(id).count().to_string(), format!("{area:.6}")]);
    }
    format!("\n{}\n", text(rows))
}

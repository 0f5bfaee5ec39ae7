//! Shapes to be embedded in a solid: points with the triangles, polygons and cells between them, of which nothing is asked.

use super::nodes::Index;
use super::{error_at, open, unreadable_file};
use crate::mesh::{MeshError, Place};
use glam::DVec3;
use std::path::Path;

/// Points, and what is between them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Shape {
    /// Positions.
    pub points: Vec<DVec3>,
    /// Polygons of three corners or more.
    pub polygons: Vec<Vec<u32>>,
    /// Tetrahedra.
    pub tets: Vec<[u32; 4]>,
}

const HELP: &str = "read: Wavefront OBJ (.obj), STL (.stl), and all formats of meshes with their triangles";

/// Reads a shape: Wavefront OBJ and STL by the names of their files, all formats of meshes by their content. Of these the
/// nodes with their triangles, quadrilaterals and tetrahedra are taken.
///
/// # Errors
/// [`MeshError::Unreadable`], [`MeshError::UnknownFormat`] or [`MeshError::Syntax`].
pub fn read_shape(path: &Path) -> Result<Shape, MeshError> {
    let is = |extension: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension));
    let shape = match () {
        () if is("obj") => obj(path)?,
        () if is("stl") => stl(path)?,
        () => of_mesh(path).map_err(with_shapes)?,
    };
    let problem = |message: String| Err(error_at(path, Place::Line(1), message, HELP));
    if shape.points.is_empty() {
        let of_faces = if is("obj") { "faces: the points of OBJ files are those of their faces" } else { "points" };
        return problem(format!("the file has no {of_faces}"));
    }
    match shape.points.iter().position(|p| !p.is_finite()) {
        Some(point) => problem(format!("point {point} is not at a finite position")),
        None => Ok(shape),
    }
}

/// The error with the formats of shapes beside those of meshes.
fn with_shapes(error: MeshError) -> MeshError {
    match error {
        MeshError::UnknownFormat { path, message } => error_at(&path, Place::Line(1), message, HELP),
        other => other,
    }
}

fn obj(path: &Path) -> Result<Shape, MeshError> {
    // Polygons as they are; materials are not looked at.
    let options = tobj::LoadOptions::default();
    let file = std::fs::File::open(path).map_err(|source| unreadable_file("shape", path, source))?;
    let mut reader = std::io::BufReader::new(file);
    let no_material = |_: &Path| -> tobj::MTLLoadResult { Ok(Default::default()) };
    let (models, _) = tobj::load_obj_buf(&mut reader, &options, no_material)
        .map_err(|error| error_at(path, Place::Line(1), format!("no Wavefront OBJ file: {error}"), HELP))?;
    let mut shape = Shape::default();
    for tobj::Model { mesh, .. } in models {
        let first = shape.points.len() as u32;
        shape.points.extend(mesh.positions.chunks_exact(3).map(DVec3::from_slice));
        let mut rest = mesh.indices.as_slice();
        let triangles = vec![3; if mesh.face_arities.is_empty() { rest.len() / 3 } else { 0 }];
        for &corners in mesh.face_arities.iter().chain(&triangles) {
            let (own, tail) = rest.split_at(corners as usize);
            rest = tail;
            if corners > 2 {
                shape.polygons.push(own.iter().map(|v| first + v).collect());
            }
        }
    }
    Ok(shape)
}

fn stl(path: &Path) -> Result<Shape, MeshError> {
    let file = std::fs::File::open(path).map_err(|source| unreadable_file("shape", path, source))?;
    let mesh = stl_io::read_stl(&mut std::io::BufReader::new(file))
        .map_err(|error| error_at(path, Place::Line(1), format!("no STL file: {error}"), HELP))?;
    let point = |v: &stl_io::Vertex| DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]));
    Ok(Shape {
        points: mesh.vertices.iter().map(point).collect(),
        polygons: mesh.faces.iter().map(|face| face.vertices.iter().map(|&v| v as u32).collect()).collect(),
        tets: Vec::new(),
    })
}

fn of_mesh(path: &Path) -> Result<Shape, MeshError> {
    let (_, mut raw) = open(path)?;
    let index = Index::new(path, &raw)?;
    let (mut triangles, mut quads) = (std::mem::take(&mut raw.triangles.nodes), std::mem::take(&mut raw.quads.nodes));
    let mut tets = std::mem::take(&mut raw.tets.nodes);
    index.resolve("triangle", &mut triangles, &raw, &raw.triangles.ids, &raw.triangles.places)?;
    index.resolve("quadrilateral", &mut quads, &raw, &raw.quads.ids, &raw.quads.places)?;
    index.resolve("tetrahedron", &mut tets, &raw, &raw.tets.ids, &raw.tets.places)?;
    let polygons = triangles.iter().map(|t| t.to_vec()).chain(quads.iter().map(|q| q.to_vec())).collect();
    Ok(Shape { points: std::mem::take(&mut raw.nodes.positions), polygons, tets })
}

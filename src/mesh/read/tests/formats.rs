//! MEDIT, VTK and binary Gmsh files: what their errors say.

use super::*;

pub(super) const MEDIT: &str = "\
MeshVersionFormatted 2
Dimension
3
# a comment
Vertices 5
0 0 0 0
1 0 0 0  0 1 0 0
0 0 1 0
0 0 -1 0
Corners 1 5
Triangles
2
1 2 4 7
1 3 5 0
Tetrahedra
2
1 2 3 4 1
1 3 2 5 2
End
";

pub(super) const VTK: &str = "\
# vtk DataFile Version 3.0
two cells
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 5 double
0 0 0
1 0 0 0 1 0
0 0 1 0 0 -1
CELLS 4 17
3 0 1 3
4 0 1 2 3
2 0 1
4 0 2 1 4
CELL_TYPES 4
5 10 3 10
CELL_DATA 4
SCALARS temperature float
LOOKUP_TABLE default
1 2 3 4
FIELD data 1
Region 1 4 int
7 1 0 2
POINT_DATA 5
VECTORS displacement float
0 0 0 0 0 0 0 0 0 0 0 0 0 0 0
";

#[test]
fn medit_references_become_regions_and_groups() {
    let MeshFile { mesh, format, .. } = parse_text(MEDIT).unwrap();
    assert_eq!((format, mesh.tets()), ("MEDIT ASCII", parse_text(MSH2).unwrap().mesh.tets()));
    assert_eq!(mesh.region_names(), ["volume-1", "volume-2"]);
    assert_eq!((mesh.groups(), area(&mesh, "surface-7")), (&["surface-7".to_owned()][..], 0.5));
}

#[test]
fn faults_of_medit_files_are_named_with_their_line() {
    assert_fault(&MEDIT.replace("Vertices 5", "Vertices 4000000000"), 5, &["4000000000 vertices", "bytes"]);
    assert_fault(&MEDIT.replace("Vertices 5", "Vertices 4"), 9, &["keyword", "\"0\""]);
    assert_fault(&MEDIT.replace("Vertices 5", "Vertices 6"), 10, &["x is", "Corners"]);
    assert_fault(&MEDIT.replace("1 3 2 5 2", "1 3 2 9 2"), 18, &["tetrahedron 2", "node 9"]);
    assert_fault(&MEDIT.replace("Dimension\n3", "Dimension\n2"), 3, &["dimension 2"]);
    assert_fault(&MEDIT.replace("Tetrahedra\n", "Hexahedra\n"), 16, &["hexahedra", "only tetrahedra are read"]);
    assert_fault(&MEDIT[..MEDIT.find("1 3 2 5 2").unwrap()], 18, &["end of the file", "cut off"]);
    assert_fault(&MEDIT.replace("Vertices", "Vertexes"), 19, &["Vertices is missing"]);
    let binary = parse_bytes(&[1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0]).unwrap_err();
    assert!(binary.to_string().contains(".meshb"), "{binary}");
}

#[test]
fn vtk_cell_data_become_regions_and_groups() {
    let MeshFile { mesh, format, notes, .. } = parse_text(VTK).unwrap();
    assert_eq!((format, mesh.tets()), ("VTK legacy ASCII", parse_text(MSH2).unwrap().mesh.tets()));
    assert_eq!(mesh.region_names(), ["volume-1", "volume-2"]);
    assert_eq!((mesh.groups(), area(&mesh, "surface-7")), (&["surface-7".to_owned()][..], 0.5));
    assert!(notes.iter().any(|note| note.contains("1 cells that are no solids")), "{notes:?}");
}

#[test]
fn faults_of_vtk_files_are_named_with_their_line() {
    assert_fault(&VTK.replace("POINTS 5", "POINTS 4000000000"), 5, &["4000000000 points", "bytes"]);
    assert_fault(&VTK.replace("1 0 0 0 1 0\n", "1 zero 0 0 1 0\n"), 7, &["zero"]);
    assert_fault(&VTK.replace("1 0 0 0 1 0\n", "1 inf 0 0 1 0\n"), 7, &["node 1", "not a finite number"]);
    assert_fault(&VTK.replace("4 0 2 1 4", "4 0 2 1 9"), 13, &["tetrahedron 3", "node 9"]);
    assert_fault(&VTK.replace("4 0 2 1 4", "4 0 2 -1 4"), 13, &["cell 3", "point -1"]);
    assert_fault(&VTK.replace("5 10 3 10", "5 10 3 12"), 13, &["cell 3", "hexahedron", "8, 20 or 27"]);
    assert_fault(&VTK.replace("CELLS 4 17", "CELLS 5 17"), 13, &["5 cells"]);
    assert_fault(&VTK.replace("UNSTRUCTURED_GRID", "POLYDATA"), 4, &["POLYDATA"]);
    assert_fault(&VTK.replace("Region 1 4 int", "Region 1 4 string"), 21, &["string"]);
    assert_fault(&VTK[..VTK.find("CELL_TYPES").unwrap()], 13, &["CELL_TYPES"]);
}

/// Byte, message and help of the error that a file gives.
fn assert_byte_fault(name: &str, change: impl Fn(&mut Vec<u8>), words: &[&str]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes").join(name);
    let mut bytes = std::fs::read(&path).unwrap();
    change(&mut bytes);
    let error = parse(&path, &bytes[..], bytes.len() as u64, Edges::Straight).unwrap_err();
    let MeshError::Syntax { at: Place::Byte(at), message, help, .. } = error else { panic!("{name}: {error}") };
    assert!(at <= bytes.len());
    for word in words {
        assert!(message.contains(word) || help.contains(word), "{name}: {word:?} is not in {message:?}, {help:?}");
    }
}

/// Replaces one text in a file by another.
fn replace<'a>(old: &'a str, new: &'a str) -> impl Fn(&mut Vec<u8>) + 'a {
    move |bytes| {
        let at = bytes.windows(old.len()).position(|window| window == old.as_bytes()).unwrap();
        bytes.splice(at..at + old.len(), new.bytes());
    }
}

#[test]
fn faults_of_binary_files_are_named_with_their_byte() {
    let nodes = |bytes: &[u8]| bytes.windows(7).position(|window| window == b"$Nodes\n").unwrap() + 7;
    let huge = |bytes: &mut Vec<u8>| {
        let at = nodes(bytes) + 8;
        bytes[at..at + 8].fill(0x7f);
    };
    assert_byte_fault("gmsh41_binary.msh", huge, &["nodes are announced", "bytes of the file remain"]);
    let cut = |bytes: &mut Vec<u8>| bytes.truncate(nodes(bytes) + 300);
    assert_byte_fault("gmsh41_binary.msh", cut, &["end of the file", "cut off"]);
    assert_byte_fault("gmsh41_binary.msh", replace("4.1 1 8\n\u{1}", "4.1 1 8\n\u{2}"), &["order of bytes"]);
    assert_byte_fault("gmsh41_binary.msh", replace("4.1 1 8", "4.1 1 4"), &["versions 2.2 and 4.1"]);
    assert_byte_fault("gmsh22_binary.msh", |bytes| bytes.truncate(bytes.len() - 40), &["end of the file"]);
    assert_byte_fault("vtk51_binary.vtk", replace("POINTS 62", "POINTS 99999999"), &["99999999 points"]);
}

#[test]
fn faults_of_vtu_files_are_named_with_their_byte() {
    let file = "vtk_inline.vtu";
    assert_byte_fault(file, replace("Piece NumberOfPoints=\"62\"", "Piece NumberOfPoints=\"63\""), &["Points", "63"]);
    assert_byte_fault(file, replace("Piece NumberOfPoints=\"62\"", "Piece NumberOfPoints=\"x\""), &["whole number"]);
    assert_byte_fault(file, replace("UnstructuredGrid", "PolyData"), &["PolyData"]);
    assert_byte_fault(file, replace("</Piece>", ""), &["XML"]);
    assert_byte_fault(file, replace("Name=\"types\"", "Name=\"kinds\""), &["no array \"types\""]);
    let lzma = replace("byte_order", "compressor=\"vtkLZMADataCompressor\" byte_order");
    assert_byte_fault(file, lzma, &["vtkLZMADataCompressor", "Zlib or LZ4"]);
    assert_byte_fault("vtk_raw.vtu", |bytes| bytes.truncate(bytes.len() - 100), &["cut off"]);
    assert_byte_fault(
        "meshio_ascii.vtu",
        replace("<DataArray type=\"Float64\"", "<DataArray type=\"String\""),
        &["type"],
    );
}

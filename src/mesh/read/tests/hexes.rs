//! Meshes of hexahedra: agreement of the formats, second order, tags, and what is refused.

use super::*;
use crate::mesh::hex::features::face_normal;
use crate::mesh::hex::{HexError, HexMesh};
use crate::mesh::read::hexes::{HexFile, parse as parse_hexes};
use glam::DVec3;
use proptest::prelude::*;

/// Two cubes one above the other; the lowest face is in two groups, the one between them in a third.
const MSH2: &str = "\
$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
3
2 1 \"base\"
3 1 \"lower\"
3 2 \"upper\"
$EndPhysicalNames
$Nodes
13
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
5 0 0 1
6 1 0 1
7 1 1 1
8 0 1 1
9 0 0 2
10 1 0 2
11 1 1 2
12 0 1 2
13 9 9 9
$EndNodes
$Elements
7
1 15 2 9 1 1
2 3 2 1 11 1 2 3 4
3 3 2 2 11 4 3 2 1
4 3 2 3 12 5 6 7 8
5 3 2 4 13 9 10 11 12
8 5 2 1 1 1 2 3 4 5 6 7 8
9 5 2 2 2 5 6 7 8 9 10 11 12
$EndElements
";

const MSH4: &str = "\
$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
3
2 1 \"base\"
3 1 \"lower\"
3 2 \"upper\"
$EndPhysicalNames
$Entities
0 0 3 2
11 0 0 0 1 1 0 2 1 2 0
12 0 0 1 1 1 1 1 3 0
13 0 0 2 1 1 2 1 4 0
1 0 0 0 1 1 1 1 1 0
2 0 0 1 1 1 2 1 2 0
$EndEntities
$Nodes
1 13 1 13
3 1 0 13
1
2
3
4
5
6
7
8
9
10
11
12
13
0 0 0
1 0 0
1 1 0
0 1 0
0 0 1
1 0 1
1 1 1
0 1 1
0 0 2
1 0 2
1 1 2
0 1 2
9 9 9
$EndNodes
$Elements
5 5 2 9
2 11 3 1
2 1 2 3 4
2 12 3 1
4 5 6 7 8
2 13 3 1
5 9 10 11 12
3 1 5 1
8 1 2 3 4 5 6 7 8
3 2 5 1
9 5 6 7 8 9 10 11 12
$EndElements
";

const INP: &str = "\
*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
9, 0, 0, 2
10, 1, 0, 2
11, 1, 1, 2
12, 0, 1, 2
*ELEMENT, TYPE=C3D8R, ELSET=lower
8, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=C3D8, ELSET=upper
9, 5, 6, 7, 8,
 9, 10, 11, 12
*ELEMENT, TYPE=S4R, ELSET=base
2, 4, 3, 2, 1
*SURFACE, NAME=lid
upper, S2
*SURFACE, NAME=front
lower, S3
upper, S3
*SURFACE, NAME=right
9, S4
*SURFACE, NAME=back
9, S5
*SURFACE, NAME=left
9, S6
*NSET, NSET=bottom
1, 2, 3, 4
";

/// The first cell as a voxel.
const VTK: &str = "\
# vtk DataFile Version 3.0
two cells
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 12 double
0 0 0 1 0 0 1 1 0 0 1 0
0 0 1 1 0 1 1 1 1 0 1 1
0 0 2 1 0 2 1 1 2 0 1 2
CELLS 3 23
8 0 1 3 2 4 5 7 6
4 0 3 2 1
8 4 5 6 7 8 9 10 11
CELL_TYPES 3
11 9 12
CELL_DATA 3
SCALARS Region int
LOOKUP_TABLE default
1 5 2
";

const TEXTS: [&str; 4] = [MSH2, MSH4, INP, VTK];

fn read_text(text: &str) -> Result<HexFile, HexError> {
    parse_hexes(Path::new("test.msh"), text.as_bytes(), text.len() as u64)
}

/// Asserts that a text is refused at a line, with words of the message and of the help.
fn assert_refused(text: &str, line: usize, words: &[&str]) {
    let Err(HexError::File(MeshError::Syntax { at: Place::Line(at), message, help, .. })) = read_text(text) else {
        panic!("no syntax error")
    };
    assert_eq!(at, line, "{message}");
    for word in words {
        assert!(message.contains(word) || help.contains(word), "{word:?} is not in {message:?}, {help:?}");
    }
}

fn normal(mesh: &HexMesh, group: &str) -> DVec3 {
    let group = mesh.group(group).unwrap();
    mesh.group_faces(group).map(|f| 0.5 * face_normal(mesh.points(), mesh.faces()[f].vertices)).sum()
}

#[test]
fn all_formats_give_the_same_cells() {
    for text in TEXTS {
        let mesh = read_text(text).unwrap().mesh;
        assert_eq!(mesh.cells(), [[0, 1, 3, 2, 4, 5, 7, 6], [4, 5, 7, 6, 8, 9, 11, 10]], "{text}");
        assert!((mesh.volume() - 2.0).abs() < 1e-15 && mesh.faces().len() == 10);
        assert_eq!(mesh.regions(), [RegionId(0), RegionId(1)]);
    }
}

#[test]
fn physical_groups_become_regions_and_groups() {
    for text in [MSH2, MSH4] {
        let file = read_text(text).unwrap();
        assert_eq!(file.mesh.region_names(), ["lower", "upper"]);
        assert_eq!(file.mesh.groups(), ["base", "surface-2", "surface-4"]);
        assert_eq!(file.inner_groups, ["surface-3"]);
        assert_eq!(normal(&file.mesh, "base"), -DVec3::Z);
        assert_eq!(normal(&file.mesh, "surface-2"), -DVec3::Z);
        assert_eq!(normal(&file.mesh, "surface-4"), DVec3::Z);
        for words in ["1 nodes that are no corners", "1 quadrilaterals are not on the boundary"] {
            assert!(file.notes.iter().any(|n| n.contains(words)), "{words}: {:?}", file.notes);
        }
    }
}

#[test]
fn abaqus_faces_are_those_of_its_manual() {
    let mesh = read_text(INP).unwrap().mesh;
    assert_eq!(mesh.region_names(), ["lower", "upper"]);
    let want = [
        ("base", -DVec3::Z),
        ("lid", DVec3::Z),
        ("front", -2.0 * DVec3::Y),
        ("right", DVec3::X),
        ("back", DVec3::Y),
        ("left", -DVec3::X),
        ("bottom", -DVec3::Z),
    ];
    for (group, area) in want {
        assert_eq!(normal(&mesh, group), area, "{group}");
    }
    assert_refused(&INP.replace("upper, S2", "upper, S7"), 22, &["S1 to S6", "hexahedron"]);
}

/// A cube of 20 nodes whose edge between the nodes 2 and 3 is bent, in the order of VTK and Abaqus, and of Gmsh.
fn bent(order: [usize; 12]) -> (String, String) {
    let corners = ["0 0 0", "2 0 0", "2 2 0", "0 2 0", "0 0 2", "2 0 2", "2 2 2", "0 2 2"];
    let mids =
        ["1 0 0", "2.5 1 0", "1 2 0", "0 1 0", "1 0 2", "2 1 2", "1 2 2", "0 1 2", "0 0 1", "2 0 1", "2 2 1", "0 2 1"];
    let nodes: Vec<String> =
        corners.into_iter().chain(order.map(|k| mids[k])).zip(1..).map(|(p, id)| format!("{id} {p}\n")).collect();
    (nodes.concat(), (1..=20).map(|id| format!(" {id}")).collect())
}

#[test]
fn curved_edges_of_second_order_cells_are_kept() {
    let (nodes, cell) = bent([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]);
    let inp =
        format!("*NODE\n{nodes}*ELEMENT, TYPE=C3D20R\n1{cell}\n").replace(' ', ", ").replace("ELEMENT, ,", "ELEMENT,");
    // Gmsh goes through the edges from their lowest corners.
    let (nodes, cell) = bent([0, 3, 8, 1, 9, 2, 10, 11, 4, 7, 5, 6]);
    let head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n20\n";
    let msh = format!("{head}{nodes}$EndNodes\n$Elements\n1\n1 17 2 0 1{cell}\n$EndElements\n");
    for text in [inp, msh] {
        let file = read_text(&text).unwrap();
        let positions: Vec<DVec3> = file.midsides.iter().map(|m| m.position).collect();
        assert_eq!(positions, [DVec3::new(2.5, 1.0, 0.0)], "{text}");
        assert_eq!((file.midsides[0].edge, file.mesh.points().len()), ([1, 2], 8));
        assert!(file.notes.iter().any(|n| n.contains("1 edges of them curved")), "{:?}", file.notes);
    }
}

#[test]
fn a_mesh_inside_out_is_flipped_and_one_inverted_cell_is_refused() {
    let one = MSH2.replace("1 2 3 4 5 6 7 8\n9", "5 6 7 8 1 2 3 4\n9");
    assert_refused(&one, 33, &["hexahedron 8", "twisted", "vertex 5", "right-handed"]);
    let both = one.replace("5 6 7 8 9 10 11 12\n$End", "9 10 11 12 5 6 7 8\n$End");
    let file = read_text(&both).unwrap();
    assert!((file.mesh.volume() - 2.0).abs() < 1e-15);
    assert!(file.notes.iter().any(|n| n.contains("all 2 hexahedra were inverted")), "{:?}", file.notes);
}

#[test]
fn faults_are_named_by_the_ids_of_the_file() {
    assert_refused(&with_line(MSH2, 34, "9 5 2 2 2 5 6 7 8 9 10 11 99"), 34, &["hexahedron 9", "node 99"]);
    assert_refused(&with_line(MSH2, 34, "9 5 2 2 2 5 6 7 8 9 10 11 11"), 34, &["hexahedron 9", "vertex 11 twice"]);
    assert_refused(&with_line(MSH2, 30, "3 3 2 2 11 4 3 2 99"), 30, &["quadrilateral 3", "node 99"]);
    let again =
        MSH2.replace("$Elements\n7", "$Elements\n8").replace("12\n$EndE", "12\n7 5 2 2 2 5 6 7 8 9 10 11 12\n$EndE");
    assert_refused(&again, 35, &["hexahedra 9 and 7", "do not match at face"]);
    assert!(matches!(read_text(&MSH2.replace("5 6 7 8 9 10", "5 6 7")), Err(HexError::File(_))));
}

#[test]
fn other_and_mixed_cells_are_refused_with_what_fits() {
    let fits = "analysis.element";
    assert_fault(
        MSH2,
        33,
        &["element 8 is a hexahedron", "2 hexahedra and no tetrahedra", fits, "catmull-clark", "hex20"],
    );
    assert_refused(super::MSH2, 28, &["2 tetrahedra", "element 8", "no hexahedra", fits, "tet10"]);
    let mixed = with_line(MSH2, 34, "9 4 2 2 2 5 6 7 9");
    assert_refused(&mixed, 34, &["1 tetrahedra", "element 9", "beside 1 hexahedra", "one kind of cells"]);
    assert_fault(&mixed, 33, &["1 hexahedra and 1 tetrahedra"]);
    let wedge = with_line(MSH2, 34, "9 6 2 2 2 5 6 7 9 10 11");
    assert_refused(&wedge, 34, &["element 9", "a prism", "hexahedra alone"]);
    let surface: String =
        MSH2.lines().filter(|l| !l.starts_with("8 5") && !l.starts_with("9 5")).map(|l| format!("{l}\n")).collect();
    assert!(matches!(read_text(&surface.replace("$Elements\n7", "$Elements\n5")), Err(HexError::NoCells)));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Whatever is done to a file, reading it gives a valid mesh or an error.
    #[test]
    fn damaged_files_never_panic(which in 0..TEXTS.len(), damages in prop::collection::vec(damage::damage(), 1..4)) {
        let text = damages.iter().fold(TEXTS[which].to_owned(), |text, d| damage::apply(&text, d));
        if let Ok(file) = read_text(&text) {
            prop_assert!(HexMesh::new(file.mesh.into_parts()).is_ok());
        }
    }
}

//! Tests of the readers: real input, agreement of the formats; faults and random damage have files of their own.

mod abaqus;
mod damage;
mod faults;
mod formats;
mod hexes;

use super::*;
use crate::mesh::{GroupId, RegionId, features::face_normal};

/// Two tetrahedra on either side of z = 0 and their triangles; face 1 2 4 is in two groups, 1 2 3 is inside.
const MSH2: &str = "\
$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
4
2 1 \"base\"
2 2 \"front side\"
3 1 \"upper\"
3 2 \"lower\"
$EndPhysicalNames
$Nodes
5
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
5 0 0 -1
$EndNodes
$Elements
9
1 15 2 9 1 1
2 1 2 0 1 1 2
3 2 2 2 11 1 2 4
4 2 2 1 12 1 2 4
5 2 2 1 12 1 3 5
6 2 2 7 13 2 3 4
7 2 2 7 13 1 2 3
8 4 2 1 1 1 2 3 4
9 4 2 2 2 1 3 2 5
$EndElements
$Periodic
0
$EndPeriodic
";

/// The same mesh.
const MSH4: &str = "\
$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
4
2 1 \"base\"
2 2 \"front side\"
3 1 \"upper\"
3 2 \"lower\"
$EndPhysicalNames
$Entities
1 1 4 2
1 0 0 0 1 9
1 0 0 0 1 0 0 0 2 1 -1
11 0 0 0 1 0 1 2 1 2 0
12 0 0 -1 0 1 0 1 1 0
13 0 0 0 1 1 1 1 7 0
14 0 0 0 1 1 1 1 7 0
1 0 0 0 1 1 1 1 1 0
2 0 0 -1 1 1 0 1 2 0
$EndEntities
$Nodes
2 5 1 5
0 1 0 1
1
0 0 0
1 1 1 4
2
3
4
5
1 0 0 0.5
0 1 0 0.5
0 0 1 0.5
0 0 -1 0.5
$EndNodes
$Elements
8 8 1 9
0 1 15 1
1 1
1 1 1 1
2 1 2
2 11 2 1
3 1 2 4
2 12 2 1
5 1 3 5
2 13 2 1
6 2 3 4
2 14 2 1
7 1 2 3
3 1 4 1
8 1 2 3 4
3 2 4 1
9 1 3 2 5
$EndElements
";

const GID: &str = "\
# exported
MESH \"part one\" dimension 3 ElemType Tetrahedra Nnode 4
Coordinates
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
5 0 0 -1
End Coordinates

Elements
8 1 2 3 4 1
9 1 3 2 5 2
End Elements
";

fn parse_text(text: &str) -> Result<MeshFile, MeshError> {
    parse_bytes(text.as_bytes())
}

fn parse_bytes(bytes: &[u8]) -> Result<MeshFile, MeshError> {
    parse(Path::new("test.msh"), bytes, bytes.len() as u64, Edges::Straight)
}

/// Line, message and help of the syntax error that a text gives.
fn fault(text: &str) -> (usize, String, String) {
    match parse_text(text) {
        Err(MeshError::Syntax { at: Place::Line(line), message, help, .. }) => (line, message, help),
        other => panic!("no syntax error but {other:?}"),
    }
}

/// Asserts the line of the fault and words of its message.
fn assert_fault(text: &str, line: usize, words: &[&str]) {
    let (found, message, help) = fault(text);
    assert_eq!(found, line, "{message}");
    for word in words {
        assert!(message.contains(word) || help.contains(word), "{word:?} is not in {message:?}, {help:?}");
    }
}

/// The text with one line (counted from 1) replaced.
fn with_line(text: &str, number: usize, new: &str) -> String {
    text.lines().zip(1..).map(|(old, n)| format!("{}\n", if n == number { new } else { old })).collect()
}

fn area(mesh: &TetMesh, name: &str) -> f64 {
    let group = mesh.group(name).unwrap();
    mesh.group_faces(group).map(|f| 0.5 * face_normal(mesh.points(), f.vertices).length()).sum()
}

#[test]
fn the_tripod_has_the_published_counts() {
    let Some(folder) = std::env::var_os("SUBSOLID_DATA") else {
        println!("skipped: SUBSOLID_DATA is not set");
        return;
    };
    let MeshFile { mesh, format, notes, .. } = read(&Path::new(&folder).join("tripod.GiD.msh")).unwrap();
    assert_eq!(format, "GiD ASCII");
    assert_eq!((mesh.tets().len(), mesh.points().len(), mesh.faces().len()), (2799, 967, 1710));
    assert_eq!(crate::mesh::topology::edges(mesh.tets()).len(), 4621);
    assert!((mesh.volume() - 16836.15).abs() < 0.005, "{}", mesh.volume());
    assert_eq!(mesh.region_names(), ["solid"]);
    // One mid-side node an edge; 5621 nodes in the file.
    assert!(notes.iter().any(|n| n.contains("33 nodes belong to no tetrahedron")), "{notes:?}");
    assert!(notes.iter().any(|n| n.contains("2799 ten-node") && n.contains("4621 mid-side")), "{notes:?}");
}

#[test]
fn both_gmsh_formats_give_the_same_mesh() {
    let [two, four] = [MSH2, MSH4].map(|text| parse_text(text).unwrap());
    assert_eq!((two.format, four.format), ("Gmsh MSH 2.2 ASCII", "Gmsh MSH 4.1 ASCII"));
    let (mesh, other) = (two.mesh.clone().into_parts(), four.mesh.into_parts());
    assert_eq!(mesh.points, other.points);
    assert_eq!((&mesh.tets, &mesh.regions, &mesh.levels), (&other.tets, &other.regions, &other.levels));
    assert_eq!((&mesh.faces, &mesh.patches, &mesh.groups), (&other.faces, &other.patches, &other.groups));
    assert_eq!(mesh.region_names, other.region_names);
}

#[test]
fn physical_names_become_regions_and_groups() {
    let MeshFile { mesh, notes, .. } = parse_text(MSH2).unwrap();
    assert_eq!(mesh.region_names(), ["upper", "lower"]);
    assert_eq!(mesh.regions(), [RegionId(0), RegionId(1)]);
    assert_eq!(mesh.groups(), ["base", "front side", "surface-7"]);
    assert_eq!(area(&mesh, "base"), 1.0);
    assert_eq!(area(&mesh, "front side"), 0.5);
    assert!((area(&mesh, "surface-7") - 0.75_f64.sqrt()).abs() < 1e-15);
    assert_eq!(mesh.patch_groups().iter().filter(|groups| **groups == [GroupId(0), GroupId(1)]).count(), 1);
    assert!(
        notes.iter().any(|n| n.contains("1 triangle is not on the boundary") && n.contains("`surface-7`")),
        "{notes:?}"
    );
    // One of its triangles is a boundary face; alone in a group, the one inside makes it an inner group.
    assert!(parse_text(MSH2).unwrap().inner_groups.is_empty());
    let inner = parse_text(&MSH2.replace("7 2 2 7 13 1 2 3", "7 2 2 8 13 1 2 3")).unwrap();
    assert_eq!((inner.inner_groups, inner.mesh.groups().len()), (vec!["surface-8".to_owned()], 3));
}

#[test]
fn surfaces_name_the_groups_of_a_file_without_physical_groups() {
    let text = MSH2.replace("2 2 2 11", "2 2 0 11").replace("2 2 1 12", "2 2 0 12").replace("2 2 7 13", "2 2 0 13");
    let mesh = parse_text(&text.replace("4 2 1 1", "4 2 0 1").replace("4 2 2 2", "4 2 0 2")).unwrap().mesh;
    assert_eq!(mesh.groups(), ["surface-11", "surface-12", "surface-13"]);
    assert_eq!(mesh.region_names(), ["solid"]);
}

#[test]
fn an_unnamed_volume_is_named_by_its_tag() {
    let mesh = parse_text(&MSH2.replace("3 2 \"lower\"", "3 5 \"lower\"")).unwrap().mesh;
    assert_eq!(mesh.region_names(), ["upper", "volume-2"]);
}

#[test]
fn gid_materials_become_regions() {
    let mesh = parse_text(GID).unwrap().mesh;
    assert_eq!(mesh.region_names(), ["material-1", "material-2"]);
    assert_eq!(mesh.tets(), parse_text(MSH2).unwrap().mesh.tets());
}

#[test]
fn second_order_cells_give_their_corners() {
    let head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n11\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
    let mids = "5 .5 0 0\n6 .5 .5 0\n7 0 .5 0\n8 0 0 .5\n9 0 .5 .5\n10 .5 0 .5\n11 9 9 9\n$EndNodes\n";
    let text = format!("{head}{mids}$Elements\n1\n1 11 2 0 1 1 2 3 4 5 6 7 8 9 10\n$EndElements\n");
    let MeshFile { mesh, notes, .. } = parse_text(&text).unwrap();
    assert_eq!((mesh.points().len(), mesh.volume()), (4, 1.0 / 6.0));
    assert!(notes[0].contains("1 ten-node") && notes[0].contains("6 mid-side"), "{notes:?}");
    assert!(notes[1].contains("1 node belongs to no tetrahedron"), "{notes:?}");
    assert_fault(&text.replace("9 10\n$End", "9 99\n$End"), 20, &["node 99"]);
}

#[test]
fn bom_and_carriage_returns_are_accepted() {
    for text in [MSH2, MSH4, GID] {
        let windows = format!("\u{feff}{}", text.replace('\n', "\r\n"));
        assert_eq!(parse_text(&windows).unwrap().mesh.tets(), parse_text(text).unwrap().mesh.tets());
    }
}

#[test]
fn a_mesh_inside_out_is_flipped_and_one_inverted_cell_is_refused() {
    let one = MSH2.replace("1 3 2 5", "1 2 3 5");
    let Err(MeshError::NotPositiveIn { at: Place::Line(line), worst, volume, count, .. }) = parse_text(&one) else {
        panic!("accepted")
    };
    assert!(one.lines().nth(line - 1).unwrap().ends_with("1 2 3 5"), "line {line}");
    assert_eq!((worst.cell, worst.vertices, count), (9, [1, 2, 3, 5], 1));
    assert!((volume + 1.0 / 6.0).abs() < 1e-15);
    let MeshFile { mesh, notes, .. } = parse_text(&one.replace("1 2 3 4\n9", "1 3 2 4\n9")).unwrap();
    assert!((mesh.volume() - 1.0 / 3.0).abs() < 1e-15);
    assert!(notes.iter().any(|n| n.contains("all 2 tetrahedra were inverted")), "{notes:?}");
}

#[test]
fn a_flat_cell_is_refused_at_any_scale() {
    for height in ["0", "1e-15"] {
        let flat = with_line(MSH2, 17, &format!("5 0 0 -{height}"));
        assert!(matches!(parse_text(&flat), Err(MeshError::NotPositiveIn { .. })), "{height}");
    }
    let small: String = GID.replace("1 0 0\n", "1e-9 0 0\n").replace("0 1 0\n", "0 1e-9 0\n");
    let small = small.replace("0 0 1\n", "0 0 1e-9\n").replace("0 0 -1\n", "0 0 -1e-9\n");
    assert!(parse_text(&small).is_ok());
}

#[test]
fn loose_parts_coincident_nodes_and_orphans_are_noted() {
    let twice = GID.replace("5 0 0 -1", "5 0 0 -1\n6 0 0 0\n7 1 0 0\n8 0 1 0\n9 5 5 5");
    let MeshFile { mesh, notes, .. } = parse_text(&twice.replace("9 1 3 2 5 2", "9 6 8 7 5 2")).unwrap();
    assert_eq!(mesh.points().len(), 8);
    for words in ["2 parts that share no face", "3 nodes lie where", "1 node belongs to no"] {
        assert!(notes.iter().any(|n| n.contains(words)), "{words}: {notes:?}");
    }
}

//! Abaqus input: sets, sections, surfaces, and what is refused.

use super::*;

/// The two tetrahedra of `MSH2` in other ids, with sets of every kind.
pub(super) const INP: &str = "\
*Heading
 two cells
** a comment
*NODE, NSET=Nall
11, 0, 0, 0
12, 1.0, 0, 0
13, 0, 1,
14, 0, 0, 1
15, 0, 0, -1
*Element, type=C3D4, elset=Eall
101, 11, 12, 13, 14
102, 11, 13,
  12, 15
*ELEMENT, TYPE=S3, ELSET=Skin
1, 11, 12, 14
2, 12, 13, 14
*ELEMENT, TYPE=B31
7, 11, 12
*ELSET, ELSET=Upper, GENERATE
101, 4000000000, 4
*ELSET, ELSET=Lower
102,
*NSET, NSET=Base
11, 13, 15
*NSET, NSET=More
Base, 14
*SURFACE, NAME=Top, TYPE=ELEMENT
Upper, S4
102, S2
*SURFACE, NAME=Free
Upper
*MATERIAL, NAME=steel
*ELASTIC
210000, 0.3
*STEP
*END STEP
";

fn faces(mesh: &TetMesh, name: &str) -> usize {
    mesh.group_faces(mesh.group(name).unwrap()).count()
}

#[test]
fn sets_and_surfaces_become_regions_and_groups() {
    let MeshFile { mesh, format, notes, .. } = parse_text(INP).unwrap();
    assert_eq!(format, "Abaqus input");
    assert_eq!(mesh.tets(), parse_text(MSH2).unwrap().mesh.tets());
    assert_eq!(mesh.region_names(), ["Upper", "Lower"]);
    assert_eq!(mesh.regions(), [RegionId(0), RegionId(1)]);
    // Skin: two triangles. Top: side S4 of 101 (13 14 11) and side S2 of 102 (11 15 13), which are x = 0. Free: three of
    // the four faces of 101. The sets of nodes: all faces, and those of x = 0 below, and on both sides.
    let groups = ["Skin", "Top", "Free", "Nall", "Base", "More"];
    assert_eq!(mesh.groups(), groups);
    assert_eq!(groups.map(|name| faces(&mesh, name)), [2, 2, 3, 6, 1, 2]);
    assert_eq!((area(&mesh, "Top"), area(&mesh, "Base"), area(&mesh, "More")), (1.0, 0.5, 1.0));
    let note = |words: &str| notes.iter().any(|note| note.contains(words));
    assert!(note("1 lines of elements") && note("*MATERIAL, *ELASTIC, *STEP, *ENDSTEP"), "{notes:?}");
}

#[test]
fn sections_name_the_regions_before_sets_do() {
    let text = INP.replace("*STEP\n", "*SOLID SECTION, ELSET=Eall, MATERIAL=steel\n*SOLID SECTION, ELSET=LOWER\n");
    assert_eq!(parse_text(&text).unwrap().mesh.region_names(), ["Eall", "LOWER"]);
    // Sets that overlap are no regions: then those of the elements' cards are.
    let text = INP.replace("*ELSET, ELSET=Lower\n102,", "*ELSET, ELSET=Lower\n102, 101\n*ELSET, ELSET=Again\nUpper");
    assert_eq!(parse_text(&text).unwrap().mesh.region_names(), ["Eall"]);
}

#[test]
fn ten_node_cells_give_their_corners() {
    let mids = "21, .5\n22, .5, .5\n23, 0, .5\n24, 0, 0, .5\n25, .5, 0, .5\n26, 0, .5, .5\n";
    let text = format!(
        "*NODE\n11, 0\n12, 1\n13, 0, 1\n14, 0, 0, 1\n{mids}*ELEMENT, TYPE=C3D10M\n1, 11, 12, 13, 14, 21, 22, 23,\n24, 25, 26\n"
    );
    let MeshFile { mesh, notes, .. } = parse_text(&text).unwrap();
    assert_eq!((mesh.points().len(), mesh.volume()), (4, 1.0 / 6.0));
    assert!(notes[0].contains("1 ten-node") && notes[0].contains("6 mid-side"), "{notes:?}");
}

#[test]
fn what_is_not_read_is_refused_with_its_line() {
    assert_fault(&INP.replace("type=C3D4", "type=C3D8R"), 13, &["element 101", "more than the 8 nodes"]);
    assert_fault(&INP.replace("type=C3D4", "type=C3D6"), 10, &["wedges"]);
    assert_fault(&INP.replace("*STEP\n", "*INCLUDE, INPUT=more.inp\n"), 35, &["*INCLUDE", "more.inp"]);
    assert_fault(&INP.replace("*STEP\n", "*PART\n*PART\n"), 36, &["second *PART"]);
    assert_fault(&INP.replace("*Heading", "*NGEN"), 1, &["*NGEN"]);
    assert_fault(&INP.replace("NSET=Nall", "SYSTEM=C"), 4, &["coordinate system", "\"C\""]);
}

#[test]
fn faults_are_named_with_their_line() {
    assert_fault(&INP.replace("12, 1.0, 0", "12, one, 0"), 6, &["x is", "one"]);
    assert_fault(&INP.replace("12, 1.0, 0", "12, nan, 0"), 6, &["not a finite number"]);
    assert_fault(&INP.replace("  12, 15\n", ""), 12, &["element 102", "2 nodes", "type 4"]);
    assert_fault(&INP.replace("  12, 15\n", " 12, 15, 14\n"), 13, &["more than the 4"]);
    assert_fault(&INP.replace("11, 13, 15\n", "11, Nowhere\n"), 24, &["Nowhere"]);
    assert_fault(&INP.replace("102, S2", "102, S5"), 29, &["S5", "S1 to S4"]);
    assert_fault(&INP.replace("101, 4000000000, 4", "101, 4, 1"), 20, &["no range"]);
    assert_fault(&INP.replace("101, 4000000000, 4", "101, 400, 0"), 20, &["no range"]);
    assert_fault(&INP.replace("ELSET=Lower", "NAME=Lower"), 21, &["without ELSET="]);
    assert_fault(&INP.replace("102, 11, 13,", "102, 11, 99,"), 12, &["tetrahedron 102", "node 99"]);
    assert_fault("*HEADING\nnothing\n", 2, &["*NODE"]);
}

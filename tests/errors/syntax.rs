//! Classes 1 to 15: files that are no meshes, or are damaged.

use super::rough::Format::{Gid, Inp, Medit, Msh2, Msh4, Vtk, Vtu};
use super::rough::{
    ALL, COUNTED, Format, Rough, WITH_IDS, assert_fails, assert_noted, assert_refused, folder, read_bytes, refused,
};
use std::path::Path;

/// A bundled file of the tests.
fn bundled(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes").join(name)).unwrap()
}

const BINARY: [&str; 8] = [
    "gmsh22_binary.msh",
    "gmsh41_binary.msh",
    "partitioned_binary.msh",
    "vtk42_binary.vtk",
    "vtk51_binary.vtk",
    "vtk_raw.vtu",
    "vtk_raw_lz4.vtu",
    "vtk_base64_zlib.vtu",
];

/// Replaces the first place where `old` stands.
fn replaced(mut bytes: Vec<u8>, old: &[u8], new: &[u8]) -> Vec<u8> {
    let at = bytes.windows(old.len()).position(|w| w == old).unwrap();
    bytes.splice(at..at + old.len(), new.iter().copied());
    bytes
}

#[test]
fn class_01_an_empty_file_is_refused() {
    for text in ["", "\r\n \n", "\u{feff}", "# nothing\n"] {
        assert!(refused(text.as_bytes()).contains("the file is empty"), "{text:?}");
    }
    let folder = folder(&[("part.msh", ""), ("empty.toml", ""), ("case.toml", "mesh.file = \"part.msh\"\n")]);
    assert_fails(folder.path(), &["run", "case.toml"], 4, &["part.msh:1: the file is empty", "export the mesh again"]);
    assert_fails(folder.path(), &["run", "empty.toml"], 3, &["empty.toml"]);
}

#[test]
fn class_02_a_truncated_file_says_what_was_expected_and_found() {
    for format in ALL {
        let text = Rough::pair().text(format);
        // Within the nodes, and within the second tetrahedron; a list of Abaqus has no end to be missed.
        let node = ["0 1 0", "0, 1, 0"].iter().find_map(|words| text.find(words)).unwrap();
        let tet = ["1 3 2 5", "1, 3, 2, 5", "0 2 1 4"].iter().find_map(|words| text.find(words)).unwrap();
        for cut in [node + 2, tet + 2] {
            let said = refused(&text.as_bytes()[..cut]);
            assert!(said.contains("part.mesh:"), "{format:?}: {said}");
        }
    }
    for name in BINARY {
        let bytes = bundled(name);
        for part in [3, 5, 8] {
            let said = refused(&bytes[..bytes.len() * part / 10]);
            assert!(said.contains("part.mesh:"), "{name}: {said}");
        }
    }
    let text = Rough::pair().text(Msh2);
    let said = refused(&text.as_bytes()[..text.find("4 0 0 1").unwrap()]);
    assert!(said.contains("expected 5 nodes") && said.contains("found 3") && said.contains("cut off"), "{said}");
}

#[test]
fn class_03_an_unknown_format_or_version_lists_what_is_read() {
    for text in ["solid part\nfacet", "MESHX", "\u{fffd}PNG", "ply\nformat ascii 1.0\n"] {
        let said = refused(text.as_bytes());
        assert!(said.contains("Gmsh MSH 2.2 and 4.1") && said.contains("VTK (.vtk, .vtu)"), "{said}");
    }
    assert!(refused(&[0xff, 0xfe, 0x4d, 0]).contains("UTF-8"));
    for (format, old, new) in [(Msh4, "4.1 0 8", "4 0 8"), (Msh4, "4.1 0 8", "nonsense"), (Msh2, "2.2 0 8", "1.0 0 8")]
    {
        let said = refused(Rough::pair().text(format).replace(old, new).as_bytes());
        assert!(said.contains("gmsh in.msh -save -format msh41 -o out.msh"), "{said}");
    }
    let vtk = Rough::pair().text(Vtk);
    assert!(refused(vtk.replace("UNSTRUCTURED_GRID", "POLYDATA").as_bytes()).contains("POLYDATA"));
    let vtu = Rough::pair().text(Vtu);
    assert!(refused(vtu.replace("UnstructuredGrid", "PolyData").as_bytes()).contains("PolyData"));
    assert!(refused(Rough::pair().text(Inp).replace("C3D4", "C3D6").as_bytes()).contains("C3D6"));
    assert!(
        refused(Rough::pair().text(Medit).replace("Dimension 3", "Dimension 2").as_bytes()).contains("dimension 2")
    );
}

/// How much memory this takes is what `huge_counts_take_no_memory` measures.
#[test]
fn class_04_a_count_larger_than_the_file_can_hold_is_refused() {
    for which in [0, 1] {
        let huge = Rough::pair().change(|r| r.counts[which] = Some("4000000000".to_owned()));
        assert_refused(&huge, &COUNTED, &["4000000000"]);
        let more = Rough::pair().change(|r| r.counts[which] = Some("6".to_owned()));
        assert_refused(&more, &COUNTED, &["part.mesh:"]);
    }
    let said = refused(&replaced(bundled("gmsh22_binary.msh"), b"$Nodes\n", b"$Nodes\n99999"));
    assert!(said.contains("nodes are announced") && said.contains("bytes of the file remain"), "{said}");
}

#[test]
fn class_05_a_count_that_is_too_small_is_refused() {
    for (which, less) in [(0, "4"), (1, "1")] {
        let fewer = Rough::pair().change(|r| r.counts[which] = Some(less.to_owned()));
        assert_refused(&fewer, &COUNTED, &["part.mesh:"]);
    }
}

#[test]
fn class_06_a_negative_count_is_refused() {
    for which in [0, 1] {
        let negative = Rough::pair().change(|r| r.counts[which] = Some("-5".to_owned()));
        assert_refused(&negative, &COUNTED, &["-5"]);
    }
}

#[test]
fn class_07_a_word_that_is_no_number_is_named_with_line_and_column() {
    let nodes = Rough::pair().change(|r| r.nodes[1][2] = "xyz".to_owned());
    let tets = Rough::pair().change(|r| r.tets[1][3] = "uvw".to_owned());
    for (rough, word) in [(nodes, "xyz"), (tets, "uvw")] {
        for format in ALL {
            let text = rough.text(format);
            let at = text.find(word).unwrap();
            let line = text[..at].matches('\n').count() + 1;
            let column = at - text[..at].rfind('\n').unwrap();
            let said = refused(text.as_bytes());
            let place = if format == Vtu { "line " } else { "part.mesh:" };
            assert!(said.contains(&format!("{place}{line}: column {column}: ")), "{format:?}: {said}");
            assert!(said.contains(&format!("is {word:?}, expected a")), "{format:?}: {said}");
        }
    }
}

#[test]
fn class_08_a_coordinate_that_is_not_finite_is_named_with_its_node() {
    for x in ["nan", "inf", "-inf", "1e400"] {
        let infinite = Rough::pair().change(|r| r.nodes[1][1] = x.to_owned());
        assert_refused(&infinite, &WITH_IDS, &["x of node 2", "not a finite number"]);
        assert_refused(&infinite, &[Medit], &["x of node 2", "not a finite number"]);
        assert_refused(&infinite, &[Vtk, Vtu], &["x of node 1", "not a finite number"]);
    }
}

#[test]
fn class_09_an_element_whose_node_is_not_listed_is_named() {
    let lost = Rough::pair().change(|r| r.tets[1][4] = "99".to_owned());
    assert_refused(&lost, &WITH_IDS, &["tetrahedron 2", "node 99"]);
    assert_refused(&lost, &[Medit], &["tetrahedron 2", "node 99"]);
    assert_refused(&lost, &[Vtk, Vtu], &["tetrahedron 1", "node 98"]);
    let before = Rough::pair().change(|r| r.tets[1][4] = "-7".to_owned());
    assert_refused(&before, &ALL, &["-"]);
}

#[test]
fn class_10_numbers_too_large_for_an_integer_are_refused() {
    for large in ["4294967296", "99999999999999999999"] {
        let id = Rough::pair().change(|r| r.nodes[4][0] = large.to_owned());
        assert_refused(&id, &WITH_IDS, &[large]);
        let node = Rough::pair().change(|r| r.tets[1][4] = large.to_owned());
        assert_refused(&node, &ALL, &["part.mesh:"]);
        let count = Rough::pair().change(|r| r.counts[0] = Some(large.to_owned()));
        assert_refused(&count, &COUNTED, &[large]);
    }
}

#[test]
fn class_11_a_node_listed_twice_is_named_with_both_places() {
    let twice = Rough::pair().change(|r| r.nodes[2][0] = "1".to_owned());
    assert_refused(&twice, &WITH_IDS, &["node 1 is listed again", "it stands in line"]);
}

#[test]
fn class_12_ids_with_gaps_are_kept_for_messages() {
    let gaps = Rough::new(
        "10 0 0 0\n4000000000 1 0 0\n30 0 1 0\n400 0 0 1\n5 0 0 -1",
        "71 10 4000000000 30 400\n9 10 30 4000000000 5",
    );
    for format in WITH_IDS {
        let mesh = read_bytes(gaps.text(format).as_bytes()).unwrap().mesh;
        assert_eq!(mesh.tets(), read_bytes(Rough::pair().text(format).as_bytes()).unwrap().mesh.tets(), "{format:?}");
    }
    let flat = gaps.change(|r| r.nodes[4][3] = "0".to_owned());
    assert_refused(&flat, &WITH_IDS, &["tet 9 (10, 30, 4000000000, 5)"]);
}

#[test]
fn class_13_the_wrong_order_of_bytes_is_read_or_refused() {
    // Gmsh and VTK XML say what theirs is, and both are read (tests/reading.rs); legacy VTK files are big-endian by definition.
    for (name, list, size) in [("vtk42_binary.vtk", "CELLS", 4), ("vtk51_binary.vtk", "OFFSETS", 8)] {
        let mut bytes = bundled(name);
        let at = bytes.windows(list.len()).position(|w| w == list.as_bytes()).unwrap();
        let start = at + bytes[at..].iter().position(|&b| b == b'\n').unwrap() + 1;
        bytes[start..start + 50 * size].chunks_mut(size).for_each(<[u8]>::reverse);
        let said = refused(&bytes);
        assert!(said.contains("other order of bytes") && said.contains("big-endian"), "{name}: {said}");
    }
    let orders: [&[u8]; 2] = [b"BigEndian", b"LittleEndian"];
    for (name, [own, other]) in [("vtk_raw.vtu", orders), ("vtk_base64_zlib.vtu", [orders[1], orders[0]])] {
        let said = refused(&replaced(bundled(name), own, other));
        assert!(said.contains("order of bytes"), "{name}: {said}");
    }
    let said = refused(&replaced(bundled("gmsh41_binary.msh"), &[1, 0, 0, 0], &[7, 0, 0, 0]));
    assert!(said.contains("order of bytes"), "{said}");
}

#[test]
fn class_14_windows_files_are_accepted_and_a_decimal_comma_is_named() {
    for format in ALL {
        let text = Rough::pair().text(format);
        let windows = format!("\u{feff}{}", text.replace('\n', "\r\n"));
        let [mesh, same] = [text, windows].map(|text| read_bytes(text.as_bytes()).unwrap().mesh);
        assert_eq!((mesh.points(), mesh.tets()), (same.points(), same.tets()), "{format:?}");
    }
    let comma = Rough::pair().change(|r| r.nodes[1][1] = "1,5".to_owned());
    let without_inp: Vec<Format> = ALL.into_iter().filter(|&f| f != Inp).collect();
    assert_refused(&comma, &without_inp, &["\"1,5\"", "decimal comma"]);
    // Where commas divide fields, a comma too many shows in their number.
    assert_refused(&comma, &[Inp], &["decimal comma"]);
}

#[test]
fn class_15_a_missing_section_is_named() {
    for (format, from, to, name) in [
        (Msh2, "$Nodes", "$Elements", "$Nodes is missing"),
        (Msh4, "$Nodes", "$Elements", "$Nodes is missing"),
        (Msh2, "$Elements", "\u{0}", "$Elements is missing"),
        (Gid, "Elements", "\u{0}", "Elements is missing"),
        (Medit, "Vertices", "Tetrahedra", "Vertices is missing"),
        (Inp, "*NODE", "*ELEMENT", "*NODE"),
        (Vtk, "CELL_TYPES", "\u{0}", "CELL_TYPES"),
        (Vtu, "<Points>", "<Cells>", "Points"),
        (Vtu, "<Cells>", "</Piece>", "Cells"),
    ] {
        let text = Rough::pair().text(format);
        let (start, end) = (text.find(from).unwrap(), text.find(to).unwrap_or(text.len()));
        let said = refused([&text[..start], &text[end..]].concat().as_bytes());
        assert!(said.contains(name), "{format:?} without {from}: {said}");
    }
    assert_noted(&Rough::pair(), &ALL, &[]);
}

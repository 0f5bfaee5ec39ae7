//! One test for each kind of fault in a file.

use super::*;

#[test]
fn a_missing_file_is_unreadable() {
    assert!(matches!(read(Path::new("no/such/file.msh")), Err(MeshError::Unreadable { .. })));
}

#[test]
fn a_file_on_disk_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.msh");
    std::fs::write(&path, MSH4).unwrap();
    assert_eq!(read(&path).unwrap().mesh.tets().len(), 2);
}

#[test]
fn truncated_files_say_what_was_expected() {
    let cut = |text: &str, lines: usize| text.lines().take(lines).map(|l| format!("{l}\n")).collect::<String>();
    assert_fault(&cut(MSH2, 15), 15, &["expected 5 nodes", "line 12", "found 3", "cut off"]);
    assert_fault(&cut(MSH2, 17), 17, &["$EndNodes", "end of the file"]);
    assert_fault(&cut(MSH2, 18), 18, &["$Elements is missing"]);
    assert_fault(&cut(MSH4, 33), 33, &["expected 4 nodes", "found 2"]);
    assert_fault(&cut(GID, 6), 6, &["end coordinates", "cut off"]);
    assert_fault(&cut(GID, 9), 9, &["Elements is missing"]);
}

#[test]
fn a_count_larger_than_the_file_is_refused() {
    assert_fault(&with_line(MSH2, 12, "4000000000"), 12, &["4000000000 nodes", "bytes"]);
    assert_fault(&with_line(MSH4, 23, "2 4000000000 1 5"), 23, &["4000000000 nodes", "bytes"]);
    assert_fault(&with_line(MSH2, 12, "99999999999999999999"), 12, &["too large"]);
    assert_fault(&with_line(MSH2, 12, "6"), 18, &["expected 6 nodes", "found 5", "$EndNodes"]);
}

#[test]
fn a_count_too_small_is_refused() {
    assert_fault(&with_line(MSH2, 12, "4"), 17, &["expected $EndNodes", "5 0 0 -1"]);
    assert_fault(&with_line(MSH4, 23, "2 4 1 5"), 35, &["4 nodes", "hold 5"]);
}

#[test]
fn a_field_that_is_no_number_is_named_with_its_column() {
    assert_fault(&with_line(MSH2, 14, "2 one 0 0"), 14, &["column 3", "one"]);
    assert_fault(&with_line(GID, 5, "  2 1 0 zero"), 5, &["column 9", "zero"]);
    assert_fault(&with_line(GID, 5, "2 1,5 0 0"), 5, &["decimal comma", "1,5"]);
    assert_fault(&with_line(GID, 5, "2 1 0"), 5, &["too short"]);
    assert_fault(&with_line(GID, 5, "2 1 0 0 0"), 5, &["too long"]);
}

#[test]
fn a_node_that_is_not_listed_is_refused() {
    assert_fault(&with_line(GID, 12, "8 1 2 3 99 1"), 12, &["tetrahedron 8", "node 99"]);
    assert_fault(&with_line(MSH2, 24, "3 2 2 2 11 1 2 99"), 24, &["triangle 3", "node 99"]);
}

#[test]
fn a_repeated_corner_and_a_repeated_cell_are_refused() {
    assert_fault(&with_line(GID, 12, "8 1 2 3 1 1"), 12, &["tetrahedron 8", "repeats a node"]);
    assert_fault(&with_line(GID, 13, "9 4 3 2 1 1"), 13, &["tetrahedron 9", "tetrahedron 8", "line 12"]);
}

#[test]
fn other_cells_are_refused_by_type_and_id() {
    for (kind, name) in [(5, "hexahedron"), (6, "prism"), (7, "pyramid"), (29, "order"), (77, "not read")] {
        let line = format!("9 {kind} 2 2 2 1 2 3 4 5 1 2 3");
        assert_fault(&with_line(MSH2, 29, &line), 29, &["element 9", name]);
    }
    assert_fault(&GID.replace("Tetrahedra", "Hexahedra"), 2, &["hexahedra"]);
    assert_fault(&GID.replace("dimension 3", "dimension 2"), 2, &["dimension 2"]);
    assert_fault(&GID.replace("Nnode 4", "Nnode 20"), 2, &["20 nodes"]);
}

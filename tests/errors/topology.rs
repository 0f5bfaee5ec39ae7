//! Classes 16 to 33: meshes that are well-formed files, but no sound solids.

use super::rough::Format::{Gid, Inp, Msh2, Vtk, Vtu};
use super::rough::{
    ALL, Rough, WITH_IDS, assert_fails, assert_noted, assert_refused, folder, read_bytes, refused, subsolid,
};
use subsolid::mesh::hex::read as hex;
use subsolid::mesh::read::{Edges, Reading, read_with};

/// Two tetrahedra on the nodes 1 to 4, and 5 to 8.
fn two_parts(moved: [&str; 3]) -> Rough {
    let mut rough =
        Rough::new("1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 0\n6 1 0 0\n7 0 1 0\n8 0 0 1", "1 1 2 3 4\n2 5 6 7 8");
    for node in &mut rough.nodes[4..] {
        for (x, by) in node[1..].iter_mut().zip(moved) {
            *x = (x.parse::<f64>().unwrap() + by.parse::<f64>().unwrap()).to_string();
        }
    }
    rough
}

#[test]
fn class_16_inverted_cells_are_named_and_a_mesh_inside_out_is_turned() {
    let one = Rough::pair().change(|r| r.tets[1].swap(2, 3));
    assert_refused(&one, &WITH_IDS, &["tet 2 (1, 2, 3, 5)", "volume -1.667e-1", "(1 such cells)", "node order"]);
    assert_refused(&one, &ALL, &["volume -1.667e-1"]);
    let all = Rough::pair().change(|r| r.tets.iter_mut().for_each(|t| t.swap(2, 3)));
    assert_noted(&all, &ALL, &["all 2 tetrahedra were inverted"]);
    let volume = read_bytes(all.text(Gid).as_bytes()).unwrap().mesh.volume();
    assert!((volume - 1.0 / 3.0).abs() < 1e-15);
}

#[test]
fn class_17_a_cell_without_volume_is_refused_at_any_scale() {
    for scale in [1e-9, 1.0, 1e9] {
        let scaled = |below: f64| {
            Rough::pair().change(|r| {
                r.nodes[4][3] = below.to_string();
                let scale = |x: &mut String| *x = (x.parse::<f64>().unwrap() * scale).to_string();
                r.nodes.iter_mut().flat_map(|n| &mut n[1..]).for_each(scale);
            })
        };
        assert_noted(&scaled(-1.0), &ALL, &[]);
        for flat in [0.0, -1e-15] {
            assert_refused(&scaled(flat), &WITH_IDS, &["tet 2 ", "is not positive beyond rounding"]);
            assert_refused(&scaled(flat), &ALL, &["is not positive beyond rounding"]);
        }
    }
}

#[test]
fn class_18_a_cell_with_a_node_twice_is_refused() {
    let twice = Rough::pair().change(|r| r.tets[1][4] = "1".to_owned());
    assert_refused(&twice, &WITH_IDS, &["tetrahedron 2", "repeats a node"]);
    assert_refused(&twice, &ALL, &["repeats a node"]);
}

#[test]
fn class_19_a_cell_listed_twice_is_refused_with_both_ids() {
    let twice = Rough::pair().change(|r| r.tets.push(["7", "3", "1", "5", "2"].map(str::to_owned)));
    assert_refused(&twice, &WITH_IDS, &["tetrahedron 7", "repeats tetrahedron 2"]);
    assert_refused(&twice, &ALL, &["repeats tetrahedron"]);
}

#[test]
fn class_20_nodes_at_one_place_are_told_and_merged_if_asked() {
    // The second tetrahedron on nodes of its own.
    let apart =
        Rough::new("1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n6 0 0 0\n7 1 0 0\n8 0 1 0", "1 1 2 3 4\n2 6 8 7 5");
    assert_noted(
        &apart,
        &ALL,
        &["3 nodes lie where another node lies", "mesh.merge = true", "2 parts that share no face"],
    );
    let folder = folder(&[("part.msh", &apart.text(Msh2))]);
    let merged = read_with(&folder.path().join("part.msh"), Reading { edges: Edges::Straight, merge: true }).unwrap();
    let whole = read_bytes(Rough::pair().text(Msh2).as_bytes()).unwrap().mesh;
    assert_eq!((merged.mesh.tets(), merged.mesh.points()), (whole.tets(), whole.points()));
    assert!(merged.notes.len() == 1 && merged.notes[0].contains("3 nodes were made one"), "{:?}", merged.notes);
    // Hexahedra alike.
    let (one, two) = (hexahedron(0), hexahedron(8));
    let nodes = [0.0, 1.0].iter().flat_map(|x| cube(*x)).collect::<Vec<_>>();
    let text = hexes(&nodes, &[one, two]);
    std::fs::write(folder.path().join("hexes.msh"), text).unwrap();
    let counts = |merge| hex::read_with(&folder.path().join("hexes.msh"), merge).unwrap().mesh.points().len();
    assert_eq!([false, true].map(counts), [16, 12]);
}

#[test]
fn class_21_a_face_of_three_cells_is_named_by_its_nodes() {
    let crowded = Rough::pair().change(|r| {
        r.nodes.push(["60", "0", "0", "2"].map(str::to_owned));
        r.tets.push(["70", "1", "2", "3", "60"].map(str::to_owned));
    });
    assert_refused(&crowded, &WITH_IDS, &["face [1, 2, 3] is shared by 3 cells", "70"]);
    let counted = crowded.change(|r| r.tets[2][4] = "6".to_owned());
    assert_refused(&counted, &ALL[4..], &["is shared by 3 cells"]);
}

#[test]
fn class_22_an_edge_where_the_solid_touches_itself_is_told_and_kept() {
    // Two tetrahedra on either side of the edge of nodes 1 and 2.
    let touching = Rough::new("1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 -1 0\n6 0 0 -1", "1 1 2 3 4\n2 1 2 5 6");
    assert_noted(
        &touching,
        &WITH_IDS,
        &["touches itself in an edge only, at nodes 1 and 2", "2 parts that share no face"],
    );
    assert_noted(&touching, &ALL, &["touches itself in an edge only"]);
}

#[test]
fn class_23_a_node_where_the_solid_touches_itself_is_told_and_kept() {
    let touching =
        Rough::new("1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 -1 0 0\n6 0 -1 0\n7 0 0 -1", "1 1 2 3 4\n2 1 6 5 7");
    assert_noted(&touching, &WITH_IDS, &["touches itself in a node only, at node 1", "2 parts that share no face"]);
    assert_noted(&touching, &ALL, &["touches itself in a node only"]);
}

#[test]
fn class_24_loose_parts_are_counted_and_each_needs_supports() {
    let loose = two_parts(["5", "0", "0"]);
    assert_noted(&loose, &ALL, &["2 parts that share no face", "1 cells in [5, 0, 0] to [6, 1, 1]"]);
    let scenario = "mesh.file = \"part.msh\"\n[materials.a]\nyoungs_modulus = 1.0\npoissons_ratio = 0.3\n[supports.a]\n\
                    plane = { normal = [1, 0, 0], offset = 0 }\nfix = [\"x\", \"y\", \"z\"]\n";
    let folder = folder(&[("part.msh", &loose.text(Msh2)), ("case.toml", scenario)]);
    let words = ["part 2 of 2 (1 cells, box (5, 0, 0) to (6, 1, 1))", "in every way"];
    assert_fails(folder.path(), &["run", "case.toml"], 5, &words);
}

#[test]
fn class_25_nodes_of_no_cell_are_dropped_and_counted() {
    let orphans = Rough::pair().change(|r| r.nodes.push(["9", "5", "5", "5"].map(str::to_owned)));
    assert_noted(&orphans, &ALL, &["1 node belongs to no tetrahedron and is dropped"]);
    assert_eq!(read_bytes(orphans.text(Vtk).as_bytes()).unwrap().mesh.points().len(), 5);
}

#[test]
fn class_26_other_cells_are_refused_by_type_and_id() {
    let text = Rough::pair().text(Msh2);
    for (kind, name) in [(6, "prism"), (7, "pyramid"), (29, "order"), (77, "not read")] {
        let other = text.replace("2 4 2 1 1 1 3 2 5", &format!("2 {kind} 2 1 1 1 2 3 4 5 1 2 3"));
        let said = refused(other.as_bytes());
        assert!(said.contains("element 2") && said.contains(name), "{said}");
    }
    let mixed = text.replace("2 4 2 1 1 1 3 2 5", "2 5 2 1 1 1 2 3 4 5 1 2 3");
    let said = refused(mixed.as_bytes());
    assert!(said.contains("element 2 is a hexahedron; the mesh has 1 hexahedra and 1 tetrahedra"), "{said}");
    assert!(refused(Rough::pair().text(Gid).replace("Tetrahedra", "Hexahedra").as_bytes()).contains("hexahedra"));
    assert!(refused(Rough::pair().text(Inp).replace("C3D4", "C3D6").as_bytes()).contains("wedges"));
    for format in [Vtk, Vtu] {
        let text = Rough::pair().text(format);
        let at = text.rfind("10\n").unwrap();
        let said = refused(format!("{}13{}", &text[..at], &text[at + 2..]).as_bytes());
        assert!(said.contains("cell 1 (VTK type 13)") && said.contains("wedge"), "{format:?}: {said}");
    }
}

#[test]
fn class_27_a_mesh_of_a_surface_has_no_volume_elements() {
    let text = Rough::pair().text(Msh2);
    let surface = text.replace("1 4 2 1 1 1 2 3 4", "1 2 2 1 1 1 2 3").replace("2 4 2 1 1 1 3 2 5", "2 2 2 1 1 1 3 2");
    for text in [surface, Rough::pair().text(Inp).replace("C3D4", "S4")] {
        let said = refused(text.as_bytes());
        assert!(said.contains("no tetrahedra") && said.contains("mesh the volume"), "{said}");
    }
}

#[test]
fn class_28_what_becomes_of_midside_nodes_is_told() {
    let text = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n5, 0.5, 0, -0.1\n6, 0.5, 0.5, 0\n7, 0, 0.5, 0\n\
                8, 0, 0, 0.5\n9, 0.5, 0, 0.5\n10, 0, 0.5, 0.5\n*ELEMENT, TYPE=C3D10\n1, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10\n";
    let notes = read_bytes(text.as_bytes()).unwrap().notes;
    assert!(
        notes[0].contains("1 ten-node tetrahedra: the four corner nodes are used, 6 mid-side nodes dropped"),
        "{notes:?}"
    );
    assert!(notes[0].contains("mesh.midside = \"curved\" keeps"), "{notes:?}");
    let folder = folder(&[("part.inp", text)]);
    let notes = read_with(&folder.path().join("part.inp"), Edges::Curved).unwrap().notes;
    assert!(notes[0].contains("1 ten-node tetrahedra, 1 edges of them curved"), "{notes:?}");
}

#[test]
fn class_29_cells_that_overlap_are_told() {
    let overlapping = two_parts(["0.1", "0.1", "0.1"]);
    assert_noted(&overlapping, &WITH_IDS, &["cells overlap: tetrahedron 1 holds node 5 of the boundary"]);
    assert_noted(&overlapping, &ALL, &["cells overlap"]);
    // The same place twice: no corner lies inside the other.
    assert_noted(&two_parts(["0", "0", "0"]), &WITH_IDS, &["holds the centre of tetrahedron 2"]);
    let notes = read_bytes(two_parts(["1", "0", "0"]).text(Msh2).as_bytes()).unwrap().notes;
    assert!(!notes.iter().any(|note| note.contains("overlap")), "{notes:?}");
}

#[test]
fn class_30_a_mesh_far_from_the_origin_or_of_odd_size_is_told() {
    let moved = |by: &str| {
        two_parts(["3", "0", "0"]).change(|r| {
            for node in &mut r.nodes {
                node[1] = (node[1].parse::<f64>().unwrap() + by.parse::<f64>().unwrap()).to_string();
            }
        })
    };
    assert_noted(&moved("1e8"), &ALL, &["times its size away from the origin", "8 are left"]);
    let notes = read_bytes(moved("1e3").text(Msh2).as_bytes()).unwrap().notes;
    assert!(!notes.iter().any(|note| note.contains("origin")), "{notes:?}");
    let scaled = |scale: f64| {
        Rough::pair().change(|r| {
            let scale = |x: &mut String| *x = (x.parse::<f64>().unwrap() * scale).to_string();
            r.nodes.iter_mut().flat_map(|n| &mut n[1..]).for_each(scale);
        })
    };
    for scale in [1e-13, 1e14] {
        assert_noted(&scaled(scale), &ALL, &["Check its units"]);
    }
}

#[test]
fn class_31_likely_wrong_units_are_told_with_box_and_modulus() {
    // A part in millimetres, its modulus in pascals.
    let scenario = "[mesh.box]\nsize = [200, 50, 50]\ncells = [4, 1, 1]\n[materials.steel]\nyoungs_modulus = 210e9\n\
                    poissons_ratio = 0.3\n[supports.a]\ngroup = \"x-min\"\nfix = [\"x\", \"y\", \"z\"]\n\
                    [loads.a]\ngroup = \"x-max\"\nforce = [0, 0, -1]\n";
    let folder = folder(&[("case.toml", scenario)]);
    let said = subsolid(folder.path(), &["check", "case.toml"]).1;
    assert!(said.contains("Young's modulus of 2.1e11") && said.contains("[0, 0, 0] to [200, 50, 50]"), "{said}");
    for fits in ["materials.steel.youngs_modulus=210e3", "mesh.box.size=[0.2, 0.05, 0.05]", "units.length=\"m\""] {
        let said = subsolid(folder.path(), &["check", "case.toml", "--set", fits]).1;
        assert!(said.contains("results would go to") && !said.contains("Young's modulus of"), "{said}");
    }
}

#[test]
fn class_32_hanging_nodes_are_refused() {
    // Below z = 0 the cell is split at the middle of the edge of nodes 2 and 3.
    let edge =
        Rough::new("1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n6 0.5 0.5 0", "1 1 2 3 4\n2 1 6 2 5\n3 1 3 6 5");
    assert_refused(&edge, &WITH_IDS, &["node 6 lies on the edge 2 3 of tetrahedron 1, but is no corner of it"]);
    assert_refused(&edge, &ALL, &["lies on the edge", "cells must share whole faces"]);
    let face = Rough::new(
        "1 0 0 0\n2 3 0 0\n3 0 3 0\n4 0 0 1\n5 0 0 -1\n6 1 1 0",
        "1 1 2 3 4\n2 1 6 2 5\n3 2 6 3 5\n4 3 6 1 5",
    );
    assert_refused(&face, &WITH_IDS, &["node 6 lies on the face 1 2 3 of tetrahedron 1"]);
    // A cube beside two halves of one.
    let mut nodes = cube(0.0);
    nodes.extend([[2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [2.0, 0.0, 1.0], [2.0, 1.0, 1.0]]);
    nodes.extend([[1.0, 0.0, 0.5], [1.0, 1.0, 0.5], [2.0, 0.0, 0.5], [2.0, 1.0, 0.5]]);
    let halves = [[2, 9, 10, 3, 13, 15, 16, 14], [13, 15, 16, 14, 6, 11, 12, 7]];
    let folder = folder(&[("part.msh", &hexes(&nodes, &[hexahedron(0), halves[0], halves[1]]))]);
    let error = hex::read(&folder.path().join("part.msh")).unwrap_err().to_string();
    assert!(
        error.contains("node 13 lies on the edge 2 6 of hexahedron 1") && error.contains("2 hanging nodes"),
        "{error}"
    );
}

/// The corners of a unit cube that begins at x, in the order of [`hexahedron`].
fn cube(x: f64) -> Vec<[f64; 3]> {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    [0.0, 1.0].iter().flat_map(|&z| square.map(|[u, v]| [x + u, v, z])).collect()
}

/// Its cell after `before` nodes.
fn hexahedron(before: usize) -> [usize; 8] {
    std::array::from_fn(|i| before + i + 1)
}

/// Hexahedra as Gmsh writes them.
fn hexes(nodes: &[[f64; 3]], cells: &[[usize; 8]]) -> String {
    let nodes: Vec<String> = (1..).zip(nodes).map(|(i, [x, y, z])| format!("{i} {x} {y} {z}\n")).collect();
    let cell = |(i, nodes): (usize, &[usize; 8])| format!("{i} 5 2 1 1 {}\n", nodes.map(|n| n.to_string()).join(" "));
    let cells: Vec<String> = (1..).zip(cells).map(cell).collect();
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n{}$EndNodes\n$Elements\n{}\n{}$EndElements\n",
        nodes.len(),
        nodes.concat(),
        cells.len(),
        cells.concat()
    )
}

#[test]
fn class_33_a_twisted_hexahedron_is_named_by_its_ids() {
    let mut nodes: Vec<[f64; 3]> = [0.0, 1.0].iter().flat_map(|x| cube(*x)).collect();
    let cells = [hexahedron(0), [2, 10, 11, 3, 6, 14, 15, 7]];
    let check = |nodes: &[[f64; 3]]| {
        let folder = folder(&[("part.msh", &hexes(nodes, &cells))]);
        hex::read(&folder.path().join("part.msh")).map_err(|e| e.to_string())
    };
    check(&nodes).unwrap();
    // Node 15 behind the cell's other side.
    nodes[14] = [0.5, 0.5, 0.5];
    let error = check(&nodes).unwrap_err();
    assert!(error.contains("part.msh:") && error.contains("hexahedron 2 ([2, 10, 3, 11, 6, 14, 7, 15])"), "{error}");
    assert!(error.contains("its Jacobian at vertex"), "{error}");
}

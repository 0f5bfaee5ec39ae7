//! Smooth tetrahedral/octahedral subdivision: the masks against a plain implementation of the paper, counts, convexity, affine
//! maps, surfaces that isolate regions, and sound cells on the bundled meshes.
#![allow(clippy::unwrap_used)]

use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use subsolid::mesh::quality::EDGES;
use subsolid::mesh::read::read;
use subsolid::mesh::tet_oct::{CellEdges, OCT_EDGES, OCT_FACES, OctSplit, TetOctMesh};
use subsolid::mesh::{RegionId, TetMesh, features, generate, surface};
use subsolid::pipeline::load::load;
use subsolid::scenario::Scenario;
use subsolid::subdiv::tet_oct::{WeightRows, composite, refine, refine_with_rows, split_linearly};

/// A displacement without any symmetry.
fn wave(p: DVec3) -> DVec3 {
    DVec3::new((7.0 * p.y + 3.0 * p.z + 3.0).sin(), (5.0 * p.z + p.x).cos(), (6.0 * p.x + 2.0 * p.y + 1.0).sin())
}

/// A unit cube of n blocks a side in two regions that meet at x = 0.5, with its vertices moved.
fn halves(n: usize, jitter: f64) -> TetMesh {
    let mut parts = generate::box_tets([1.0; 3], [n; 3]).unwrap().into_parts();
    parts.region_names.push("right".to_owned());
    for (tet, region) in parts.tets.iter().zip(&mut parts.regions) {
        let x = tet.iter().map(|&v| parts.points[v as usize].x).sum::<f64>() / 4.0;
        *region = RegionId(u16::from(x > 0.5));
    }
    parts.points.iter_mut().for_each(|p| *p += jitter / n as f64 * wave(37.0 * *p));
    features::with_creases(TetMesh::new(parts).unwrap(), 60.0, &[])
}

/// The meshes of the bundled scenarios that have one of tetrahedra, with their creases.
fn bundled() -> Vec<(String, TetMesh)> {
    let mut meshes = Vec::new();
    for folder in ["scenarios", "scenarios/verification"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
        files.sort();
        for path in files.into_iter().filter(|p| p.extension().is_some_and(|e| e == "toml")) {
            let Ok(scenario) = Scenario::from_file(&path, &[]) else { continue };
            // Those of hexahedra, and the tripod where it is not there.
            let Ok(file) = load(&scenario) else { continue };
            // At 40 degrees four of the tripod's cells are inverted after two steps: edges of 7.5 degrees, rounded.
            let angle = if scenario.name() == "tripod" { 20.0 } else { 40.0 };
            meshes.push((scenario.name().to_owned(), features::with_creases(file.mesh, angle, &[])));
        }
    }
    assert!(meshes.len() > 10);
    meshes
}

/// What is not inside a region: vertices of the boundary and of interfaces.
fn on_surface(mesh: &TetOctMesh) -> Vec<bool> {
    let mut on = vec![false; mesh.points().len()];
    let faces = mesh.parts().faces.iter().map(|f| f.vertices).chain(mesh.parts().interfaces.iter().copied());
    faces.flatten().for_each(|v| on[v as usize] = true);
    on
}

/// The paper's pseudocode: centroids of all cells in all orientations, divided by the numbers of cells.
fn plainly_smoothed(mesh: &TetOctMesh) -> Vec<DVec3> {
    let old = mesh.points();
    let (mut sums, mut counts) = (vec![DVec3::ZERO; old.len()], vec![0.0; old.len()]);
    let mut add = |v: u32, p: DVec3| {
        sums[v as usize] += p;
        counts[v as usize] += 1.0;
    };
    for tet in mesh.tets() {
        for &v in tet {
            let weight = |w: u32| if w == v { -1.0 / 16.0 } else { 17.0 / 48.0 };
            add(v, tet.iter().map(|&w| weight(w) * old[w as usize]).sum());
        }
    }
    for oct in mesh.octs() {
        for (i, &v) in oct.iter().enumerate() {
            let weight = |j: usize| match j {
                _ if j == i => 3.0 / 8.0,
                _ if j / 2 == i / 2 => 7.0 / 24.0,
                _ => 1.0 / 12.0,
            };
            add(v, (0..6).map(|j| weight(j) * old[oct[j] as usize]).sum());
        }
    }
    sums.iter().zip(&counts).map(|(sum, count)| *sum / *count).collect()
}

#[test]
fn inside_a_step_is_the_split_and_the_mean_of_centroids_of_the_paper() {
    let mut mesh = TetOctMesh::from(&halves(3, 0.15));
    for step in 0..3 {
        let fine = refine(&mesh);
        let plain = plainly_smoothed(&split_linearly(&mesh).0);
        let mut inside = 0;
        for (v, on) in on_surface(&fine).into_iter().enumerate().filter(|(_, on)| !on) {
            assert!(fine.points()[v].distance(plain[v]) < 1e-14, "step {step}, vertex {v}, {on}");
            inside += 1;
        }
        assert!(inside > 10);
        mesh = fine;
    }
}

#[test]
fn counts_are_those_of_the_split_over_four_steps_and_cells_keep_their_orientation() {
    for start in [halves(1, 0.0), halves(2, 0.1)] {
        let mut mesh = TetOctMesh::from(&start);
        for step in 1..=4 {
            let (t, o) = (mesh.tets().len(), mesh.octs().len());
            let faces = (mesh.parts().faces.len(), mesh.parts().interfaces.len());
            mesh = refine(&mesh);
            assert_eq!((mesh.tets().len(), mesh.octs().len()), (4 * t + 8 * o, t + 6 * o), "step {step}");
            assert_eq!((mesh.parts().faces.len(), mesh.parts().interfaces.len()), (4 * faces.0, 4 * faces.1));
            assert!(mesh.worst_volume() > 0.0);
        }
    }
}

/// `TetMesh::new` checks that the cells conform, that none is inverted and that the boundary faces are the boundary.
#[test]
fn both_ways_to_cut_octahedra_give_a_conforming_mesh_of_the_same_solid() {
    let fine = refine(&refine(&TetOctMesh::from(&halves(2, 0.1))));
    for (split, each) in [(OctSplit::Diagonal, 4), (OctSplit::Centroid, 8)] {
        let cut = fine.tetrahedra(split).unwrap();
        assert_eq!(cut.mesh.tets().len(), fine.tets().len() + each * fine.octs().len());
        assert!((cut.mesh.volume() - fine.volume()).abs() < if each == 4 { 2e-3 } else { 1e-14 });
        let interfaces: Vec<_> = surface::interfaces(&cut.mesh);
        assert_eq!(interfaces.len(), fine.parts().interfaces.len());
    }
}

#[test]
fn a_linear_split_keeps_the_solid_and_gives_cells_of_equal_volume_classes() {
    let start = TetOctMesh::from(&halves(2, 0.1));
    let mut mesh = start.clone();
    for _ in 0..3 {
        mesh = split_linearly(&mesh).0;
        assert!((mesh.volume() - start.volume()).abs() < 1e-14);
    }
    // Affine images of the honeycomb: the octahedra of one tetrahedron have half its volume each time, in all 4/8.
    assert!(mesh.worst_volume() > 0.1);
}

fn row(rows: &WeightRows, i: usize) -> BTreeMap<u32, f64> {
    rows.row(i).collect()
}

#[test]
fn uniform_vertices_have_the_masks_of_the_convolution() {
    // Inside one tetrahedron split three times.
    let tet = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let mut mesh = TetOctMesh::from(&TetMesh::from_cells(tet.to_vec(), vec![[0, 1, 2, 3]], "solid").unwrap());
    for _ in 0..3 {
        mesh = split_linearly(&mesh).0;
    }
    let (_, rows) = refine_with_rows(&mesh);
    let scaled = |v: usize| 8.0 * mesh.points()[v];
    let mut seen = 0;
    for v in 0..mesh.points().len() {
        let p = scaled(v);
        if p.min_element() < 1.5 || p.element_sum() > 6.5 {
            continue;
        }
        let mut masks: Vec<f64> = row(&rows, v).values().copied().collect();
        masks.sort_by(f64::total_cmp);
        let expected = [[1.0 / 288.0].repeat(6), [11.0 / 288.0].repeat(12), vec![25.0 / 48.0]].concat();
        assert_eq!(masks.len(), 19);
        assert!(masks.iter().zip(&expected).all(|(got, want)| (got - want).abs() < 1e-15), "{masks:?}");
        seen += 1;
    }
    assert!(seen > 0);
}

#[test]
fn composite_weights_are_convex_on_every_bundled_mesh() {
    for (name, start) in bundled() {
        let steps = if start.tets().len() > 3000 { 1 } else { 2 };
        let start = TetOctMesh::from(&start);
        let (fine, rows) = composite(&start, steps);
        assert_eq!((rows.rows(), rows.width()), (fine.points().len(), start.points().len()));
        for i in 0..rows.rows() {
            assert!(rows.row(i).all(|(_, w)| w >= 0.0), "{name}, row {i}");
            assert!((rows.row(i).map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-13, "{name}, row {i}");
        }
        let diagonal = start.points().iter().map(|p| p.length()).fold(0.0, f64::max);
        let made = rows.apply(start.points());
        assert!(made.iter().zip(fine.points()).all(|(a, b)| a.distance(*b) < 1e-13 * diagonal), "{name}");
    }
}

#[test]
fn cells_stay_positive_on_every_bundled_mesh() {
    let mut worst = Vec::new();
    for (name, start) in bundled() {
        let mut mesh = TetOctMesh::from(&start);
        let steps = if start.tets().len() > 3000 { 2 } else { 3 };
        for step in 1..=steps {
            mesh = refine(&mesh);
            worst.push(mesh.worst_volume());
            println!("{name}: {} cells, step {step}: {:.4}", mesh.cell_count(), mesh.worst_volume());
            assert!(mesh.worst_volume() > 0.0, "{name}, step {step}");
        }
        mesh.tetrahedra(OctSplit::Diagonal).unwrap();
    }
    assert!(worst.len() > 30);
}

#[test]
fn no_region_hears_of_another_across_a_crease_surface() {
    let start = TetOctMesh::from(&halves(4, 0.1));
    let surface = on_surface(&start);
    let right: Vec<bool> = {
        let mut right = vec![false; start.points().len()];
        for (tet, region) in start.tets().iter().zip(&start.parts().tet_regions) {
            tet.iter().for_each(|&v| right[v as usize] |= *region == RegionId(1));
        }
        right
    };
    // All that lies strictly inside the right half and on its part of the boundary, away from the interface.
    let on_interface = {
        let mut on = vec![false; start.points().len()];
        start.parts().interfaces.iter().flatten().for_each(|&v| on[v as usize] = true);
        on
    };
    let moved = start.with_points(
        (0..start.points().len())
            .map(|v| {
                start.points()[v] + if right[v] && !on_interface[v] { wave(start.points()[v]) } else { DVec3::ZERO }
            })
            .collect(),
    );
    assert!(surface.iter().any(|s| *s));
    let [before, after] = [start, moved].map(|mesh| refine(&refine(&refine(&mesh))));
    let (mut still, mut travelled) = (0.0_f64, 0.0_f64);
    for (cells, region) in before.tets().iter().zip(&before.parts().tet_regions) {
        for &v in cells {
            let distance = before.points()[v as usize].distance(after.points()[v as usize]);
            let largest = if *region == RegionId(0) { &mut still } else { &mut travelled };
            *largest = largest.max(distance);
        }
    }
    assert!(still < 1e-13 && travelled > 0.1, "{still} {travelled}");
}

/// Loop's limits and the cubic B-spline, on a box whose edges are creases.
#[test]
fn surfaces_creases_and_corners_have_the_masks_of_hoppe() {
    let start = TetOctMesh::from(&features::with_creases(generate::box_tets([3.0; 3], [3; 3]).unwrap(), 40.0, &[]));
    let (_, rows) = refine_with_rows(&start);
    let number = |p: DVec3| start.points().iter().position(|q| q.distance(p) < 1e-12).unwrap();
    let of = |p: DVec3| {
        let weights = row(&rows, number(p));
        let own = weights[&(number(p) as u32)];
        (own, weights.values().copied().fold(1.0, f64::min), weights.len())
    };
    assert_eq!(of(DVec3::ZERO), (1.0, 1.0, 1));
    assert_eq!(of(DVec3::X), (0.75, 0.125, 3));
    // Six triangles around it.
    assert_eq!(of(DVec3::new(1.0, 1.0, 0.0)), (0.625, 0.0625, 7));
    let edges = CellEdges::new(&start);
    let middle = |a: DVec3, b: DVec3| {
        let edge = edges.find([number(a) as u32, number(b) as u32]).unwrap();
        let mut weights: Vec<f64> = row(&rows, start.points().len() + edge as usize).into_values().collect();
        weights.sort_by(f64::total_cmp);
        weights
    };
    assert_eq!(middle(DVec3::ZERO, DVec3::X), [0.5, 0.5]);
    assert_eq!(middle(DVec3::new(1.0, 1.0, 0.0), DVec3::new(2.0, 1.0, 0.0)), [0.125, 0.125, 0.375, 0.375]);
}

#[test]
fn the_same_bytes_come_out_on_any_number_of_threads() {
    let start = TetOctMesh::from(&halves(5, 0.1));
    let [one, four] = [1, 4].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| (refine(&refine(&start)), composite(&start, 2)))
    });
    assert_eq!(one.0.points(), four.0.points());
    assert_eq!((one.0.tets(), one.0.octs()), (four.0.tets(), four.0.octs()));
    assert_eq!(one.1.1, four.1.1);
}

#[test]
fn every_edge_is_found_with_its_cells() {
    let mesh = refine(&TetOctMesh::from(&halves(2, 0.1)));
    let edges = CellEdges::new(&mesh);
    let mut uses = BTreeMap::<[u32; 2], usize>::new();
    let sorted = |a: u32, b: u32| [a.min(b), a.max(b)];
    mesh.tets().iter().for_each(|t| EDGES.iter().for_each(|&[i, j]| *uses.entry(sorted(t[i], t[j])).or_default() += 1));
    mesh.octs()
        .iter()
        .for_each(|o| OCT_EDGES.iter().for_each(|&[i, j]| *uses.entry(sorted(o[i], o[j])).or_default() += 1));
    assert_eq!(edges.all(), uses.keys().copied().collect::<Vec<_>>());
    for (e, (ends, count)) in uses.into_iter().enumerate() {
        assert_eq!((edges.find(ends), edges.uses(e).count()), (Some(e as u32), count));
    }
    // Opposite faces of an octahedron have no vertex in common, and no two opposite vertices lie on one.
    for (i, face) in OCT_FACES.iter().enumerate() {
        assert!(face.iter().all(|v| !OCT_FACES[7 - i].contains(v) && !face.contains(&(v ^ 1))));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn affine_maps_commute_with_subdivision(
        entries in prop::array::uniform9(-2.0_f64..2.0), shift in prop::array::uniform3(-5.0_f64..5.0)
    ) {
        let map = DAffine3::from_mat3_translation(DMat3::from_cols_array(&entries), DVec3::from_array(shift));
        let start = TetOctMesh::from(&halves(2, 0.15));
        let mapped = start.with_points(start.points().iter().map(|p| map.transform_point3(*p)).collect());
        let [fine, of_mapped] = [start, mapped].map(|mesh| refine(&refine(&mesh)));
        for (p, q) in fine.points().iter().zip(of_mapped.points()) {
            prop_assert!(map.transform_point3(*p).distance(*q) < 1e-13);
        }
    }
}

#[test]
fn the_command_writes_a_mesh_that_is_read_back_and_refuses_what_it_cannot_do() {
    let folder = tempfile::tempdir().unwrap();
    let (out, json) = (folder.path().join("out.vtu"), folder.path().join("out.json"));
    let run = |mesh: &Path, more: &[&str]| {
        let mut command = assert_cmd::Command::cargo_bin("subsolid").unwrap();
        command.arg("subdivide").arg(mesh).args(["--scheme", "tet-oct", "-o"]).arg(&out).arg("--json").arg(&json);
        let output = command.args(more).output().unwrap();
        (output.status.code().unwrap(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let bracket = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/bracket.msh");
    for (more, code, words) in [
        (&["--select", "boundary"][..], 2, "--select"),
        (&["--frames", "f"], 2, "--frames"),
        (&["--steps", "12"], 4, "fewer steps"),
    ] {
        let (got, said) = run(&bracket, more);
        assert!(got == code && said.contains(words) && !out.exists(), "{more:?}: {got} {said}");
    }
    assert_eq!(run(&bracket, &["--steps", "2"]).0, 0);
    let (before, after) = (read(&bracket).unwrap().mesh, read(&out).unwrap().mesh);
    let figures: serde_json::Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    let count = |key: &str| figures[key].as_u64().unwrap() as usize;
    let cells = before.tets().len();
    assert_eq!((count("tetrahedra"), count("octahedra")), (24 * cells, 10 * cells));
    assert_eq!(after.tets().len(), 24 * cells + 4 * 10 * cells);
    assert_eq!((after.groups(), after.region_names()), (before.groups(), before.region_names()));
    for group in before.groups() {
        let [fine, coarse] = [&after, &before].map(|m| m.group_faces(m.group(group).unwrap()).count());
        assert_eq!(fine, 16 * coarse, "{group}");
    }
    let text = std::fs::read_to_string(&out).unwrap();
    assert!(text.contains("Name=\"octahedron\""));
}

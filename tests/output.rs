//! What is written can be read back: files, names, order, bytes.

// The functions beside the tests are parts of them.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use std::path::{Path, PathBuf};
use subsolid::fem::Space;
use subsolid::mesh::TetMesh;
use subsolid::output::options::{Compression, Units};
use subsolid::output::plot::{Axis, dihedral_histogram, error_curves, error_histogram};
use subsolid::output::pvd::write_pvd;
use subsolid::output::vtk::{Fields, Values, write_vtu};
use vtkio::model::{Attribute, DataSet, Piece, UnstructuredGridPiece, Vtk};

/// A unit cube of `n`^3 cubes of six tetrahedra each, all around the diagonals.
fn cube(n: usize) -> TetMesh {
    let id = |p: [usize; 3]| ((p[2] * (n + 1) + p[1]) * (n + 1) + p[0]) as u32;
    let range = |m: usize| (0..m).flat_map(move |z| (0..m).flat_map(move |y| (0..m).map(move |x| [x, y, z])));
    let points = range(n + 1).map(|p| DVec3::from_array(p.map(|x| x as f64 / n as f64))).collect();
    let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let tets = range(n).flat_map(|corner| {
        orders.iter().enumerate().map(move |(i, order)| {
            let mut path = [corner; 4];
            for step in 1..4 {
                path[step] = path[step - 1];
                path[step][order[step - 1]] += 1;
            }
            let [a, b, c, d] = path.map(id);
            if i < 3 { [a, b, c, d] } else { [a, b, d, c] }
        })
    });
    TetMesh::from_cells(points, tets.collect(), "solid").unwrap()
}

struct Data {
    displacement: Vec<DVec3>,
    nodal_stress: Vec<[f64; 6]>,
    stress: Vec<[f64; 6]>,
    von_mises: Vec<f64>,
    marked: Vec<bool>,
}

impl Data {
    fn on(mesh: &TetMesh) -> Self {
        let (nodes, cells) = (mesh.points().len(), mesh.tets().len());
        let tensor = |i: usize| [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(|c| c + 10.0 * i as f64);
        Self {
            displacement: mesh.points().iter().map(|p| p.cross(DVec3::new(0.1, 0.2, 0.3))).collect(),
            nodal_stress: (0..nodes).map(tensor).collect(),
            stress: (0..cells).map(tensor).collect(),
            von_mises: (0..cells).map(|t| (t as f64).sin().abs() * 1e-300).collect(),
            marked: (0..cells).map(|t| t % 3 == 0).collect(),
        }
    }

    fn fields(&self, time: f64) -> Fields<'_> {
        Fields {
            time,
            units: Units::default(),
            points: vec![
                ("displacement", Values::Vectors(&self.displacement)),
                ("stress", Values::Tensors(&self.nodal_stress)),
            ],
            cells: vec![
                ("stress", Values::Tensors(&self.stress)),
                ("von_mises", Values::Scalars(&self.von_mises)),
                ("error_indicator", Values::Scalars(&self.von_mises)),
                ("marked", Values::Flags(&self.marked)),
            ],
        }
    }
}

fn read(path: &Path) -> UnstructuredGridPiece {
    match Vtk::import(path).unwrap().data {
        DataSet::UnstructuredGrid { mut pieces, .. } => match pieces.pop() {
            Some(Piece::Inline(piece)) => *piece,
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

fn values(attributes: &[Attribute], name: &str) -> Vec<f64> {
    let array = attributes.iter().find(|a| a.name() == name).unwrap();
    match array {
        Attribute::DataArray(a) => a.data.cast_into::<f64>().unwrap(),
        Attribute::Field { .. } => panic!("{name} is a field"),
    }
}

/// A folder that stays after the test, for `tests/read_back.py`.
fn kept_folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("vtu").join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn vtu_files_hold_the_numbers_given_under_every_compression() {
    for (name, compression) in [("none", Compression::None), ("lz4", Compression::Lz4), ("zlib", Compression::Zlib)] {
        let folder = kept_folder(name);
        let mut files = Vec::new();
        // 15 cubes a side make 4,096 nodes: arrays that fill the blocks of the compressor exactly.
        for (step, n) in [1, 3, 15].into_iter().enumerate() {
            let mesh = cube(n);
            let data = Data::on(&mesh);
            let file = format!("step_{step:03}.vtu");
            write_vtu(&folder.join(&file), &Space::linear(&mesh), &data.fields(step as f64), compression).unwrap();
            files.push((step as f64, file.clone()));
            write_pvd(&folder.join("results.pvd"), &files).unwrap();

            let piece = read(&folder.join(&file));
            let flat: Vec<f64> = mesh.points().iter().flat_map(DVec3::to_array).collect();
            assert_eq!(piece.points.cast_into::<f64>().unwrap(), flat);
            let flat: Vec<f64> = data.displacement.iter().flat_map(DVec3::to_array).collect();
            assert_eq!(values(&piece.data.point, "displacement"), flat);
            assert_eq!(values(&piece.data.point, "stress"), data.nodal_stress.concat());
            assert_eq!(values(&piece.data.cell, "stress"), data.stress.concat());
            assert_eq!(values(&piece.data.cell, "von_mises"), data.von_mises);
            let flags: Vec<f64> = data.marked.iter().map(|&m| f64::from(u8::from(m))).collect();
            assert_eq!(values(&piece.data.cell, "marked"), flags);
            // Kuhn's tetrahedra have dihedral angles of 45, 60 and 90 degrees.
            assert!(values(&piece.data.cell, "quality").iter().all(|a| (a - 45.0).abs() < 1e-9));
            assert!(values(&piece.data.cell, "region").iter().all(|&r| r == 0.0));
        }
    }
}

#[test]
fn a_mesh_without_fields_is_a_file_too() {
    let path = kept_folder("bare").join("mesh.vtu");
    write_vtu(&path, &Space::linear(&cube(2)), &Fields::default(), Compression::Lz4).unwrap();
    let piece = read(&path);
    assert!(piece.data.point.is_empty());
    assert_eq!(values(&piece.data.cell, "refinement_level"), [0.0; 48]);
}

#[test]
fn the_same_fields_give_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = cube(4);
    let data = Data::on(&mesh);
    let bytes = ["a.vtu", "b.vtu"].map(|name| {
        let path = folder.path().join(name);
        write_vtu(&path, &Space::linear(&mesh), &data.fields(0.25), Compression::Lz4).unwrap();
        std::fs::read(path).unwrap()
    });
    assert!(bytes[0] == bytes[1]);
    let text = String::from_utf8(bytes[0].clone()).unwrap();
    assert!(text.contains("Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">0.25<"));
    assert_eq!(text.matches("ComponentName5=\"XZ\"").count(), 2);
}

#[test]
fn fields_that_do_not_fit_or_are_not_finite_are_refused_and_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.vtu");
    let mesh = cube(1);
    let mut numbers = vec![1.0; mesh.tets().len()];
    let write = |numbers: &[f64]| {
        let cells = vec![("von_mises", Values::Scalars(numbers))];
        write_vtu(&path, &Space::linear(&mesh), &Fields { cells, ..Fields::default() }, Compression::Lz4)
    };
    let short = write(&numbers[1..]).unwrap_err().to_string();
    assert!(short.contains("\"von_mises\" has 5 values, the mesh asks for 6"), "{short}");
    numbers[4] = f64::NAN;
    let nan = write(&numbers).unwrap_err().to_string();
    assert!(nan.contains("value 4 of \"von_mises\" is not finite"), "{nan}");
    assert!(!path.exists());
}

#[test]
fn collections_escape_file_names() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("results.pvd");
    write_pvd(&path, &[(0.0, "a&\"b<.vtu".to_owned())]).unwrap();
    let text = std::fs::read_to_string(path).unwrap();
    assert!(text.contains("timestep=\"0.0\" group=\"\" part=\"0\" file=\"a&amp;&quot;b&lt;.vtu\""));
}

/// Numbers that spread like `low`..`high` on average, without randomness.
fn spread(n: usize, low: f64, high: f64) -> Vec<f64> {
    let phase = |i: usize, f: f64| ((i as f64 * f).sin() + 1.0) / 2.0;
    let mean = |i: usize| (phase(i, 1.7) + phase(i, 0.9) + phase(i, 2.3)) / 3.0;
    (0..n).map(|i| low + (high - low) * mean(i)).collect()
}

/// The texts of an SVG picture.
fn texts(path: &Path) -> String {
    let svg = std::fs::read_to_string(path).unwrap();
    svg.split("<text").skip(1).map(|t| t.split(['>', '<']).nth(1).unwrap().trim()).collect::<Vec<_>>().join("|")
}

#[test]
fn pictures_have_axes_units_and_legends() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("plots");
    std::fs::create_dir_all(&folder).unwrap();
    let file = |name: &str| folder.join(name);
    let steps = |low: f64, high: f64| -> Vec<(String, Vec<f64>)> {
        (0..3).map(|i| (format!("step {i}"), spread(3000 << i, low, high))).collect()
    };
    dihedral_histogram(&file("dihedral.svg"), &steps(5.0, 70.0)).unwrap();
    let written = texts(&file("dihedral.svg"));
    for text in ["step 2: worst", "minimum dihedral angle of a cell, degrees", "share of the cells, %"] {
        assert!(written.contains(text), "{text} in {written}");
    }

    let errors: Vec<_> =
        steps(-4.0, -0.5).into_iter().map(|(l, e)| (l, e.iter().map(|x| 10_f64.powf(*x)).collect())).collect();
    error_histogram(&file("errors.svg"), &errors, Some("mJ")).unwrap();
    let labels = texts(&file("errors.svg"));
    assert!(labels.contains("estimated error of a cell in the energy norm") && labels.contains("(mJ)"), "{labels}");

    let curve = |rate: f64, step: f64, n: i32| -> Vec<(f64, f64)> {
        (0..n).map(|i| 2901.0 * step.powi(i)).map(|x| (x, 0.4 * (x / 2901.0).powf(-rate))).collect()
    };
    let runs = vec![("global".to_owned(), curve(0.2, 8.0, 3)), ("adaptive".to_owned(), curve(0.3, 1.8, 6))];
    error_curves(&file("error_dofs.svg"), Axis::Unknowns(1), "estimated", &runs).unwrap();
    let written = texts(&file("error_dofs.svg"));
    for text in ["global", "adaptive", "slope -1/3", "unknowns", "estimated relative error, %", "10,000"] {
        assert!(written.contains(text), "{text} in {written}");
    }
    let timed: Vec<_> = runs.iter().map(|(l, c)| (l.clone(), c.iter().map(|(x, e)| (x / 1e5, *e)).collect())).collect();
    error_curves(&file("error_seconds.svg"), Axis::Seconds, "true", &timed[1..]).unwrap();
    let written = texts(&file("error_seconds.svg"));
    assert!(written.contains("seconds since the start") && !written.contains("slope"), "{written}");
}

#[test]
fn pictures_of_nothing_are_still_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("empty.svg");
    error_curves(&path, Axis::Unknowns(1), "estimated", &[("run".to_owned(), vec![(0.0, f64::NAN)])]).unwrap();
    error_histogram(&path, &[("step 0".to_owned(), vec![0.0; 5])], None).unwrap();
    dihedral_histogram(&path, &[("step 0".to_owned(), Vec::new())]).unwrap();
    dihedral_histogram(&path, &[]).unwrap();
    assert!(std::fs::read_to_string(&path).unwrap().ends_with("</svg>\n"));
}

//! Random solids, random selections, every scheme, boundary rule and way to optimise: what must hold after every step.
//!
//! The checks are made here from points, cells and faces alone, not by the code that refines. `PROPTEST_CASES=4000 cargo
//! test --release --test properties` makes a long run of it.
#![allow(clippy::unwrap_used)]

use glam::{DMat3, DVec3};
use proptest::prelude::*;
use std::collections::BTreeMap;
use subsolid::mesh::{TetMesh, features, generate, topology};
use subsolid::subdiv::options::{Boundary, Mode, Objective, Optimise, Options, Scheme};
use subsolid::subdiv::{self, Directions, History, Weights};

/// A solid of unit cubes, some of them left out, in two regions; bent by a wave if `bend` is not zero.
#[derive(Debug, Clone)]
struct Model {
    bricks: [usize; 3],
    /// Bit by bit which cubes are kept, and which are of the second region.
    kept: u64,
    second: u64,
    shear: [f64; 3],
    bend: f64,
}

impl Model {
    fn brick(&self, p: DVec3) -> usize {
        let [x, y, z] = (0..3).map(|i| (p[i].max(0.0) as usize).min(self.bricks[i] - 1)).collect::<Vec<_>>()[..] else {
            unreachable!("three coordinates")
        };
        x + self.bricks[0] * (y + self.bricks[1] * z)
    }

    fn is_kept(&self, p: DVec3) -> bool {
        self.kept >> (self.brick(p) % 64) & 1 == 1
    }

    fn region(&self, p: DVec3) -> u16 {
        (self.second >> (self.brick(p) % 64) & 1) as u16
    }

    fn shear(&self) -> DMat3 {
        let [a, b, c] = self.shear;
        DMat3::from_cols(DVec3::new(1.0, a, 0.0), DVec3::new(0.0, 1.0, b), DVec3::new(c, 0.0, 1.0))
    }

    fn place(&self, p: DVec3) -> DVec3 {
        self.shear() * (p + self.bend * DVec3::new((2.0 * p.y + p.z).sin(), (1.5 * p.z + p.x).cos(), (p.x + p.y).sin()))
    }

    /// `None` if no cube is left.
    fn mesh(&self) -> Option<TetMesh> {
        let whole = generate::box_tets(self.bricks.map(|n| n as f64), self.bricks).unwrap();
        let cells: Vec<usize> = (0..whole.tets().len()).filter(|&t| self.is_kept(centre(&whole, t))).collect();
        let mut number = vec![u32::MAX; whole.points().len()];
        let mut points = Vec::new();
        for v in cells.iter().flat_map(|&t| whole.tets()[t]) {
            if number[v as usize] == u32::MAX {
                number[v as usize] = points.len() as u32;
                points.push(whole.points()[v as usize]);
            }
        }
        if cells.is_empty() {
            return None;
        }
        let tets = cells.iter().map(|&t| whole.tets()[t].map(|v| number[v as usize])).collect();
        let mut parts = TetMesh::from_cells(points, tets, "first").unwrap().into_parts();
        parts.region_names.push("second".to_owned());
        let regions = cells.iter().map(|&t| self.region(centre(&whole, t)));
        parts.regions.iter_mut().zip(regions).for_each(|(r, region)| r.0 = region);
        parts.points.iter_mut().for_each(|p| *p = self.place(*p));
        let mesh = TetMesh::new(parts).unwrap();
        let low: Vec<bool> = mesh.faces().iter().map(|f| self.is_low(&mesh, f.vertices)).collect();
        let mesh = if low.contains(&true) { mesh.with_group("low", &low).unwrap().0 } else { mesh };
        Some(features::with_creases(mesh, 40.0, &[]))
    }

    /// True for faces of z = 0.
    fn is_low(&self, mesh: &TetMesh, vertices: [u32; 3]) -> bool {
        let back = self.shear().inverse();
        self.bend == 0.0 && vertices.iter().all(|&v| (back * mesh.points()[v as usize]).z.abs() < 1e-12)
    }
}

fn centre(mesh: &TetMesh, t: usize) -> DVec3 {
    mesh.cell_points(t).iter().sum::<DVec3>() / 4.0
}

fn models() -> impl Strategy<Value = Model> {
    let bricks = [1..4_usize, 1..4, 1..3];
    let bend = prop_oneof![Just(0.0), 0.02..0.15_f64];
    (bricks, any::<u64>(), any::<u64>(), any::<u64>(), [-0.2..0.2, -0.2..0.2, -0.2..0.2_f64], bend).prop_map(
        // Three of four cubes are kept.
        |(bricks, k, l, second, shear, bend)| Model { bricks, kept: k | l, second, shear, bend },
    )
}

fn optimisers() -> impl Strategy<Value = Optimise> {
    let of =
        |(mode, objective, directions, passes)| Optimise { mode, objective, directions, passes, ..Optimise::default() };
    prop::sample::select(vec![
        (Mode::Paper, Objective::Quality, true, 0),
        (Mode::Paper, Objective::Quality, true, 2),
        (Mode::Best, Objective::Quality, true, 2),
        (Mode::Best, Objective::Error, true, 2),
        (Mode::Best, Objective::Error, false, 2),
    ])
    .prop_map(of)
}

fn options() -> impl Strategy<Value = Options> {
    let scheme = prop_oneof![4 => Just(Scheme::Sqrt3), 1 => Just(Scheme::Red), 1 => Just(Scheme::LongestEdge)];
    let boundary = prop::sample::select(vec![Boundary::Fixed, Boundary::Approximating, Boundary::Interpolating]);
    (scheme, boundary, optimisers()).prop_map(|(scheme, boundary, optimise)| {
        let boundary = if scheme == Scheme::Sqrt3 { boundary } else { Boundary::Fixed };
        Options { scheme, boundary, optimise, ..Options::default() }
    })
}

/// How cells are selected.
#[derive(Debug, Clone, Copy)]
enum Selection {
    All,
    Nothing,
    /// One in so many, at random.
    Scattered(u64, u64),
    /// Those at a vertex, by its number modulo the number of vertices.
    AtVertex(usize),
    /// Those within a distance of a vertex.
    Ball(usize, f64),
    /// Those with a boundary face, but for one in three.
    Boundary(u64),
}

fn selections() -> impl Strategy<Value = Selection> {
    prop_oneof![
        2 => Just(Selection::All),
        1 => Just(Selection::Nothing),
        3 => (any::<u64>(), 2..20_u64).prop_map(|(seed, n)| Selection::Scattered(seed, n)),
        2 => any::<usize>().prop_map(Selection::AtVertex),
        2 => (any::<usize>(), 0.2..1.0).prop_map(|(v, radius)| Selection::Ball(v, radius)),
        1 => any::<u64>().prop_map(Selection::Boundary),
    ]
}

fn hash(i: usize, seed: u64) -> u64 {
    let x = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(seed);
    (x ^ x >> 31).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 33
}

fn select(mesh: &TetMesh, selection: Selection) -> Vec<bool> {
    let at = |v: usize| v % mesh.points().len();
    let surface = boundary_of(mesh);
    (0..mesh.tets().len())
        .map(|t| match selection {
            Selection::All => true,
            Selection::Nothing => false,
            Selection::Scattered(seed, n) => hash(t, seed).is_multiple_of(n),
            Selection::AtVertex(v) => mesh.tets()[t].contains(&(at(v) as u32)),
            Selection::Ball(v, radius) => centre(mesh, t).distance(mesh.points()[at(v)]) < radius,
            Selection::Boundary(seed) => {
                !hash(t, seed).is_multiple_of(3)
                    && topology::tet_faces(mesh.tets()[t]).iter().any(|f| surface.contains_key(&topology::sorted3(*f)))
            }
        })
        .collect()
}

/// Faces of one cell only, with the cell. Panics where cells do not fit together: more than two at a face, or two on the
/// same side of it.
fn boundary_of(mesh: &TetMesh) -> BTreeMap<[u32; 3], ([u32; 3], usize)> {
    let mut open = BTreeMap::new();
    let mut closed = std::collections::BTreeSet::new();
    for (t, tet) in mesh.tets().iter().enumerate() {
        for face in topology::tet_faces(*tet) {
            let key = topology::sorted3(face);
            assert!(!closed.contains(&key), "three cells at face {key:?}");
            match open.remove(&key) {
                None => {
                    open.insert(key, (face, t));
                }
                Some((other, _)) => {
                    assert!(!is_even(face, other), "two cells on the same side of face {key:?}");
                    closed.insert(key);
                }
            }
        }
    }
    open
}

/// True if one is a rotation of the other.
fn is_even([a, b, c]: [u32; 3], face: [u32; 3]) -> bool {
    [[a, b, c], [b, c, a], [c, a, b]].contains(&face)
}

/// The mesh fits together: cells positive and face to face, the faces it lists are its boundary, seen from outside, and
/// the boundary is closed: an even number of faces at each edge, two if `manifold`.
fn assert_fits_together(mesh: &TetMesh, manifold: bool) {
    for t in 0..mesh.tets().len() {
        let [a, b, c, d] = mesh.cell_points(t);
        assert!((b - a).cross(c - a).dot(d - a) > 0.0, "cell {t} is not positive");
    }
    let boundary = boundary_of(mesh);
    assert_eq!(boundary.len(), mesh.faces().len());
    let mut at_edge: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for face in mesh.faces() {
        let (outward, _) = boundary[&topology::sorted3(face.vertices)];
        assert!(is_even(outward, face.vertices), "face {:?} is seen from inside", face.vertices);
        let [a, b, c] = face.vertices;
        for edge in [[a, b], [b, c], [c, a]] {
            *at_edge.entry(topology::sorted2(edge)).or_default() += 1;
        }
    }
    assert!(at_edge.values().all(|n| n % 2 == 0 && (*n == 2 || !manifold)));
    let edges = topology::edges(mesh.tets());
    assert!(mesh.creases().iter().all(|c| edges.binary_search(&c.vertices).is_ok()), "a crease that is no edge");
}

fn is_manifold(mesh: &TetMesh) -> bool {
    features::boundary_edges(mesh.faces()).iter().all(|(_, faces)| faces.len() == 2)
}

/// Volume of each region, area of each group, length of the features.
fn measures(mesh: &TetMesh) -> Vec<f64> {
    let mut volumes = vec![0.0; mesh.region_names().len()];
    (0..mesh.tets().len()).for_each(|t| volumes[mesh.regions()[t].0 as usize] += mesh.cell_volume(t));
    let area = |f: &subsolid::mesh::Face| 0.5 * features::face_normal(mesh.points(), f.vertices).length();
    let areas = mesh.groups().iter().map(|g| mesh.group_faces(mesh.group(g).unwrap()).map(area).sum::<f64>());
    volumes.extend(areas.collect::<Vec<_>>());
    volumes.push(features::feature_count_and_length(mesh).1);
    volumes
}

fn assert_kept(before: &[f64], after: &[f64], what: &str) {
    for (old, new) in before.iter().zip(after) {
        assert!((old - new).abs() <= 1e-12 * old.abs().max(1.0), "{what}: {old} became {new}");
    }
}

/// A step of an unbent model leaves every cell in a cube of its region, every face of "low" at z = 0, and every
/// boundary vertex on a side of a cube.
fn assert_tags_are_exact(mesh: &TetMesh, model: &Model) {
    let back = model.shear().inverse();
    for t in 0..mesh.tets().len() {
        let p = back * centre(mesh, t);
        assert!(model.is_kept(p), "cell {t} lies outside");
        assert_eq!(mesh.regions()[t].0, model.region(p), "cell {t} is of the other region");
    }
    for face in mesh.faces() {
        let corners = face.vertices.map(|v| back * mesh.points()[v as usize]);
        let flat = |i: usize| {
            let plane = corners[0][i].round();
            corners.iter().all(|p| (p[i] - plane).abs() < 1e-12)
        };
        assert!((0..3).any(flat), "face {:?} has left its plane: {corners:?}", face.vertices);
    }
    if let Some(group) = mesh.group("low") {
        assert!(mesh.group_faces(group).all(|f| model.is_low(mesh, f.vertices)));
        let low = mesh.faces().iter().filter(|f| model.is_low(mesh, f.vertices)).count();
        assert_eq!(mesh.group_faces(group).count(), low);
    }
}

/// One step with whatever comes after it. Red refinement takes all cells.
fn step(mesh: &TetMesh, history: &History, selection: Selection, options: &Options) -> (TetMesh, History) {
    let all = options.scheme == Scheme::Red;
    let selected = &select(mesh, if all { Selection::All } else { selection });
    let refined = subdiv::refine(mesh, history, selected, options).unwrap();
    if !options.optimise.ends_in_error() {
        return (refined.mesh, refined.history);
    }
    let sizes = mesh.points().iter().map(|p| 1.0 + p.length_squared());
    let weights = if options.optimise.directions {
        Weights::Directions(sizes.map(|x| Directions([x, 0.2, 2.0, 0.1, 0.3, x.sqrt()])).collect())
    } else {
        Weights::Factors(sizes.collect())
    };
    let weights = weights.carried_over(&refined.transfer);
    let first = mesh.points().len();
    let optimised = subdiv::optimise_error(&refined.mesh, &weights, options.optimise.passes, first).unwrap();
    (optimised.mesh, refined.history.renumbered(&optimised.kept))
}

proptest! {
    #[test]
    fn every_step_leaves_a_sound_mesh_of_the_same_solid(
        model in models(), options in options(), selections in proptest::collection::vec(selections(), 1..4),
    ) {
        let Some(mut mesh) = model.mesh() else { return Ok(()) };
        let (mut history, manifold) = (History::default(), is_manifold(&mesh));
        let corners: Vec<DVec3> = mesh.corners().iter().map(|&v| mesh.points()[v as usize]).collect();
        for selection in selections {
            let before = measures(&mesh);
            let (next, later) = step(&mesh, &history, selection, &options);
            assert_fits_together(&next, manifold);
            let after = measures(&next);
            if options.boundary == Boundary::Fixed || model.bend == 0.0 {
                assert_kept(&before, &after, "volumes, areas, features");
            } else {
                assert_kept(&before[before.len() - 1..], &after[after.len() - 1..], "features");
            }
            if model.bend == 0.0 {
                assert_tags_are_exact(&next, &model);
            }
            let still: Vec<DVec3> = next.corners().iter().map(|&v| next.points()[v as usize]).collect();
            prop_assert_eq!(&still, &corners);
            (mesh, history) = (next, later);
            if mesh.tets().len() > 4000 {
                break;
            }
        }
    }

    #[test]
    fn the_number_of_threads_does_not_show(model in models(), options in options(), selection in selections()) {
        let Some(mesh) = model.mesh() else { return Ok(()) };
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| step(&mesh, &History::default(), selection, &options))
        };
        let (one, history) = run(1);
        for threads in [2, 8] {
            let (many, later) = run(threads);
            prop_assert_eq!((one.points(), one.tets(), one.faces()), (many.points(), many.tets(), many.faces()));
            prop_assert_eq!((one.creases(), one.levels(), one.regions()), (many.creases(), many.levels(), many.regions()));
            prop_assert_eq!(&history, &later);
        }
    }
}

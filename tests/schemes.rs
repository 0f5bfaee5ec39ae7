//! Longest-edge bisection and the interpolating boundary of sqrt(3) subdivision: what must hold after every step, and maps
//! that commute with a step of any scheme.
//!
//! `TetMesh::new` itself checks after every step that all cells are positive and that the boundary faces are exactly the
//! boundary, so a step that returns has kept both.
#![allow(clippy::unwrap_used)]

use glam::{DMat3, DQuat, DVec3};
use proptest::prelude::*;
use subsolid::mesh::{TetMesh, features, generate, quality, read, topology};
use subsolid::subdiv::options::{Boundary, Optimise, Options, Scheme};
use subsolid::subdiv::{self, History, Refined};

const BISECTION: Options = options(Scheme::LongestEdge, Boundary::Fixed);

const fn options(scheme: Scheme, boundary: Boundary) -> Options {
    Options { scheme, boundary, optimise: OPTIMISE, frames: false }
}

const OPTIMISE: Optimise = Optimise {
    mode: subsolid::subdiv::options::Mode::Paper,
    objective: subsolid::subdiv::options::Objective::Quality,
    directions: true,
    measure: subsolid::subdiv::options::QualityMeasure::MinSine,
    passes: 3,
    target_angle: 32.0,
    valence_limit: 50,
};

fn unit_box(n: usize) -> TetMesh {
    features::with_creases(generate::box_tets([1.0; 3], [n; 3]).unwrap(), 40.0, &[])
}

/// The mesh with its points moved.
fn moved(mesh: TetMesh, to: impl Fn(DVec3) -> DVec3) -> TetMesh {
    let mut parts = mesh.into_parts();
    parts.points.iter_mut().for_each(|p| *p = to(*p));
    TetMesh::new(parts).unwrap()
}

/// A displacement without any symmetry.
fn wave(p: DVec3) -> DVec3 {
    DVec3::new((7.0 * p.y + 3.0 * p.z + 3.0).sin(), (5.0 * p.z + p.x).cos(), (6.0 * p.x + 2.0 * p.y + 1.0).sin())
}

/// A box of two regions that meet near x = 0.5, its inner vertices moved by up to `jitter`.
fn jittered(n: usize, jitter: f64) -> TetMesh {
    let mut parts = unit_box(n).into_parts();
    parts.region_names.push("right".to_owned());
    for (t, tet) in parts.tets.iter().enumerate() {
        let x = tet.iter().map(|&v| parts.points[v as usize].x).sum::<f64>() / 4.0;
        parts.regions[t].0 = u16::from(x > 0.5);
    }
    let inside = |p: DVec3| p.min_element() > 1e-9 && p.max_element() < 1.0 - 1e-9;
    let mesh = features::with_creases(TetMesh::new(parts).unwrap(), 40.0, &[]);
    moved(mesh, |p| if inside(p) { p + jitter / n as f64 * wave(37.0 * p) } else { p })
}

fn refine(mesh: &TetMesh, selected: &[bool], options: &Options) -> Refined {
    subdiv::refine(mesh, &History::default(), selected, options).unwrap()
}

fn refine_all(mesh: &TetMesh, options: &Options) -> Refined {
    refine(mesh, &vec![true; mesh.tets().len()], options)
}

/// Cells drawn with probability `share` / 10.
fn random_selection(count: usize, seed: u64, share: u64) -> Vec<bool> {
    let mut state = seed | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state >> 33
    };
    (0..count).map(|_| next() % 10 < share).collect()
}

fn region_volumes(mesh: &TetMesh) -> Vec<f64> {
    let mut volumes = vec![0.0; mesh.region_names().len()];
    (0..mesh.tets().len()).for_each(|t| volumes[mesh.regions()[t].0 as usize] += mesh.cell_volume(t));
    volumes
}

fn group_areas(mesh: &TetMesh) -> Vec<f64> {
    let area = |f: &subsolid::mesh::Face| 0.5 * features::face_normal(mesh.points(), f.vertices).length();
    mesh.groups().iter().map(|g| mesh.group_faces(mesh.group(g).unwrap()).map(area).sum()).collect()
}

/// Lengths of the features and of the other creases.
fn crease_lengths(mesh: &TetMesh) -> [f64; 2] {
    [true, false].map(|feature| {
        let creases = mesh.creases().iter().filter(|c| c.feature == feature);
        creases.map(|c| mesh.points()[c.vertices[0] as usize].distance(mesh.points()[c.vertices[1] as usize])).sum()
    })
}

fn assert_same(what: &str, before: &[f64], after: &[f64]) {
    for (a, b) in before.iter().zip(after) {
        assert!((a - b).abs() <= 1e-12 * a.abs().max(1e-3), "{what}: {a} became {b}");
    }
}

/// The domain with its tags is the same set of points as before.
fn assert_kept(before: &TetMesh, after: &TetMesh) {
    assert_same("volume", &[before.volume()], &[after.volume()]);
    assert_same("volumes of the regions", &region_volumes(before), &region_volumes(after));
    assert_same("areas of the groups", &group_areas(before), &group_areas(after));
    assert_same("lengths of the creases", &crease_lengths(before), &crease_lengths(after));
    assert_eq!(before.corners(), after.corners());
}

/// Every crease is an edge of the mesh.
fn assert_creases_are_edges(mesh: &TetMesh) {
    let edges = topology::edges(mesh.tets());
    assert!(mesh.creases().iter().all(|c| edges.binary_search(&c.vertices).is_ok()));
}

#[test]
fn three_bisections_of_a_kuhn_box_are_one_regular_refinement() {
    let (start, mut mesh) = (unit_box(2), unit_box(2));
    for step in 1..=3 {
        let refined = refine_all(&mesh, &BISECTION);
        assert_kept(&mesh, &refined.mesh);
        mesh = refined.mesh;
        assert_eq!(mesh.tets().len(), start.tets().len() << step, "all longest edges are selected: no path is needed");
        assert!(mesh.levels().iter().all(|&level| level == step));
    }
    // Bisection of Kuhn's tetrahedron leads back to it after three steps.
    assert_eq!(mesh.points().len(), unit_box(4).points().len());
    assert!((quality::quality(&mesh).worst - quality::quality(&start).worst).abs() < 1e-9);
}

#[test]
fn bisecting_at_one_vertex_again_and_again_keeps_the_shapes() {
    for (place, start) in [
        ("corner", DVec3::ZERO),
        ("crease", DVec3::new(0.5, 0.0, 0.0)),
        ("face", DVec3::new(0.5, 0.5, 0.0)),
        ("inside", DVec3::splat(0.5)),
    ] {
        for jitter in [0.0, 0.2] {
            let mut mesh = jittered(2, jitter);
            let points = mesh.points();
            let nearest = |v: &usize, w: &usize| points[*v].distance(start).total_cmp(&points[*w].distance(start));
            let vertex = (0..points.len()).min_by(nearest).unwrap() as u32;
            let mut history = vec![(quality::quality(&mesh), mesh.tets().len())];
            for _ in 0..30 {
                let at: Vec<bool> = mesh.tets().iter().map(|t| t.contains(&vertex)).collect();
                let refined = refine(&mesh, &at, &BISECTION);
                assert_kept(&mesh, &refined.mesh);
                mesh = refined.mesh;
                history.push((quality::quality(&mesh), mesh.tets().len()));
            }
            let [(first, _), (_, n), (middle, m), (last, l)] = [0, 10, 20, 30].map(|step| history[step]);
            assert!(last.worst >= 0.5 * first.worst, "{place}, {jitter}: {} became {}", first.worst, last.worst);
            // The mesh shrinks towards the vertex in copies of itself: nothing new appears, as many cells in each round.
            assert!(last.worst > 0.99 * middle.worst && last.max_valence <= middle.max_valence, "{place}, {jitter}");
            assert!((l - m) * 4 < (m - n) * 5, "{place}, {jitter}: {} cells, then {}", m - n, l - m);
        }
    }
}

#[test]
fn an_empty_selection_bisects_nothing() {
    let mesh = jittered(2, 0.1);
    let refined = refine(&mesh, &vec![false; mesh.tets().len()], &BISECTION);
    assert_eq!((refined.mesh.tets(), refined.mesh.points()), (mesh.tets(), mesh.points()));
    assert_eq!((refined.info.asked, refined.info.split), (0, 0));
}

#[test]
fn an_edge_of_a_few_units_in_the_last_place_is_refused() {
    // Far from the origin the midpoint of the short edges is rounded onto an end.
    let tiny = moved(unit_box(1), |p| DVec3::splat(1.0) + p * 2.0 * f64::EPSILON);
    let mut mesh = tiny;
    for _ in 0..12 {
        let all = vec![true; mesh.tets().len()];
        match subdiv::refine(&mesh, &History::default(), &all, &BISECTION) {
            Ok(refined) => mesh = refined.mesh,
            Err(_) => return,
        }
    }
    panic!("edges cannot be halved for ever");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn random_bisections_keep_the_domain_and_its_tags(
        seeds in proptest::collection::vec(any::<u64>(), 4), jitter in 0.0..0.25_f64, share in 0_u64..9,
    ) {
        let mut mesh = jittered(3, jitter);
        let first = quality::quality(&mesh).worst;
        for seed in seeds {
            let selected = random_selection(mesh.tets().len(), seed, share);
            let refined = refine(&mesh, &selected, &BISECTION);
            assert_kept(&mesh, &refined.mesh);
            assert_creases_are_edges(&refined.mesh);
            let (after, info) = (&refined.mesh, refined.info);
            prop_assert_eq!(info.asked, selected.iter().filter(|s| **s).count());
            prop_assert!(info.split >= info.asked);
            prop_assert!(after.tets().len() >= mesh.tets().len() + info.split);
            prop_assert_eq!(&after.points()[..mesh.points().len()], mesh.points());
            let x = |m: &TetMesh| m.points().iter().map(|p| p.x).collect::<Vec<f64>>();
            prop_assert_eq!(subdiv::carry_over(&x(&mesh), &refined.transfer), x(after));
            // Each selected cell is gone.
            let mut left: Vec<[u32; 4]> = after.tets().to_vec();
            left.sort_unstable();
            prop_assert!((0..selected.len()).all(|t| !selected[t] || left.binary_search(&mesh.tets()[t]).is_err()));
            let again = refine(&mesh, &selected, &BISECTION).mesh;
            prop_assert_eq!((again.points(), again.tets(), again.faces()), (after.points(), after.tets(), after.faces()));
            prop_assert_eq!((again.creases(), again.levels()), (after.creases(), after.levels()));
            mesh = refined.mesh;
        }
        prop_assert!(quality::quality(&mesh).worst >= 0.3 * first);
    }

    /// Decisions look at ratios of lengths and at angles only, so a similarity of the input is one of the output.
    #[test]
    fn a_similarity_commutes_with_a_step_of_any_scheme(
        seed in any::<u64>(), axis in prop::array::uniform3(0.1_f64..1.0), angle in 0.1_f64..3.0, scale in 0.01_f64..100.0,
    ) {
        let turn = DQuat::from_axis_angle(DVec3::from(axis).normalize(), angle);
        let map = |p: DVec3| scale * (turn * p + DVec3::new(0.3, -0.2, 0.1));
        // Without symmetry there are no ties that rounding could break.
        let mesh = moved(unit_box(2), |p| p + 0.05 * wave(p + DVec3::splat((seed % 1000) as f64)));
        let image = moved(mesh.clone(), map);
        for (scheme, boundary) in [
            (Scheme::Red, Boundary::Fixed),
            (Scheme::LongestEdge, Boundary::Fixed),
            (Scheme::Sqrt3, Boundary::Fixed),
            (Scheme::Sqrt3, Boundary::Approximating),
            (Scheme::Sqrt3, Boundary::Interpolating),
        ] {
            let mut options = options(scheme, boundary);
            options.optimise.passes = 0;
            let [a, b] = [&mesh, &image].map(|m| refine_all(m, &options).mesh);
            prop_assert_eq!(a.tets(), b.tets(), "{:?}", options);
            let far = a.points().iter().zip(b.points()).map(|(p, q)| map(*p).distance(*q)).fold(0.0, f64::max);
            prop_assert!(far <= 1e-12 * scale, "{:?}: {}", options, far);
        }
    }

    /// Which way an edge is halved first or an octahedron is cut depends on lengths, but where vertices go does not.
    #[test]
    fn an_affine_map_commutes_with_the_vertices_of_a_step_without_optimisation(
        shear in prop::array::uniform3(-0.25_f64..0.25), stretch in prop::array::uniform3(0.8_f64..1.25),
    ) {
        let [xy, yz, zx] = shear;
        let columns = [DVec3::new(1.0, xy, 0.0), DVec3::new(0.0, 1.0, yz), DVec3::new(zx, 0.0, 1.0)];
        let matrix = DMat3::from_diagonal(DVec3::from(stretch)) * DMat3::from_cols(columns[0], columns[1], columns[2]);
        let mesh = moved(unit_box(2), |p| p + 0.04 * wave(p));
        let image = moved(mesh.clone(), |p| matrix * p);
        for (scheme, boundary) in [
            (Scheme::Red, Boundary::Fixed),
            (Scheme::Sqrt3, Boundary::Fixed),
            (Scheme::Sqrt3, Boundary::Approximating),
            (Scheme::Sqrt3, Boundary::Interpolating),
        ] {
            let mut options = options(scheme, boundary);
            options.optimise.passes = 0;
            let [a, b] = [&mesh, &image].map(|m| refine_all(m, &options));
            prop_assert_eq!((a.info.rejected, b.info.rejected), (0, 0), "{:?}", options);
            prop_assert_eq!(a.mesh.points().len(), b.mesh.points().len());
            for p in a.mesh.points().iter().map(|p| matrix * *p) {
                prop_assert!(b.mesh.points().iter().any(|q| p.distance(*q) < 1e-13), "{:?}: {} is missing", options, p);
            }
        }
    }
}

const INTERPOLATING: Options = options(Scheme::Sqrt3, Boundary::Interpolating);

/// Boundary vertices that a step has added to a mesh of `old` vertices.
fn new_boundary_vertices(mesh: &TetMesh, old: usize) -> Vec<DVec3> {
    let mut vertices: Vec<u32> = mesh.faces().iter().flat_map(|f| f.vertices).filter(|&v| v as usize >= old).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices.into_iter().map(|v| mesh.points()[v as usize]).collect()
}

#[test]
fn flat_parts_stay_flat_under_the_interpolating_rule() {
    for adaptive in [false, true] {
        let (mut mesh, mut history) = (unit_box(3), History::default());
        for step in 0..3 {
            let count = mesh.tets().len();
            let selected = if adaptive { random_selection(count, 77 + step, 3) } else { vec![true; count] };
            let refined = subdiv::refine(&mesh, &history, &selected, &INTERPOLATING).unwrap();
            assert_kept(&mesh, &refined.mesh);
            for &v in refined.mesh.faces().iter().flat_map(|f| &f.vertices) {
                let p = refined.mesh.points()[v as usize];
                let off = p.to_array().iter().map(|x| x.abs().min((x - 1.0).abs())).fold(1.0, f64::min);
                assert!(off < 1e-14, "{p} has left the faces of the box");
            }
            assert_creases_are_edges(&refined.mesh);
            (mesh, history) = (refined.mesh, refined.history);
        }
    }
}

#[test]
fn cubic_surfaces_are_reproduced_on_the_regular_lattice() {
    let cubic = |x: f64, y: f64| 0.1 * (x - 0.2 * y - 2.0 * x * y + x.powi(3) - 1.5 * x * y * y + y.powi(3));
    let block = features::with_creases(generate::box_tets([1.0, 1.0, 0.5], [8, 8, 4]).unwrap(), 40.0, &[]);
    let mesh = moved(block, |p| p + DVec3::Z * 2.0 * p.z * cubic(p.x, p.y));
    let refined = refine_all(&mesh, &INTERPOLATING);
    assert_eq!(refined.info.rejected, 0);
    let mut checked = 0;
    for p in new_boundary_vertices(&refined.mesh, mesh.points().len()) {
        // Where no stencil reaches the rim of the top, two cells from it.
        let inside = |x: f64| (0.26..0.74).contains(&x);
        if p.z > 0.3 && inside(p.x) && inside(p.y) {
            assert!((p.z - 0.5 - cubic(p.x, p.y)).abs() < 1e-14, "{p}");
            checked += 1;
        }
    }
    assert_eq!(checked, 32, "two faces on each of the inner squares");
}

/// The box blown up to the unit ball, without features and groups.
fn ball(n: usize) -> TetMesh {
    let mut parts = generate::box_tets([2.0; 3], [n; 3]).unwrap().into_parts();
    (parts.groups, parts.patches) = (Vec::new(), vec![Vec::new()]);
    parts.faces.iter_mut().for_each(|f| f.patch.0 = 0);
    moved(TetMesh::new(parts).unwrap(), |p| {
        let q = p - 1.0;
        // Equal angles instead of equal lengths along the faces of the box.
        let q = q.to_array().map(|x| (x * std::f64::consts::FRAC_PI_4).tan()).into();
        let radius = DVec3::abs(q).max_element();
        if radius > 0.0 { q.normalize() * radius } else { q }
    })
}

/// The largest distance from the unit sphere of the new boundary vertices of one step well inside the six sides, and of all.
fn distances(n: usize) -> (f64, f64) {
    let mesh = ball(n);
    let refined = refine_all(&mesh, &INTERPOLATING);
    let boundary: Vec<u32> = mesh.faces().iter().flat_map(|f| f.vertices).collect();
    for v in boundary {
        assert_eq!(mesh.points()[v as usize], refined.mesh.points()[v as usize], "old boundary vertices stay");
    }
    let new = new_boundary_vertices(&refined.mesh, mesh.points().len());
    let far = |points: &mut dyn Iterator<Item = &DVec3>| points.map(|p| (p.length() - 1.0).abs()).fold(0.0, f64::max);
    let inner = |p: &&DVec3| {
        let mut sizes = p.abs().to_array();
        sizes.sort_by(f64::total_cmp);
        sizes[1] < 0.5 * sizes[2]
    };
    (far(&mut new.iter().filter(inner)), far(&mut new.iter()))
}

#[test]
fn a_sphere_is_interpolated_with_fourth_order_on_regular_parts() {
    let ((inner, all), (finer_inner, finer_all)) = (distances(6), distances(12));
    assert!(inner / finer_inner > 12.0, "order {} on regular parts", (inner / finer_inner).log2());
    assert!(all / finer_all > 3.0, "order {} over all", (all / finer_all).log2());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn random_selections_on_a_ball_keep_it_sound_and_its_vertices_in_place(
        seeds in proptest::collection::vec(any::<u64>(), 3), share in 1_u64..9,
    ) {
        let (mut mesh, mut history) = (ball(4), History::default());
        let ball = 4.0 / 3.0 * std::f64::consts::PI;
        for seed in seeds {
            let selected = random_selection(mesh.tets().len(), seed, share);
            let refined = subdiv::refine(&mesh, &history, &selected, &INTERPOLATING).unwrap();
            prop_assert!(refined.info.worst_sine > 0.0);
            let (before, after) = ((mesh.volume() - ball).abs(), (refined.mesh.volume() - ball).abs());
            prop_assert!(after < before + 0.01 * ball, "{} from the ball, before {}", after, before);
            for v in mesh.faces().iter().flat_map(|f| f.vertices) {
                prop_assert_eq!(mesh.points()[v as usize], refined.mesh.points()[v as usize]);
            }
            (mesh, history) = (refined.mesh, refined.history);
        }
    }
}

/// Beyond a crease there is nothing to interpolate; what replaces it must still be far better than flat faces.
#[test]
fn a_round_bar_is_rounded_up_to_its_rims() {
    let mut parts = generate::box_tets([2.0, 2.0, 1.0], [8, 8, 4]).unwrap().into_parts();
    (parts.groups, parts.patches) = (Vec::new(), vec![Vec::new()]);
    parts.faces.iter_mut().for_each(|f| f.patch.0 = 0);
    let bar = moved(TetMesh::new(parts).unwrap(), |p| {
        let q = (p.truncate() - 1.0).to_array().map(|x| (x * std::f64::consts::FRAC_PI_4).tan());
        let (q, radius) = (glam::DVec2::from(q), q[0].abs().max(q[1].abs()));
        (if radius > 0.0 { q.normalize() * radius } else { q }).extend(p.z)
    });
    let mesh = features::with_creases(bar, 40.0, &[]);
    let on_side = |v: &u32| (mesh.points()[*v as usize].truncate().length() - 1.0).abs() < 1e-12;
    let side = mesh.faces().iter().filter(|f| f.vertices.iter().all(on_side));
    let flat = |f: &subsolid::mesh::Face| {
        1.0 - f.vertices.iter().map(|&v| mesh.points()[v as usize].truncate()).sum::<glam::DVec2>().length() / 3.0
    };
    let flat = side.map(flat).fold(0.0, f64::max);
    let refined = refine_all(&mesh, &INTERPOLATING);
    let new = new_boundary_vertices(&refined.mesh, mesh.points().len());
    let round = new.iter().filter(|p| p.z > 1e-12 && p.z < 1.0 - 1e-12).map(|p| (p.truncate().length() - 1.0).abs());
    let (count, far) = round.fold((0, 0.0), |(n, far), d| (n + 1, f64::max(far, d)));
    assert_eq!(count, 2 * 4 * 8 * 4);
    assert!(far < 0.2 * flat, "{far} against {flat}");
}

#[test]
fn the_number_of_threads_does_not_show() {
    let run = |threads: usize, options: Options| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mesh = ball(5);
            let selected = random_selection(mesh.tets().len(), 5, 6);
            let first = refine(&mesh, &selected, &options);
            let all = vec![true; first.mesh.tets().len()];
            subdiv::refine(&first.mesh, &first.history, &all, &options).unwrap()
        })
    };
    for options in [BISECTION, INTERPOLATING] {
        let one = run(1, options);
        for threads in [2, 8] {
            let many = run(threads, options);
            assert_eq!((one.mesh.points(), one.mesh.tets()), (many.mesh.points(), many.mesh.tets()));
            assert_eq!((one.mesh.faces(), one.mesh.creases()), (many.mesh.faces(), many.mesh.creases()));
            assert_eq!((&one.history, one.info), (&many.history, many.info));
        }
    }
}

/// The papers' own mesh, uniform and with an interpolated surface.
#[test]
fn the_tripod_is_interpolated_without_spoiling_its_cells() {
    let Some(folder) = std::env::var_os("SUBSOLID_DATA") else {
        eprintln!("skipped: SUBSOLID_DATA is not set, so there is no tripod to refine");
        return;
    };
    let input = read::read(&std::path::Path::new(&folder).join("tripod.GiD.msh")).unwrap().mesh;
    let (mut mesh, mut history) = (features::with_creases(input, 70.0, &[]), History::default());
    let volume = mesh.volume();
    for _ in 0..2 {
        let all = vec![true; mesh.tets().len()];
        let refined = subdiv::refine(&mesh, &history, &all, &INTERPOLATING).unwrap();
        let quality = quality::quality(&refined.mesh);
        eprintln!("{quality:?} {:?} volume {:+.5}", refined.info, refined.mesh.volume() / volume - 1.0);
        assert_same("lengths of the creases", &crease_lengths(&mesh), &crease_lengths(&refined.mesh));
        assert!(quality.inverted == 0 && quality.worst > 5.0, "{quality:?}");
        assert!((refined.mesh.volume() / volume - 1.0).abs() < 0.005, "the surface goes through the same vertices");
        (mesh, history) = (refined.mesh, refined.history);
    }
}

//! Sqrt(3) subdivision of several regions: interfaces are refined as surfaces, from both sides at once, and never crossed;
//! creases inside a region stay edges.
//!
//! `TetMesh::new` itself checks after every step that all cells are positive and that the boundary faces are exactly the
//! boundary, so a step that returns has kept both.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use proptest::prelude::*;
use rustc_hash::FxHashMap;
use subsolid::mesh::surface::{self, SurfaceFace};
use subsolid::mesh::{TetMesh, features, generate, quality, topology};
use subsolid::subdiv::options::{Boundary, Mode, Optimise, Options, Scheme};
use subsolid::subdiv::{self, History, Refined, Weights};

const SMOOTH: [Boundary; 2] = [Boundary::Approximating, Boundary::Interpolating];
const BOUNDARIES: [Boundary; 3] = [Boundary::Fixed, Boundary::Approximating, Boundary::Interpolating];

fn options(boundary: Boundary, mode: Mode) -> Options {
    let optimise = Optimise { mode, ..Optimise::default() };
    Options { scheme: Scheme::Sqrt3, boundary, optimise, ..Options::default() }
}

/// A mesh with what the next step has to know.
#[derive(Clone)]
struct State(TetMesh, History);

impl State {
    fn new(mesh: &TetMesh) -> Self {
        Self(mesh.clone(), History::default())
    }

    fn refine(&mut self, selected: &[bool], options: &Options) -> subdiv::Info {
        let Refined { mesh, history, info, .. } = subdiv::refine(&self.0, &self.1, selected, options).unwrap();
        *self = Self(mesh, history);
        info
    }

    fn refine_all(&mut self, options: &Options) -> subdiv::Info {
        let all = vec![true; self.0.tets().len()];
        self.refine(&all, options)
    }

    /// Refines about `share` tenths of the cells.
    fn refine_some(&mut self, seed: u64, share: u64, options: &Options) -> subdiv::Info {
        let mut state = seed | 1;
        let mut next = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state % 10
        };
        let selected: Vec<bool> = self.0.tets().iter().map(|_| next() < share).collect();
        self.refine(&selected, options)
    }
}

/// A cube [0, 1]^3 of n blocks whose cells have the region that `region` says of their centroids; then its vertices are
/// moved.
fn cube(
    n: [usize; 3],
    names: &[&str],
    region: impl Fn(DVec3) -> u16,
    to: impl Fn(DVec3) -> DVec3,
    angle: f64,
) -> TetMesh {
    let mut parts = generate::box_tets([1.0; 3], n).unwrap().into_parts();
    parts.region_names = names.iter().map(|name| (*name).to_owned()).collect();
    for (t, tet) in parts.tets.iter().enumerate() {
        parts.regions[t].0 = region(tet.iter().map(|&v| parts.points[v as usize]).sum::<DVec3>() / 4.0);
    }
    parts.points.iter_mut().for_each(|p| *p = to(*p));
    features::with_creases(TetMesh::new(parts).unwrap(), angle, &[])
}

/// Height of a smooth hill in the middle of the unit square: no stencil that reaches the rim sees it.
fn hill(y: f64, z: f64) -> f64 {
    let squared = ((y - 0.5).powi(2) + (z - 0.5).powi(2)) / 0.4_f64.powi(2);
    0.15 * (1.0 - squared).max(0.0).powi(4)
}

/// A wave that cuts the sides of the cube in curves.
fn wavy(y: f64, z: f64) -> f64 {
    0.08 * ((5.0 * y + 1.0).sin() + (4.0 * z + y).cos())
}

/// Two materials that meet where x is 0.5 + `height` of y and z.
fn two_materials(n: [usize; 3], height: impl Fn(f64, f64) -> f64) -> TetMesh {
    let lift = |p: DVec3| p + DVec3::X * (1.0 - (2.0 * p.x - 1.0).abs()) * height(p.y, p.z);
    cube(n, &["left", "right"], |p| u16::from(p.x > 0.5), lift, 60.0)
}

/// A matrix with a ball of radius 1/4 in it. Equal angles instead of equal lengths along the sides of the inner cube.
fn inclusion(n: usize) -> TetMesh {
    let size = |p: DVec3| (p - 0.5).abs().max_element();
    let round = |p: DVec3| {
        let (q, r) = (p - 0.5, size(p));
        if r == 0.0 {
            return p;
        }
        let angles = DVec3::from((q / r).to_array().map(|x| (x * std::f64::consts::FRAC_PI_4).tan()));
        let ball = r * angles.normalize();
        let share = ((r - 0.25) / 0.25).max(0.0);
        0.5 + ball.lerp(q, share)
    };
    cube([n; 3], &["ball", "matrix"], |p| u16::from(size(p) > 0.25), round, 60.0)
}

fn interfaces(mesh: &TetMesh) -> Vec<SurfaceFace> {
    surface::interfaces(mesh)
}

fn vertices(faces: &[SurfaceFace]) -> Vec<u32> {
    let mut vertices: Vec<u32> = faces.iter().flat_map(|f| f.vertices).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

fn area(mesh: &TetMesh, faces: &[SurfaceFace]) -> f64 {
    faces.iter().map(|f| 0.5 * features::face_normal(mesh.points(), f.vertices).length()).sum()
}

fn region_volumes(mesh: &TetMesh) -> Vec<f64> {
    let mut volumes = vec![0.0; mesh.region_names().len()];
    (0..mesh.tets().len()).for_each(|t| volumes[mesh.regions()[t].0 as usize] += mesh.cell_volume(t));
    volumes
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

fn assert_creases_are_edges(mesh: &TetMesh) {
    let edges = topology::edges(mesh.tets());
    assert!(mesh.creases().iter().all(|c| edges.binary_search(&c.vertices).is_ok()), "a crease is no edge any more");
}

/// The interface of two regions hangs together and is a 2-manifold whose rim lies on the boundary, each region hangs
/// together, and the faces around a region enclose its volume.
fn assert_interface(mesh: &TetMesh, closed: bool) {
    let faces = interfaces(mesh);
    let edges = surface::surface_edges(&faces);
    let boundary = features::boundary_edges(mesh.faces());
    for (edge, at) in &edges {
        let rim = boundary.binary_search_by_key(edge, |(key, _)| *key).is_ok();
        assert_eq!(at.len(), if rim { 1 } else { 2 }, "faces at interface edge {edge:?}, on the boundary: {rim}");
        assert!(!rim || mesh.creases().binary_search_by_key(edge, |c| c.vertices).is_ok(), "{edge:?} is no crease");
    }
    let mut part: Vec<usize> = (0..faces.len()).collect();
    fn root(part: &[usize], mut f: usize) -> usize {
        while part[f] != f {
            f = part[f];
        }
        f
    }
    for (_, at) in edges.iter().filter(|(_, at)| at.len() == 2) {
        let [a, b] = [root(&part, at[0]), root(&part, at[1])];
        part[a.max(b)] = a.min(b);
    }
    assert_eq!((0..part.len()).filter(|&f| part[f] == f).count(), 1, "parts of the interface");
    // With pinched vertices there were fewer of them.
    let euler = vertices(&faces).len() + faces.len() - edges.len();
    assert_eq!(euler, if closed { 2 } else { 1 }, "Euler characteristic of the interface");

    let volumes = region_volumes(mesh);
    for region in [0_u16, 1] {
        let cells: Vec<[u32; 4]> =
            (0..mesh.tets().len()).filter(|&t| mesh.regions()[t].0 == region).map(|t| mesh.tets()[t]).collect();
        assert_eq!(topology::parts(&cells).1, 1, "parts of region {region}");
        let enclosed: f64 = surface::surface_faces(mesh)
            .iter()
            .filter_map(|f| {
                let [a, b, c] = f.vertices.map(|v| mesh.points()[v as usize]);
                let inside = mesh.regions()[f.inner as usize].0 == region;
                let outside = f.outer.is_some_and(|t| mesh.regions()[t as usize].0 == region);
                (inside || outside).then(|| a.cross(b).dot(c) / 6.0 * if inside { 1.0 } else { -1.0 })
            })
            .sum();
        assert!((enclosed - volumes[usize::from(region)]).abs() < 1e-12, "{enclosed} {volumes:?}");
    }
}

#[test]
fn an_interface_is_refined_as_a_sqrt3_surface() {
    for (start, closed) in [(two_materials([4; 3], wavy), false), (inclusion(8), true)] {
        let first = interfaces(&start);
        for boundary in SMOOTH {
            let mut state = State::new(&start);
            for step in 1..=2 {
                state.refine_all(&options(boundary, Mode::Paper));
                assert_interface(&state.0, closed);
                assert_creases_are_edges(&state.0);
                let faces = interfaces(&state.0);
                assert_eq!(faces.len(), first.len() * 3_usize.pow(step), "1-3 splits; creases wait, then make three");
                assert_same("creases", &crease_lengths(&start), &crease_lengths(&state.0));
                for v in start.creases().iter().flat_map(|c| c.vertices) {
                    assert_eq!(start.points()[v as usize], state.0.points()[v as usize], "rims stay");
                }
                assert!((state.0.volume() - 1.0).abs() < 1e-12, "the cube itself is flat");
            }
            let ratio = area(&state.0, &interfaces(&state.0)) / area(&start, &first);
            assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
        }
    }
}

/// The old edges of an interface are gone after a uniform step, but for creases; on a closed one a centre then has six
/// neighbours, an old vertex as many as before.
#[test]
fn old_interface_edges_are_flipped() {
    let valences = |faces: &[SurfaceFace]| {
        let mut valences: FxHashMap<u32, usize> = FxHashMap::default();
        faces.iter().flat_map(|f| f.vertices).for_each(|v| *valences.entry(v).or_default() += 1);
        valences
    };
    for boundary in SMOOTH {
        for (start, closed, steps) in [(inclusion(8), true, 1), (two_materials([4; 3], hill), false, 2)] {
            let mut state = State::new(&start);
            for _ in 0..steps {
                let before = state.0.clone();
                state.refine_all(&options(boundary, Mode::Paper));
                let [old, new] = [&before, &state.0].map(interfaces);
                let edges = surface::surface_edges(&new);
                let is_kept = |e: &[u32; 2]| edges.binary_search_by_key(e, |(key, _)| *key).is_ok();
                let is_crease = |e: &[u32; 2]| before.creases().binary_search_by_key(e, |c| c.vertices).is_ok();
                assert!(surface::surface_edges(&old).iter().all(|(e, _)| is_crease(e) || !is_kept(e)), "{boundary:?}");
                let before = valences(&old);
                for (v, n) in valences(&new).into_iter().filter(|_| closed) {
                    assert_eq!(n, before.get(&v).copied().unwrap_or(6), "valence of vertex {v}");
                }
            }
        }
    }
}

#[test]
fn the_interface_of_a_ball_follows_the_rule_of_kobbelt() {
    let start = inclusion(8);
    let mut around: FxHashMap<u32, Vec<DVec3>> = FxHashMap::default();
    for ([a, b], _) in surface::surface_edges(&interfaces(&start)) {
        around.entry(a).or_default().push(start.points()[b as usize]);
        around.entry(b).or_default().push(start.points()[a as usize]);
    }
    let mut state = State::new(&start);
    let info = state.refine_all(&options(Boundary::Approximating, Mode::Paper));
    assert_eq!(info.rejected, 0);
    for (&v, ring) in &around {
        let n = ring.len() as f64;
        let beta = (4.0 - 2.0 * (2.0 * std::f64::consts::PI / n).cos()) / 9.0;
        let expected = start.points()[v as usize] * (1.0 - beta) + ring.iter().copied().sum::<DVec3>() * (beta / n);
        assert!((state.0.points()[v as usize] - expected).length() < 1e-14);
    }
}

/// An interpolated interface keeps its vertices, whatever optimises the cells, and stays near the sphere.
#[test]
fn an_interpolated_interface_goes_through_its_vertices() {
    let start = inclusion(8);
    let sphere = |mesh: &TetMesh, v: u32| (mesh.points()[v as usize].distance(DVec3::splat(0.5)) - 0.25).abs();
    assert!(vertices(&interfaces(&start)).iter().all(|&v| sphere(&start, v) < 1e-15));
    let centre = |f: &SurfaceFace| f.vertices.iter().map(|&v| start.points()[v as usize]).sum::<DVec3>() / 3.0;
    let depth = |f: &SurfaceFace| 0.25 - centre(f).distance(DVec3::splat(0.5));
    let depth = interfaces(&start).iter().map(depth).fold(0.0, f64::max);
    let flat = area(&start, &interfaces(&start));
    let round = std::f64::consts::PI / 4.0;
    for mode in [Mode::Paper, Mode::Best] {
        let mut state = State::new(&start);
        for _ in 0..2 {
            let before = state.0.clone();
            state.refine_all(&options(Boundary::Interpolating, mode));
            for v in vertices(&interfaces(&before)) {
                assert_eq!(before.points()[v as usize], state.0.points()[v as usize], "{mode:?}");
            }
            assert_interface(&state.0, true);
        }
        let faces = interfaces(&state.0);
        let far = vertices(&faces).into_iter().map(|v| sphere(&state.0, v)).fold(0.0, f64::max);
        assert!(far < 0.4 * depth, "{mode:?}: {far} from the sphere, the faces were {depth}");
        let left = (area(&state.0, &faces) - round).abs() / (flat - round).abs();
        assert!(left < 0.3, "{mode:?}: {left} of the error of the area is left");
    }
}

#[test]
fn area_and_normals_of_an_interpolated_interface_converge() {
    // The area of the hill, by the midpoint rule with the exact slopes.
    let slope = |y: f64, z: f64| {
        let h = 1e-6;
        let d = |f: &dyn Fn(f64) -> f64, x: f64| (f(x + h) - f(x - h)) / (2.0 * h);
        [d(&|s| hill(s, z), y), d(&|s| hill(y, s), z)]
    };
    let samples = 400;
    let at = |i: usize| (i as f64 + 0.5) / samples as f64;
    let exact: f64 = (0..samples * samples)
        .map(|k| {
            let [a, b] = slope(at(k % samples), at(k / samples));
            (1.0 + a * a + b * b).sqrt() / (samples * samples) as f64
        })
        .sum();
    let errors = |mesh: &TetMesh| {
        let faces = interfaces(mesh);
        let turn = |f: &SurfaceFace| {
            let n = features::face_normal(mesh.points(), f.vertices).normalize();
            let c = f.vertices.iter().map(|&v| mesh.points()[v as usize]).sum::<DVec3>() / 3.0;
            let [a, b] = slope(c.y, c.z);
            let size = 0.5 * features::face_normal(mesh.points(), f.vertices).length();
            size * n.cross(DVec3::new(1.0, -a, -b).normalize()).length_squared()
        };
        let normals = faces.iter().map(turn).sum::<f64>().sqrt();
        ((area(mesh, &faces) - exact).abs(), normals)
    };
    let [coarse, fine] = [8, 12].map(|n| {
        let mut state = State::new(&two_materials([4, n, n], hill));
        let before = errors(&state.0);
        for _ in 0..2 {
            state.refine_all(&options(Boundary::Interpolating, Mode::Paper));
        }
        (before, errors(&state.0))
    });
    let (before, after) = fine;
    assert!(after.0 < 0.7 * before.0 && after.1 < 0.5 * before.1, "area and normals: {before:?}, then {after:?}");
    // Of second and first order at least.
    let order = [coarse.1.0 / after.0, coarse.1.1 / after.1].map(|ratio| ratio.ln() / 1.5_f64.ln());
    assert!(order[0] > 2.0 && order[1] > 1.0, "orders of area and normals {order:?}");
}

#[test]
fn the_interpolating_rule_is_of_high_order_on_an_interface() {
    let error = |n: usize| {
        let start = two_materials([4, n, n], hill);
        let mut state = State::new(&start);
        let info = state.refine_all(&options(Boundary::Interpolating, Mode::Paper));
        assert_eq!(info.rejected, 0);
        let points = vertices(&interfaces(&state.0)).into_iter().map(|v| state.0.points()[v as usize]);
        points.map(|p| (p.x - 0.5 - hill(p.y, p.z)).abs()).fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(8), error(16));
    assert!(coarse / fine > 8.0, "order {}", (coarse / fine).log2());
}

/// In-plane jitter of everything inside, so that nothing is symmetric.
fn jitter(p: DVec3, plane: bool) -> DVec3 {
    let inside = p.min_element() > 1e-9 && p.max_element() < 1.0 - 1e-9;
    let wave = DVec3::new((37.0 * p.y + 3.0).sin(), (41.0 * p.z).cos(), (43.0 * p.x + 29.0 * p.y + 1.0).sin());
    let wave = if plane { DVec3 { x: 0.0, ..wave } } else { wave };
    if inside { p + 0.03 * wave } else { p }
}

#[test]
fn a_flat_interface_stays_flat_and_regions_keep_their_volumes() {
    let flat = |p: DVec3| jitter(p, (p.x - 0.5).abs() < 1e-9);
    let start = cube([2, 3, 3], &["left", "right"], |p| u16::from(p.x > 0.5), flat, 40.0);
    for boundary in BOUNDARIES {
        for mode in [Mode::Paper, Mode::Best] {
            for adaptive in [false, true] {
                let mut state = State::new(&start);
                for step in 0..if adaptive { 3 } else { 2 } {
                    if adaptive {
                        state.refine_some(91 + step, 3, &options(boundary, mode));
                    } else {
                        state.refine_all(&options(boundary, mode));
                    }
                    assert_interface(&state.0, false);
                    assert_creases_are_edges(&state.0);
                    assert_same("regions", &[0.5, 0.5], &region_volumes(&state.0));
                    assert_same("creases", &crease_lengths(&start), &crease_lengths(&state.0));
                    for v in vertices(&interfaces(&state.0)) {
                        let x = state.0.points()[v as usize].x;
                        assert!((x - 0.5).abs() < 1e-12, "{boundary:?} {mode:?}: vertex {v} at x = {x}");
                    }
                }
            }
        }
    }
}

/// Sharp edges and corners of an interface are features; where three regions meet there is a crease that is none.
#[test]
fn sharp_interfaces_and_junctions_of_regions_stay() {
    let block = |p: DVec3| u16::from((p - 0.5).abs().max_element() > 0.25);
    let start = cube([4; 3], &["block", "matrix"], block, |p| p, 40.0);
    let edges = 12.0 + 12.0 * 0.5;
    assert_same("features", &[edges, 0.0], &crease_lengths(&start));
    let junction = |p: DVec3| if p.x < 0.5 { 0 } else { 1 + u16::from(p.y > 0.5) };
    let three = cube([4; 3], &["a", "b", "c"], junction, |p| p, 40.0);
    // The cube's edges; the rim of the wall at x = 0.5, that of the half wall at y = 0.5, with the line where they meet.
    assert_same("features and borders", &[12.0, 4.0 + 3.0], &crease_lengths(&three));
    for (start, steps) in [(start, 4), (three, 4)] {
        for boundary in SMOOTH {
            let mut state = State::new(&start);
            for step in 0..steps {
                if step < 2 {
                    state.refine_all(&options(boundary, Mode::Paper));
                } else {
                    state.refine_some(17 + step, 2, &options(boundary, Mode::Paper));
                }
                assert_creases_are_edges(&state.0);
                assert_same("creases", &crease_lengths(&start), &crease_lengths(&state.0));
                assert_same("regions", &region_volumes(&start), &region_volumes(&state.0));
                let walls = [&start, &state.0].map(|m| area(m, &interfaces(m)));
                assert_same("area of the interfaces", &walls[..1], &walls[1..]);
                if step == 1 {
                    assert_eq!(interfaces(&state.0).len(), 9 * interfaces(&start).len());
                    assert_eq!(state.0.creases().len(), 3 * start.creases().len());
                }
            }
        }
    }
}

/// A crease inside one region is an edge for ever: it waits in an odd step and is trisected in an even one, or halved
/// where surfaces are.
#[test]
fn a_crease_inside_a_region_is_kept_and_refined() {
    let region = |_: DVec3| 0;
    let plain = cube([4; 3], &["solid"], region, |p| p, 40.0);
    let number = |x: [f64; 3]| plain.points().iter().position(|p| p.distance(DVec3::from(x)) < 1e-9).unwrap() as u32;
    // From the boundary into the solid, with a bend.
    let path = [[0.5, 0.5, 0.0], [0.5, 0.5, 0.25], [0.5, 0.5, 0.5], [0.75, 0.5, 0.5]].map(number);
    let edges: Vec<[u32; 2]> = path.windows(2).map(|w| [w[0], w[1]]).collect();
    let start = features::with_creases(cube([4; 3], &["solid"], region, |p| jitter(p, false), 40.0), 40.0, &edges);
    assert_eq!(start.creases().len(), plain.creases().len() + 3);
    for boundary in BOUNDARIES {
        for mode in [Mode::Paper, Mode::Best] {
            for adaptive in [false, true] {
                let mut state = State::new(&start);
                for step in 0..if adaptive { 4 } else { 2 } {
                    let at_path = |tet: &[u32; 4]| tet.iter().any(|v| path.contains(v));
                    if adaptive {
                        let selected: Vec<bool> = state.0.tets().iter().map(at_path).collect();
                        state.refine(&selected, &options(boundary, mode));
                        state.refine_some(5 + step, 1, &options(boundary, mode));
                    } else {
                        state.refine_all(&options(boundary, mode));
                        let factor = if boundary == Boundary::Fixed { [2, 4] } else { [1, 3] }[step as usize];
                        assert_eq!(state.0.creases().len(), factor * start.creases().len(), "{boundary:?} {step}");
                    }
                    assert_creases_are_edges(&state.0);
                    assert_same("features", &crease_lengths(&start), &crease_lengths(&state.0));
                    for v in path {
                        assert_eq!(start.points()[v as usize], state.0.points()[v as usize]);
                    }
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn random_selections_never_cross_a_curved_interface(
        seeds in proptest::collection::vec(any::<u64>(), 3),
        share in 1_u64..4,
        boundary in prop::sample::select(BOUNDARIES.to_vec()),
        best in any::<bool>(),
        closed in any::<bool>(),
    ) {
        let start = if closed { inclusion(4) } else { two_materials([4; 3], wavy) };
        let mode = if best { Mode::Best } else { Mode::Paper };
        let mut state = State::new(&start);
        let before = region_volumes(&start);
        for seed in seeds {
            let old = state.0.clone();
            let info = state.refine_some(seed, share, &options(boundary, mode));
            prop_assert!(info.worst_sine > 0.0);
            assert_interface(&state.0, closed);
            assert_creases_are_edges(&state.0);
            assert_same("creases", &crease_lengths(&start), &crease_lengths(&state.0));
            let after = region_volumes(&state.0);
            assert_same("volume", &[1.0], &[after.iter().sum()]);
            match boundary {
                Boundary::Fixed => assert_same("regions", &before, &after),
                Boundary::Approximating => {}
                Boundary::Interpolating if best => {}
                Boundary::Interpolating => {
                    for v in vertices(&interfaces(&old)) {
                        prop_assert_eq!(old.points()[v as usize], state.0.points()[v as usize]);
                    }
                }
            }
            prop_assert!(before.iter().zip(&after).all(|(a, b)| (a - b).abs() < 0.05), "{:?} {:?}", before, after);
        }
    }
}

/// A selection on one side refines the interface from both: its faces are split, its old edges flipped.
#[test]
fn cells_across_a_selected_interface_are_refined_with_it() {
    let start = inclusion(8);
    for boundary in SMOOTH {
        let mut state = State::new(&start);
        let ball: Vec<bool> = start.regions().iter().map(|r| r.0 == 0).collect();
        state.refine(&ball, &options(boundary, Mode::Paper));
        let [old, new] = [&start, &state.0].map(interfaces);
        assert_eq!(new.len(), 3 * old.len());
        let edges = surface::surface_edges(&new);
        let left = |(e, _): &([u32; 2], Vec<usize>)| edges.binary_search_by_key(e, |(key, _)| *key).is_ok();
        assert!(!surface::surface_edges(&old).iter().any(left));
        for f in &new {
            assert!(f.cells().all(|t| state.0.levels()[t as usize] == 1), "both sides of {f:?}");
        }
        assert_interface(&state.0, true);
    }
}

/// No optimiser moves a vertex off a curved interface or changes its triangles, and all keep creases inside.
#[test]
fn optimisers_keep_curved_interfaces() {
    let mut state = State::new(&inclusion(4));
    state.refine_all(&options(Boundary::Interpolating, Mode::Paper));
    let mesh = &state.0;
    let weights = Weights::Factors(mesh.points().iter().map(|p| 1.0 + 20.0 * p.x).collect());
    let by_error = subdiv::optimise_error(mesh, &weights, 3, mesh.points().len()).unwrap().mesh;
    assert_ne!(by_error.points(), mesh.points(), "nothing was optimised");
    let faces = |mesh: &TetMesh| {
        let mut faces: Vec<[u32; 3]> = interfaces(mesh).iter().map(|f| topology::sorted3(f.vertices)).collect();
        faces.sort_unstable();
        faces
    };
    assert_eq!(faces(&by_error), faces(mesh));
    let by_quality = subdiv::optimise_quality(mesh, &Optimise { mode: Mode::Best, ..Optimise::default() }).unwrap();
    for better in [by_error, by_quality] {
        for v in vertices(&interfaces(mesh)) {
            assert_eq!(better.points()[v as usize], mesh.points()[v as usize]);
        }
        assert_interface(&better, true);
        assert_creases_are_edges(&better);
        assert_same("regions", &region_volumes(mesh), &region_volumes(&better));
    }
}

/// Refining at one vertex again and again, where the interface is curved and where it meets the boundary.
#[test]
fn refining_one_vertex_of_an_interface_again_and_again_keeps_good_angles() {
    let start = two_materials([4; 3], wavy);
    let on_wall = |v: &u32| (1e-9..1.0 - 1e-9).contains(&start.points()[*v as usize].z);
    let wall = vertices(&interfaces(&start));
    let inside = *wall.iter().find(|v| on_wall(v) && (0.4..0.6).contains(&start.points()[**v as usize].y)).unwrap();
    let rim = *wall.iter().find(|v| on_wall(v) && start.points()[**v as usize].y < 1e-9).unwrap();
    for boundary in SMOOTH {
        for vertex in [inside, rim] {
            let mut state = State::new(&start);
            let least = if boundary == Boundary::Approximating { 17.0 } else { 8.0 };
            for _ in 0..10 {
                let at: Vec<bool> = state.0.tets().iter().map(|t| t.contains(&vertex)).collect();
                state.refine(&at, &options(boundary, Mode::Best));
                let worst = quality::quality(&state.0).worst;
                assert!(worst > least, "{boundary:?}: {worst} degrees at vertex {vertex}");
                assert_interface(&state.0, false);
            }
            if vertex == rim {
                assert_eq!(start.points()[rim as usize], state.0.points()[rim as usize]);
            }
        }
    }
}

#[test]
fn the_number_of_threads_does_not_show_with_several_regions() {
    let run = |threads: usize, mode: Mode| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut state = State::new(&inclusion(4));
            state.refine_some(3, 5, &options(Boundary::Interpolating, mode));
            state.refine_all(&options(Boundary::Approximating, mode));
            state
        })
    };
    for mode in [Mode::Paper, Mode::Best] {
        let one = run(1, mode);
        for threads in [2, 8] {
            let many = run(threads, mode);
            assert_eq!(
                (one.0.points(), one.0.tets(), one.0.creases()),
                (many.0.points(), many.0.tets(), many.0.creases())
            );
            assert_eq!(one.1, many.1);
        }
    }
}

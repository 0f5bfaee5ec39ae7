//! Edge contraction: a vertex that is not worth its price is pulled into a neighbour. Those in a flat part of the surface are
//! pulled along it, those on a straight crease along that, so that the solid stays as it is.

use super::super::freedom::Freedom;
use super::super::parallel::{select, vertices_of};
use super::super::rest_of;
use super::mean;
use super::weight::Weight;
use super::weighted::Fan;
use crate::mesh::Face;
use crate::subdiv::solid::Solid;
use smallvec::SmallVec;

/// Vertices whose cells cost more than this many prices are not looked at: that is what the cells of a vertex cost in the
/// mean, and where they cost more a vertex is hardly ever worth less than its price.
const DEAR: f64 = 6.0;

/// Neighbours into which a vertex may be pulled, the nearest: others are hardly ever better.
const NEAREST: usize = 4;

/// Removes vertices with numbers from `first` on where that raises the weighted cost by less than `price`, and leaves no
/// cell below both `floor` and the worst of those that go; returns how many went.
pub(super) fn contract<W: Weight>(
    solid: &mut Solid,
    weights: &[W],
    freedoms: &[Freedom],
    (since, first): (u32, u32),
    (price, floor): (f64, f64),
) -> usize {
    let mut vertices = vertices_of(solid, solid.cells_since(since));
    vertices.retain(|&v| v >= first && freedoms[v as usize] != Freedom::Fixed);
    let target = |fan: &mut Fan<W>, solid: &Solid, v: u32| {
        cheapest(fan, solid, weights, (v, freedoms[v as usize]), (price, floor))
    };
    let mut fan = Fan::default();
    let mut gone = 0;
    for v in select(vertices, |fan, &v| target(fan, solid, v).is_some()) {
        if let Some(b) = target(&mut fan, solid, v) {
            pull(solid, v, b);
            gone += 1;
        }
    }
    gone
}

/// The neighbour into which `v` is best pulled, if the weighted cost rises by less than the price.
///
/// The cells around v fill a polyhedron; those that come fill it too if they are all positive, so the mesh stays
/// conforming. That holds at the surface too, where the neighbour lies in all planes of the faces around v.
fn cheapest<W: Weight>(
    fan: &mut Fan<W>,
    solid: &Solid,
    weights: &[W],
    (v, freedom): (u32, Freedom),
    (price, floor): (f64, f64),
) -> Option<u32> {
    gather(fan, solid, weights, v, v);
    let now = fan.cost_and_sine(solid.point(v)).0;
    if now > DEAR * price {
        return None;
    }
    let floor = floor.min(solid.worst_sine(solid.cells_at(v)));
    let mut least = (now + price, None);
    for b in nearest(solid, v, freedom) {
        gather(fan, solid, weights, v, b);
        let (cost, sine) = fan.cost_and_sine(solid.point(b));
        if cost < least.0 && sine >= floor {
            least = (cost, Some(b));
        }
    }
    least.1
}

/// The nearest neighbours of `v` into which it may be pulled without changing the solid.
fn nearest(solid: &Solid, v: u32, freedom: Freedom) -> SmallVec<[u32; 64]> {
    let mut around: SmallVec<[u32; 64]> =
        solid.cells_at(v).iter().flat_map(|&t| solid.tet(t)).filter(|&w| w != v).collect();
    around.sort_unstable();
    around.dedup();
    match freedom {
        Freedom::Space => {}
        Freedom::Plane(_) => around.retain(|w| solid.is_surface_edge([v, *w])),
        Freedom::Line(_) => around.retain(|w| solid.is_crease([v, *w])),
        Freedom::Fixed => around.clear(),
    }
    let distance = |w: &u32| solid.point(*w).distance_squared(solid.point(v));
    around.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    around.truncate(NEAREST);
    around
}

/// Collects the cells at `v`, except those at `b` too, with the weights that they have once `v` is pulled into `b`.
fn gather<W: Weight>(fan: &mut Fan<W>, solid: &Solid, weights: &[W], v: u32, b: u32) {
    fan.clear();
    for &t in solid.cells_at(v) {
        let tet = solid.tet(t);
        if b == v || !tet.contains(&b) {
            let new = tet.map(|w| if w == v { b } else { w });
            fan.push(rest_of(tet, v).map(|w| solid.point(w)), mean(weights, new));
        }
    }
}

/// Replaces `v` by `b` in all its cells, faces and creases; those that hold both vanish.
fn pull(solid: &mut Solid, v: u32, b: u32) {
    solid.pull_creases(v, b);
    for t in solid.cells_at(v).to_vec() {
        let (tet, tag) = solid.remove_cell(t);
        if !tet.contains(&b) {
            solid.add_cell(tet.map(|w| if w == v { b } else { w }), tag);
        }
    }
    for face in solid.faces_at(v).copied().collect::<SmallVec<[Face; 16]>>() {
        solid.remove_face(face.vertices);
        if !face.vertices.contains(&b) {
            solid.add_face(Face { vertices: face.vertices.map(|w| if w == v { b } else { w }), ..face });
        }
    }
}

//! Boundary bubbles: what the natural end condition of the boundary's rules takes from the space, given back.
//!
//! At a boundary the masks amount to a phantom control point c0 = 2 c1 - c2, so second normal derivatives vanish there, and the
//! error of smooth problems falls with order 1.5 in energy only. The phantom's own spline b0 = (1 - t)^3 / 6 is added as an
//! unknown: on the first layer of cells at a sheet S of the boundary, at the distance t from it,
//!
//!   G_v^S = b0(t) N_v(foot),   psi_v^S = G_v^S - N_v / 6,
//!
//! where the foot is the place below on the sheet and N_v a vertex's function. The bubble psi vanishes on S, so prescribed
//! displacements are untouched; on boxes the space becomes that of all cubic splines. Where two or three sheets meet at an edge of
//! a single cell, products belong to it: psi^(ST) = G^(ST) - (G^S + G^T) / 6 + N / 36 with G^(ST) = b0(s) b0(t) N_v(foot on both).

use super::Table;
use super::ring::Ring;
use super::spline;
use crate::mesh::hex::NONE;
use crate::subdiv::catmull_clark::Control;
use glam::DVec3;

/// A bubble of the boundary.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bubble {
    /// Its vertex.
    pub vertex: u32,
    /// The sheets on which it vanishes, ascending: one on smooth parts, more at creases between them.
    pub sheets: Vec<u32>,
}

/// A bubble seen from a cell.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct LocalBubble {
    /// The ring's vertex.
    vertex: u16,
    /// Number of sheets.
    order: u8,
    /// For each sheet that the cell lies at, the cell's faces there, as bits.
    faces: Vec<u8>,
}

/// The bubbles of a mesh.
pub(super) struct Enriched {
    pub bubbles: Vec<Bubble>,
    /// The sheet of each face of the mesh; [`NONE`] inside.
    pub sheets: Vec<u32>,
    /// Where the bubbles of each vertex begin, and their number.
    starts: Vec<u32>,
}

impl Enriched {
    pub fn new(control: &Control<'_>) -> Self {
        let sheets = sheets(control);
        let spoilt = spoilt(control);
        let (mut bubbles, mut starts) = (Vec::new(), vec![0]);
        for v in 0..control.corner.len() as u32 {
            if !spoilt[v as usize] {
                let of_vertex = combinations(control, &sheets, v);
                bubbles.extend(of_vertex.into_iter().map(|sheets| Bubble { vertex: v, sheets }));
            }
            starts.push(bubbles.len() as u32);
        }
        Self { bubbles, sheets, starts }
    }

    /// The bubbles that do not vanish on cell `t`, with their numbers.
    pub fn of_ring(&self, control: &Control<'_>, t: u32, ring: &Ring) -> Vec<(u32, LocalBubble)> {
        let own = control.topology.cell_faces()[t as usize].map(|f| self.sheets[f as usize]);
        let mut found = Vec::new();
        for (local, &v) in (0..).zip(&ring.vertices) {
            for number in self.starts[v as usize]..self.starts[v as usize + 1] {
                let sheets = &self.bubbles[number as usize].sheets;
                let bits = |s: &u32| (0..6).fold(0, |bits, f| bits | u8::from(own[f] == *s) << f);
                let faces = sheets.iter().map(bits).filter(|bits| *bits != 0).collect();
                found.push((number, LocalBubble { vertex: local, order: sheets.len() as u8, faces }));
            }
        }
        found
    }
}

/// The sheet of each face: boundary faces that hang together through edges of two cells.
fn sheets(control: &Control<'_>) -> Vec<u32> {
    let topology = control.topology;
    let mut sheets = vec![NONE; topology.faces().len()];
    let mut count = 0;
    for (first, _) in topology.boundary() {
        if sheets[first as usize] != NONE {
            continue;
        }
        sheets[first as usize] = count;
        let mut open = vec![first];
        while let Some(f) = open.pop() {
            let joints = topology.face_edges()[f as usize].into_iter().filter(|&e| topology.edge_cells(e).len() == 2);
            for next in joints.flat_map(|e| topology.boundary_faces_at(e)) {
                if sheets[next as usize] == NONE {
                    sheets[next as usize] = count;
                    open.push(next);
                }
            }
        }
        count += 1;
    }
    sheets
}

/// The vertices near concave edges, where the first layer of cells has gaps and bubbles would not be continuous.
fn spoilt(control: &Control<'_>) -> Vec<bool> {
    let topology = control.topology;
    let mut spoilt = vec![false; control.corner.len()];
    for (e, ends) in (0..).zip(topology.edges()) {
        if topology.edge_cells(e).len() > 2 && topology.boundary_faces_at(e).next().is_some() {
            for &t in ends.iter().flat_map(|&v| topology.vertex_cells(v)) {
                control.cells[t as usize].iter().for_each(|&v| spoilt[v as usize] = true);
            }
        }
    }
    spoilt
}

/// The sets of sheets that meet at a vertex in one cell, sorted.
fn combinations(control: &Control<'_>, sheets: &[u32], v: u32) -> Vec<Vec<u32>> {
    let topology = control.topology;
    let mut all = Vec::new();
    for &t in topology.vertex_cells(v) {
        let here = |f: &&u32| sheets[**f as usize] != NONE && topology.faces()[**f as usize].contains(&v);
        let mut own: Vec<u32> =
            topology.cell_faces()[t as usize].iter().filter(here).map(|&f| sheets[f as usize]).collect();
        own.sort_unstable();
        own.dedup();
        for chosen in 1..1_u32 << own.len() {
            all.push((0..own.len()).filter(|i| chosen >> i & 1 == 1).map(|i| own[i]).collect::<Vec<u32>>());
        }
    }
    all.sort_unstable_by(|a, b| (a.len(), a).cmp(&(b.len(), b)));
    all.dedup();
    all
}

/// A table with the columns of bubbles behind those of the vertices; `feet` makes tables of the vertices' functions.
pub(super) fn enriched_table(
    bubbles: &[LocalBubble],
    plain: &Table,
    points: &[DVec3],
    feet: impl Fn(&[DVec3]) -> Table,
) -> Table {
    let tables: Vec<(u8, Table)> = projections(bubbles)
        .map(|faces| (faces, feet(&points.iter().map(|p| foot(*p, faces)).collect::<Vec<_>>())))
        .collect();
    let functions = plain.functions + bubbles.len();
    let mut table = Table { functions, ..Table::default() };
    for (point, &at) in points.iter().enumerate() {
        table.values.extend(plain.values_at(point));
        table.gradients.extend(plain.gradients_at(point));
        for bubble in bubbles {
            let v = usize::from(bubble.vertex);
            let scale = (-1.0_f64 / 6.0).powi(i32::from(bubble.order));
            let (mut value, mut gradient) = (scale * plain.values_at(point)[v], scale * plain.gradients_at(point)[v]);
            for (faces, of_feet) in tables.iter().filter(|(faces, _)| bubble.takes(*faces)) {
                let scale = scale * (-6.0_f64).powi(faces.count_ones() as i32);
                let (n, dn) = (of_feet.values_at(point)[v], of_feet.gradients_at(point)[v]);
                let (g, dg) = lift(at, *faces, n, dn);
                value += scale * g;
                gradient += scale * dg;
            }
            table.values.push(value);
            table.gradients.push(gradient);
        }
    }
    table
}

/// The functions of a cell as others of the same span that do not depend on each other: those of vertices, and of each bubble whose
/// sheets the cell all lies at the product G without its correction, `sum psi^A / 6^(|B| - |A|)` over the subsets A of its sheets B,
/// which vanishes on cells beside. Each as a combination of the cell's functions; `None` where it vanishes.
pub(super) fn lifted(bubbles: &[LocalBubble], vertices: usize) -> Vec<Option<Vec<(usize, f64)>>> {
    let of_vertex = |v: usize| Some(vec![(v, 1.0)]);
    let of_bubble = |bubble: &LocalBubble| {
        if bubble.faces.len() < usize::from(bubble.order) {
            return None;
        }
        let parts = bubbles.iter().enumerate().filter(|(_, part)| {
            part.vertex == bubble.vertex
                && part.faces.len() == usize::from(part.order)
                && part.faces.iter().all(|sheet| bubble.faces.contains(sheet))
        });
        let scale = |order: u8| 6.0_f64.powi(i32::from(order) - i32::from(bubble.order));
        let own = parts.map(|(place, part)| (vertices + place, scale(part.order)));
        Some(own.chain([(usize::from(bubble.vertex), scale(0))]).collect())
    };
    (0..vertices).map(of_vertex).chain(bubbles.iter().map(of_bubble)).collect()
}

/// The coefficients of vertices and bubbles of a function given by those of vertices and products G (see [`lifted`]): that of a
/// set of sheets is the sum over the sets B of the vertex that hold it, `G^B / 6^..` with their correction.
pub(super) fn lowered<T: Copy>(
    bubbles: &[Bubble],
    vertices: usize,
    lifted: &[T],
    sum: impl Fn(&mut dyn Iterator<Item = (T, f64)>) -> T,
) -> Vec<T> {
    let mut lowered = lifted.to_vec();
    let mut first = 0;
    for own in bubbles.chunk_by(|a, b| a.vertex == b.vertex) {
        let above = |sheets: &[u32]| -> Vec<(T, f64)> {
            let holds = |b: &&(usize, &Bubble)| sheets.iter().all(|s| b.1.sheets.contains(s));
            let scale = |b: &Bubble| 6.0_f64.powi(sheets.len() as i32 - b.sheets.len() as i32);
            let found: Vec<(usize, &Bubble)> = own.iter().enumerate().collect();
            found.iter().filter(holds).map(|(i, b)| (lifted[vertices + first + i], scale(b))).collect()
        };
        for (i, bubble) in own.iter().enumerate() {
            lowered[vertices + first + i] = sum(&mut above(&bubble.sheets).into_iter());
        }
        let v = own[0].vertex as usize;
        lowered[v] = sum(&mut above(&[]).into_iter().chain([(lifted[v], 1.0)]));
        first += own.len();
    }
    lowered
}

impl LocalBubble {
    /// Whether `G` with these faces is a term of the bubble: they are on distinct sheets of it.
    fn takes(&self, faces: u8) -> bool {
        let mut sheets = self.faces.clone();
        (0..6).filter(|f| faces >> f & 1 == 1).all(|f| {
            let sheet = sheets.iter().position(|bits| bits >> f & 1 == 1);
            sheet.map(|s| sheets.swap_remove(s)).is_some()
        })
    }
}

/// The sets of faces, as bits, below which bubbles take values: those of which no two are opposite.
pub(super) fn projections(bubbles: &[LocalBubble]) -> impl Iterator<Item = u8> {
    let own = bubbles.iter().flat_map(|b| &b.faces).fold(0, |all, bits| all | bits);
    (1..64_u8).filter(move |f| f & !own == 0 && (0..3).all(|axis| f >> (2 * axis) & 3 != 3))
}

/// The point on all these faces below a point.
fn foot(at: DVec3, faces: u8) -> DVec3 {
    let mut foot = at;
    (0..6).filter(|f| faces >> f & 1 == 1).for_each(|f| foot[f / 2] = (f % 2) as f64);
    foot
}

/// The product of the splines b0 of the distances from these faces with a function of the foot.
fn lift(at: DVec3, faces: u8, n: f64, dn: DVec3) -> (f64, DVec3) {
    let factors = [0, 1, 2].map(|axis| match faces >> (2 * axis) & 3 {
        0 => None,
        1 => Some(spline::cubic(at[axis])[0]),
        _ => Some(spline::cubic(1.0 - at[axis])[0]).map(|[b, db]| [b, -db]),
    });
    let product: f64 = factors.iter().flatten().map(|f| f[0]).product();
    let gradient = [0, 1, 2].map(|axis| match factors[axis] {
        None => product * dn[axis],
        Some([_, db]) => {
            let others = (0..3).filter(|a| *a != axis).filter_map(|a| factors[a]).map(|f| f[0]);
            n * db * others.product::<f64>()
        }
    });
    (product * n, DVec3::from_array(gradient))
}

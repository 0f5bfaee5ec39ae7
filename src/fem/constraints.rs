//! Whether the supports hold the solid, and if not, which rigid motion they leave free.
//!
//! The kernel of the stiffness is known in advance: each part (cells connected through faces) moves rigidly, and parts
//! that touch at vertices move alike there. So a part that hangs at an edge of another is held but for the rotation about
//! that edge. What the supports leave of this kernel is found from a small dense eigenproblem, before any large matrix.

use super::numbering::Dofs;
use super::{FemError, Model, Space, check};
use crate::mesh::TetMesh;
use glam::DVec3;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Relative size of an eigenvalue that counts as zero: a lever arm of 1e-6 of the part's size counts as none.
const ZERO: f64 = 1e-12;

/// Parts that touch each other and are examined together; in larger crowds each part has to be held by its own supports,
/// since the dense eigenproblem would take minutes.
const MAX_COUPLED: usize = 64;

/// Parts named in an error.
const MAX_NAMED: usize = 3;

/// Checks that the supports of a model leave no rigid motion of any part free. Refinement inherits supports, and what holds
/// the vertices of flat faces holds all their nodes, so once on the input mesh is enough.
///
/// # Errors
/// [`FemError::FreeMotion`] names the motion; others as [`super::assemble`].
pub fn check_constraints(mesh: &TetMesh, model: &Model) -> Result<(), FemError> {
    check::check(mesh, model)?;
    let (part_of, count) = mesh.connected_parts();
    let bodies = Bodies::new(mesh.points(), mesh.tets(), part_of, count);
    let rows = bodies.constraint_rows(mesh, model, &Dofs::new(&Space::linear(mesh), model)?);
    check_rows(&bodies, &rows)
}

/// Displacements that are held at places: part, place, direction, and the support that does it.
pub(super) type Held = (u32, DVec3, DVec3, usize);

/// As [`check_constraints`], of cells in connected parts that are held at places.
///
/// # Errors
/// [`FemError::FreeMotion`].
pub(super) fn check_held<const N: usize>(
    points: &[DVec3],
    cells: &[[u32; N]],
    (part_of, count): (&[u32], usize),
    held: &[Held],
) -> Result<(), FemError> {
    let bodies = Bodies::new(points, cells, part_of, count);
    let mut rows = bodies.joint_rows(points);
    for &(part, x, direction, support) in held {
        let coefficients = bodies.parts[part as usize].modes(x, direction);
        rows[part as usize].push(Row { coefficients, other: None, support: Some(support) });
    }
    check_rows(&bodies, &rows)
}

/// Refuses parts that the conditions leave free.
fn check_rows(bodies: &Bodies, rows: &[Vec<Row>]) -> Result<(), FemError> {
    let (mut motions, mut supports) = (Vec::new(), Vec::new());
    for cluster in bodies.clusters() {
        let free = free_motions(&cluster, rows);
        for (place, &part) in cluster.iter().enumerate() {
            let own = column_space(free.rows(6 * place, 6).into_owned());
            if own.ncols() > 0 {
                motions.push(bodies.sentence(part, &own));
                supports.extend(rows[part as usize].iter().filter_map(|row| row.support));
            }
        }
    }
    let more = motions.len().saturating_sub(MAX_NAMED);
    motions.truncate(MAX_NAMED);
    if more > 0 {
        motions.push(format!("{more} more parts can move as well"));
    }
    supports.sort_unstable();
    supports.dedup();
    if motions.is_empty() { Ok(()) } else { Err(FemError::FreeMotion { motions, supports }) }
}

/// The parts as rigid bodies.
struct Bodies {
    parts: Vec<Body>,
    /// The first part of each vertex.
    part_at: Vec<u32>,
    /// (vertex, its first part, another part there), sorted.
    joints: Vec<(u32, u32, u32)>,
}

/// A part as a rigid body.
#[derive(Clone)]
struct Body {
    cells: usize,
    lo: DVec3,
    hi: DVec3,
}

impl Body {
    fn centre(&self) -> DVec3 {
        0.5 * (self.lo + self.hi)
    }

    fn radius(&self) -> f64 {
        0.5 * (self.hi - self.lo).length()
    }

    /// Component `c` at `x` of the six rigid motions: translations, and rotations that move the corners by about one.
    fn modes(&self, x: DVec3, direction: DVec3) -> [f64; 6] {
        let arm = (x - self.centre()) / self.radius();
        std::array::from_fn(|k| if k < 3 { direction[k] } else { DVec3::AXES[k - 3].cross(arm).dot(direction) })
    }
}

/// A linear condition on rigid motions: six coefficients for a part, and for a joint six for another.
struct Row {
    coefficients: [f64; 6],
    other: Option<(u32, [f64; 6])>,
    /// The support that makes it.
    support: Option<usize>,
}

impl Bodies {
    fn new<const N: usize>(points: &[DVec3], cells: &[[u32; N]], part_of: &[u32], count: usize) -> Self {
        let mut parts = vec![Body { cells: 0, lo: DVec3::INFINITY, hi: DVec3::NEG_INFINITY }; count];
        let mut part_at = vec![u32::MAX; points.len()];
        let mut joints = Vec::new();
        for (cell, &part) in cells.iter().zip(part_of) {
            parts[part as usize].cells += 1;
            for &v in cell {
                let first = &mut part_at[v as usize];
                if *first == u32::MAX {
                    *first = part;
                } else if *first != part {
                    joints.push((v, *first, part));
                }
            }
        }
        joints.sort_unstable();
        joints.dedup();
        let first = (0..).zip(&part_at).filter(|(_, part)| **part != u32::MAX).map(|(v, part)| (v, *part));
        for (v, part) in first.chain(joints.iter().map(|&(v, _, other)| (v as usize, other))) {
            let (body, x) = (&mut parts[part as usize], points[v]);
            (body.lo, body.hi) = (body.lo.min(x), body.hi.max(x));
        }
        Self { parts, part_at, joints }
    }

    /// The conditions of the supports and joints, by part; those of a joint with the first of its two.
    fn constraint_rows(&self, mesh: &TetMesh, model: &Model, numbering: &Dofs) -> Vec<Vec<Row>> {
        let modes =
            |part: u32, v: u32, c: usize| self.parts[part as usize].modes(mesh.points()[v as usize], DVec3::AXES[c]);
        let mut rows = self.joint_rows(mesh.points());
        for p in numbering.prescribed() {
            let part = self.part_at[p.node as usize];
            let coefficients = modes(part, p.node, p.component as usize);
            rows[part as usize].push(Row { coefficients, other: None, support: Some(p.support as usize) });
        }
        // A foundation holds the corners of its faces: no motion but zero has zero in all of them and energy none.
        for (index, support) in model.supports.iter().enumerate() {
            let held: Vec<usize> = (0..3).filter(|&c| support.stiffness[c] > 0.0).collect();
            for v in mesh.group_faces(support.group).flat_map(|f| f.vertices) {
                let part = self.part_at[v as usize];
                let row = |c| Row { coefficients: modes(part, v, c), other: None, support: Some(index) };
                rows[part as usize].extend(held.iter().map(|&c| row(c)));
            }
        }
        rows
    }

    /// The conditions of the joints, each with the first of its two parts.
    fn joint_rows(&self, points: &[DVec3]) -> Vec<Vec<Row>> {
        let modes = |part: u32, v: u32, c: usize| self.parts[part as usize].modes(points[v as usize], DVec3::AXES[c]);
        let mut rows: Vec<Vec<Row>> = self.parts.iter().map(|_| Vec::new()).collect();
        for &(v, a, b) in &self.joints {
            let row = |c| Row { coefficients: modes(a, v, c), other: Some((b, modes(b, v, c))), support: None };
            rows[a as usize].extend((0..3).map(row));
        }
        rows
    }

    /// Sets of parts connected by joints, ascending.
    fn clusters(&self) -> Vec<Vec<u32>> {
        let mut root: Vec<u32> = (0..self.parts.len() as u32).collect();
        let find = |root: &[u32], mut p: u32| {
            while root[p as usize] != p {
                p = root[p as usize];
            }
            p
        };
        for &(_, a, b) in &self.joints {
            let (a, b) = (find(&root, a), find(&root, b));
            root[a.max(b) as usize] = a.min(b);
        }
        let mut sorted: Vec<(u32, u32)> = (0..root.len() as u32).map(|p| (find(&root, p), p)).collect();
        sorted.sort_unstable();
        let members = |same: &[(u32, u32)]| same.iter().map(|s| s.1).collect::<Vec<_>>();
        let (small, crowds): (Vec<_>, Vec<_>) =
            sorted.chunk_by(|a, b| a.0 == b.0).map(members).partition(|cluster| cluster.len() <= MAX_COUPLED);
        small.into_iter().chain(crowds.into_iter().flatten().map(|part| vec![part])).collect()
    }

    /// Says how a part can move; `free` holds orthonormal motions in its columns.
    fn sentence(&self, part: u32, free: &DMatrix<f64>) -> String {
        let body = &self.parts[part as usize];
        let (lo, hi) = (rounded(body.lo, body.radius()), rounded(body.hi, body.radius()));
        let (number, count) = (part + 1, self.parts.len());
        let motion = if free.ncols() == 6 { "move and rotate in every way".to_owned() } else { describe(body, free) };
        format!("part {number} of {count} ({} cells, box {lo} to {hi}) can still {motion}", body.cells)
    }
}

/// The motions of a cluster of parts that satisfy all conditions: orthonormal columns, six rows a part.
fn free_motions(cluster: &[u32], rows: &[Vec<Row>]) -> DMatrix<f64> {
    let size = 6 * cluster.len();
    let mut gram = DMatrix::<f64>::zeros(size, size);
    for (own, &part) in cluster.iter().enumerate() {
        for row in &rows[part as usize] {
            let mut condition = DVector::<f64>::zeros(size);
            condition.rows_mut(6 * own, 6).copy_from_slice(&row.coefficients);
            if let Some((other, coefficients)) = &row.other {
                // A joint to a part examined elsewhere (see MAX_COUPLED) is no condition here.
                let Ok(place) = cluster.binary_search(other) else { continue };
                condition.rows_mut(6 * place, 6).iter_mut().zip(coefficients).for_each(|(f, c)| *f = -c);
            }
            gram.ger(1.0, &condition, &condition, 1.0);
        }
    }
    let eigen = SymmetricEigen::new(gram);
    let bound = ZERO * eigen.eigenvalues.amax();
    let zero: Vec<usize> = (0..size).filter(|&k| eigen.eigenvalues[k] <= bound).collect();
    eigen.eigenvectors.select_columns(&zero)
}

/// Orthonormal basis of the span of the columns, without directions that hardly show.
fn column_space(columns: DMatrix<f64>) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(&columns * columns.transpose());
    let kept: Vec<usize> = (0..columns.nrows()).filter(|&k| eigen.eigenvalues[k] > ZERO).collect();
    eigen.eigenvectors.select_columns(&kept)
}

/// Translations and rotations in words.
fn describe(body: &Body, free: &DMatrix<f64>) -> String {
    let (shift, spin) = (free.rows(0, 3), free.rows(3, 3));
    let eigen = SymmetricEigen::new(spin.transpose() * spin);
    let (mut shifts, mut screws) = (Vec::new(), Vec::new());
    for k in 0..free.ncols() {
        let v = eigen.eigenvectors.column(k);
        let [t, w] = [shift * v, spin * v].map(|m| DVec3::new(m[0], m[1], m[2]));
        if eigen.eigenvalues[k] > ZERO { screws.push((w, t)) } else { shifts.push(t) }
    }
    let mut words: Vec<String> =
        axis_basis(&shifts).into_iter().map(|t| format!("move along {}", direction(t))).collect();
    let spins: Vec<DVec3> = screws.iter().map(|(w, _)| w.normalize()).collect();
    words.extend(axis_basis(&spins).into_iter().map(|w| {
        // The vectors w_k are orthogonal: the coordinates of w among them give the shift that goes with it.
        let shift: DVec3 = screws.iter().map(|(wk, tk)| wk.dot(w) / wk.length_squared() * *tk).sum();
        let shift = shift - shifts.iter().map(|s| s.dot(shift) * *s).sum::<DVec3>();
        let through = body.centre() + body.radius() * w.cross(shift);
        let screw = if shift.dot(w).abs() > ZERO.sqrt() { " and along" } else { "" };
        format!("rotate about{screw} {} through {}", direction(w), rounded(through, body.radius()))
    }));
    words.join(", ")
}

/// An orthonormal basis of the span of orthonormal vectors, as close to the coordinate axes as can be.
fn axis_basis(span: &[DVec3]) -> Vec<DVec3> {
    let mut basis: Vec<DVec3> = Vec::new();
    while basis.len() < span.len() {
        let inside = |e: DVec3| span.iter().map(|s| s.dot(e) * *s).sum::<DVec3>();
        let left = |e: DVec3| inside(e) - basis.iter().map(|b| b.dot(e) * *b).sum::<DVec3>();
        let [x, y, z] = DVec3::AXES.map(left);
        let best = [y, z].into_iter().fold(x, |a, b| if b.length() > a.length() + ZERO.sqrt() { b } else { a });
        basis.push(best.normalize());
    }
    basis
}

fn direction(v: DVec3) -> String {
    let axis = DVec3::AXES.into_iter().zip(["x", "y", "z"]).find(|(e, _)| v.cross(*e).length() < ZERO.sqrt());
    axis.map_or_else(|| rounded(v, 1.0), |(_, name)| name.to_owned())
}

/// A position or vector to four digits of `scale`.
fn rounded(p: DVec3, scale: f64) -> String {
    let decimals = (3 - scale.log10().floor() as i32).clamp(0, 300);
    // Text and back drops trailing zeros; adding zero turns -0 into 0.
    let [x, y, z] = p.to_array().map(|c| format!("{c:.0$}", decimals as usize).parse().unwrap_or(c) + 0.0);
    format!("({x}, {y}, {z})")
}

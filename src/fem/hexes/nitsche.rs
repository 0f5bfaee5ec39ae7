//! Supports that hold in the mean over their faces, by Nitsche's symmetric method (Nitsche 1971): along the normal of curved
//! faces, which no single coefficient prescribes, and on parts of smooth surfaces, which would need a crease to end sharply.
//!
//! With P the projection onto the held directions, n the normal and g the prescribed displacement,
//! `int (-P s(u) n . v - P s(v) n . (u - g) + beta P (u - g) . v) dA` is added to the equations. They stay positive definite if beta
//! is large enough for the cell: `int_F |P s(v) n|^2 dA <= C a_K(v, v)` for all of its functions v and `beta > C` (the local
//! trace inequality); C is the largest eigenvalue of a small problem on each cell.

use super::super::block_matrix::BlockMatrix;
use super::super::{FemError, Model, Support, Weakly};
use super::matrix::{self, CellMatrix};
use super::rule::Quadrature;
use super::stress::{material, strain};
use super::{AtPoint, HexSpace, face_area};
use glam::{DMat3, DVec3};
use nalgebra::{Cholesky, DMatrix, SymmetricEigen};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Gauss points a direction on faces.
const POINTS: usize = 5;

/// How far above the constant of the trace inequality beta is: half of each cell's stiffness is left.
const SAFETY: f64 = 2.0;

/// What is added to a diagonal of ones, so that rigid motions of a cell have some stiffness.
const REGULAR: f64 = 1e-11;

/// Cells whose matrices are kept at a time.
const BATCH: usize = 64;

/// What a support holds in the mean at a point of its faces.
struct Point {
    x: DVec3,
    area: f64,
    /// Projection onto the held directions.
    held: DMat3,
    /// Value of each function of the cell.
    values: Vec<f64>,
    /// Of each function: the matrix that makes of its coefficient the traction.
    tractions: Vec<DMat3>,
    /// Traction of the displacement.
    traction: DVec3,
    /// The displacement.
    moved: DVec3,
}

/// A face of a cell that a support holds in the mean.
struct Face<'a> {
    support: (usize, &'a Support),
    points: Vec<Point>,
}

/// The cells at faces that supports hold in the mean, each with (support, its face there).
fn cells_at(space: &HexSpace<'_>, model: &Model) -> Vec<(usize, Vec<(usize, usize)>)> {
    let mut cells: BTreeMap<usize, Vec<(usize, usize)>> = BTreeMap::new();
    for (index, support) in model.supports.iter().enumerate().filter(|(_, s)| s.weakly.is_some()) {
        for face in space.mesh().group_faces(support.group) {
            let (t, k) = space.cell_of_face(face);
            cells.entry(t).or_default().push((index, k));
        }
    }
    cells.into_iter().collect()
}

/// The held faces of a cell with their points.
fn faces<'a>(
    space: &HexSpace<'_>,
    model: &'a Model,
    (t, own): &(usize, Vec<(usize, usize)>),
    rules: &[Quadrature; 6],
    u: Option<&[DVec3]>,
) -> Vec<Face<'a>> {
    let material = material(space, model, *t);
    let (lambda, mu) = (material.lambda(), material.mu());
    let face = |&(index, k): &(usize, usize)| {
        let support = &model.supports[index];
        let (weights, table) = rules[k].of(space, *t);
        let mut at = AtPoint::default();
        let point = |(q, weight): (usize, &f64)| {
            space.at_point(*t, &table, q, &mut at);
            let area = *weight * face_area(k, &at.jacobian);
            let n = area.normalize_or_zero();
            let traction =
                |g: &DVec3| lambda * outer(n, *g) + mu * (DMat3::from_diagonal(DVec3::splat(g.dot(n))) + outer(*g, n));
            let moved = |u: &[DVec3]| {
                let stress = material.stress(strain(space, u, *t, &at));
                (super::super::traction(stress, n), space.interpolate(u, *t, &table, q))
            };
            let (own_traction, own_displacement) = u.map(moved).unwrap_or_default();
            Point {
                x: at.x,
                area: area.length(),
                held: held(support, n),
                values: table.values_at(q).to_vec(),
                tractions: at.gradients.iter().map(traction).collect(),
                traction: own_traction,
                moved: own_displacement,
            }
        };
        Face { support: (index, support), points: weights.iter().enumerate().map(point).collect() }
    };
    own.iter().map(face).collect()
}

/// The projection onto the directions that a support holds where the normal is `n`.
fn held(support: &Support, n: DVec3) -> DMat3 {
    match support.weakly {
        Some(Weakly::Normal) => outer(n, n),
        _ => DMat3::from_diagonal(DVec3::from_array([0, 1, 2].map(|c| f64::from(support.displacement[c].is_some())))),
    }
}

/// `a b^T`.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(b.x * a, b.y * a, b.z * a)
}

/// The factor beta of each face of a cell.
fn penalties(stiffness: &CellMatrix, faces: &[Face<'_>]) -> Vec<f64> {
    let n = 3 * stiffness.functions;
    let entry = |i: usize, j: usize| stiffness.block(i / 3, j / 3).col(j % 3)[i % 3];
    let scale: Vec<f64> = (0..n).map(|i| 1.0 / entry(i, i).max(f64::MIN_POSITIVE).sqrt()).collect();
    let scaled = DMatrix::from_fn(n, n, |i, j| scale[i] * entry(i, j) * scale[j] + if i == j { REGULAR } else { 0.0 });
    let factor = Cholesky::new(scaled);
    let of_face = |face: &Face<'_>| {
        let mut traction = DMatrix::zeros(n, 3 * face.points.len());
        for (q, point) in face.points.iter().enumerate() {
            for (a, of_function) in point.tractions.iter().enumerate() {
                let part = point.area.sqrt() * point.held * *of_function;
                for (c, j) in (0..3).flat_map(|c| (0..3).map(move |j| (c, j))) {
                    traction[(3 * a + j, 3 * q + c)] = scale[3 * a + j] * part.col(j)[c];
                }
            }
        }
        // A cell whose matrix is not positive is refused elsewhere.
        let Some(factor) = &factor else { return 0.0 };
        factor.l_dirty().solve_lower_triangular_mut(&mut traction);
        let eigen = SymmetricEigen::new(traction.tr_mul(&traction));
        SAFETY * faces.len() as f64 * eigen.eigenvalues.amax()
    };
    faces.iter().map(of_face).collect()
}

fn rules(space: &HexSpace<'_>) -> [Quadrature; 6] {
    std::array::from_fn(|k| Quadrature::on_face(space, k, POINTS))
}

/// Adds what supports that hold in the mean add to stiffness and loads.
///
/// # Errors
/// [`FemError::NotFiniteAt`] where a prescribed displacement has no finite value; [`FemError::Folded`].
pub(super) fn add(
    space: &HexSpace<'_>,
    model: &Model,
    stiffness: &mut BlockMatrix,
    mut loads: Option<&mut Vec<DVec3>>,
) -> Result<(), FemError> {
    let (cells, rules) = (cells_at(space, model), rules(space));
    let quadrature = Quadrature::of_stiffness(space, 0, 0);
    type Blocks = (Vec<DMat3>, Vec<DVec3>);
    let of_cell = |cell: &(usize, Vec<(usize, usize)>)| -> Result<Blocks, FemError> {
        let faces = faces(space, model, cell, &rules, None);
        let own = matrix::of_cell(space, &quadrature, &model.materials, cell.0)?;
        let n = own.functions;
        let (mut blocks, mut forces) = (vec![DMat3::ZERO; n * n], vec![DVec3::ZERO; n]);
        for (face, beta) in faces.iter().zip(penalties(&own, &faces)) {
            for p in &face.points {
                let target = p.held * wanted(face.support.1, p.x)?;
                for i in 0..n {
                    let (value, traction) = (p.area * p.values[i], p.area * p.held * p.tractions[i]);
                    let across = traction.transpose();
                    forces[i] += beta * value * target - across * target;
                    for j in 0..n {
                        blocks[i * n + j] += value * beta * p.values[j] * p.held
                            - value * p.held * p.tractions[j]
                            - p.values[j] * across;
                    }
                }
            }
        }
        Ok((blocks, forces))
    };
    for batch in cells.chunks(BATCH) {
        let found: Vec<Blocks> = batch.par_iter().map(of_cell).collect::<Result<_, _>>()?;
        for ((t, _), (blocks, forces)) in batch.iter().zip(found) {
            let own = space.cell(*t);
            for (place, block) in blocks.iter().enumerate() {
                if let Some(entry) = stiffness.block_mut(own[place / own.len()], own[place % own.len()]) {
                    *entry += *block;
                }
            }
            if let Some(loads) = loads.as_deref_mut() {
                own.iter().zip(forces).for_each(|(v, force)| loads[*v as usize] += force);
            }
        }
    }
    Ok(())
}

/// The displacement that a support prescribes at a place; zero where free.
fn wanted(support: &Support, x: DVec3) -> Result<DVec3, FemError> {
    let mut wanted = DVec3::ZERO;
    for (c, field) in support.displacement.iter().enumerate() {
        let Some(field) = field else { continue };
        wanted[c] = field.at(x);
        if !wanted[c].is_finite() {
            return Err(FemError::not_finite_at("support", &support.name, field, x));
        }
    }
    Ok(wanted)
}

/// Adds the forces of supports that hold in the mean: with those of all supports and the loads they sum to zero.
pub(super) fn add_reactions(space: &HexSpace<'_>, model: &Model, u: &[DVec3], reactions: &mut [DVec3]) {
    let (cells, rules) = (cells_at(space, model), rules(space));
    let quadrature = Quadrature::of_stiffness(space, 0, 0);
    let of_cell = |cell: &(usize, Vec<(usize, usize)>)| -> Vec<(usize, DVec3)> {
        let faces = faces(space, model, cell, &rules, Some(u));
        // Folded cells and values that are not finite were refused when the system was made.
        let Ok(own) = matrix::of_cell(space, &quadrature, &model.materials, cell.0) else { return Vec::new() };
        let force = |(face, beta): (&Face<'_>, f64)| {
            let at = |p: &Point| {
                let missed = p.moved - wanted(face.support.1, p.x).unwrap_or_default();
                p.area * (p.held * (p.traction - beta * missed))
            };
            (face.support.0, face.points.iter().map(at).sum::<DVec3>())
        };
        faces.iter().zip(penalties(&own, &faces)).map(force).collect()
    };
    let all: Vec<Vec<(usize, DVec3)>> = cells.par_iter().map(of_cell).collect();
    all.into_iter().flatten().for_each(|(support, force)| reactions[support] += force);
}

//! The finest level: the unknowns of a stiffness matrix.

use super::frame::Frame;
use super::operator::{Entries, Operator};
use super::order::Order;
use super::real::Real;
use crate::fem::FemError;
use crate::fem::block_matrix::{BlockMatrix, CHUNK};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// A level of displacements.
pub(super) struct Finest<T> {
    pub a: Operator<T, 3, 4>,
    pub frame: Frame<3>,
}

/// Nodes with unknowns, and the matrix between them, scaled to have its largest diagonal entry near one. Rows and columns
/// of prescribed components are those of the identity.
///
/// # Errors
/// [`FemError::Multigrid`].
pub(super) fn finest<T: Real>(k: &BlockMatrix, points: &[DVec3], mask: &[DVec3]) -> Result<Finest<T>, FemError> {
    let active: Vec<bool> = mask.iter().map(|m| *m != DVec3::ZERO).collect();
    let size = |i: usize| if active[i] { k.diagonal(i).x_axis.x.abs() } else { 0.0 };
    let largest = (0..k.rows()).into_par_iter().with_min_len(CHUNK).map(size).reduce(|| 0.0, f64::max);
    let scale = if largest > 0.0 { 1.0 / largest } else { 1.0 };
    let near = |i: u32, call: &mut dyn FnMut(u32)| k.row(i as usize).for_each(|(j, _)| call(j as u32));
    let order = Order::new(points, &active, CHUNK, near);
    let free = |i: &u32| {
        let m = mask[*i as usize];
        (m != DVec3::ONE).then(|| Box::new([[m.x, 0.0, 0.0], [0.0, m.y, 0.0], [0.0, 0.0, m.z]]))
    };
    let frame = Frame {
        points: order.natural.iter().map(|&i| points[i as usize]).collect(),
        radii: Vec::new(),
        free: order.natural.iter().map(free).collect(),
    };
    let place = order.place.clone();
    let row = |i: u32, entries: &mut Entries<T, 3, 4>| {
        let i = i as usize;
        for (j, block) in k.row(i).filter(|(j, _)| active[*j]) {
            let mut block = *block * scale;
            if mask[i] != DVec3::ONE || mask[j] != DVec3::ONE {
                block = DMat3::from_diagonal(mask[i]) * block * DMat3::from_diagonal(mask[j]);
                if i == j {
                    block += DMat3::from_diagonal(DVec3::ONE - mask[i]);
                }
            }
            let column = |c: DVec3| [T::new(c.x), T::new(c.y), T::new(c.z), T::default()];
            entries.push((place[j], [column(block.x_axis), column(block.y_axis), column(block.z_axis)]));
        }
    };
    Ok(Finest { a: Operator::new(order, row)?, frame })
}

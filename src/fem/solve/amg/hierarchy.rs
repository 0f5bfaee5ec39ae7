//! The levels and the cycle through them.

use super::aggregate::Aggregates;
use super::finest::{Finest, finest};
use super::frame::Frame;
use super::galerkin::Coarse;
use super::level::{Bottom, Midpoints};
use super::operator::Operator;
use super::order::{NONE, Order};
use super::real::Real;
use super::smoother::{Kind, Smoother, is_tight};
use super::spectrum::largest_eigenvalue;
use super::transfer::{Transfer, WIDE};
use crate::fem::{FemError, System};
use glam::DVec3;
use rayon::prelude::*;

/// Nodes a chunk on coarse levels.
const CHUNK: usize = 64;

/// Strength of a coupling that makes nodes of one aggregate, relative to the diagonal: where sweeps smooth well, and where
/// more and smaller aggregates pay.
const STRONG: [f64; 2] = [0.08, 0.1];

/// Nodes that a level is solved directly for: on levels so small, aggregates are too few to represent soft motions.
const FEW: usize = 200;

/// A symmetric positive definite approximation of the inverse of a stiffness matrix.
pub(in super::super) struct Hierarchy<T> {
    /// The finest level, by natural numbers outside.
    order: FinestOrder,
    midpoints: Option<Top<T>>,
    vertices: Stage<T, 3, 4>,
    coarser: Vec<Stage<T, 6, WIDE>>,
    bottom: Bottom,
}

/// Places of the nodes outside and on the finest level.
struct FinestOrder {
    natural: Vec<u32>,
    place: Vec<u32>,
}

/// The level of the midpoints.
struct Top<T> {
    smoother: Smoother<T, 3, 4>,
    way: Midpoints,
    /// 1 where a component is unknown, 0 elsewhere: of this level's nodes, and of the vertices.
    free: [Vec<[T; 4]>; 2],
}

/// What the level of the midpoints is made of: its matrix, the way to the vertices, where components are unknown.
type Above<T> = (Operator<T, 3, 4>, Midpoints, [Vec<[T; 4]>; 2]);

/// A level, and the way to the next one unless it is the last.
struct Stage<T, const N: usize, const W: usize> {
    smoother: Smoother<T, N, W>,
    way: Option<Transfer<T, N>>,
}

impl<T: Real> Hierarchy<T> {
    /// Builds the levels for the unknowns of a system, with this smoother or the one that suits it.
    ///
    /// # Errors
    /// [`FemError::Multigrid`] where a level is not positive definite, mostly for rounding; as the direct method's.
    pub fn of(system: &System, smoother: Option<Kind>) -> Result<Self, FemError> {
        let (stiffness, points, mask) = (&system.stiffness, &system.points, system.numbering.mask());
        let Some(linear) = &system.linear else {
            let finest = finest(stiffness, points, mask)?;
            return Self::below(finest, None, smoother);
        };
        let count = linear.stiffness.rows();
        let top = finest::<T>(stiffness, points, mask)?;
        let vertices = finest::<T>(&linear.stiffness, &points[..count], &mask[..count])?;
        let place = &vertices.a.order.place;
        let ends = |&i: &u32| match (i as usize).checked_sub(count) {
            Some(edge) => linear.ends[edge].map(|v| place.get(v as usize).copied().unwrap_or(NONE)),
            None => [place[i as usize]; 2],
        };
        let way = Midpoints::new(top.a.order.natural.iter().map(ends).collect(), vertices.a.len());
        let free = [&top.a.order, &vertices.a.order].map(|order| free(order, mask));
        Self::below(vertices, Some((top.a, way, free)), smoother)
    }

    fn below(vertices: Finest<T>, midpoints: Option<Above<T>>, smoother: Option<Kind>) -> Result<Self, FemError> {
        let Finest { a, frame } = vertices;
        let top = midpoints.as_ref().map_or(&a.order, |(top, ..)| &top.order);
        let order = FinestOrder { natural: top.natural.clone(), place: top.place.clone() };
        let largest = largest_eigenvalue(&a);
        let strong = STRONG[usize::from(is_tight(largest))];
        let (way, mut next) = descend(&a, &frame, largest, strong)?;
        let size = way.as_ref().map_or(f64::INFINITY, |way| a.len() as f64 / way.coarse() as f64);
        let kind = smoother.unwrap_or_else(|| Kind::choose(largest, size));
        let mut bottom = if way.is_none() { Some(Bottom::new(&a)?) } else { None };
        let vertices = Stage { smoother: Smoother::new(a, kind, largest), way };
        let mut coarser = Vec::new();
        while let Some((a, frame)) = next {
            let largest = largest_eigenvalue(&a);
            let (way, further) = descend(&a, &frame, largest, strong)?;
            if way.is_none() {
                bottom = Some(Bottom::new(&a)?);
            }
            coarser.push(Stage { smoother: Smoother::new(a, kind, largest), way });
            next = further;
        }
        let midpoints = midpoints.map(|(a, way, free)| Top { smoother: Smoother::estimated(a, kind), way, free });
        let Some(bottom) = bottom else { return Err(FemError::Ordering("no last level".to_owned())) };
        Ok(Self { order, midpoints, vertices, coarser, bottom })
    }

    /// `z = M r` at the unknowns, zero elsewhere, where `size` is about the size of `r`.
    ///
    /// # Errors
    /// As the direct method's.
    pub fn apply(&mut self, r: &[DVec3], size: f64, z: &mut [DVec3]) -> Result<(), FemError> {
        let scale = 1.0 / size;
        let own = self.midpoints.as_mut().map_or(&mut self.vertices.smoother, |top| &mut top.smoother);
        own.r.par_iter_mut().zip(&self.order.natural).with_min_len(1024).for_each(|(own, &i)| {
            let [x, y, z] = (scale * r[i as usize]).to_array();
            *own = [T::new(x), T::new(y), T::new(z), T::default()];
        });
        self.cycle()?;
        let own = self.midpoints.as_ref().map_or(&self.vertices.smoother, |top| &top.smoother);
        z.par_iter_mut().zip(&self.order.place).with_min_len(1024).for_each(|(z, &k)| {
            let found = own.z.get(k as usize);
            *z = found.map_or(DVec3::ZERO, |f| size * DVec3::new(f[0].get(), f[1].get(), f[2].get()));
        });
        Ok(())
    }

    /// Numbers stored in the matrices of all levels, diagonal blocks counted once.
    pub fn numbers(&self) -> usize {
        let top = self.midpoints.as_ref().map_or(0, |top| 9 * top.smoother.a.blocks());
        let coarser: usize = self.coarser.iter().map(|stage| 36 * stage.smoother.a.blocks()).sum();
        top + 9 * self.vertices.smoother.a.blocks() + coarser
    }

    /// One V-cycle.
    fn cycle(&mut self) -> Result<(), FemError> {
        let Some(top) = &mut self.midpoints else { return self.vertices_cycle() };
        top.smoother.before();
        top.way.restrict(&top.smoother.rest, &top.free[1], &mut self.vertices.smoother.r);
        self.vertices_cycle()?;
        if let Some(top) = &mut self.midpoints {
            top.way.prolong(&self.vertices.smoother.z, &top.free[0], &mut top.smoother.z);
            top.smoother.after();
        }
        Ok(())
    }

    fn vertices_cycle(&mut self) -> Result<(), FemError> {
        let own = &mut self.vertices;
        let Some(way) = &own.way else { return self.bottom.solve::<T, 3, 4>(&own.smoother.r, &mut own.smoother.z) };
        own.smoother.before();
        way.restrict(&own.smoother.rest, &mut self.coarser[0].smoother.r);
        cycle(&mut self.coarser, &self.bottom)?;
        way.prolong(&self.coarser[0].smoother.z, &mut own.smoother.z);
        own.smoother.after();
        Ok(())
    }
}

/// The mask in the order of a level.
fn free<T: Real>(order: &Order, mask: &[DVec3]) -> Vec<[T; 4]> {
    let free = |&i: &u32| {
        let m = mask[i as usize];
        [T::new(m.x), T::new(m.y), T::new(m.z), T::default()]
    };
    order.natural.iter().map(free).collect()
}

/// A V-cycle through the coarse levels.
fn cycle<T: Real>(stages: &mut [Stage<T, 6, WIDE>], bottom: &Bottom) -> Result<(), FemError> {
    let Some((own, below)) = stages.split_first_mut() else { return Ok(()) };
    let (Some(way), Some(_)) = (&own.way, below.first()) else {
        return bottom.solve::<T, 6, WIDE>(&own.smoother.r, &mut own.smoother.z);
    };
    own.smoother.before();
    way.restrict(&own.smoother.rest, &mut below[0].smoother.r);
    cycle(below, bottom)?;
    way.prolong(&below[0].smoother.z, &mut own.smoother.z);
    own.smoother.after();
    Ok(())
}

/// The way to a coarser level and its matrix, unless this one is small, or its nodes hardly make aggregates.
type Way<T, const N: usize> = (Option<Transfer<T, N>>, Option<(Operator<T, 6, WIDE>, Frame<6>)>);

/// The next level below; `largest` is the largest eigenvalue of `D^-1 A`, `strong` the strength of couplings that count.
fn descend<T: Real, const N: usize, const W: usize>(
    a: &Operator<T, N, W>,
    frame: &Frame<N>,
    largest: f64,
    strong: f64,
) -> Result<Way<T, N>, FemError> {
    if a.len() <= FEW {
        return Ok((None, None));
    }
    let aggregates = Aggregates::new(a, strong);
    if aggregates.count == 0 || 5 * aggregates.count > 4 * a.len() {
        return Ok((None, None));
    }
    let (coarse, motions) = frame.coarsen(&aggregates);
    let mut way = Transfer::smoothed(a, &aggregates, &motions, 4.0 / 3.0 / largest);
    let matrix = Coarse::new(a, &way, &coarse.free);
    let all = vec![true; aggregates.count];
    let order = Order::new(&coarse.points, &all, CHUNK, |i, call| matrix.neighbours(i, call));
    way.renumber(&order.place, &order.natural);
    let (frame, place) = (coarse.permuted(&order.natural), order.place.clone());
    let next = Operator::new(order, |i, entries| matrix.row(&place, i, entries))?;
    Ok((Some(way), Some((next, frame))))
}

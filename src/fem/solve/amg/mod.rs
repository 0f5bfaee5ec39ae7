//! Smoothed-aggregation multigrid (Vanek, Mandel and Brezina 1996) for elasticity, as a preconditioner.
//!
//! Displacements that are smooth, which sweeps over the nodes hardly change, are nearly rigid on small pieces of the solid.
//! So nodes are gathered into aggregates, whose rigid motions, smoothed, span the displacements of a coarser level; its
//! nodes are aggregated in turn, until a direct solution costs nothing. Above the level of the vertices of ten-node cells
//! is that of all their nodes.

mod aggregate;
mod finest;
mod frame;
mod galerkin;
mod hierarchy;
mod level;
mod operator;
mod order;
mod real;
mod rows;
mod smoother;
mod spectrum;
#[cfg(test)]
mod tests;
mod transfer;

pub(super) use hierarchy::Hierarchy;
pub(super) use real::Real;
pub(super) use smoother::Kind;

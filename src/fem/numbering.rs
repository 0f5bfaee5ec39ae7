//! The numbering of degrees of freedom: the only place that knows which are unknown and which are prescribed.

use super::{FemError, Model, Space};
use glam::DVec3;

/// A prescribed component of a node's displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prescribed {
    /// The node.
    pub node: u32,
    /// 0, 1, 2 for x, y, z.
    pub component: u8,
    /// The displacement.
    pub value: f64,
    /// Index of the support; the first one where several prescribe the same component.
    pub support: u32,
}

/// Which displacement components are unknown and which are prescribed.
///
/// Nodes of no cell have neither: they carry no stiffness, and their displacement is zero.
#[derive(Debug, Clone)]
pub(super) struct Dofs {
    /// 1 where a component is unknown, 0 elsewhere.
    mask: Vec<DVec3>,
    /// Sorted by node and component.
    prescribed: Vec<Prescribed>,
    free: usize,
}

impl Dofs {
    /// Numbers the nodes under the supports of a model.
    ///
    /// # Errors
    /// [`FemError::ConflictingSupports`].
    pub fn new(space: &Space<'_>, model: &Model) -> Result<Self, FemError> {
        Ok(Self::from_prescribed(space, prescribed(space, model)?))
    }

    /// Numbers the nodes when the prescribed components are given, sorted and each once.
    pub fn from_prescribed(space: &Space<'_>, prescribed: Vec<Prescribed>) -> Self {
        let mut used = vec![false; space.points().len()];
        for v in (0..space.mesh().tets().len()).flat_map(|t| space.cell(t)) {
            used[v as usize] = true;
        }
        Self::from_used(used, prescribed)
    }

    /// Numbers the nodes that are used, when the prescribed components are given, sorted and each once.
    pub fn from_used(used: Vec<bool>, prescribed: Vec<Prescribed>) -> Self {
        let mut mask: Vec<DVec3> = used.into_iter().map(|used| DVec3::splat(f64::from(u8::from(used)))).collect();
        for p in &prescribed {
            mask[p.node as usize][p.component as usize] = 0.0;
        }
        let free = mask.iter().map(|m| m.element_sum() as usize).sum();
        Self { mask, prescribed, free }
    }

    /// The same components prescribed, with other values.
    pub fn with_values(mut self, value: impl Fn(&Prescribed) -> f64) -> Self {
        self.prescribed.iter_mut().for_each(|p| p.value = value(p));
        self
    }

    /// Number of unknowns.
    pub fn free(&self) -> usize {
        self.free
    }

    /// For each node 1 where a component is unknown, 0 elsewhere.
    pub fn mask(&self) -> &[DVec3] {
        &self.mask
    }

    /// Prescribed components, sorted by node and component.
    pub fn prescribed(&self) -> &[Prescribed] {
        &self.prescribed
    }

    /// The displacement that is as prescribed, and zero where unknown.
    pub fn lifting(&self) -> Vec<DVec3> {
        let mut u = vec![DVec3::ZERO; self.mask.len()];
        for p in &self.prescribed {
            u[p.node as usize][p.component as usize] = p.value;
        }
        u
    }

    /// The unknowns as (node, component), in the order of their numbers.
    pub fn unknowns(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let component = |m: &DVec3, c: &usize| m[*c] != 0.0;
        self.mask
            .iter()
            .enumerate()
            .flat_map(move |(i, m)| (0..3).filter(move |c| component(m, c)).map(move |c| (i, c)))
    }
}

/// Difference of two prescribed displacements that counts as rounding, relative to their size and to the body's: two
/// expressions may mean the same.
const SAME: f64 = 1e-10;
const NOTHING: f64 = 1e-13;

/// The prescribed components of all supports, each once, sorted by node and component.
///
/// # Errors
/// [`FemError::ConflictingSupports`]; [`FemError::NotFiniteAt`] where an expression has no finite value.
pub fn prescribed(space: &Space<'_>, model: &Model) -> Result<Vec<Prescribed>, FemError> {
    let mut all = Vec::new();
    for (support, s) in model.supports.iter().enumerate() {
        let nodes = s.nodes(space);
        for (component, field) in s.displacement.iter().enumerate() {
            let Some(field) = field else { continue };
            for &node in &nodes {
                let value = field.at(space.points()[node as usize]);
                if !value.is_finite() {
                    return Err(FemError::not_finite_at("support", &s.name, field, space.points()[node as usize]));
                }
                all.push(Prescribed { node, component: component as u8, value, support: support as u32 });
            }
        }
    }
    merged(all, model, space.points(), space.mesh().diagonal())
}

/// The prescribed components of nodes at these places, each once, sorted by node and component.
///
/// # Errors
/// [`FemError::ConflictingSupports`].
pub(super) fn merged(
    mut all: Vec<Prescribed>,
    model: &Model,
    points: &[DVec3],
    diagonal: f64,
) -> Result<Vec<Prescribed>, FemError> {
    all.sort_unstable_by_key(|p| (p.node, p.component, p.support));
    let same = |a: &Prescribed, b: &Prescribed| (a.node, a.component) == (b.node, b.component);
    let nothing = NOTHING * diagonal;
    let rounding = |a: &Prescribed, b: &Prescribed| SAME * a.value.abs().max(b.value.abs()) + nothing;
    let differ = |a: &Prescribed, b: &Prescribed| (a.value - b.value).abs() > rounding(a, b);
    if let Some(pair) = all.windows(2).find(|w| same(&w[0], &w[1]) && differ(&w[0], &w[1])) {
        return Err(conflict(points, model, pair[0], pair[1]));
    }
    all.dedup_by(|b, a| same(a, b));
    Ok(all)
}

fn conflict(points: &[DVec3], model: &Model, a: Prescribed, b: Prescribed) -> FemError {
    let name = |p: Prescribed| model.supports[p.support as usize].name.clone();
    FemError::ConflictingSupports {
        first: name(a),
        second: name(b),
        axis: ["x", "y", "z"][a.component as usize],
        values: [a.value, b.value],
        vertex: a.node as usize,
        position: points[a.node as usize],
    }
}

//! Supports: which coefficients they prescribe.
//!
//! On a face only functions with a trace there count. Where a support's faces are bounded by creases these are its own, and
//! prescribing their coefficients prescribes the displacement on the faces and nothing beside them. Affine displacements are
//! exact with the values at the control points as coefficients; others are projected in the mean square over the faces.

use super::super::constraints::check_held;
use super::super::numbering::{Prescribed, merged};
use super::super::{FemError, Model, Support, Weakly, check};
use super::matrix::Mass;
use super::{HexSpace, Rule, Tables, face_area};
use crate::field::Field;
use crate::mesh::GroupId;
use crate::mesh::hex::{EDGES, FACES, HexMesh};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// Value of a function below which its trace counts as zero.
const NO_TRACE: f64 = 1e-12;

/// Relative deviation of a prescribed displacement from the field below which no projection is needed.
const EXACT: f64 = 1e-11;

/// How far, in the projection's own largest error, a coefficient may be from one that is prescribed already, and relative to
/// the values prescribed.
const FOLLOWED: f64 = 20.0;
const SAME: f64 = 1e-6;

/// Gauss points a direction of the projection.
const POINTS: usize = 5;

/// The coefficients that the supports of a model prescribe, each once, sorted by function and component.
///
/// # Errors
/// [`FemError::ConflictingSupports`]; [`FemError::NotFiniteAt`] where an expression has no finite value.
pub fn prescribed_on_hexes(space: &HexSpace<'_>, model: &Model) -> Result<Vec<Prescribed>, FemError> {
    let (mut all, mut to_project) = (Vec::new(), Vec::new());
    for (index, support) in (0..).zip(&model.supports) {
        if support.weakly.is_some() || support.displacement.iter().all(Option::is_none) {
            continue;
        }
        let traces = Rc::new(Traces::new(space, support));
        for (component, field) in (0..).zip(&support.displacement) {
            let Some(field) = field else { continue };
            let wanted = traces.wanted(support, field)?;
            match traces.at_control_points(space, field, &wanted) {
                Some(values) => all.extend(values.into_iter().map(|(node, value)| Prescribed {
                    node,
                    component,
                    value,
                    support: index,
                })),
                None => to_project.push((index, component, traces.clone(), wanted)),
            }
        }
    }
    // Projections keep what is prescribed already.
    let mut all = merged(all, model, space.points(), space.mesh().diagonal())?;
    for (support, component, traces, wanted) in to_project {
        let known: BTreeMap<u32, f64> =
            all.iter().filter(|p| p.component == component).map(|p| (p.node, p.value)).collect();
        let values = traces.projected(&wanted, &known);
        if let Some((node, [first, second])) = traces.contradiction(&wanted, &known) {
            let other = all.iter().find(|p| (p.node, p.component) == (node, component)).map_or(support, |p| p.support);
            let name = |index: u32| model.supports[index as usize].name.clone();
            return Err(FemError::ConflictingSupports {
                first: name(other),
                second: name(support),
                axis: ["x", "y", "z"][component as usize],
                values: [first, second],
                vertex: node as usize,
                position: space.whereabouts()[node as usize],
            });
        }
        all.extend(values.into_iter().map(|(node, value)| Prescribed { node, component, value, support }));
    }
    all.sort_unstable_by_key(|p| (p.node, p.component));
    Ok(all)
}

/// The functions of a support at points of its faces (or edges, where it meets another group).
struct Traces {
    /// Functions with a trace, ascending.
    functions: Vec<u32>,
    points: Vec<Trace>,
}

/// The functions at a point of a support.
struct Trace {
    cell: usize,
    x: DVec3,
    normal: DVec3,
    weight: f64,
    /// Functions and their values there.
    values: Vec<(u32, f64)>,
}

impl Traces {
    fn new(space: &HexSpace<'_>, support: &Support) -> Self {
        let meets = support.meets.map(|other| common_edges(space.mesh(), support.group, other));
        let rules: [Rule; 6] =
            std::array::from_fn(|k| if meets.is_some() { edges_rule(k) } else { Rule::face(k, POINTS) });
        let tables: [Tables; 6] = std::array::from_fn(|k| space.tables(rules[k].points.clone()));
        let mut points = Vec::new();
        for face in space.mesh().group_faces(support.group) {
            let (t, k) = space.cell_of_face(face);
            let table = tables[k].of(space, t);
            let edges = meets.as_ref().map(|meets| edges_among(space, t, k, meets));
            for (q, weight) in rules[k].weights.iter().enumerate() {
                if edges.is_some_and(|edges| !edges[q / POINTS]) {
                    continue;
                }
                let (x, jacobian) = space.frame(t, &table, q);
                let values = space.cell(t).iter().copied().zip(table.values_at(q).iter().copied());
                let values = values.filter(|(_, n)| n.abs() > NO_TRACE).collect();
                let area = face_area(k, &jacobian);
                points.push(Trace {
                    cell: t,
                    x,
                    normal: area.normalize_or_zero(),
                    weight: weight * area.length(),
                    values,
                });
            }
        }
        let mut functions: Vec<u32> = points.iter().flat_map(|p| &p.values).map(|f| f.0).collect();
        functions.sort_unstable();
        functions.dedup();
        Self { functions, points }
    }

    /// The values of a field at the points.
    fn wanted(&self, support: &Support, field: &Field) -> Result<Vec<f64>, FemError> {
        let at = |p: &Trace| {
            let value = field.at(p.x);
            if value.is_finite() {
                Ok(value)
            } else {
                Err(FemError::not_finite_at("support", &support.name, field, p.x))
            }
        };
        self.points.iter().map(at).collect()
    }

    /// The field at nodes or control points as coefficients: right for nodes, and at control points if the field is affine.
    fn at_control_points(&self, space: &HexSpace<'_>, field: &Field, wanted: &[f64]) -> Option<Vec<(u32, f64)>> {
        // A control point may lie where the field has no value.
        let guess = |v: &u32| if (*v as usize) < space.placed() { field.at(space.points()[*v as usize]) } else { 0.0 };
        let values: Vec<f64> = self.functions.iter().map(guess).collect();
        let got = |p: &Trace| p.values.iter().map(|(v, n)| n * values[self.place(*v)]).sum::<f64>();
        let size = wanted.iter().map(|w| w.abs()).fold(0.0, f64::max);
        let fits = |(p, w): (&Trace, &f64)| (got(p) - w).abs() <= EXACT * size;
        let right = !space.element().is_smooth() || self.points.iter().zip(wanted).all(fits);
        (right && values.iter().all(|v| v.is_finite())).then(|| self.functions.iter().copied().zip(values).collect())
    }

    /// The coefficients that are not known yet, of the function nearest to the field in the mean square over the faces.
    fn projected(&self, wanted: &[f64], known: &BTreeMap<u32, f64>) -> Vec<(u32, f64)> {
        let (mut entries, mut right) = (Vec::new(), vec![DVec3::ZERO; self.functions.len()]);
        for (p, wanted) in self.points.iter().zip(wanted) {
            for &(i, a) in p.values.iter().filter(|(i, _)| !known.contains_key(i)) {
                right[self.place(i)].x += p.weight * a * wanted;
                for &(j, b) in &p.values {
                    match known.get(&j) {
                        Some(value) => right[self.place(i)].x -= p.weight * a * b * value,
                        None => entries.push((self.place(i) as u32, self.place(j) as u32, p.weight * a * b)),
                    }
                }
            }
        }
        let values = Mass::new(self.functions.len(), entries).solve(&right);
        let unknown = self.functions.iter().copied().zip(values).filter(|(v, _)| !known.contains_key(v));
        unknown.map(|(v, x)| (v, x.x)).collect()
    }

    /// A coefficient that is known otherwise than the field itself would have it, with both values. What a smooth function
    /// cannot follow is no contradiction: its own projection then misses the field as well.
    fn contradiction(&self, wanted: &[f64], known: &BTreeMap<u32, f64>) -> Option<(u32, [f64; 2])> {
        if !self.functions.iter().any(|v| known.contains_key(v)) {
            return None;
        }
        let free: BTreeMap<u32, f64> = self.projected(wanted, &BTreeMap::new()).into_iter().collect();
        let got = |p: &Trace| p.values.iter().map(|(v, n)| n * free.get(v).unwrap_or(&0.0)).sum::<f64>();
        let misses = self.points.iter().zip(wanted).map(|(p, w)| (got(p) - w).abs()).fold(0.0, f64::max);
        let size = wanted.iter().map(|w| w.abs()).fold(0.0, f64::max);
        let differs = |(v, value): (&u32, &f64)| {
            let own = *free.get(v)?;
            let most = FOLLOWED * misses + SAME * size.max(value.abs());
            ((own - value).abs() > most).then_some((*v, [*value, own]))
        };
        known.iter().find_map(differs)
    }

    fn place(&self, v: u32) -> usize {
        self.functions.binary_search(&v).unwrap_or(0)
    }
}

/// The edges where faces of two groups meet.
#[must_use]
pub fn common_edges(mesh: &HexMesh, group: GroupId, other: GroupId) -> BTreeSet<u32> {
    let topology = mesh.topology();
    let edges = |group| -> BTreeSet<u32> {
        let faces = mesh.group_faces(group).map(|f| topology.boundary_number(f));
        faces.flat_map(|f| topology.face_edges()[f as usize]).collect()
    };
    edges(group).intersection(&edges(other)).copied().collect()
}

/// The edges of face `k` of a cell, in the order of [`EDGES`].
fn edges_of_face(k: usize) -> impl Iterator<Item = usize> {
    (0..EDGES.len()).filter(move |e| EDGES[*e].iter().all(|c| FACES[k].contains(c)))
}

/// Which edges of face `k` of cell `t` are among `edges`.
fn edges_among(space: &HexSpace<'_>, t: usize, k: usize, edges: &BTreeSet<u32>) -> [bool; 4] {
    let mut among = [false; 4];
    let own = edges_of_face(k).map(|e| space.mesh().topology().cell_edges()[t][e]);
    among.iter_mut().zip(own).for_each(|(among, e)| *among = edges.contains(&e));
    among
}

/// Gauss points on the four edges of face `k` of a cell.
fn edges_rule(k: usize) -> Rule {
    let corner = |c: usize| DVec3::new((c & 1) as f64, (c >> 1 & 1) as f64, (c >> 2) as f64);
    // The first line of a face's rule.
    let line = Rule::face(0, POINTS);
    let mut rule = Rule::default();
    for [a, b] in edges_of_face(k).map(|e| EDGES[e]) {
        for q in 0..POINTS {
            rule.points.push(corner(a).lerp(corner(b), line.points[q].y));
            rule.weights.push(line.weights[q]);
        }
    }
    rule
}

/// Checks that the supports of a model leave no rigid motion of any part free, with the supports' traces as conditions.
///
/// # Errors
/// [`FemError::FreeMotion`] names the motion; others as [`super::assemble_hexes`].
pub fn check_hex_constraints(space: &HexSpace<'_>, model: &Model) -> Result<(), FemError> {
    check::check(space.mesh(), model)?;
    let (part_of, count) = space.mesh().connected_parts();
    let mut held = Vec::new();
    for (index, support) in model.supports.iter().enumerate() {
        let components = (0..3).filter(|&c| support.displacement[c].is_some() || support.stiffness[c] > 0.0);
        let axes: Vec<DVec3> = components.map(|c| DVec3::AXES[c]).collect();
        for p in Traces::new(space, support).points {
            let normal = (support.weakly == Some(Weakly::Normal)).then_some(p.normal);
            held.extend(axes.iter().copied().chain(normal).map(|d| (part_of[p.cell], p.x, d, index)));
        }
    }
    check_held(space.mesh().points(), space.mesh().cells(), (&part_of, count), &held)
}

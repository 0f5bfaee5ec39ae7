//! `[supports]` and `[loads]`: what holds and what acts.

use super::error::Fault;
use super::fields::{field, vector_field};
use super::numbers::{Checked, outside, vector};
use super::raw::{Named, RawLoad, RawSelector, RawSupport, Table};
use super::selector::{KINDS, Selector, at_most_one, no_selector, one};
use super::spanned::Spanned;
use crate::field::{Field, VectorField};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, de};
use std::{fmt, ops::Range};

/// What holds the solid.
#[derive(Debug, Clone, PartialEq)]
pub struct Support {
    /// Name of its table.
    pub name: String,
    /// Where it is written.
    pub place: String,
    /// The boundary faces it acts on.
    pub selector: Selector,
    /// If given, it acts only on the edges where these faces meet those.
    pub meets: Option<Selector>,
    /// Prescribed displacement in x, y, z; `None` where free.
    pub displacement: [Option<Field>; 3],
    /// Whether the displacement normal to the faces, which lie in planes of one normal, is zero.
    pub sliding: bool,
    /// Whether the displacement is that of `[exact]`.
    pub exact: bool,
    /// Whether it holds in the mean over its faces instead of at nodes or control points.
    pub weak: bool,
    /// Stiffness of an elastic foundation in x, y, z: force per area and displacement.
    pub stiffness: DVec3,
}

/// A load.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// Name of its table.
    pub name: String,
    /// Where it is written.
    pub place: String,
    /// What acts where.
    pub kind: LoadKind,
}

/// What a load does.
#[derive(Debug, Clone, PartialEq)]
pub enum LoadKind {
    /// Force per area.
    Traction(Selector, VectorField),
    /// Force per area against the outward normal.
    Pressure(Selector, Field),
    /// Total force, spread evenly over the area.
    Force(Selector, DVec3),
    /// Force (second) at a point (first).
    PointForce(DVec3, DVec3),
    /// Force per volume on all cells.
    BodyForce(VectorField),
    /// Acceleration of all cells.
    Gravity(DVec3),
}

/// A direction that a support can fix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Direction {
    X,
    Y,
    Z,
    Normal,
    Exact,
}

/// `fix`: one direction or several.
#[derive(Debug, JsonSchema)]
#[schemars(untagged)]
pub(super) enum Fixed {
    One(Direction),
    Many(Vec<Spanned<Direction>>),
}

impl<'de> Deserialize<'de> for Fixed {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FixedVisitor)
    }
}

struct FixedVisitor;

impl<'de> de::Visitor<'de> for FixedVisitor {
    type Value = Fixed;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array such as [\"x\", \"y\"], \"normal\" or \"exact\"")
    }

    fn visit_str<E: de::Error>(self, name: &str) -> Result<Fixed, E> {
        Direction::deserialize(de::value::StrDeserializer::new(name)).map(Fixed::One)
    }

    fn visit_seq<A: de::SeqAccess<'de>>(self, list: A) -> Result<Fixed, A::Error> {
        Vec::deserialize(de::value::SeqAccessDeserializer::new(list)).map(Fixed::Many)
    }
}

/// `spring`: one stiffness, or one each direction.
#[derive(Debug, JsonSchema)]
#[schemars(untagged)]
pub(super) enum RawStiffness {
    One(f64),
    Many(Vec<f64>),
}

impl<'de> Deserialize<'de> for RawStiffness {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(StiffnessVisitor)
    }
}

struct StiffnessVisitor;

impl<'de> de::Visitor<'de> for StiffnessVisitor {
    type Value = RawStiffness;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or three numbers")
    }

    fn visit_f64<E>(self, k: f64) -> Result<RawStiffness, E> {
        Ok(RawStiffness::One(k))
    }

    fn visit_i64<E>(self, k: i64) -> Result<RawStiffness, E> {
        Ok(RawStiffness::One(k as f64))
    }

    fn visit_seq<A: de::SeqAccess<'de>>(self, list: A) -> Result<RawStiffness, A::Error> {
        Vec::deserialize(de::value::SeqAccessDeserializer::new(list)).map(RawStiffness::Many)
    }
}

type Place<'a> = &'a dyn Fn(&Range<usize>) -> String;

/// The supports, by name; `known` says whether there is an exact solution.
pub(super) fn supports(raw: Named<RawSupport>, known: bool, place: Place) -> Checked<Vec<Support>> {
    raw.into_iter().map(|(name, table)| support(name, table, known, place)).collect()
}

/// The loads, by name.
pub(super) fn loads(raw: Named<RawLoad>, place: Place) -> Checked<Vec<Load>> {
    raw.into_iter().map(|(name, table)| load(name, table, place)).collect()
}

fn support(name: String, Table { span, mut value }: Table<RawSupport>, known: bool, place: Place) -> Checked<Support> {
    let mut displacement = [None, None, None];
    if let Some(Table { value: given, .. }) = &value.displacement {
        for (slot, x) in displacement.iter_mut().zip([&given.x, &given.y, &given.z]) {
            *slot = x.as_ref().map(field).transpose()?;
        }
    }
    let mut normal = value.symmetry.as_ref().filter(|s| *s.get_ref()).map(Spanned::span);
    let mut exact = None;
    for direction in directions(value.fix.as_ref()) {
        match direction.get_ref() {
            Direction::Normal => {
                normal = Some(direction.span());
                continue;
            }
            Direction::Exact => {
                exact = Some(direction.span());
                continue;
            }
            _ => {}
        }
        let slot = &mut displacement[*direction.get_ref() as usize];
        if slot.is_some() {
            let fault = Fault::new(direction.span(), "is prescribed twice", "named before");
            return Err(fault.help("name each direction once"));
        }
        *slot = Some(Field::ZERO);
    }
    let prescribes = displacement.iter().any(Option::is_some);
    if let (Some(span), true) = (&exact, prescribes || normal.is_some() || !known) {
        let fault = Fault::new(span.clone(), "asks for the exact displacement", "of [exact], and all of it");
        return Err(fault.help("name a solution in [exact], and nothing else here"));
    }
    if let (Some(span), true) = (&normal, prescribes) {
        let fault = Fault::new(span.clone(), "stands beside other directions", "the normal direction alone");
        return Err(fault.help("make two supports: one for the normal direction, one for x, y, z"));
    }
    let stiffness = value.spring.as_ref().map(stiffness).transpose()?.unwrap_or(DVec3::ZERO);
    let free = normal.is_none() && exact.is_none() && !prescribes;
    if free && stiffness == DVec3::ZERO {
        return Err(Fault::new(span, "prescribes nothing", "which directions?").help(
            "add fix = [\"x\", \"y\", \"z\"], displacement = { y = -0.1 } (free where not named), fix = \"normal\" \
             (sliding, symmetry) or spring = 1e6 (per area)",
        ));
    }
    let weak = value.weak.as_ref().filter(|weak| *weak.get_ref());
    if let (Some(weak), true) = (weak, free || value.meet.is_some()) {
        let fault = Fault::new(weak.span(), "is for a displacement held on faces", "of what?");
        return Err(fault.help("name it with fix or displacement, or leave `weak` out"));
    }
    let weak = weak.is_some();
    let meet = value.meet.take();
    if let (Some(meet), true) = (&meet, normal.is_some() || stiffness != DVec3::ZERO) {
        let fault = Fault::new(meet.span(), "is an edge, which has no normal and no area", "an edge");
        return Err(fault.help("edges take fix = [\"x\", \"y\", \"z\"] and displacement = { .. }"));
    }
    let (selector, meets) = match meet {
        None => (one(value.into(), &span)?, None),
        Some(meet) => edge(meet, at_most_one(value.into())?)?,
    };
    let (sliding, exact, place) = (normal.is_some(), exact.is_some(), place(&span));
    Ok(Support { name, place, selector, meets, displacement, sliding, exact, weak, stiffness })
}

/// The two selectors of faces that meet at an edge; `beside` is a selector that stands beside them.
fn edge(meet: Spanned<Vec<Table<RawSelector>>>, beside: Option<Selector>) -> Checked<(Selector, Option<Selector>)> {
    let span = meet.span();
    let example = "meet = [{ group = \"x-min\" }, { group = \"z-min\" }] alone: the edges where their faces meet";
    match <[Table<RawSelector>; 2]>::try_from(meet.into_inner()) {
        Ok([a, b]) if beside.is_none() => Ok((one(a.value, &a.span)?, Some(one(b.value, &b.span)?))),
        Ok(_) => Err(Fault::new(span, "stands beside a selector", "faces or an edge?").help(example)),
        Err(_) => Err(Fault::new(span, "takes two selectors", "of which faces?").help(example)),
    }
}

/// The directions of `fix`, each with its place.
fn directions(fix: Option<&Spanned<Fixed>>) -> Vec<Spanned<Direction>> {
    match fix {
        None => Vec::new(),
        Some(one) => match one.get_ref() {
            Fixed::One(direction) => vec![Spanned::new(one.span(), *direction)],
            Fixed::Many(list) => list.clone(),
        },
    }
}

/// Three finite numbers that are not negative, and not all zero.
fn stiffness(raw: &Spanned<RawStiffness>) -> Checked<DVec3> {
    let k = match raw.get_ref() {
        RawStiffness::One(k) => DVec3::splat(*k),
        RawStiffness::Many(list) => vector(&Spanned::new(raw.span(), list.clone()))?,
    };
    let sound = k.is_finite() && k.min_element() >= 0.0 && k.max_element() > 0.0;
    let range = "one or three stiffnesses per area, finite, not negative, not all zero";
    if sound { Ok(k) } else { Err(outside(raw.span(), &k, range)) }
}

fn load(name: String, Table { span, value }: Table<RawLoad>, place: Place) -> Checked<Load> {
    check_one_kind(&value)?;
    let RawLoad { traction, pressure, force, point, body_force, gravity, .. } = &value;
    let (traction, pressure) = (traction.as_ref().map(vector_field), pressure.as_ref().map(field));
    let (force, gravity) = (force.as_ref().map(vector), gravity.as_ref().map(vector));
    let (body_force, at) = (body_force.as_ref().map(vector_field), point.as_ref().map(vector).transpose()?);
    if let (Some(point), None) = (point, &force) {
        return Err(Fault::new(point.span(), "goes with `force`", "no force acts here").help("add force = [x, y, z]"));
    }
    let selector = at_most_one(value.into())?;
    let target = |selector: Option<Selector>| selector.ok_or_else(|| no_selector(&span));
    let everywhere = |what: &str, selector: &Option<Selector>| match selector {
        Some(_) => Err(Fault::new(span.clone(), format!("has a selector, but {what}"), "this load")
            .help(format!("remove the selector ({KINDS})"))),
        None => Ok(()),
    };
    let kind = if let Some(t) = traction {
        LoadKind::Traction(target(selector)?, t?)
    } else if let Some(p) = pressure {
        LoadKind::Pressure(target(selector)?, p?)
    } else if let (Some(f), Some(at)) = (&force, at) {
        everywhere("a force at a point needs none", &selector)?;
        LoadKind::PointForce(at, f.clone()?)
    } else if let Some(f) = force {
        LoadKind::Force(target(selector)?, f?)
    } else if let Some(b) = body_force {
        everywhere("a body force acts on all cells", &selector)?;
        LoadKind::BodyForce(b?)
    } else if let Some(g) = gravity {
        everywhere("gravity acts on all cells", &selector)?;
        LoadKind::Gravity(g?)
    } else {
        return Err(Fault::new(span, "does not say what acts", "which load?").help(LOADS));
    };
    let place = place(&span);
    Ok(Load { name, place, kind })
}

const LOADS: &str = "a load has one of traction = [x, y, z] (per area), pressure = p, force = [x, y, z] (total; with \
                     point = [x, y, z] at a point), body_force = [x, y, z] (per volume), gravity = [x, y, z]";

/// Refuses a second kind of load in a table.
fn check_one_kind(raw: &RawLoad) -> Checked<()> {
    let given = [
        ("traction", raw.traction.as_ref().map(Spanned::span)),
        ("pressure", raw.pressure.as_ref().map(Spanned::span)),
        ("force", raw.force.as_ref().map(Spanned::span)),
        ("body_force", raw.body_force.as_ref().map(Spanned::span)),
        ("gravity", raw.gravity.as_ref().map(Spanned::span)),
    ];
    let given: Vec<_> = given.into_iter().filter_map(|(key, span)| Some((key, span?))).collect();
    match &given[..] {
        [(first, _), (_, second), ..] => {
            let problem = format!("stands beside `{first}`: a load has one kind");
            let fault = Fault::new(second.clone(), problem, "the second kind");
            Err(fault.help(format!("{LOADS}; make two loads")))
        }
        _ => Ok(()),
    }
}

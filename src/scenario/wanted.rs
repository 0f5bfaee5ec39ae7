//! What is asked of a solution: quantities, probes, and what they are expected to be.

use super::error::Fault;
use super::numbers::{Checked, finite, integer, outside, positive, vector};
use super::raw::{Integer, Named, Number, RawExact, RawQuantity, Table, Text, Vector};
use super::selector::{Selector, at_most_one, brick_corners};
use super::spanned::Spanned;
use super::suggest;
use crate::fem::options::{ExactSolution, Field, Total};
use glam::DVec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::ops::Range;

/// Most points of a probe.
const MAX_POINTS: i64 = 1_000_000;

/// A named number of the solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Name of its table.
    pub name: String,
    /// Where it is written.
    pub place: String,
    /// What.
    pub kind: QuantityKind,
}

/// What a quantity is.
#[derive(Debug, Clone, PartialEq)]
pub enum QuantityKind {
    /// Mean of a field.
    Average(Field, Extent),
    /// Maximum of a field.
    Maximum(Field, Extent),
    /// Value of a field at a point.
    Value(Field, DVec3),
    /// Integral over cells.
    Total(Total, Cells),
    /// Component 0, 1, 2 of the force that the support of this name exerts.
    Reaction(String, usize),
}

/// Where a field is averaged or searched.
#[derive(Debug, Clone, PartialEq)]
pub enum Extent {
    /// Boundary faces.
    Faces(Selector),
    /// The inside.
    Cells(Cells),
}

/// The cells of a region (all if absent), and of these what lies in a box (smallest and largest coordinates).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cells {
    /// Name of the region.
    pub region: Option<String>,
    /// The box.
    pub within: Option<[DVec3; 2]>,
}

/// Points on a line at which the solution is written.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// Name of its table, which names its file.
    pub name: String,
    /// Where it is written.
    pub place: String,
    /// First point.
    pub from: DVec3,
    /// Last point.
    pub to: DVec3,
    /// Number of points, both ends included.
    pub points: usize,
}

/// The solution that is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Exact {
    /// Where it is written.
    pub place: String,
    /// Which.
    pub solution: ExactSolution,
    /// The faces on which its tractions act as loads.
    pub tractions: Option<Selector>,
}

/// What a quantity is expected to be at the last step.
#[derive(Debug, Clone, PartialEq)]
pub struct Expectation {
    /// The quantity, which exists, or a figure that every run has.
    pub subject: Subject,
    /// What it has to be.
    pub bound: Bound,
    /// Where that is from.
    pub source: Option<String>,
}

/// Of what something is expected.
#[derive(Debug, Clone, PartialEq)]
pub enum Subject {
    /// A quantity of the scenario, which exists.
    Quantity(String),
    /// A figure of the run.
    Figure(Figure),
}

impl Subject {
    /// The name of its table in `[expect]`.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Quantity(name) => name,
            Self::Figure(figure) => figure.name(),
        }
    }
}

/// A figure of a run that can be expected without being asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Figure {
    /// Half of u.K.u.
    StrainEnergy,
    /// The estimated relative error in the energy norm.
    RelativeError,
    /// The true one, where the solution is known.
    TrueRelativeError,
    /// The estimated over the true error, where the solution is known.
    Effectivity,
}

impl Figure {
    const ALL: [Self; 4] = [Self::StrainEnergy, Self::RelativeError, Self::TrueRelativeError, Self::Effectivity];

    /// The name of its table in `[expect]`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::StrainEnergy => "strain-energy",
            Self::RelativeError => "relative-error",
            Self::TrueRelativeError => "true-relative-error",
            Self::Effectivity => "effectivity",
        }
    }

    /// Whether only a run with a known solution has it.
    fn needs_exact(self) -> bool {
        matches!(self, Self::TrueRelativeError | Self::Effectivity)
    }
}

/// What a number has to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// A value, within a tolerance.
    Near(f64, Tolerance),
    /// From one number to another.
    Between(f64, f64),
}

/// How far from a value is well.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tolerance {
    /// In the units of the value.
    Absolute(f64),
    /// As a fraction of the value.
    Relative(f64),
}

impl Tolerance {
    /// The distance from `value` that is allowed.
    #[must_use]
    pub fn distance(self, value: f64) -> f64 {
        match self {
            Self::Absolute(distance) => distance,
            Self::Relative(fraction) => fraction * value.abs(),
        }
    }
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawProbe {
    from: Vector,
    to: Vector,
    points: Integer,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawExpectation {
    value: Option<Number>,
    tolerance: Option<Table<RawTolerance>>,
    between: Option<Spanned<Vec<f64>>>,
    source: Option<String>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RawTolerance {
    absolute: Option<Number>,
    relative: Option<Number>,
}

type Place<'a> = &'a dyn Fn(&Range<usize>) -> String;

const KINDS: &str = "a quantity has one of average = \"uz\", maximum = \"von-mises\", value = \"ux\" (with point = [x, y, z]), \
                     total = \"strain-energy\", reaction = \"<support>\" (with component = \"x\")";

/// Checks `[quantities]`; `supports` are the names of the supports there are.
pub(super) fn quantities(raw: Named<RawQuantity>, supports: &[&str], place: Place) -> Checked<Vec<Quantity>> {
    let one = |(name, table): (String, Table<RawQuantity>)| {
        Ok(Quantity { name, place: place(&table.span), kind: kind(table, supports)? })
    };
    raw.into_iter().map(one).collect()
}

fn kind(Table { span, value: mut raw }: Table<RawQuantity>, supports: &[&str]) -> Checked<QuantityKind> {
    check_one_kind(&raw, &span)?;
    goes_with(raw.point.as_ref().map(Spanned::span), "value", raw.value.is_some())?;
    goes_with(raw.component.as_ref().map(Spanned::span), "reaction", raw.reaction.is_some())?;
    if let Some(field) = raw.value.take() {
        return value_at(field.into_inner(), raw, span);
    }
    if let Some(support) = raw.reaction.take() {
        return reaction_of(support, raw, span, supports);
    }
    let (average, maximum, total) = (raw.average.take(), raw.maximum.take(), raw.total.take());
    match (average, maximum, total, extent(raw)?) {
        (Some(field), _, _, extent) => Ok(QuantityKind::Average(field.into_inner(), extent)),
        (_, Some(field), _, extent) => Ok(QuantityKind::Maximum(field.into_inner(), extent)),
        (_, _, Some(total), Extent::Cells(cells)) => Ok(QuantityKind::Total(total.into_inner(), cells)),
        _ => Err(Fault::new(span, "is a total over cells, but has a selector of faces", "this quantity")
            .help("remove the selector; a part of the cells is named by region = \"...\" or within = { min, max }")),
    }
}

/// Refuses a key at `written` that belongs to a kind which is not there.
fn goes_with(written: Option<Range<usize>>, kind: &str, is_there: bool) -> Checked<()> {
    match written {
        Some(span) if !is_there => Err(Fault::new(span, format!("goes with `{kind}` only"), "remove this").help(KINDS)),
        _ => Ok(()),
    }
}

fn lacks(span: Range<usize>, key: &str, example: &str) -> Fault {
    Fault::new(span, format!("lacks `{key}`"), format!("`{key}` is missing here"))
        .help(format!("for example {example}"))
}

fn value_at(field: Field, mut raw: RawQuantity, span: Range<usize>) -> Checked<QuantityKind> {
    let point = raw.point.take().ok_or_else(|| lacks(span.clone(), "point", "point = [0, 0, 0]"))?;
    no_extent(raw, &span, "`value` is at a point")?;
    Ok(QuantityKind::Value(field, vector(&point)?))
}

fn reaction_of(support: Text, mut raw: RawQuantity, span: Range<usize>, supports: &[&str]) -> Checked<QuantityKind> {
    let component = raw.component.take().ok_or_else(|| lacks(span.clone(), "component", "component = \"z\""))?;
    no_extent(raw, &span, "`reaction` acts where its support does")?;
    if !supports.contains(&support.get_ref().as_str()) {
        let help = suggest::help(support.get_ref(), "supports", supports);
        let problem = format!("is {:?}, which is not a support", support.get_ref());
        return Err(Fault::new(support.span(), problem, "unknown support").help(help));
    }
    Ok(QuantityKind::Reaction(support.into_inner(), component.into_inner() as usize))
}

/// Refuses a table with no kind or two.
fn check_one_kind(raw: &RawQuantity, span: &Range<usize>) -> Checked<()> {
    let given = [
        ("average", raw.average.as_ref().map(Spanned::span)),
        ("maximum", raw.maximum.as_ref().map(Spanned::span)),
        ("value", raw.value.as_ref().map(Spanned::span)),
        ("total", raw.total.as_ref().map(Spanned::span)),
        ("reaction", raw.reaction.as_ref().map(Spanned::span)),
    ];
    let given: Vec<_> = given.into_iter().filter_map(|(key, span)| Some((key, span?))).collect();
    match &given[..] {
        [] => Err(Fault::new(span.clone(), "does not say what it is", "which quantity?").help(KINDS)),
        [(first, _), (_, second), ..] => {
            let problem = format!("stands beside `{first}`: a quantity has one kind");
            Err(Fault::new(second.clone(), problem, "the second kind").help(KINDS))
        }
        _ => Ok(()),
    }
}

/// The extent that the keys left in a table name: the whole inside if none.
fn extent(raw: RawQuantity) -> Checked<Extent> {
    let (mut raw, mut cells) = (raw, Cells::default());
    let within = raw.within.take();
    let inside = raw.region.as_ref().map(Spanned::span).or(within.as_ref().map(|t| t.span.clone()));
    cells.region = raw.region.take().map(Spanned::into_inner);
    cells.within =
        within.as_ref().map(|w| brick_corners(&w.value.min, &w.value.max)).transpose()?.map(|(min, max)| [min, max]);
    match (at_most_one(raw.into())?, inside) {
        (Some(_), Some(inside)) => Err(Fault::new(inside, "stands beside a selector of faces", "faces or cells?")
            .help("keep one of them: selectors choose boundary faces, `region` and `within` the inside")),
        (Some(selector), None) => Ok(Extent::Faces(selector)),
        (None, _) => Ok(Extent::Cells(cells)),
    }
}

fn no_extent(raw: RawQuantity, span: &Range<usize>, why: &str) -> Checked<()> {
    match extent(raw)? {
        Extent::Cells(cells) if cells == Cells::default() => Ok(()),
        _ => Err(Fault::new(span.clone(), format!("names a place, but {why}"), "this quantity")
            .help("remove the selector, `region` or `within`")),
    }
}

/// Checks `[exact]`.
pub(super) fn exact(Table { span, value: raw }: Table<RawExact>, place: Place) -> Checked<Exact> {
    let example = "solution = \"smooth-cube\"";
    let solution = raw.solution.ok_or_else(|| lacks(span.clone(), "solution", example))?;
    Ok(Exact { place: place(&span), solution, tractions: at_most_one(raw.into())? })
}

/// Checks `[probes]`.
pub(super) fn probes(raw: Named<RawProbe>, place: Place) -> Checked<Vec<Probe>> {
    let one = |(name, Table { span, value: raw }): (String, Table<RawProbe>)| {
        let allowed = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
        if !name.chars().all(allowed) {
            return Err(Fault::new(span, "has a name that no file can take", "this name")
                .help("its results go to probe_<name>.csv: use letters, digits, - and _"));
        }
        let points = integer(&raw.points, 2..=MAX_POINTS)?;
        let (from, to) = (vector(&raw.from)?, vector(&raw.to)?);
        if from == to {
            return Err(Fault::new(raw.to.span(), "is the point it starts `from`", "the same point")
                .help("a line has two ends; for one point use [quantities.<name>] with value and point"));
        }
        Ok(Probe { name, place: place(&span), from, to, points })
    };
    raw.into_iter().map(one).collect()
}

/// Checks `[expect]`; each table bears the name of a quantity, or of a figure that every run has (`known`: with a known
/// solution).
pub(super) fn expectations(
    raw: Named<RawExpectation>,
    quantities: &[Quantity],
    known: bool,
) -> Checked<Vec<Expectation>> {
    let one = |(name, Table { span, value: raw }): (String, Table<RawExpectation>)| {
        let subject = subject(name, &span, quantities, known)?;
        Ok(Expectation { subject, bound: bound(&raw, span)?, source: raw.source })
    };
    raw.into_iter().map(one).collect()
}

/// What an expectation of this name is of.
fn subject(name: String, span: &Range<usize>, quantities: &[Quantity], known: bool) -> Checked<Subject> {
    if quantities.iter().any(|q| q.name == name) {
        return Ok(Subject::Quantity(name));
    }
    if let Some(figure) = Figure::ALL.into_iter().find(|f| f.name() == name) {
        if figure.needs_exact() && !known {
            let fault = Fault::new(span.clone(), "needs a known solution", "the true error is not known");
            return Err(fault.help("add [exact] with solution = \"...\", or expect something else"));
        }
        return Ok(Subject::Figure(figure));
    }
    let figures = Figure::ALL.map(Figure::name);
    let names: Vec<&str> = quantities.iter().map(|q| q.name.as_str()).chain(figures).collect();
    let help = if quantities.is_empty() {
        let figures = figures.join(", ");
        format!("the scenario has no quantities: add [quantities.{name}] ({KINDS}); every run has {figures}")
    } else {
        suggest::help(&name, "quantities", &names)
    };
    Err(Fault::new(span.clone(), "is not the name of a quantity", "of which quantity?").help(help))
}

/// What a number has to be: a value within a tolerance, or a range.
fn bound(raw: &RawExpectation, span: Range<usize>) -> Checked<Bound> {
    const FORMS: &str = "value = 1.0 with tolerance = { relative = 0.01 }, or between = [0.9, 1.1]";
    match (&raw.value, &raw.tolerance, &raw.between) {
        (Some(value), Some(tolerance), None) => {
            let value = finite(value)?;
            Ok(Bound::Near(value, self::tolerance(tolerance, value)?))
        }
        (None, None, Some(between)) => match between.get_ref()[..] {
            [low, high] if low.is_finite() && high.is_finite() && low < high => Ok(Bound::Between(low, high)),
            _ => Err(outside(between.span(), &format!("{:?}", between.get_ref()), "two numbers, the smaller first")),
        },
        (.., Some(between)) => {
            Err(Fault::new(between.span(), "stands beside a value", "one of the two").help(format!("say {FORMS}")))
        }
        (None, ..) => Err(lacks(span, "value", FORMS)),
        (_, None, _) => Err(lacks(span, "tolerance", "tolerance = { relative = 0.01 } or { absolute = 1e-3 }")),
    }
}

fn tolerance(raw: &Table<RawTolerance>, value: f64) -> Checked<Tolerance> {
    match (&raw.value.absolute, &raw.value.relative) {
        (Some(x), None) => Ok(Tolerance::Absolute(positive(x)?)),
        (None, Some(x)) if value == 0.0 => Err(Fault::new(x.span(), "is relative to a value of zero", "relative to 0")
            .help("say tolerance = { absolute = ... }")),
        (None, Some(x)) => Ok(Tolerance::Relative(positive(x)?)),
        _ => Err(Fault::new(raw.span.clone(), "must name one bound", "exactly one")
            .help("{ relative = 0.01 } or { absolute = 1e-3 }")),
    }
}

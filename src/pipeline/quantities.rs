//! What a scenario asks of a solution, from its words to numbers: quantities, probes, expectations.

use super::analyse::Analysed;
use super::resolve::{Body, Resolved, Targets, check_density, properties};
use super::{ModelError, span};
use crate::error::Error;
use crate::fem::options::{ExactSolution, Total};
use crate::fem::{self, State, SymTensor};
use crate::mesh::locate::Locator;
use crate::mesh::{RegionId, Tagged, TetMesh};
use crate::output::csv::write_csv;
use crate::output::report::{ExpectationRecord, QuantityRecord, Report, StepRecord};
use crate::output::table::short;
use crate::scenario::{
    Bound, Cells, Exact, Expectation, Extent, Figure, Material, Probe, Quantity, QuantityKind, Scenario, Subject,
    suggest,
};
use glam::DVec3;
use std::cell::LazyCell;
use std::path::Path;

/// Distance from the mesh at which a point counts as outside, as a fraction of the diagonal of the bounding box.
pub(super) const OUTSIDE: f64 = 1e-6;

/// The columns of a probe's table.
const COLUMNS: [&str; 14] =
    ["s", "x", "y", "z", "ux", "uy", "uz", "sxx", "syy", "szz", "sxy", "syz", "sxz", "von_mises"];

/// The quantities of a scenario on its mesh; faces become groups.
///
/// # Errors
/// [`ModelError`]: a selector or a box that holds nothing, a region or group that does not exist, a point outside, the mass
/// of a material of unknown density.
pub(super) fn resolve(
    scenario: &Scenario,
    chosen: &[&Material],
    targets: &mut Targets<impl Body>,
) -> Result<Vec<fem::Quantity>, ModelError> {
    let mut quantities = Vec::new();
    for q in &scenario.quantities {
        let kind = match &q.kind {
            QuantityKind::Average(field, e) => fem::QuantityKind::Average(*field, extent(q, e, targets)?),
            QuantityKind::Maximum(field, e) => fem::QuantityKind::Maximum(*field, extent(q, e, targets)?),
            QuantityKind::Value(field, point) => fem::QuantityKind::Value(*field, *point),
            QuantityKind::Total(what, c) => {
                let cells = cells(q, c, &targets.body)?;
                if *what == Total::Mass {
                    let materials = cells.region.map_or(chosen, |r| &chosen[usize::from(r.0)..=usize::from(r.0)]);
                    check_density(format!("quantity `{}` is a mass", q.name), &q.place, materials)?;
                }
                fem::QuantityKind::Total(*what, cells)
            }
            QuantityKind::Reaction(support, component) => {
                // The scenario was checked to have this support; the model has them in the same order.
                let index = scenario.supports.iter().position(|s| s.name == *support).unwrap_or(0);
                fem::QuantityKind::Reaction(index, *component)
            }
        };
        quantities.push(fem::Quantity { name: q.name.clone(), kind });
    }
    check_points(scenario, &targets.body)?;
    Ok(quantities)
}

fn extent(q: &Quantity, extent: &Extent, targets: &mut Targets<impl Body>) -> Result<fem::Extent, ModelError> {
    match extent {
        Extent::Faces(selector) => targets.group("quantity", &q.name, &q.place, selector).map(fem::Extent::Faces),
        Extent::Cells(c) => cells(q, c, &targets.body).map(fem::Extent::Cells),
    }
}

fn cells(q: &Quantity, cells: &Cells, body: &impl Body) -> Result<fem::Cells, ModelError> {
    let mesh = body.mesh();
    let fault = |problem: String, help: String| {
        let (place, what) = (q.place.clone(), format!("quantity `{}`", q.name));
        Err(ModelError::Place { place, what, problem, help })
    };
    let region = match &cells.region {
        None => None,
        Some(name) => match mesh.region_names().iter().position(|r| r == name) {
            Some(index) => Some(RegionId(index as u16)),
            None => {
                let regions: Vec<&str> = mesh.region_names().iter().map(String::as_str).collect();
                let help = suggest::help(name, "regions of this mesh", &regions);
                return fault(format!("asks for region `{name}`, which the mesh does not have"), help);
            }
        },
    };
    let resolved = fem::Cells { region, within: cells.within };
    match body.fault(&resolved) {
        None => Ok(resolved),
        Some(problem) => fault(problem, format!("the model spans {}", span(mesh))),
    }
}

/// The known solution of a scenario on its mesh.
///
/// # Errors
/// [`ModelError`]: several materials, another solid than that of the solution, a selector that matches nothing.
pub(super) fn exact(
    e: &Exact,
    chosen: &[&Material],
    targets: &mut Targets<impl Body>,
) -> Result<fem::Exact, ModelError> {
    let fault = |problem: &str, help: String| {
        let (place, what, problem) = (e.place.clone(), "the exact solution".to_owned(), problem.to_owned());
        Err(ModelError::Place { place, what, problem, help })
    };
    let [first, others @ ..] = chosen else { return fault("needs a material", "add one".to_owned()) };
    if others.iter().any(|m| properties(m) != properties(first)) {
        return fault("is that of one material", "give all regions the same material".to_owned());
    }
    let tractions = match &e.tractions {
        Some(selector) => Some(targets.group("exact", "tractions", &e.place, selector)?),
        None => None,
    };
    let exact = fem::Exact { solution: e.solution, material: properties(first), tractions };
    let (lo, hi) = targets.mesh().limits();
    if !exact.fits(lo, hi) {
        let help = format!("it is known on {}; the model spans {}", body(e.solution), span(targets.mesh()));
        return fault("is that of another solid", help);
    }
    Ok(exact)
}

/// The body of a known solution.
fn body(solution: ExactSolution) -> &'static str {
    match solution {
        ExactSolution::SmoothCube => "the unit cube from 0 to 1, such as mesh.box with size = [1, 1, 1]",
        ExactSolution::LameSphere => "an eighth of a sphere, mesh.sphere-shell with radii = [1, 2]",
        ExactSolution::Kirsch => "a quarter of a plate, mesh.plate-with-hole with radius = 1 and size = 4",
        ExactSolution::LameCylinder => "a quarter of a tube, mesh.tube with radii = [1, 2] and quarter = true",
        ExactSolution::Timoshenko => "a beam, mesh.box with size = [8, 2, any]",
        ExactSolution::QuadraticPatch => "any body",
        ExactSolution::LPrism => "the L-prism [-1, 1]^2 x [0, 1] without its quarter x, y < 0, mesh.l-prism",
    }
}

/// Checks that the points of quantities, and one of each probe at least, lie in the mesh.
fn check_points(scenario: &Scenario, body: &impl Body) -> Result<(), ModelError> {
    let points = scenario.quantities.iter().filter_map(|q| match q.kind {
        QuantityKind::Value(_, point) => Some((format!("quantity `{}`", q.name), &q.place, vec![point])),
        _ => None,
    });
    let lines = scenario.probes.iter().map(|p| (format!("probe `{}`", p.name), &p.place, line(p)));
    let mesh = body.mesh();
    let (lo, hi) = mesh.limits();
    for (what, place, points) in points.chain(lines) {
        let nearest = body.nearest(&points).into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((distance, on_mesh)) = nearest.filter(|n| n.0 > OUTSIDE * lo.distance(hi)) else { continue };
        let problem = match points[..] {
            [p] => format!("asks for the point {p}, which lies outside the mesh"),
            _ => "lies outside the mesh with all its points".to_owned(),
        };
        let help = format!("the nearest point of the mesh is {on_mesh}, {distance:.3e} away");
        return Err(ModelError::Place { place: place.clone(), what, problem, help });
    }
    Ok(())
}

fn line(probe: &Probe) -> Vec<DVec3> {
    let last = (probe.points - 1) as f64;
    (0..probe.points).map(|i| probe.from.lerp(probe.to, i as f64 / last)).collect()
}

/// The quantities of a solution.
pub(super) fn values(problem: &Resolved, analysed: &Analysed<'_>) -> Vec<(String, QuantityRecord)> {
    if problem.quantities.is_empty() {
        return Vec::new();
    }
    let recovered = recovered(analysed);
    let state = state(problem, analysed, &recovered);
    // Few quantities are at points.
    let locator = LazyCell::new(|| Locator::new(analysed.space.mesh()));
    let value = |q: &fem::Quantity| state.value(q.kind, &|p| locator.nearest(p));
    let record = |(i, q): (usize, &fem::Quantity)| {
        let computed = value(q);
        let goal = analysed.goal.as_ref().filter(|_| problem.goal == Some(i));
        let record = goal.map(|goal| QuantityRecord {
            value: computed + goal.correction,
            error: Some(goal.bar),
            computed: Some(computed),
        });
        (q.name.clone(), record.unwrap_or(QuantityRecord { value: computed, error: None, computed: None }))
    };
    problem.quantities.iter().enumerate().map(record).collect()
}

/// One quantity of a solution.
pub(super) fn value(problem: &Resolved, analysed: &Analysed<'_>, index: usize) -> f64 {
    let recovered = recovered(analysed);
    let locator = LazyCell::new(|| Locator::new(analysed.space.mesh()));
    state(problem, analysed, &recovered).value(problem.quantities[index].kind, &|p| locator.nearest(p))
}

fn state<'a>(
    problem: &'a Resolved,
    analysed: &'a Analysed<'a>,
    recovered: &'a dyn Fn(usize) -> [SymTensor; 10],
) -> State<'a> {
    State { space: &analysed.space, model: &problem.model, solution: &analysed.solution, recovered }
}

/// The recovered stress at the nodes of a cell; those that four-node cells do not have are zero.
fn recovered<'a>(analysed: &'a Analysed<'a>) -> impl Fn(usize) -> [SymTensor; 10] + 'a {
    |t| {
        let mut nodes = [[0.0; 6]; 10];
        nodes.iter_mut().zip(analysed.errors.recovered.of_cell(t)).for_each(|(node, stress)| *node = stress);
        nodes
    }
}

/// The name of a probe's file.
pub(super) fn probe_file(name: &str) -> String {
    format!("probe_{name}.csv")
}

/// How many points of each probe lie in the mesh.
pub(super) fn points_inside(probes: &[Probe], mesh: &TetMesh) -> Vec<usize> {
    let locator = LazyCell::new(|| Locator::new(mesh));
    let inside = |p: &DVec3| locator.nearest(*p).distance <= OUTSIDE * mesh.diagonal();
    probes.iter().map(|probe| line(probe).iter().filter(|p| inside(p)).count()).collect()
}

/// Writes the probes of a solution on tetrahedra.
pub(super) fn write_probes(
    folder: &Path,
    probes: &[Probe],
    problem: &Resolved,
    analysed: &Analysed<'_>,
) -> Result<(), Error> {
    if probes.is_empty() {
        return Ok(());
    }
    let mesh = analysed.space.mesh();
    let recovered = recovered(analysed);
    let (state, locator) = (state(problem, analysed, &recovered), Locator::new(mesh));
    let outside = OUTSIDE * mesh.diagonal();
    write_lines(folder, probes, &|p| {
        let found = locator.nearest(p);
        let inside = found.distance <= outside;
        inside.then(|| (state.displacement(found.cell, found.weights), state.stress(found.cell, found.weights)))
    })
}

/// Writes probes, a file each, of what is known at a place: displacement and stress, or nothing outside the body.
pub(super) fn write_lines(
    folder: &Path,
    probes: &[Probe],
    at: &dyn Fn(DVec3) -> Option<(DVec3, SymTensor)>,
) -> Result<(), Error> {
    for probe in probes {
        let row = |p: DVec3| {
            let mut row = vec![p.distance(probe.from), p.x, p.y, p.z];
            match at(p) {
                None => row.resize(COLUMNS.len(), f64::NAN),
                Some((displacement, stress)) => {
                    row.extend(displacement.to_array());
                    row.extend(stress);
                    row.push(fem::von_mises(stress));
                }
            }
            row
        };
        let rows: Vec<Vec<f64>> = line(probe).into_iter().map(row).collect();
        write_csv(&folder.join(probe_file(&probe.name)), &COLUMNS, &rows)?;
    }
    Ok(())
}

/// What is expected of a step beside what came out.
pub(super) fn expectations(scenario: &Scenario, step: &StepRecord) -> Vec<(String, ExpectationRecord)> {
    let compare = |e: &Expectation| {
        let value = value_of(&e.subject, step);
        // The nearest value that is allowed.
        let (expected, allowed, between) = match e.bound {
            Bound::Near(expected, tolerance) => (expected, tolerance.distance(expected), None),
            Bound::Between(low, high) => (value.max(low).min(high), 0.0, Some([low, high])),
        };
        let deviation = value - expected;
        let passed = deviation.abs() <= allowed;
        let record =
            ExpectationRecord { value, expected, deviation, allowed, between, passed, source: e.source.clone() };
        (e.subject.name().to_owned(), record)
    };
    scenario.expectations.iter().map(compare).collect()
}

/// A number of a step; NaN if the step does not have it.
fn value_of(subject: &Subject, step: &StepRecord) -> f64 {
    let value = match subject {
        Subject::Quantity(name) => step.quantities.iter().find(|(n, _)| n == name).map(|(_, q)| q.value),
        Subject::Figure(Figure::StrainEnergy) => Some(step.strain_energy),
        Subject::Figure(Figure::RelativeError) => Some(step.error.relative),
        Subject::Figure(Figure::TrueRelativeError) => step.error.true_relative,
        Subject::Figure(Figure::Effectivity) => step.error.effectivity,
    };
    value.unwrap_or(f64::NAN)
}

/// The error to end with if an expectation failed.
pub(super) fn failed_expectations(report: &Report) -> Option<Error> {
    let failed = report.expectations.iter().filter(|(_, e)| !e.passed);
    let sentence = |(name, e): &(String, ExpectationRecord)| {
        let source = e.source.as_ref().map_or(String::new(), |s| format!(" ({s})"));
        let [value, expected, allowed] = [(e.value, 12), (e.expected, 12), (e.allowed, 6)].map(|(x, n)| short(x, n));
        let wanted = match e.between {
            Some([low, high]) => format!("{} to {}", short(low, 12), short(high, 12)),
            None => format!("{expected} within {allowed}"),
        };
        format!("{name} is {value}, expected {wanted}{source}")
    };
    let sentences: Vec<String> = failed.map(sentence).collect();
    (!sentences.is_empty()).then(|| Error::Unexpected { sentences: sentences.join("; ") })
}

//! `subsolid check`: what a run would do, without solving.

use super::describe::{self, MeshDetails, word};
use super::forecast::{self, Forecast};
use super::hexes::check_hexes;
use super::inspect::{describe_groups, describe_mesh};
use super::resolve::{Resolved, check_supports, choose_materials};
use super::smooth::check_size;
use super::{RunOptions, load, print, resolve, wrapped};
use crate::error::Error;
use crate::mesh::{Tagged, TetMesh};
use crate::output::options::Units;
use crate::output::report::write_json;
use crate::output::table::{count, figures, short, table, text, units};
use crate::scenario::{Material, Refine, Scenario, Strategy, Tolerance};
use crate::subdiv::options::Scheme;
use std::time::Instant;

/// Figures of a number that a scenario gives.
const DIGITS: usize = 6;

/// Reads a scenario's mesh, resolves its selectors and prints what a run would do.
///
/// # Errors
/// All that a run would report before it solves.
pub fn check(scenario: &Scenario, options: &RunOptions) -> Result<(), Error> {
    if let Some(hexes) = scenario.hexes {
        return check_hexes(scenario, hexes, options);
    }
    options.check_targets(scenario)?;
    let start = Instant::now();
    let file = load::load(scenario)?;
    let given_groups = file.mesh.groups().len();
    let resolved =
        resolve::resolve_curved(scenario, file.mesh, file.midsides).map_err(|e| e.with_inner(&file.inner_groups))?;
    check_supports(scenario, &resolved)?;
    scenario.smooth.map_or(Ok(()), |smooth| check_size(&resolved.mesh, smooth))?;
    let forecast = Forecast::of(scenario, &resolved)?;
    if let Some(path) = &options.json {
        let details = Details {
            mesh: MeshDetails::of(&resolved.mesh, given_groups, start.elapsed().as_secs_f64()),
            units: scenario.units.clone(),
            materials: materials(scenario, &resolved.mesh)?,
            supports: describe::supports(&resolved),
            loads: describe::loads(&resolved)?,
            quantities: describe::quantities(&resolved),
            probes: describe::probes(scenario, &resolved.mesh),
            forecast: forecast.clone(),
        };
        write_json(path, &details)?;
    }
    if options.quiet {
        return Ok(());
    }
    let mut text = format!("{}\n\n{}", scenario.title, describe_mesh(&resolved.mesh, file.format));
    file.notes.iter().for_each(|note| text += &wrapped(&format!("note: {note}")));
    text += &units(&scenario.units);
    text += &describe_groups(&resolved.mesh, given_groups);
    text += &describe_materials(scenario, &resolved.mesh)?;
    text += &describe_selections(&resolved)?;
    text += &describe_wishes(scenario, &resolved);
    text += &format!("\nelements: {}\n{}", word(&scenario.element), wrapped(&describe_refinement(scenario)));
    text += &describe_forecast(&forecast);
    text += &format!("results would go to {}\n", options.folder(scenario).display());
    let large = forecast.too_large().map(|s| {
        let needs = forecast::size(s.bytes);
        format!(
            "step {} may take {needs} of memory, more than is free: refine.stop.max_memory ends a run before",
            s.step
        )
    });
    for warning in scenario.warnings.iter().chain(&resolved.warnings).chain(&large) {
        text += &wrapped(&format!("warning: {warning}"));
    }
    print(&text)
}

pub(super) fn describe_materials(scenario: &Scenario, mesh: &impl Tagged) -> Result<String, Error> {
    let mut rows = table("region|material|Young's modulus|Poisson's ratio|density");
    for (region, m) in mesh.region_names().iter().zip(choose_materials(&scenario.materials, mesh)?) {
        let density = m.density.map_or_else(|| "-".to_owned(), |d| short(d, DIGITS));
        rows.add_row([
            region.clone(),
            m.name.clone(),
            short(m.youngs_modulus, DIGITS),
            short(m.poissons_ratio, DIGITS),
            density,
        ]);
    }
    Ok(format!("\n{}\n", text(rows)))
}

/// What `--json` holds.
#[derive(serde::Serialize)]
struct Details {
    #[serde(flatten)]
    mesh: MeshDetails,
    #[serde(skip_serializing_if = "Units::is_empty")]
    units: Units,
    materials: Vec<MaterialRecord>,
    supports: Vec<describe::Support>,
    loads: Vec<describe::Load>,
    quantities: Vec<describe::Quantity>,
    probes: Vec<describe::Probe>,
    forecast: Forecast,
}

/// The material of a region.
#[derive(serde::Serialize)]
struct MaterialRecord {
    region: String,
    material: String,
    youngs_modulus: f64,
    poissons_ratio: f64,
    density: Option<f64>,
}

fn materials(scenario: &Scenario, mesh: &TetMesh) -> Result<Vec<MaterialRecord>, Error> {
    let chosen = choose_materials(&scenario.materials, mesh)?;
    let record = |(region, m): (&String, &Material)| MaterialRecord {
        region: region.clone(),
        material: m.name.clone(),
        youngs_modulus: m.youngs_modulus,
        poissons_ratio: m.poissons_ratio,
        density: m.density,
    };
    Ok(mesh.region_names().iter().zip(chosen).map(record).collect())
}

fn describe_selections(resolved: &Resolved) -> Result<String, Error> {
    let mut held = table("support|faces|area|vertices|x|y|z");
    for s in describe::supports(resolved) {
        let [x, y, z] = std::array::from_fn(|c| match (&s.displacement[c], s.spring[c]) {
            (Some(u), _) => u.constant().map_or_else(|| u.to_string(), |x| short(x, DIGITS)),
            (None, 0.0) => "free".to_owned(),
            (None, k) => format!("spring {}", short(k, DIGITS)),
        });
        let (faces, area) =
            if s.faces == 0 { ("-".to_owned(), "-".to_owned()) } else { (s.faces.to_string(), figures(s.area, 5)) };
        held.add_row([s.name, faces, area, s.vertices.to_string(), x, y, z]);
    }
    let mut acts = table("load|is|faces|area|total x|y|z");
    for l in describe::loads(resolved)? {
        let value = l.value.iter().map(|v| v.constant().map_or_else(|| v.to_string(), |x| short(x, DIGITS)));
        let value = value.collect::<Vec<String>>().join(", ");
        let [x, y, z] = l.total_force.map(|f| figures(f, 5));
        let extent = |text: String| if l.faces == 0 { "-".to_owned() } else { text };
        let (faces, area) = (extent(l.faces.to_string()), extent(figures(l.area, 5)));
        let kind = l.point.map_or(l.kind.to_owned(), |[x, y, z]| format!("at ({x}, {y}, {z})"));
        acts.add_row([l.name, format!("{kind} {value}"), faces, area, x, y, z]);
    }
    Ok(format!("\n{}\n\n{}\n", text(held), text(acts)))
}

/// Quantities and probes, with what they are taken over; nothing if there are none.
fn describe_wishes(scenario: &Scenario, resolved: &Resolved) -> String {
    let mut told = String::new();
    let mut wanted = table("quantity|what|taken over");
    for q in describe::quantities(resolved) {
        let faces = q.faces.map(|n| format!("{n} faces, area {}", figures(q.area.unwrap_or_default(), 6)));
        let volume = q.volume.map(|v| format!("volume {}", figures(v, 6)));
        let point = q.point.map(|[x, y, z]| format!("({x}, {y}, {z})"));
        wanted.add_row([q.name, q.what, faces.or(volume).or(point).unwrap_or_else(|| "-".to_owned())]);
    }
    if !wanted.is_empty() {
        told += &format!("\n{}\n", text(wanted));
    }
    let mut lines = table("probe|from|to|points|in the part");
    for p in describe::probes(scenario, &resolved.mesh) {
        let [from, to] = [p.from, p.to].map(|[x, y, z]| format!("({x}, {y}, {z})"));
        lines.add_row([p.name, from, to, p.points.to_string(), p.inside.to_string()]);
    }
    if !lines.is_empty() {
        told += &format!("\n{}\n", text(lines));
    }
    told
}

/// The sizes of the steps that a run may make.
fn describe_forecast(forecast: &Forecast) -> String {
    let mut rows = table("step|cells|nodes|dofs|memory");
    for s in &forecast.steps {
        let about = |n: usize| if s.exact { count(n) } else { format!("~ {}", count(rough(n))) };
        rows.add_row([
            s.step.to_string(),
            about(s.cells),
            about(s.nodes),
            about(s.dofs),
            format!("~ {}", forecast::size(s.bytes)),
        ]);
    }
    let free = forecast.free_bytes.map_or(String::new(), |b| format!(" {} of memory are free.", forecast::size(b)));
    let end = format!("The forecast ends by {}. ~ is an estimate, mostly within a factor of two.{free}", forecast.end);
    format!("\n{}\n{}", text(rows), wrapped(&end))
}

/// An estimate to two figures.
fn rough(n: usize) -> usize {
    let unit = 10_usize.pow(n.max(1).ilog10().saturating_sub(1));
    (n + unit / 2) / unit * unit
}

/// The plan of refinement in a sentence or two.
fn describe_refinement(scenario: &Scenario) -> String {
    let Refine { strategy, steps, options, stop } = &scenario.refine;
    let scheme = word(&options.scheme);
    // Of the schemes, sqrt(3) alone has a rule for the boundary.
    let boundary = match options.scheme {
        Scheme::Sqrt3 => format!(", boundary {}", word(&options.boundary)),
        Scheme::Red | Scheme::LongestEdge => String::new(),
    };
    let plan = match strategy {
        Strategy::None => return "refinement: none".to_owned(),
        Strategy::Global => "all cells".to_owned(),
        Strategy::Adaptive => {
            let (marking, rings) = (word(&scenario.adapt.marking), scenario.adapt.grow);
            let what = scenario.adapt.goal.as_ref().map_or(String::new(), |goal| format!(" of `{goal}`"));
            format!("cells by {} error{what}, {marking}, {rings} rings of neighbours", word(&scenario.adapt.estimator))
        }
    };
    let errors = [
        stop.relative_error.map(|e| format!("relative error {e}")),
        stop.quantity_error.zip(scenario.adapt.goal.as_ref()).map(|(asked, goal)| match asked {
            Tolerance::Relative(fraction) => format!("relative error {fraction} of `{goal}`"),
            Tolerance::Absolute(distance) => format!("error {distance} of `{goal}`"),
        }),
    ];
    let errors = errors.into_iter().flatten().reduce(|energy, goal| format!("{energy} and {goal}"));
    let rules = [
        errors,
        stop.max_cells.map(|n| format!("{n} cells")),
        stop.max_memory.map(|n| format!("{n} bytes")),
        stop.seconds.map(|s| format!("{s} s")),
    ];
    let rules: Vec<String> = rules.into_iter().flatten().collect();
    let stop = if rules.is_empty() { String::new() } else { format!(", ends early at {}", rules.join(" or ")) };
    format!("refinement: {scheme}, {plan}{boundary}, at most {steps} steps{stop}")
}

//! Keys as written -> checked values.

use super::document::Document;
use super::elements::{check_smooth, elements, locking, midside, smooth};
use super::error::Fault;
use super::numbers::{Checked, integer, outside, positive, vector, within};
use super::raw::*;
use super::spanned::Spanned;
use super::*;
use crate::output::options::{FieldName, PublishedStep};
use crate::subdiv::options::{Boundary, Mode, Objective, Optimise, QualityMeasure, Scheme};
use std::ops::Range;

/// Most refinement steps a scenario may ask for.
pub const MAX_STEPS: i64 = 20;

/// Steps of a run on hexahedra that has stop rules and names no number.
const MAX_HEX_STEPS: usize = 5;

/// Most cells a generated box may have before each is cut into tetrahedra.
const MAX_BOX_CELLS: usize = 100_000_000;

/// Checks everything that can be checked without the mesh. Leaves path, folder, document and overrides empty.
pub(super) fn scenario(raw: RawScenario, document: &Document<'_>) -> Checked<Scenario> {
    let mut warnings = Vec::new();
    let place = |span: &Range<usize>| document.place(span);
    let materials = materials(raw.materials.unwrap_or_default(), &place)?;
    let supports = actions::supports(raw.supports.unwrap_or_default(), raw.exact.is_some(), &place)?;
    let names: Vec<&str> = supports.iter().map(|s| s.name.as_str()).collect();
    let known = raw.exact.is_some();
    let quantities = wanted::quantities(raw.quantities.unwrap_or_default(), &names, &place)?;
    let merge = raw.mesh.as_ref().is_some_and(|m| m.value.merges());
    let midside_key = raw.mesh.as_ref().and_then(|m| m.value.midside.clone());
    let body = mesh(raw.mesh)?;
    let mut analysis = raw.analysis.map(|t| t.value);
    let smooth = smooth(analysis.as_mut().and_then(|a| a.smooth.take()), analysis.as_ref())?;
    let (element, hexes) = elements(analysis, &body)?;
    warnings.extend(locking(&materials, element, hexes));
    let is_straight = midside_key.as_ref().is_some_and(|m| *m.get_ref() == Midside::Straight);
    let hexes = hexes.map(|h| Hexes { curved: h.element.has_edge_nodes() && !is_straight, ..h });
    let midside = midside(midside_key, element)?;
    let has_goal = raw.adapt.as_ref().is_some_and(|t| t.value.goal.is_some());
    let written = raw.refine.as_ref().map(|t| t.span.clone());
    let optimises = raw.refine.as_ref().is_some_and(|t| t.value.optimise.is_some());
    let refine = refine(raw.refine.map(|t| t.value), hexes, has_goal, &mut warnings)?;
    check_smooth(smooth, &refine, written, raw.adapt.as_ref())?;
    let asked = refine.stop.relative_error.is_some();
    if raw.adapt.as_ref().is_some_and(|t| t.value.steers()) {
        if hexes.is_some() {
            warnings
                .push("[adapt] is for tetrahedra: hexahedra are refined globally, it has no effect here".to_owned());
        } else if smooth.is_some() {
            warnings.push("[adapt] chooses cells: of a smooth solid all are refined, it has no effect here".to_owned());
        }
    }
    if smooth.is_some() && optimises {
        warnings.push("refine.optimise has no effect on the control mesh of a smooth solid".to_owned());
    }
    let adapt = adapt(raw.adapt.map(|t| t.value).unwrap_or_default(), asked, &quantities, &supports)?;
    Ok(Scenario {
        path: PathBuf::new(),
        directory: PathBuf::new(),
        document: toml::Table::new(),
        overrides: Vec::new(),
        title: raw.title.unwrap_or_default(),
        description: raw.description.unwrap_or_default(),
        mesh: body,
        features: features(raw.features)?,
        materials,
        supports,
        loads: actions::loads(raw.loads.unwrap_or_default(), &place)?,
        probes: wanted::probes(raw.probes.unwrap_or_default(), &place)?,
        exact: raw.exact.map(|t| wanted::exact(t, &place)).transpose()?,
        expectations: wanted::expectations(raw.expect.unwrap_or_default(), &quantities, known)?,
        quantities,
        refine,
        midside,
        merge,
        element,
        smooth,
        hexes,
        adapt,
        solver: solver(raw.solver.map(|t| t.value).unwrap_or_default())?,
        output: output(&raw.output.map(|t| t.value).unwrap_or_default(), hexes.is_some())?,
        published: raw.published.map(|t| published(t.value)).transpose()?,
        units: raw.units.map(|t| t.value).unwrap_or_default(),
        warnings,
    })
}

pub(super) fn mesh(raw: Option<Table<RawMesh>>) -> Checked<MeshSource> {
    let help = "add [mesh] with file = \"part.msh\", or [mesh.box] with size = [4, 1, 1] and cells = [8, 2, 2]";
    let Some(Table { span, mut value }) = raw else {
        return Err(Fault::new(0..0, "the scenario has no [mesh]", "no [mesh] in this file").help(help));
    };
    if let Some(merge) = value.merge.as_ref().filter(|_| value.file.is_none()) {
        return Err(Fault::new(merge.span(), "goes with mesh.file", "generated bodies have one node at each place"));
    }
    let mut shapes = shapes::all(&mut value)?;
    if let Some((span, shape)) = shapes.pop() {
        if value.file.is_some() || value.brick.is_some() || !shapes.is_empty() {
            return Err(shapes::one_too_many(span));
        }
        return match value.midside {
            Some(midside) if !shape.is_curved() => Err(needless(&midside)),
            _ => Ok(MeshSource::Shape(shape)),
        };
    }
    match (value.file, value.brick) {
        (Some(_), Some(brick)) => Err(Fault::new(brick.span, "stands beside `file`", "one mesh too many")
            .help("keep either mesh.file or mesh.box")),
        (None, None) => Err(Fault::new(span, "names no mesh", "which mesh?").help(help)),
        (Some(file), None) => Ok(MeshSource::File(PathBuf::from(file.into_inner()))),
        (None, Some(brick)) => match value.midside {
            Some(midside) => Err(needless(&midside)),
            None => self::brick(&brick.value),
        },
    }
}

/// The fault of `midside` beside a body whose edges are all straight.
fn needless(midside: &Spanned<Midside>) -> Fault {
    Fault::new(midside.span(), "goes with mesh.file and generated bodies with curved sides", "remove this")
}

fn brick(raw: &RawBrick) -> Checked<MeshSource> {
    let size = vector(&raw.size)?;
    if size.min_element() <= 0.0 {
        return Err(outside(raw.size.span(), &size, "three positive lengths"));
    }
    let given = raw.cells.get_ref();
    let range = format!("three integers from 1 whose product is at most {MAX_BOX_CELLS}");
    let fault = || outside(raw.cells.span(), &format!("{given:?}"), &range);
    let cells: Vec<usize> = given.iter().filter_map(|&n| usize::try_from(n).ok()).collect();
    let &[x, y, z] = &cells[..] else { return Err(fault()) };
    match x.checked_mul(y).and_then(|xy| xy.checked_mul(z)) {
        Some(1..=MAX_BOX_CELLS) => Ok(MeshSource::Box { size: size.to_array(), cells: [x, y, z] }),
        _ => Err(fault()),
    }
}

pub(super) fn features(raw: Option<Table<RawFeatures>>) -> Checked<Features> {
    let Some(Table { value: raw, .. }) = raw else {
        return Ok(Features { angle: None, edges: Vec::new(), corners: Vec::new() });
    };
    let angle = raw.angle.map(|a| within(&a, "an angle from 0 to 180 degrees", |a| (0.0..=180.0).contains(&a)));
    let edge = |e: Spanned<Vec<u32>>| match e.get_ref()[..] {
        [a, b] if a != b => Ok([a, b]),
        _ => Err(outside(e.span(), &format!("{:?}", e.get_ref()), "two different vertex numbers")),
    };
    Ok(Features {
        angle: angle.transpose()?,
        edges: raw.edges.unwrap_or_default().into_iter().map(edge).collect::<Checked<_>>()?,
        corners: raw.corners.unwrap_or_default(),
    })
}

type Place<'a> = &'a dyn Fn(&Range<usize>) -> String;

fn materials(raw: Named<RawMaterial>, place: Place) -> Checked<Vec<Material>> {
    let mut materials: Vec<Material> = Vec::new();
    for (name, table) in raw {
        let group = table.value.group.as_ref().map(|g| g.get_ref().clone());
        if let Some(other) = materials.iter().find(|m| m.group == group) {
            let span = table.value.group.as_ref().map_or(table.span, Spanned::span);
            return Err(Fault::new(span, format!("fills the same regions as `{}`", other.name), "which of the two?")
                .help("give each material the region it fills: group = \"...\" (at most one may go without)"));
        }
        materials.push(material(name, &table, group, place)?);
    }
    Ok(materials)
}

fn material(
    name: String,
    Table { span, value: raw }: &Table<RawMaterial>,
    group: Option<String>,
    place: Place,
) -> Checked<Material> {
    let nu = *raw.poissons_ratio.get_ref();
    if nu == 0.5 {
        let fault = outside(raw.poissons_ratio.span(), &nu, "below 0.5: the material would be incompressible");
        return Err(fault.help("displacement elements cannot carry it; rubber is usually computed with about 0.49"));
    }
    let poissons_ratio = within(&raw.poissons_ratio, "above -1 and below 0.5", |nu| nu > -1.0 && nu < 0.5)?;
    Ok(Material {
        place: place(span),
        youngs_modulus: positive(&raw.youngs_modulus)?,
        poissons_ratio,
        density: raw.density.as_ref().map(positive).transpose()?,
        group,
        name,
    })
}

fn refine(raw: Option<RawRefine>, hexes: Option<Hexes>, has_goal: bool, warnings: &mut Vec<String>) -> Checked<Refine> {
    let absent = raw.is_none();
    let raw = raw.unwrap_or_default();
    let raw_stop = raw.stop.map(|t| t.value).unwrap_or_default();
    let quantity_error = raw_stop.quantity_error.as_ref().map(Spanned::span);
    let stop = stop(&raw_stop, has_goal)?;
    if let (Some(_), Some(written)) = (hexes, &quantity_error) {
        let fault = Fault::new(written.clone(), "is for tetrahedra", "not estimated on hexahedra");
        return Err(fault.help("stop by relative_error, or choose analysis.element = \"tet10\""));
    }
    let scheme = raw.scheme.as_ref().map_or(Scheme::Sqrt3, |s| *s.get_ref());
    let default = match scheme {
        _ if absent => Strategy::None,
        _ if hexes.is_some() => Strategy::Global,
        Scheme::Red => Strategy::Global,
        Scheme::Sqrt3 | Scheme::LongestEdge => Strategy::Adaptive,
    };
    let strategy = raw.strategy.as_ref().map_or(default, |s| *s.get_ref());
    if let (Some(hexes), Strategy::Adaptive, Some(written)) = (hexes, strategy, &raw.strategy) {
        let name = hexes.element.name();
        let fault = Fault::new(written.span(), "is \"adaptive\", but hexahedra are refined globally", "not adaptive");
        return Err(fault.help(format!(
            "leave it out or set \"global\"; analysis.element = \"{name}\" has no adaptive refinement"
        )));
    }
    if let (Some(_), Some(written)) = (hexes, &raw.scheme) {
        let fault = Fault::new(written.span(), "is for tetrahedra", "no scheme here");
        return Err(fault.help("leave it out: hexahedra are split in eight, Catmull-Clark solids by their masks"));
    }
    if let (Scheme::Red, Strategy::Adaptive, Some(written)) = (scheme, strategy, &raw.scheme) {
        return Err(Fault::new(written.span(), "is \"red\", which refines all cells or none", "not adaptive")
            .help("set refine.strategy = \"global\", or refine.scheme = \"sqrt3\" or \"longest-edge\""));
    }
    // A stop rule ends the run where it is met; without one, a single step is the modest choice.
    let default_steps = match hexes {
        _ if stop == Stop::default() => 1,
        // Each step has eight times the cells.
        Some(_) => MAX_HEX_STEPS,
        None => MAX_STEPS as usize,
    };
    let steps = raw.steps.map(|n| integer(&n, 0..=MAX_STEPS)).transpose()?.unwrap_or(default_steps);
    let optimises = raw.optimise.is_some();
    let optimise = optimise(&raw.optimise.map(|t| t.value).unwrap_or_default())?;
    let boundary = raw.boundary.unwrap_or(Boundary::Fixed);
    if hexes.is_some() && (raw.boundary.is_some() || optimises) {
        warnings.push("refine.boundary and refine.optimise are for tetrahedra: they have no effect here".to_owned());
    } else if let Some(name) = moving(boundary)
        && strategy != Strategy::None
    {
        let effect = match scheme {
            Scheme::Sqrt3 => {
                "moves the surface: each step solves another domain, so that energies and errors of different steps do not \
                 compare exactly (\"fixed\" keeps the surface)"
            }
            Scheme::Red | Scheme::LongestEdge => "is for refine.scheme = \"sqrt3\": here it has no effect",
        };
        warnings.push(format!("refine.boundary = \"{name}\" {effect}"));
    }
    Ok(Refine { strategy, steps, options: Options { scheme, boundary, optimise, frames: false }, stop })
}

/// For analysis the objective is a small error; the paper's operations know only the angles.
fn optimise(raw: &RawOptimise) -> Checked<Optimise> {
    let passes = raw.passes.as_ref().map(|n| integer(n, 1..=100)).transpose()?.unwrap_or(3);
    let default = Optimise::default();
    let angle = |x: &Number| within(x, "from 1 to 60 degrees", |a| (1.0..=60.0).contains(&a));
    let mode = raw.mode.unwrap_or(Mode::Best);
    let measure = raw.measure.as_ref().map_or(QualityMeasure::MinSine, |m| *m.get_ref());
    if let (Mode::Best, true, Some(written)) = (mode, measure != QualityMeasure::MinSine, &raw.measure) {
        return Err(Fault::new(written.span(), "is a measure for the published operations", "not in mode \"best\"")
            .help("set refine.optimise.mode = \"paper\", or leave the measure out"));
    }
    let objective = raw.objective.unwrap_or(Objective::Error);
    if let Some(written) = raw.directions.as_ref().filter(|_| (mode, objective) != (Mode::Best, Objective::Error)) {
        return Err(Fault::new(written.span(), "is for the objective \"error\" in mode \"best\"", "remove this"));
    }
    Ok(Optimise {
        mode,
        objective,
        directions: raw.directions.as_ref().is_none_or(|d| *d.get_ref()),
        measure,
        passes,
        target_angle: raw.target_angle.as_ref().map(angle).transpose()?.unwrap_or(default.target_angle),
        valence_limit: raw
            .valence_limit
            .as_ref()
            .map(|n| integer(n, 20..=10_000))
            .transpose()?
            .unwrap_or(default.valence_limit),
    })
}

/// The name of a boundary rule that moves the surface.
fn moving(boundary: Boundary) -> Option<&'static str> {
    match boundary {
        Boundary::Fixed => None,
        Boundary::Approximating => Some("approximating"),
        Boundary::Interpolating => Some("interpolating"),
    }
}

fn stop(raw: &RawStop, has_goal: bool) -> Checked<Stop> {
    if let (Some(written), false) = (&raw.quantity_error, has_goal) {
        let fault = Fault::new(written.span(), "needs to know of which quantity", "the error of what?");
        return Err(fault.help("name one of [quantities] in adapt.goal"));
    }
    let error = |x| within(x, "above 0 and below 1", |e| e > 0.0 && e < 1.0);
    let memory = |bytes: &Spanned<Bytes>| match bytes.get_ref().0 {
        0 => Err(outside(bytes.span(), &0, "at least one byte")),
        n => Ok(n),
    };
    Ok(Stop {
        relative_error: raw.relative_error.as_ref().map(error).transpose()?,
        quantity_error: raw.quantity_error.as_ref().map(wanted::quantity_error).transpose()?,
        max_cells: raw.max_cells.as_ref().map(|n| integer(n, 1..=i64::MAX)).transpose()?,
        max_memory: raw.max_memory.as_ref().map(memory).transpose()?,
        seconds: raw.seconds.as_ref().map(positive).transpose()?,
    })
}

/// `asked`: whether there is a tolerance to look ahead to.
fn adapt(raw: RawAdapt, asked: bool, quantities: &[Quantity], supports: &[Support]) -> Checked<Adapt> {
    let goal = raw.goal.as_ref().map(|goal| wanted::goal(goal, quantities, supports)).transpose()?;
    if let Some(written) = raw.marking.as_ref().and_then(|t| t.value.look_ahead.as_ref()).filter(|_| !asked) {
        return Err(Fault::new(written.span(), "looks ahead to a tolerance, but none is asked for", "to which error?")
            .help("set refine.stop.relative_error, or mark by { doerfler = 0.5 }"));
    }
    let written = raw.marking.as_ref().map(|t| t.span.clone());
    let ahead = asked && goal.is_none();
    let default = if ahead { Marking::LookAhead(0.8) } else { Marking::Doerfler(0.5) };
    let marking = raw.marking.map(|t| marking(&t)).transpose()?.unwrap_or(default);
    if let (Marking::Threshold(_) | Marking::LookAhead(_), Some(_), Some(span)) = (marking, &goal, written) {
        let fault = Fault::new(span, "goes by the error of the energy, beside a goal", "not with a goal");
        return Err(fault.help("take { doerfler = 0.5 }, { maximum = 0.5 } or { fraction = 0.1 }"));
    }
    Ok(Adapt {
        estimator: raw.estimator.unwrap_or(Estimator::Spr),
        marking,
        grow: raw.grow.map(|n| integer(&n, 0..=100)).transpose()?.unwrap_or(0),
        goal,
    })
}

fn marking(Table { span, value: raw }: &Table<RawMarking>) -> Checked<Marking> {
    let fraction = |x: &Number| within(x, "above 0 and at most 1", |x| x > 0.0 && x <= 1.0);
    let given = [&raw.doerfler, &raw.maximum, &raw.fraction, &raw.threshold, &raw.look_ahead];
    match given {
        [Some(x), None, None, None, None] => fraction(x).map(Marking::Doerfler),
        [None, Some(x), None, None, None] => fraction(x).map(Marking::Maximum),
        [None, None, Some(x), None, None] => fraction(x).map(Marking::Fraction),
        [None, None, None, Some(x), None] => positive(x).map(Marking::Threshold),
        [None, None, None, None, Some(x)] => fraction(x).map(Marking::LookAhead),
        _ => {
            let count = given.into_iter().flatten().count();
            Err(Fault::new(span.clone(), format!("names {count} markings, but must name one"), "exactly one")
                .help("one of { doerfler = 0.5 }, { maximum = 0.5 }, { fraction = 0.1 }, { threshold = 1e-3 }, { look_ahead = 0.8 }"))
        }
    }
}

fn solver(raw: RawSolver) -> Checked<SolverOptions> {
    let default = SolverOptions::default();
    let inside = |x: &Number| within(x, "above 0 and below 1", |x| x > 0.0 && x < 1.0);
    let tolerance = raw.tolerance.as_ref().map(inside).transpose()?.unwrap_or(default.tolerance);
    Ok(SolverOptions { method: raw.method.unwrap_or(default.method), tolerance, ..default })
}

fn output(raw: &RawOutput, on_hexes: bool) -> Checked<Output> {
    if let Some(hexahedra) = raw.hexahedra.as_ref().filter(|_| !on_hexes) {
        let fault = Fault::new(hexahedra.span(), "is for elements of hexahedra", "not with this element");
        return Err(fault.help("leave it out, or set analysis.element = \"catmull-clark\""));
    }
    Ok(Output {
        vtk: raw.vtk.unwrap_or(true),
        report: raw.report.unwrap_or(true),
        fields: raw.fields.clone().unwrap_or_else(|| FieldName::ALL.to_vec()),
        compression: raw.compression.unwrap_or_default(),
        hexahedra: raw.hexahedra.as_ref().map(|h| *h.get_ref()).unwrap_or_default(),
    })
}

fn published(raw: RawPublished) -> Checked<Published> {
    let step = |Table { value: s, .. }: Table<RawPublishedStep>| {
        Ok(PublishedStep {
            label: s.label,
            cells: integer(&s.cells, 1..=i64::MAX)?,
            milliseconds: positive(&s.milliseconds)?,
            error: positive(&s.error)?,
        })
    };
    Ok(Published { source: raw.source, steps: raw.steps.into_iter().map(step).collect::<Checked<_>>()? })
}

//! Scenarios: what is accepted, and what a fault says: its place, its key, its remedy, its exit code.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::Path;
use subsolid::Error;
use subsolid::adapt::options::{Estimator, Marking};
use subsolid::fem::options::Method;
use subsolid::field::Field;
use subsolid::scenario::{Invalid, LoadKind, MeshSource, Scenario, ScenarioError, Selector, Stop, Strategy};
use subsolid::subdiv::options::{Boundary, QualityMeasure, Scheme};

const BASE: &str = r#"
[mesh]
file = "part.msh"

[materials.steel]
youngs_modulus = 1000
poissons_ratio = 0.3

[supports.feet]
group = "y-min"
fix = ["x", "y", "z"]

[loads.push]
group = "y-max"
traction = [0, -1, 0]
"#;

fn parse(text: &str, overrides: &[&str]) -> Result<Scenario, ScenarioError> {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    Scenario::from_text(text, Path::new("dir/case.toml"), &overrides)
}

fn accept(text: &str, overrides: &[&str]) -> Scenario {
    parse(text, overrides).unwrap_or_else(|e| panic!("{:?}", miette::Report::new(e)))
}

/// The fault, after a check of its exit code and that its span lies in its text.
fn refuse(text: &str, overrides: &[&str]) -> Invalid {
    let error = Error::from(parse(text, overrides).expect_err("accepted"));
    assert_eq!(error.exit_code(), 3);
    let Error::Scenario(ScenarioError::Invalid(fault)) = error else { panic!("{error}") };
    assert!(fault.span.offset() + fault.span.len() <= fault.source_code.inner().len());
    *fault
}

/// The text that the label of a fault points at.
fn labelled(fault: &Invalid) -> &str {
    &fault.source_code.inner()[fault.span.offset()..fault.span.offset() + fault.span.len()]
}

fn help(fault: &Invalid) -> &str {
    fault.help.as_deref().unwrap_or("")
}

/// BASE with more text behind it.
fn with(more: &str) -> String {
    format!("{BASE}\n{more}\n")
}

#[test]
fn defaults_are_those_of_the_manual() {
    let s = accept(BASE, &[]);
    assert_eq!(s.title, "case");
    assert_eq!(s.directory, Path::new("dir"));
    assert_eq!(s.document, BASE.parse().unwrap());
    assert_eq!(s.mesh, MeshSource::File("part.msh".into()));
    assert_eq!((s.features.sharp_angle(), s.refine.strategy), (40.0, Strategy::None));
    assert_eq!((s.adapt.estimator, s.adapt.marking, s.adapt.grow), (Estimator::Spr, Marking::Doerfler(0.5), 0));
    assert_eq!((s.solver.method, s.solver.tolerance), (Method::Auto, 1e-8));
    assert_eq!(s.supports[0].displacement, [const { Some(Field::ZERO) }; 3]);
    assert_eq!(s.loads[0].kind, LoadKind::Traction(Selector::Group("y-max".to_owned()), glam::DVec3::NEG_Y.into()));
    assert!(s.output.vtk && s.output.report && s.warnings.is_empty());
}

const EVERY_KEY: &str = r#"
title = "all"
[mesh.box]
size = [4, 1, 1.5]
cells = [8, 2, 3]
element = "tet"
[features]
angle = 70
edges = [[0, 1], [3, 2]]
corners = [5]
[materials.rubber]
youngs_modulus = 1.0
poissons_ratio = 0.495
density = 2
group = "soft"
[materials.rest]
youngs_modulus = 2.0
poissons_ratio = -0.2
[supports.a]
plane = { normal = [0, 2, 0], offset = -20, tolerance = 1e-5 }
displacement = { y = -0.1 }
fix = ["z"]
[supports.b]
fix = ["x"]
any = [
  { sphere = { center = [0, 0, 0], radius = 1 } },
  { not = { cylinder = { point = [0, 0, 0], axis = [0, 0, 1], radius = 2 } } },
]
[loads.p]
all = [{ box = { min = [0, 0, 0], max = [1, 1, 1] } }, { normal = { direction = [1, 0, 0], angle = 5 } }]
pressure = -3.5
[loads.f]
group = "g"
force = [1, 2, 3]
[loads.w]
gravity = [0, 0, -9.81]
[analysis]
element = "tet4"
[refine]
scheme = "sqrt3"
strategy = "global"
steps = 4
boundary = "approximating"
optimise = { mode = "paper", objective = "quality", measure = "min-solid-angle", passes = 2 }
[refine.stop]
relative_error = 0.05
max_cells = 100_000
max_memory = "2 GiB"
seconds = 60
[adapt]
estimator = "averaging"
marking = { fraction = 0.1 }
grow = 1
[solver]
method = "amg-cg"
tolerance = 1e-10
[output]
vtk = false
report = true
compression = "zlib"
[published]
source = "Burkhart, Hamann, Umlauf 2011"
steps = [{ label = "base", cells = 2799, milliseconds = 491, error = 0.08 }]
"#;

#[test]
fn every_key_is_read() {
    let s = accept(EVERY_KEY, &[]);
    let MeshSource::Box { size, cells } = s.mesh else { panic!() };
    assert_eq!((size, cells), ([4.0, 1.0, 1.5], [8, 2, 3]));
    assert_eq!((s.features.angle, s.features.edges, s.features.corners), (Some(70.0), vec![[0, 1], [3, 2]], vec![5]));
    assert_eq!((s.materials[1].density, s.materials[1].group.as_deref()), (Some(2.0), Some("soft")));
    assert_eq!(s.supports[0].displacement, [None, Some((-0.1).into()), Some(Field::ZERO)]);
    assert!(matches!(&s.supports[1].selector, Selector::Any(list) if list.len() == 2));
    assert_eq!(s.loads.iter().map(|l| l.name.as_str()).collect::<Vec<_>>(), ["f", "p", "w"]);
    let stop = Stop {
        relative_error: Some(0.05),
        quantity_error: None,
        max_cells: Some(100_000),
        max_memory: Some(2 << 30),
        seconds: Some(60.0),
    };
    assert_eq!((s.refine.stop, s.refine.steps, s.refine.options.optimise.passes), (stop, 4, 2));
    assert_eq!(s.refine.options.optimise.measure, QualityMeasure::MinSolidAngle);
    assert_eq!((s.refine.options.boundary, s.refine.strategy), (Boundary::Approximating, Strategy::Global));
    assert_eq!((s.adapt.marking, s.adapt.grow), (Marking::Fraction(0.1), 1));
    assert_eq!(s.published.unwrap().steps[0].cells, 2799);
    // Nearly incompressible, and energies of different domains.
    assert_eq!(s.warnings.len(), 2, "{:?}", s.warnings);
}

#[test]
fn class_47_an_unknown_key_gives_line_column_and_suggestion() {
    let fault = refuse("[mesh]\nfile = \"a\"\n[refine]\n  stepz = 3\n", &[]);
    assert_eq!((fault.place.as_str(), fault.key.as_str()), ("dir/case.toml:4:3", "refine.stepz"));
    assert_eq!(labelled(&fault), "stepz");
    assert!(help(&fault).contains("did you mean `steps`?") && help(&fault).contains("boundary"));

    assert!(help(&refuse(&with("[materails.a]\n"), &[])).contains("did you mean `materials`?"));
    let inner = refuse(&with("[supports.b]\nfix = [\"x\"]\nplane = { normal = [1, 0, 0], ofset = 1 }"), &[]);
    assert_eq!((inner.key.as_str(), labelled(&inner)), ("supports.b.plane.ofset", "ofset"));
}

#[test]
fn an_unknown_value_lists_what_there_is() {
    let fault = refuse(&with("[refine]\nscheme = \"sqrt4\""), &[]);
    assert_eq!((fault.key.as_str(), labelled(&fault)), ("refine.scheme", "\"sqrt4\""));
    assert!(help(&fault).contains("did you mean `sqrt3`?") && help(&fault).contains("red"));
}

#[test]
fn what_the_format_reserves_is_refused_with_what_to_use() {
    for (text, word) in [
        ("[refine]\nboundary = \"fixed-trisection\"", "\"fixed\""),
        ("[refine]\nengine = \"x\"", "engine"),
        ("[mesh.box]\nsize = [1, 1, 1]\ncells = [1, 1, 1]\nelement = \"hex\"", "\"tet\""),
    ] {
        let fault = refuse(text, &[]);
        assert!(fault.message.contains("not available in this version") && fault.message.contains(word), "{fault}");
    }
}

#[test]
fn class_48_a_wrong_type_names_path_expected_and_got() {
    for (text, key, expected, got) in [
        ("[refine]\nsteps = \"three\"", "refine.steps", "an integer", "\"three\""),
        ("[refine]\nsteps = 1.5", "refine.steps", "an integer", "1.5"),
        ("[refine]\nscheme = 3", "refine.scheme", "a string", ""),
        ("[solver]\ntolerance = true", "solver.tolerance", "a number", "true"),
        ("[output]\nvtk = \"yes\"", "output.vtk", "true or false", "\"yes\""),
        ("[materials]\ndensity = 1", "materials.density", "a table", "1"),
        ("[loads.b]\nforce = [1, 2, \"3\"]", "loads.b.force[2]", "a number", "\"3\""),
        ("[loads.b]\nforce = 1", "loads.b.force", "an array", "1"),
        ("[[refine]]\nsteps = 1", "refine", "a table", ""),
        ("adapt = [\"spr\"]", "adapt", "a table", ""),
        ("[refine.stop]\nmax_memory = \"2 GiBs\"", "refine.stop.max_memory", "\"2 GiB\"", "\"2 GiBs\""),
    ] {
        let fault = refuse(text, &[]);
        assert_eq!(fault.key, key, "{fault}");
        assert!(fault.message.contains(expected) && fault.message.contains(got), "{fault}");
    }
}

#[test]
fn a_vector_has_exactly_three_numbers() {
    for numbers in ["[1, 2]", "[1, 2, 3, 4]"] {
        let fault = refuse(&with(&format!("[loads.b]\ngroup = \"g\"\nforce = {numbers}")), &[]);
        assert_eq!((fault.key.as_str(), labelled(&fault)), ("loads.b.force", numbers));
    }
}

#[test]
fn measures_are_for_the_published_operations() {
    let fault = refuse(&with("[refine.optimise]\nmeasure = \"edge-ratio\""), &[]);
    assert_eq!((fault.key.as_str(), labelled(&fault)), ("refine.optimise.measure", "\"edge-ratio\""));
    let s = accept(&with("[refine.optimise]\nmeasure = \"edge-ratio\"\nmode = \"paper\""), &[]);
    assert_eq!(s.refine.options.optimise.measure, QualityMeasure::EdgeRatio);
}

#[test]
fn ranges_are_kept() {
    for (text, key) in [
        ("[refine]\nsteps = -1", "refine.steps"),
        ("[refine]\nsteps = 21", "refine.steps"),
        ("[refine.optimise]\npasses = 0", "refine.optimise.passes"),
        ("[adapt]\nmarking = { doerfler = 0 }", "adapt.marking.doerfler"),
        ("[adapt]\nmarking = { doerfler = 1.01 }", "adapt.marking.doerfler"),
        ("[adapt]\nmarking = { maximum = nan }", "adapt.marking.maximum"),
        ("[adapt]\nmarking = { threshold = inf }", "adapt.marking.threshold"),
        ("[adapt]\ngrow = -1", "adapt.grow"),
        ("[solver]\ntolerance = 1", "solver.tolerance"),
        ("[solver]\ntolerance = 0.0", "solver.tolerance"),
        ("[features]\nangle = 181", "features.angle"),
        ("[features]\nedges = [[1, 1]]", "features.edges[0]"),
        ("[features]\ncorners = [-1]", "features.corners[0]"),
        ("[refine.stop]\nrelative_error = 1.0", "refine.stop.relative_error"),
        ("[refine.stop]\nmax_cells = 0", "refine.stop.max_cells"),
        ("[refine.stop]\nmax_memory = -1", "refine.stop.max_memory"),
        ("[refine.stop]\nseconds = 0", "refine.stop.seconds"),
        ("[materials.b]\nyoungs_modulus = 0\npoissons_ratio = 0\ngroup = \"b\"", "materials.b.youngs_modulus"),
        ("[materials.b]\nyoungs_modulus = inf\npoissons_ratio = 0\ngroup = \"b\"", "materials.b.youngs_modulus"),
        ("[materials.b]\nyoungs_modulus = 1\npoissons_ratio = -1\ngroup = \"b\"", "materials.b.poissons_ratio"),
        ("[materials.b]\nyoungs_modulus = 1\npoissons_ratio = nan\ngroup = \"b\"", "materials.b.poissons_ratio"),
        ("[loads.b]\ngroup = \"g\"\npressure = nan", "loads.b.pressure"),
        ("[loads.b]\nforce = [0, inf, 0]\ngroup = \"g\"", "loads.b.force"),
        ("[loads.b]\npressure = 1\nplane = { normal = [0, 0, 0], offset = 1 }", "loads.b.plane.normal"),
        ("[loads.b]\npressure = 1\nsphere = { center = [0, 0, 0], radius = 0 }", "loads.b.sphere.radius"),
        ("[loads.b]\npressure = 1\nbox = { min = [0, 0, 0], max = [1, -1, 1] }", "loads.b.box.max"),
        ("[loads.b]\npressure = 1\nnormal = { direction = [1, 0, 0], angle = -1 }", "loads.b.normal.angle"),
        ("[supports.b]\ngroup = \"g\"\ndisplacement = { x = nan }", "supports.b.displacement.x"),
    ] {
        let fault = refuse(&with(text), &[]);
        assert_eq!(fault.key, key, "{fault}");
        assert!(!labelled(&fault).is_empty());
    }
    for (size, cells) in [
        ("[0, 1, 1]", "[1, 1, 1]"),
        ("[1, 1, 1]", "[1, 0, 1]"),
        ("[1, 1, 1]", "[1, 1]"),
        ("[1, 1, 1]", "[9999999999, 9999999999, 9999999999]"),
    ] {
        let fault = refuse(&format!("[mesh.box]\nsize = {size}\ncells = {cells}"), &[]);
        assert!(fault.key.starts_with("mesh.box."), "{fault}");
    }
}

#[test]
fn class_42_incompressible_is_refused_and_nearly_so_is_warned_of() {
    let fault = refuse(&BASE.replace("0.3", "0.5"), &[]);
    assert_eq!((fault.key.as_str(), labelled(&fault)), ("materials.steel.poissons_ratio", "0.5"));
    assert!(fault.message.contains("incompressible"));
    let rubber = BASE.replace("0.3", "0.495");
    assert!(accept(&rubber, &["analysis.element=tet4"]).warnings[0].contains("lock"));
    assert!(accept(&rubber, &[]).warnings.is_empty());
}

#[test]
fn a_load_has_one_kind_and_a_table_one_selector() {
    let two_kinds = refuse(&with("[loads.b]\ngroup = \"g\"\npressure = 1\nforce = [1, 0, 0]"), &[]);
    assert_eq!((two_kinds.key.as_str(), labelled(&two_kinds)), ("loads.b.force", "[1, 0, 0]"));
    assert!(two_kinds.message.contains("`pressure`"));

    let none = refuse(&with("[loads.b]\ngroup = \"g\""), &[]);
    assert!(none.key == "loads.b" && help(&none).contains("traction"));

    let weight = refuse(&with("[loads.b]\ngroup = \"g\"\ngravity = [0, 0, -1]"), &[]);
    assert!(weight.key == "loads.b" && weight.message.contains("all cells"));

    let two = refuse(&with("[loads.b]\npressure = 1\ngroup = \"g\"\nplane = { normal = [1, 0, 0], offset = 0 }"), &[]);
    assert_eq!(two.key, "loads.b.plane");
    assert!(two.message.contains("`group`") && help(&two).contains("all = ["));

    let no_selector = refuse(&with("[supports.b]\nfix = [\"x\"]"), &[]);
    assert!(no_selector.key == "supports.b" && help(&no_selector).contains("plane"));

    let empty = refuse(&with("[supports.b]\nfix = [\"x\"]\nall = []"), &[]);
    assert_eq!(empty.key, "supports.b.all");

    let nested = refuse(&with("[supports.b]\nfix = [\"x\"]\nall = [{ group = \"g\" }, {}]"), &[]);
    assert_eq!(nested.key, "supports.b.all[1]");
}

#[test]
fn a_support_prescribes_each_direction_at_most_once() {
    assert!(help(&refuse(&with("[supports.b]\ngroup = \"g\""), &[])).contains("fix"));
    let twice = refuse(&with("[supports.b]\ngroup = \"g\"\nfix = [\"x\", \"y\"]\ndisplacement = { y = 1 }"), &[]);
    assert_eq!((twice.key.as_str(), labelled(&twice)), ("supports.b.fix[1]", "\"y\""));
}

#[test]
fn one_marking_and_one_mesh() {
    assert_eq!(refuse(&with("[adapt]\nmarking = {}"), &[]).key, "adapt.marking");
    assert_eq!(refuse(&with("[adapt]\nmarking = { doerfler = 0.5, maximum = 0.5 }"), &[]).key, "adapt.marking");
    assert!(help(&refuse("", &[])).contains("[mesh]"));
    assert!(help(&refuse("[mesh]\n", &[])).contains("file = "));
    let two = refuse("[mesh]\nfile = \"a\"\n[mesh.box]\nsize = [1, 1, 1]\ncells = [1, 1, 1]\n", &[]);
    assert_eq!(two.key, "mesh.box");
    let lacking = refuse("[mesh.box]\nsize = [1, 1, 1]\n", &[]);
    assert!(lacking.key == "mesh.box" && lacking.message.contains("`cells`") && help(&lacking).contains("cells = ["));
    let regions = refuse(&with("[materials.b]\nyoungs_modulus = 1\npoissons_ratio = 0"), &[]);
    assert!(regions.key == "materials.steel" && regions.message.contains("`b`"));
}

#[test]
fn text_that_is_not_toml_is_refused_with_its_place() {
    for (text, place) in [
        ("[mesh\nfile = 1", "dir/case.toml:1:6"),
        ("a = 1\na = 2", "dir/case.toml:2:1"),
        ("x = ", "dir/case.toml:1:5"),
        ("# äöü\n[mesh]\nfile = \"ä\" b", "dir/case.toml:3:12"),
    ] {
        assert_eq!(refuse(text, &[]).place, place, "{text:?}");
    }
}

#[test]
fn overrides_apply_to_tables_that_exist_and_to_those_that_do_not() {
    let s = accept(BASE, &["refine.strategy=none", "refine.scheme=red"]);
    assert_eq!((s.refine.strategy, s.refine.options.scheme), (Strategy::None, Scheme::Red));
    let s = accept(BASE, &["refine.scheme=red", "refine.steps=2"]);
    assert_eq!((s.refine.strategy, s.refine.steps), (Strategy::Global, 2));
    let table = with("[refine]\nstrategy = \"adaptive\"\nsteps = 1\n[adapt]\nmarking = { doerfler = 0.5 }");
    let s = accept(&table, &["refine.strategy=global", "refine.steps = 2", "adapt.marking={ maximum = 0.7 }"]);
    assert_eq!((s.refine.strategy, s.refine.steps, s.adapt.marking), (Strategy::Global, 2, Marking::Maximum(0.7)));
    let steel = ["materials.\"st.37\".group=x", "materials.\"st.37\".youngs_modulus=1"];
    let s = accept(BASE, &[steel[0], steel[1], "materials.\"st.37\".poissons_ratio=0", "title=a = b"]);
    assert_eq!((s.title.as_str(), s.materials[0].name.as_str()), ("a = b", "st.37"));
    assert_eq!(s.overrides.len(), 4);
}

/// What is written beside the results is the scenario with its overrides, but for the names of places in error messages.
#[test]
fn a_scenario_written_to_run_again_is_the_same() {
    let given = [
        "refine.scheme=sqrt3",
        "refine.steps=2",
        "supports.foot.fix=[\"x\"]",
        "supports.foot.all=[{ plane = { normal = [0, 0, 1], offset = -1e-7 } }, { not = { group = \"a \\\"b\\\"\" } }]",
        "adapt.marking={ maximum = 0.7 }",
        "title=line\nbreak",
    ];
    let s = accept(BASE, &given);
    let text = s.to_run_again(Strategy::Global, Some(Path::new("../there/part.msh"))).unwrap();
    let again = accept(&text, &[]);
    assert_eq!((again.refine.strategy, again.mesh), (Strategy::Global, MeshSource::File("../there/part.msh".into())));
    assert_eq!((again.title, again.refine.steps, again.refine.options), (s.title, 2, s.refine.options));
    assert_eq!((again.adapt, again.solver, again.output), (s.adapt, s.solver, s.output));
    let supports = |list: &[subsolid::scenario::Support]| {
        list.iter().map(|s| (s.selector.clone(), s.displacement.clone())).collect::<Vec<_>>()
    };
    assert_eq!(supports(&again.supports), supports(&s.supports));
    assert_eq!(again.supports.len(), 2);
}

#[test]
fn a_fault_in_an_override_names_the_override() {
    for (given, key, shown) in [
        ("refine.steps=-1", "refine.steps", "-1"),
        ("refine.steps=many", "refine.steps", "\"many\""),
        ("refine.stepz=1", "refine.stepz", "stepz"),
        ("refine.scheme=sqrt4", "refine.scheme", "\"sqrt4\""),
        ("loads.push.traction=[1, 2]", "loads.push.traction", "[1, 2]"),
        ("materials.steel.poissons_ratio=0.5", "materials.steel.poissons_ratio", "0.5"),
    ] {
        let fault = refuse(BASE, &["title=first", given]);
        let name = given.split('=').next().unwrap();
        assert!(fault.place.starts_with(&format!("--set {name}")), "{}", fault.place);
        assert_eq!((fault.key.as_str(), labelled(&fault)), (key, shown), "{fault}");
    }
    for given in ["refine.steps", "=3", "a b=3", "[refine]=1", "mesh.file.name=a"] {
        let fault = refuse(BASE, &[given]);
        assert!(fault.place.starts_with("--set") && fault.place.contains(given.split('=').next().unwrap()), "{fault}");
    }
    // The file's own faults stay in the file.
    assert_eq!(refuse("[mesh]\nfil = 1", &["title=a"]).place, "dir/case.toml:2:1");
}

#[test]
fn red_refinement_is_not_adaptive() {
    let fault = refuse(&with("[refine]\nstrategy = \"adaptive\""), &["refine.scheme=red"]);
    assert_eq!(fault.key, "refine.scheme");
    assert!(help(&fault).contains("refine.strategy = \"global\""));
}

#[test]
fn longest_edge_bisection_is_adaptive_unless_told_otherwise() {
    let s = accept(BASE, &["refine.scheme=longest-edge", "refine.boundary=interpolating"]);
    assert_eq!((s.refine.strategy, s.refine.options.scheme), (Strategy::Adaptive, Scheme::LongestEdge));
    let moves = s.warnings.iter().any(|w| w.contains("moves the surface"));
    assert!(!moves, "bisection keeps the surface whatever the rule");
    let s = accept(BASE, &["refine.scheme=sqrt3", "refine.boundary=interpolating"]);
    assert_eq!(s.refine.options.boundary, Boundary::Interpolating);
    assert!(s.warnings.iter().any(|w| w.contains("\"interpolating\" moves the surface")));
}

#[test]
fn a_boundary_rule_without_effect_is_warned_of() {
    for scheme in ["red", "longest-edge"] {
        let scheme = format!("refine.scheme={scheme}");
        let warnings = accept(BASE, &[&scheme, "refine.boundary=approximating"]).warnings;
        assert!(warnings.len() == 1 && warnings[0].contains("no effect"), "{warnings:?}");
        assert!(accept(BASE, &[&scheme]).warnings.is_empty());
    }
    let warnings = accept(BASE, &["refine.boundary=approximating"]).warnings;
    assert!(warnings.len() == 1 && warnings[0].contains("moves the surface"), "{warnings:?}");
}

#[test]
fn a_tube_needs_three_cells_around() {
    let tube = BASE.replace("file = \"part.msh\"", "tube = { radii = [1, 2], length = 1, cells = [1, 2, 1] }");
    let fault = refuse(&tube, &[]);
    assert_eq!((fault.key.as_str(), labelled(&fault)), ("mesh.tube.cells", "[1, 2, 1]"));
    assert!(fault.message.contains("three"), "{}", fault.message);
}

#[test]
fn an_unreadable_scenario_says_which() {
    let error = Scenario::from_file(Path::new("no/such.toml"), &[]).unwrap_err();
    assert!(error.to_string().contains("no/such.toml"));
    assert_eq!(Error::from(error).exit_code(), 3);
}

#[test]
fn every_bundled_scenario_is_accepted_as_it_stands() {
    let Ok(entries) = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios")) else {
        return println!("skipped: there is no folder scenarios/");
    };
    for path in entries.map(|e| e.unwrap().path()).filter(|p| p.extension().is_some_and(|e| e == "toml")) {
        Scenario::from_file(&path, &[]).unwrap_or_else(|e| panic!("{e}"));
    }
}

/// A text with `insert` in place of `length` characters from the `start`-th.
fn edited(text: &str, start: usize, length: usize, insert: &str) -> String {
    let mut chars: Vec<char> = text.chars().collect();
    let start = start % chars.len();
    let end = (start + length).min(chars.len());
    chars.splice(start..end, insert.chars());
    chars.into_iter().collect()
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(2000))]

    #[test]
    fn whatever_is_written_is_accepted_or_refused_with_a_place(
        start: usize,
        length in 0_usize..12,
        insert in "[a-z0-9.,=\\[\\]{}\"\n #ä€-]{0,6}",
        over in proptest::option::of("[a-z.]{0,12}=?[a-z0-9.\\[\\]{}\"ä-]{0,6}"),
    ) {
        let text = edited(EVERY_KEY, start, length, &insert);
        let overrides: Vec<&str> = over.iter().map(String::as_str).collect();
        if let Err(error) = parse(&text, &overrides) {
            let ScenarioError::Invalid(fault) = &error else { panic!("{error}") };
            let (offset, source) = (fault.span.offset(), fault.source_code.inner());
            assert!(source.get(offset..offset + fault.span.len()).is_some(), "{fault}");
            assert!(fault.place.starts_with("--set ") || fault.place.starts_with("dir/case.toml:"), "{fault}");
            assert!(!format!("{:?}", miette::Report::new(error)).is_empty());
        }
    }
}

#[test]
fn an_expression_is_refused_where_it_is_wrong() {
    for (text, key, label, advice) in [
        ("traction = [0, \"sine(x)\", 0]", "loads.b.traction[1]", "sine", "did you mean `sin`?"),
        ("traction = [0, \"1e3*X\", 0]", "loads.b.traction[1]", "X", "did you mean `x`?"),
        ("traction = [\"2x\", 0, 0]", "loads.b.traction[0]", "x", "for example"),
        ("pressure = \"(z - 2\"", "loads.b.pressure", "\"(z - 2\"", "for example"),
        ("pressure = \"\"", "loads.b.pressure", "\"\"", "for example"),
        ("pressure = \"1/0\"", "loads.b.pressure", "\"1/0\"", ""),
        ("pressure = \"\\u0078 + r\"", "loads.b.pressure", "\"\\u0078 + r\"", "its"),
    ] {
        let fault = refuse(&with(&format!("[loads.b]\ngroup = \"g\"\n{text}")), &[]);
        assert_eq!((fault.key.as_str(), labelled(&fault)), (key, label), "{fault}");
        assert!(help(&fault).contains(advice) || advice == "its", "{text}: {}", help(&fault));
    }
    let fault = refuse(BASE, &["loads.push.traction=[0, \"y + sine(x)\", 0]"]);
    assert_eq!((labelled(&fault), fault.place.starts_with("--set")), ("sine", true), "{fault}");
    let fault = refuse(&with("[supports.b]\ngroup = \"g\"\ndisplacement = { x = true }"), &[]);
    assert!(fault.message.contains("a number or an expression") && fault.message.contains("true"), "{fault}");
}

#[test]
fn supports_and_loads_say_what_does_not_go_together() {
    for (text, key, word) in [
        ("[supports.b]\ngroup = \"g\"", "supports.b", "spring"),
        ("[supports.b]\ngroup = \"g\"\nspring = 0", "supports.b.spring", "not all zero"),
        ("[supports.b]\ngroup = \"g\"\nspring = [1, -1, 0]", "supports.b.spring", "not negative"),
        ("[supports.b]\ngroup = \"g\"\nspring = [1, 2]", "supports.b.spring", "3"),
        ("[supports.b]\ngroup = \"g\"\nspring = nan", "supports.b.spring", "finite"),
        ("[supports.b]\ngroup = \"g\"\nfix = \"norml\"", "supports.b.fix", "did you mean `normal`?"),
        ("[supports.b]\ngroup = \"g\"\nfix = [\"normal\", \"x\"]", "supports.b.fix[0]", "two supports"),
        ("[supports.b]\ngroup = \"g\"\nsymmetry = false", "supports.b", "prescribes nothing"),
        ("[loads.b]\npoint = [0, 0, 0]", "loads.b.point", "force"),
        ("[loads.b]\npoint = [0, 0]\nforce = [1, 0, 0]", "loads.b.point", "3"),
        ("[loads.b]\npoint = [0, 0, 0]\nforce = [1, 0, 0]\ngroup = \"g\"", "loads.b", "remove the selector"),
        ("[loads.b]\nbody_force = [1, 0, 0]\ngroup = \"g\"", "loads.b", "all cells"),
        ("[loads.b]\nbody_force = [1, 0, 0]\ngravity = [0, 0, 1]", "loads.b.gravity", "one kind"),
        ("[units]\nlenght = \"mm\"", "units.lenght", "did you mean `length`?"),
        ("[units]\nlength = 1", "units.length", "a string"),
    ] {
        let fault = refuse(&with(text), &[]);
        assert_eq!(fault.key, key, "{text}: {fault}");
        let said = format!("{} {}", fault.message, help(&fault));
        assert!(said.contains(word), "{text}: {said}");
    }
}

#[test]
fn units_are_kept_as_written() {
    let s = accept(&with("[units]\nlength = \"mm\"\nstress = \"MPa\""), &[]);
    assert_eq!((s.units.length.as_deref(), s.units.stress.as_deref(), s.units.force), (Some("mm"), Some("MPa"), None));
}

/// Whether a schema, with its definitions in `root`, has a place for every key of a value.
fn has_keys(root: &serde_json::Value, schema: &serde_json::Value, value: &toml::Value) -> bool {
    if let Some(path) = schema["$ref"].as_str() {
        return has_keys(root, root.pointer(path.trim_start_matches('#')).unwrap(), value);
    }
    if let Some(options) = schema["anyOf"].as_array().or(schema["oneOf"].as_array()) {
        return options.iter().any(|option| has_keys(root, option, value));
    }
    match value {
        toml::Value::Table(table) => table.iter().all(|(key, value)| {
            let known = schema["properties"].get(key).or(schema.get("additionalProperties"));
            known.is_some_and(|inner| inner.is_object() && has_keys(root, inner, value))
        }),
        toml::Value::Array(list) => list.iter().all(|item| has_keys(root, &schema["items"], item)),
        _ => true,
    }
}

#[test]
fn the_schema_knows_every_key_and_no_other() {
    let schema = subsolid::scenario::schema();
    let more = "[units]\nlength = \"mm\"\n[supports.s]\ngroup = \"g\"\nsymmetry = true\nspring = [1, 2, 3]\n\
         [loads.q]\npoint = [0, 0, 0]\nforce = [1, 0, 0]\n[loads.r]\nbody_force = [\"x\", 0, 0]\n";
    let text = format!("{EVERY_KEY}{more}");
    accept(&text, &[]);
    let known = |text: &str| has_keys(&schema, &schema, &toml::Value::Table(text.parse().unwrap()));
    assert!(known(&text));
    for wrong in [("steps = 4", "stepz = 4"), ("[units]", "[unit]"), ("radius = 2", "diameter = 4")] {
        assert!(!known(&text.replacen(wrong.0, wrong.1, 1)), "{wrong:?}");
    }
}

//! Whole runs of the program on small boxes: how they end, what they say, what they leave.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;

/// A bar of four bricks, held so that it can stretch freely, and pulled: its stress is constant.
const PULLED: &str = r#"
[mesh.box]
size = [2.0, 1.0, 1.0]
cells = [4, 2, 2]
[materials.steel]
youngs_modulus = 1000.0
poissons_ratio = 0.3
[supports.x]
group = "x-min"
fix = ["x"]
[supports.y]
group = "y-min"
fix = ["y"]
[supports.z]
group = "z-min"
fix = ["z"]
[loads.pull]
group = "x-max"
traction = [1.0, 0.0, 0.0]
[refine]
steps = 2
"#;

/// The bar clamped and bent.
const BENT: &str = r#"
[mesh.box]
size = [2.0, 1.0, 1.0]
cells = [4, 2, 2]
[materials.steel]
youngs_modulus = 1000.0
poissons_ratio = 0.3
[supports.clamp]
group = "x-min"
fix = ["x", "y", "z"]
[loads.tip]
group = "x-max"
force = [0.0, 0.0, -1.0]
[refine]
steps = 2
"#;

/// One tetrahedron on its face z = 0, in Gmsh's format.
const CELL: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n\
                    $Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n";

/// A scenario for it.
const SINGLE: &str = r#"
mesh.file = "cell.msh"
[materials.steel]
youngs_modulus = 1000.0
poissons_ratio = 0.3
[supports.foot]
plane = { normal = [0.0, 0.0, 1.0], offset = 0.0 }
fix = ["x", "y", "z"]
[loads.push]
normal = { direction = [1.0, 1.0, 1.0], angle = 1.0 }
traction = [1.0, 0.0, 0.0]
[refine]
strategy = "none"
"#;

/// A folder that holds the scenarios.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("pulled.toml", PULLED), ("bent.toml", BENT), ("cell.toml", SINGLE), ("cell.msh", CELL)] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// Runs `subsolid` in a folder; gives its exit code, standard output and standard error.
fn subsolid(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::cargo_bin("subsolid").unwrap().args(arguments).current_dir(folder).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Runs a scenario of the folder with settings; gives what it printed and its report.
fn run(folder: &Path, scenario: &str, settings: &[&str]) -> (String, Value) {
    let file = format!("{scenario}.toml");
    let mut arguments = vec!["run", &file];
    settings.iter().for_each(|s| arguments.extend(["--set", s]));
    let (code, stdout, stderr) = subsolid(folder, &arguments);
    assert_eq!(code, Some(0), "{stderr}");
    (stdout, json(&folder.join("results").join(scenario).join("report.json")))
}

#[test]
fn class_60_an_exact_solution_is_not_refined() {
    let folder = folder();
    let (stdout, report) = run(folder.path(), "pulled", &[]);
    assert_eq!((&report["stop_reason"], report["steps"].as_array().unwrap().len()), (&"exact".into(), 1));
    assert!(report["steps"][0]["error"]["relative"].as_f64().unwrap() < 1e-12);
    assert!(stdout.contains("stopped after step 0: 96 cells, the estimated error is rounding"), "{stdout}");
}

#[test]
fn a_marking_that_selects_nothing_is_not_exact() {
    let folder = folder();
    let (stdout, report) = run(folder.path(), "bent", &["adapt.marking={ threshold = 1e9 }"]);
    assert_eq!((&report["stop_reason"], report["steps"].as_array().unwrap().len()), (&"steps".into(), 1));
    assert!(report["warnings"][0].as_str().unwrap().contains("marking selected no cell"));
    assert!(stdout.contains("warning: marking selected no cell"), "{stdout}");
}

#[test]
fn runs_say_why_they_ended() {
    let folder = folder();
    let (stdout, _) = run(folder.path(), "bent", &["refine.stop.max_cells=100"]);
    assert!(stdout.contains("cells, max_cells = 100 reached"), "{stdout}");
    let (stdout, _) = run(folder.path(), "bent", &["refine.stop.relative_error=0.9"]);
    assert!(stdout.contains("90.0 % asked for"), "{stdout}");
    let (stdout, _) = run(folder.path(), "bent", &["refine.steps=1"]);
    assert!(stdout.contains("stopped after step 1") && stdout.contains("steps = 1 reached"), "{stdout}");
    let (_, stdout, _) = subsolid(folder.path(), &["compare", "bent.toml", "--set", "refine.steps=1"]);
    assert!(stdout.contains("global: stopped after") && stdout.contains("adaptive: stopped after"), "{stdout}");
}

#[test]
fn the_error_of_a_single_cell_is_not_known() {
    let folder = folder();
    let (_, report) = run(folder.path(), "cell", &[]);
    assert_eq!(report["stop_reason"], "steps");
    let error = &report["steps"][0]["error"];
    assert!(error["relative"].is_null() && error["energy"].is_null() && error["normalised_mean"].is_null(), "{error}");
    assert!(report["warnings"][0].as_str().unwrap().contains("the error of 1 cell cannot be estimated"));
    let arguments = ["run", "cell.toml", "--set", "refine.stop.relative_error=0.99"];
    let (code, _, stderr) = subsolid(folder.path(), &arguments);
    assert_eq!(code, Some(7));
    assert!(stderr.contains("cannot be estimated") && stderr.contains("99.0 %"), "{stderr}");
    // Refined, it can be estimated.
    let (_, report) = run(folder.path(), "cell", &["refine.strategy=adaptive", "refine.steps=2"]);
    assert!(report["steps"][2]["error"]["relative"].is_f64(), "{report}");
}

#[test]
fn large_displacements_are_doubted() {
    let folder = folder();
    let (stdout, _) = run(folder.path(), "bent", &["loads.tip.force=[0.0, 0.0, -100.0]", "refine.steps=0"]);
    assert!(stdout.contains("of the model's diagonal: check units"), "{stdout}");
    let (stdout, _) = run(folder.path(), "bent", &["refine.steps=0"]);
    assert!(!stdout.contains("diagonal"), "{stdout}");
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort_unstable();
    names
}

#[test]
fn the_copied_scenario_runs_again_to_the_same_bytes() {
    let folder = folder();
    run(folder.path(), "cell", &["refine.strategy=adaptive", "refine.steps=1", "loads.push.traction=[0, 0, -1.0]"]);
    let results = folder.path().join("results/cell");
    let arguments = ["run", "results/cell/scenario.toml", "--output", "again"];
    let (code, _, stderr) = subsolid(folder.path(), &arguments);
    assert_eq!(code, Some(0), "{stderr}");
    for file in ["step_000.vtu", "step_001.vtu"] {
        let [one, two] =
            [results.join(file), folder.path().join("again").join(file)].map(|f| std::fs::read(f).unwrap());
        assert!(one == two, "{file} differs");
    }
    let (code, ..) = subsolid(folder.path(), &["compare", "bent.toml", "--set", "refine.steps=1", "--quiet"]);
    assert_eq!(code, Some(0));
    for strategy in ["global", "adaptive"] {
        let copy =
            std::fs::read_to_string(folder.path().join(format!("results/bent/{strategy}/scenario.toml"))).unwrap();
        assert!(copy.contains(&format!("strategy = \"{strategy}\"")) && copy.contains("steps = 1"), "{copy}");
    }
    // Run in its own folder it is not overwritten.
    std::fs::copy(folder.path().join("bent.toml"), folder.path().join("scenario.toml")).unwrap();
    let (code, ..) = subsolid(folder.path(), &["run", "scenario.toml", "--output", ".", "--quiet"]);
    assert_eq!(
        (code, std::fs::read_to_string(folder.path().join("scenario.toml")).unwrap()),
        (Some(0), BENT.to_owned())
    );
}

#[test]
fn run_and_compare_do_not_mix() {
    let folder = folder();
    let results = folder.path().join("results/bent");
    let command = |command, settings: &[&str]| {
        let mut arguments = vec![command, "bent.toml", "--quiet"];
        settings.iter().for_each(|s| arguments.extend(["--set", s]));
        assert_eq!(subsolid(folder.path(), &arguments).0, Some(0));
        names(&results)
    };
    let run = command("run", &["refine.steps=1"]);
    std::fs::write(results.join("notes.txt"), "mine").unwrap();
    let compared = command("compare", &["refine.steps=1"]);
    assert!(compared.contains(&"compare.json".to_owned()) && !compared.contains(&"report.json".to_owned()));
    let mut again = command("run", &["refine.steps=1"]);
    again.retain(|n| n != "notes.txt");
    assert_eq!(again, run);
    assert!(results.join("notes.txt").exists());
    assert!(command("run", &["refine.steps=0"]).len() < run.len() + 1);
}

/// A run whose folder holds its own mesh, or files that no run wrote, leaves all as it was.
#[test]
fn results_replace_nothing_but_earlier_results() {
    let folder = folder();
    let at = |file: &str| folder.path().join(file);
    run(folder.path(), "cell", &["refine.strategy=adaptive", "refine.steps=1"]);
    let (code, ..) = subsolid(folder.path(), &["compare", "cell.toml", "--output", "cd", "--quiet"]);
    assert_eq!(code, Some(0));
    std::fs::create_dir(at("keep")).unwrap();
    for file in ["keep/view.py", "step_000.vtu", "step_007.vtu"] {
        std::fs::copy(at("results/cell/step_001.vtu"), at(file)).unwrap();
    }
    let push = "loads.push.normal={ direction = [1, 1, 1], angle = 1 }";
    let refused = |command, mesh: &str, more: &[&str], blamed: &str| {
        let before = ["", "results/cell", "cd", "cd/global", "cd/adaptive", "keep"].map(|f| names(&at(f)));
        let mesh = format!("mesh.file={mesh}");
        let arguments = [&[command, "cell.toml", "--set", &mesh, "--set", push, "--quiet"], more].concat();
        let (code, _, stderr) = subsolid(folder.path(), &arguments);
        let text = stderr.replace(['\n', '│', ' '], "");
        assert!(code == Some(6) && text.contains(blamed) && text.contains("--output"), "{stderr}");
        assert_eq!(["", "results/cell", "cd", "cd/global", "cd/adaptive", "keep"].map(|f| names(&at(f))), before);
    };
    refused("run", "results/cell/step_001.vtu", &[], "step_001.vtuisthemesh");
    refused("run", "cd/global/step_000.vtu", &["--output", "cd"], "step_000.vtuisthemesh");
    refused("compare", "cd/adaptive/step_000.vtu", &["--output", "cd"], "step_000.vtuisthemesh");
    refused("run", "step_000.vtu", &["--output", "."], "step_000.vtuisintheway");
    refused("run", "cell.msh", &["--output", "keep"], "view.pyisintheway");
    // What no run listed stays, though it has the name of a step.
    std::fs::remove_file(at("keep/view.py")).unwrap();
    std::fs::write(at("keep/step_999.vtu"), "mine").unwrap();
    for _ in 0..2 {
        let (code, _, stderr) = subsolid(folder.path(), &["run", "cell.toml", "--output", "keep", "--quiet"]);
        assert_eq!(
            (code, std::fs::read_to_string(at("keep/step_999.vtu")).unwrap().as_str()),
            (Some(0), "mine"),
            "{stderr}"
        );
    }
}

/// A surface inside the solid is named where the mesh is read, and where a load asks for it.
#[test]
fn class_45_a_load_on_faces_inside_the_solid_is_refused_by_name() {
    let folder = folder();
    let two = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 7 \"interface\"\n$EndPhysicalNames\n$Nodes\n5\n\
               1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n$EndNodes\n$Elements\n3\n1 2 2 7 1 1 2 3\n\
               2 4 2 1 1 1 2 3 4\n3 4 2 1 1 1 3 2 5\n$EndElements\n";
    std::fs::write(folder.path().join("two.msh"), two).unwrap();
    let scenario = SINGLE
        .replace("cell.msh", "two.msh")
        .replace("plane = { normal = [0.0, 0.0, 1.0], offset = 0.0 }", "not = { group = \"interface\" }");
    std::fs::write(folder.path().join("two.toml"), scenario).unwrap();
    let (_, stdout, _) = subsolid(folder.path(), &["inspect", "two.msh"]);
    assert!(stdout.contains("1 triangle is not on the boundary") && stdout.contains("`interface`"), "{stdout}");
    for command in ["run", "check"] {
        let (code, _, stderr) = subsolid(folder.path(), &[command, "two.toml"]);
        assert!(code == Some(5) && stderr.contains("group `interface` lies inside the solid"), "{stderr}");
    }
}

#[test]
fn check_tells_what_holds_and_what_acts() {
    let folder = folder();
    let heavy = ["materials.steel.density=3.0", "loads.weight.gravity=[0.0, 0.0, -2.0]"];
    let arguments = ["check", "bent.toml", "--json", "-", "--set", heavy[0], "--set", heavy[1]];
    let (code, stdout, stderr) = subsolid(folder.path(), &arguments);
    assert_eq!(code, Some(0), "{stderr}");
    let json: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(json["supports"][0]["displacement"], serde_json::json!([0.0, 0.0, 0.0]));
    let weight = json["loads"].as_array().unwrap().iter().find(|l| l["name"] == "weight").unwrap();
    // Density 3, volume 2, acceleration 2.
    assert!((weight["total_force"][2].as_f64().unwrap() + 12.0).abs() < 1e-12, "{weight}");
    assert_eq!((json["groups"].as_array().unwrap().len(), &json["regions"][0]["cells"]), (6, &96.into()));
    let (_, stdout, _) = subsolid(folder.path(), &["check", "pulled.toml"]);
    assert!(stdout.contains("free") && stdout.contains("traction") && stdout.contains("results/pulled"), "{stdout}");
}

#[test]
fn a_run_prints_reactions_that_balance_the_loads() {
    let folder = folder();
    let (stdout, _) = run(folder.path(), "bent", &["refine.steps=0"]);
    let line = stdout.lines().find(|l| l.starts_with("sum")).unwrap();
    let z: f64 = line.split_whitespace().last().unwrap().parse().unwrap();
    assert!((z - 1.0).abs() < 1e-5, "{line}");
}

#[test]
fn variants_are_compared_on_equal_terms() {
    let folder = tempfile::tempdir().unwrap();
    let text = "title = \"cell\"\nmesh.l-prism = { cells = 1 }\n\
                materials.m = { youngs_modulus = 1.0, poissons_ratio = 0.3 }\nexact.solution = \"l-prism\"\n\
                analysis.element = \"tet4\"\n\
                supports.sides = { any = [{ group = \"x-min\" }, { group = \"x-max\" }, { group = \"y-min\" }, { group = \"y-max\" }], fix = \"exact\" }\n\
                supports.ends = { any = [{ group = \"z-min\" }, { group = \"z-max\" }], fix = [\"z\"] }\n\
                refine = { steps = 8, stop.max_cells = 300 }\noutput.vtk = false\n";
    std::fs::write(folder.path().join("l.toml"), text).unwrap();
    let run = |arguments: &[&str]| {
        subsolid(folder.path(), &[&["compare", "l.toml", "--output", "out", "--repeat", "1"], arguments].concat())
    };
    let (code, stdout, stderr) = run(&["--schemes"]);
    assert_eq!(code, Some(0), "{stdout}{stderr}");
    let json = std::fs::read_to_string(folder.path().join("out/compare.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let variants = json["variants"].as_array().unwrap();
    let names: Vec<&str> = variants.iter().map(|v| v["name"].as_str().unwrap()).collect();
    let all = ["sqrt3-paper", "sqrt3-quality", "sqrt3-error", "bisection", "bisection-error", "red", "red-error"];
    assert_eq!(names, all);
    assert_eq!(json["error_source"], "true");
    // The same input mesh and solver: the first steps agree to the last bit, and every run has paid for the common error.
    for variant in variants {
        let first = |key: &str| variant["report"]["steps"][0][key].clone();
        assert_eq!(first("strain_energy"), variants[0]["report"]["steps"][0]["strain_energy"]);
        let unknowns = variant["paid"]["unknowns"].as_f64().unwrap();
        assert!(unknowns >= first("free_dofs").as_f64().unwrap(), "{variant}");
        // Over few steps a slope says nothing.
        assert_eq!(variant["slope"].is_null(), variant["slope_steps"].as_u64().unwrap() < 4, "{variant}");
    }
    for file in
        ["error_dofs.svg", "error_seconds.svg", "error_memory.svg", "red/report.json", "sqrt3-error/scenario.toml"]
    {
        assert!(folder.path().join("out").join(file).is_file(), "{file}");
    }
    let (code, stdout, _) = run(&["--variant", "coarse", "--variant", "fine: mesh.l-prism.cells=2"]);
    assert!(code == Some(0) && stdout.contains("fine") && stdout.contains("coarse"), "{stdout}");
    let (code, _, stderr) = run(&["--variant", "a", "--variant", "a: refine.steps=1"]);
    assert!(code == Some(2) && stderr.contains("`a` and `a` would share a folder"), "{stderr}");
    let (code, _, stderr) = run(&["--variant", "a: refine.stepps=1"]);
    assert!(
        code == Some(3) && stderr.contains("--variant a: refine.stepps=1") && !stderr.contains("--set"),
        "{stderr}"
    );
}

/// What a scenario expects and the tolerance it asks for hold for each variant; the code is that of a run.
#[test]
fn variants_that_are_not_as_expected_or_miss_their_tolerance_fail_by_name() {
    let folder = folder();
    std::fs::write(
        folder.path().join("pull.toml"),
        "title = \"Bar\"\nanalysis.element = \"tet4\"\nmesh.box = { size = [2, 1, 1], cells = [2, 1, 1] }\n\
         materials.m = { youngs_modulus = 1e3, poissons_ratio = 0.25 }\n\
         supports.x = { group = \"x-min\", fix = [\"x\", \"y\", \"z\"] }\n\
         loads.pull = { group = \"x-max\", traction = [1, 0, 0] }\n\
         quantities.tip = { average = \"ux\", group = \"x-max\" }\nadapt.goal = \"tip\"\n\
         refine = { strategy = \"adaptive\", steps = 1 }\noutput.vtk = false\n\
         expect.tip = { value = 1.95e-3, tolerance = { relative = 0.1 } }\n",
    )
    .unwrap();
    let run = |variants: &[&str]| {
        let options: Vec<&str> = variants.iter().flat_map(|v| ["--variant", v]).collect();
        subsolid(folder.path(), &[&["compare", "pull.toml", "--output", "out", "--repeat", "1"], &options[..]].concat())
    };
    let soft = "soft: materials.m.youngs_modulus=500";
    let missed = "missed: refine.stop.relative_error=1e-6";
    let (code, stdout, stderr) = run(&["as-it-is", soft, missed]);
    assert_eq!(code, Some(1), "{stdout}{stderr}");
    assert!(
        stderr.contains("soft: not as expected: tip is") && stderr.contains("missed: the estimated relative error")
    );
    assert!(!stderr.contains("as-it-is"), "{stderr}");
    let line = |start: &str, word: &str| stdout.lines().any(|l| l.starts_with(start) && l.contains(word));
    assert!(line("soft", "FAIL") && line("as-it-is", "pass") && line("as-it-is", "+-"), "{stdout}");
    let (code, ..) = run(&["as-it-is", missed]);
    assert_eq!(code, Some(7));
    let (code, ..) = run(&["as-it-is"]);
    assert_eq!(code, Some(0));
}

/// A plate a hundred times as long as thick: its cells are flat because it is thin, and repairs of their angles cost accuracy.
#[test]
fn optimisation_keeps_the_accuracy_of_thin_plates() {
    let folder = folder();
    let plate = "mesh.box = { size = [10, 10, 0.1], cells = [10, 10, 1] }\n\
                 materials.m = { youngs_modulus = 1000, poissons_ratio = 0.3 }\n\
                 supports.c = { group = \"x-min\", fix = [\"x\", \"y\", \"z\"] }\n\
                 loads.l = { group = \"z-max\", traction = [0, 0, -1e-4] }\n\
                 refine = { steps = 1 }\nadapt.marking = { doerfler = 0.8 }\noutput.vtk = false\n";
    std::fs::write(folder.path().join("plate.toml"), plate).unwrap();
    let steps = |settings: &[&str]| {
        let (_, report) = run(folder.path(), "plate", settings);
        let of = |i: usize, key: &[&str]| key.iter().fold(&report["steps"][i], |v, k| &v[*k]).as_f64().unwrap();
        [0, 1].map(|i| (of(i, &["strain_energy"]), of(i, &["error", "relative"])))
    };
    let [before, after] = steps(&[]);
    assert!(after.0 > before.0 && after.1 < 0.9 * before.1, "{before:?} {after:?}");
    // On cells twenty times as long as thick the mesh may be another, but hardly a worse one.
    let [before, after] = steps(&["mesh.box.cells=[5, 5, 1]", "refine.scheme=longest-edge"]);
    assert!(after.0 > 0.995 * before.0, "{before:?} {after:?}");
}

/// Of the bundled scenarios, the one with the longest names and most quantities among those that take no time.
#[test]
fn tables_fit_into_a_terminal() {
    let folder = folder();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let scenario = root.join("scenarios/verification/timoshenko-1.toml");
    let scenario = scenario.to_str().unwrap();
    let bent = folder.path().join("bent.toml");
    let bent = bent.to_str().unwrap();
    for arguments in [
        &["check", scenario][..],
        &["run", scenario, "--output", "out"],
        &["compare", bent, "--output", "out", "--repeat", "1", "--set", "refine.stop.max_cells=200", "--schemes"],
        &["compare", bent, "--output", "out", "--repeat", "1"],
    ] {
        let (_, stdout, _) = subsolid(folder.path(), arguments);
        assert!(stdout.lines().count() > 10, "{arguments:?}");
        // Paths are as long as they are.
        let wide = stdout.lines().find(|l| l.chars().count() > 80 && !l.contains('/'));
        assert_eq!(wide, None, "{arguments:?}");
    }
}

/// A script that reads `report.json` alone sees what was said before the run.
#[test]
fn the_report_repeats_what_was_said_before_the_run() {
    let folder = folder();
    let rubber = ["materials.steel.poissons_ratio=0.499", "analysis.element=tet4", "refine.strategy=none"];
    let (stdout, report) = run(folder.path(), "bent", &rubber);
    let lock = |w: &&Value| w.as_str().unwrap().contains("incompressible");
    assert_eq!(report["warnings"].as_array().unwrap().iter().filter(lock).count(), 1, "{report:#}");
    assert_eq!(stdout.matches("incompressible").count(), 1, "{stdout}");
}

/// The arrays of a page: the texts of its steps.
fn page_arrays(page: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(page).unwrap();
    text.lines().filter(|line| line.starts_with("<script type=\"text/plain\" id=\"step-")).map(str::to_owned).collect()
}

#[test]
fn pages_do_not_depend_on_threads_and_are_written_again() {
    let folder = folder();
    let at = |file: &str| folder.path().join(file);
    let command = |arguments: &[&str]| {
        let (code, _, stderr) = subsolid(folder.path(), arguments);
        assert_eq!(code, Some(0), "{stderr}");
    };
    for threads in ["1", "2"] {
        command(&["run", "bent.toml", "--quiet", "--threads", threads, "--output", threads]);
    }
    let arrays = page_arrays(&at("1/report.html"));
    assert_eq!((arrays.len(), &arrays), (3, &page_arrays(&at("2/report.html"))));

    // From files, faces may begin at another corner.
    let again = ["1", "2"].map(|of| {
        command(&["report", of, "--quiet"]);
        page_arrays(&at(of).join("report.html"))
    });
    assert!(again[0].len() == 3 && again[0] == again[1]);

    command(&["compare", "bent.toml", "--quiet", "--set", "refine.steps=1", "--repeat", "1"]);
    assert_eq!(page_arrays(&at("results/bent/report.html")).len(), 4);
    command(&["report", "results/bent", "--quiet"]);
    assert_eq!(page_arrays(&at("results/bent/report.html")).len(), 4);

    command(&["run", "bent.toml", "--quiet", "--set", "output.report=false", "--output", "none"]);
    assert!(!names(&at("none")).contains(&"report.html".to_owned()));
    let (code, _, stderr) = subsolid(folder.path(), &["report", "none"]);
    assert!(code == Some(6) && stderr.contains("no results"), "{code:?} {stderr}");
}

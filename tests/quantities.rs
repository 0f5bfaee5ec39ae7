//! Quantities, probes and expectations of whole runs, against what is known of the solutions.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;

/// A bar that is held so that it can stretch freely, and pulled: its stress is constant, u = (x, -nu y, -nu z) / E.
const PULLED: &str = r#"
[mesh.box]
size = [2.0, 1.0, 1.0]
cells = [4, 2, 3]
[materials.steel]
youngs_modulus = 1000.0
poissons_ratio = 0.3
density = 5.0
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
"#;

/// A beam of length 10 and section 1 x 1 of linear elements, clamped and bent by a force of 1.
const BENT: &str = r#"
[mesh.box]
size = [10.0, 1.0, 1.0]
cells = [40, 6, 6]
[analysis]
element = "tet4"
[materials.steel]
youngs_modulus = 1000.0
poissons_ratio = 0.0
[supports.clamp]
group = "x-min"
fix = ["x", "y", "z"]
[loads.tip]
group = "x-max"
force = [0.0, 0.0, -1.0]
"#;

/// Runs a scenario in a folder; gives its exit code, standard output and standard error.
fn subsolid(folder: &Path, text: &str, settings: &[&str]) -> (Option<i32>, String, String) {
    std::fs::write(folder.join("case.toml"), text).unwrap();
    let mut command = Command::cargo_bin("subsolid").unwrap();
    command.args(["run", "case.toml", "--output", "results"]).current_dir(folder);
    settings.iter().for_each(|s| {
        command.args(["--set", s]);
    });
    let output = command.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// The report of a scenario that runs.
fn report(text: &str) -> (Value, String) {
    let folder = tempfile::tempdir().unwrap();
    let (code, stdout, stderr) = subsolid(folder.path(), text, &[]);
    assert_eq!(code, Some(0), "{stderr}");
    let json = std::fs::read_to_string(folder.path().join("results/report.json")).unwrap();
    (serde_json::from_str(&json).unwrap(), stdout)
}

/// The exit code and the messages of a scenario that does not.
fn refused(text: &str) -> (Option<i32>, String) {
    let folder = tempfile::tempdir().unwrap();
    let (code, _, stderr) = subsolid(folder.path(), text, &[]);
    assert!(!folder.path().join("results").exists(), "results of a scenario that was refused");
    (code, stderr.split_whitespace().collect::<Vec<_>>().join(" "))
}

#[test]
fn quantities_of_a_linear_field_are_exact() {
    // Each quantity of u = (x, -0.3 y, -0.3 z) / 1000 on [0, 2] x [0, 1] x [0, 1] under the stress XX = 1, by hand.
    let at = [0.31, 0.77, 0.23_f64];
    let length = 1e-3 * (at[0].powi(2) + 0.09 * (at[1].powi(2) + at[2].powi(2))).sqrt();
    let within = "within = { min = [0.1, 0.2, 0.3], max = [0.9, 0.5, 3.0] }";
    let overlap = 0.8 * 0.3 * 0.7;
    let cases = [
        ("average = \"ux\"\ngroup = \"x-max\"".to_owned(), 2e-3),
        ("average = \"uy\"\nnormal = { direction = [0, 0, 1], angle = 1 }".to_owned(), -0.15e-3),
        ("average = \"ux\"".to_owned(), 1e-3),
        (format!("average = \"ux\"\n{within}"), 0.5e-3),
        (format!("average = \"uz\"\n{within}"), -0.3e-3 * 0.65),
        (format!("average = \"sxx\"\n{within}"), 1.0),
        ("average = \"von-mises\"\ngroup = \"z-max\"".to_owned(), 1.0),
        ("average = \"syz\"\nregion = \"solid\"".to_owned(), 0.0),
        (format!("value = \"ux\"\npoint = {at:?}"), 0.31e-3),
        (format!("value = \"displacement\"\npoint = {at:?}"), length),
        (format!("value = \"sxx\"\npoint = {at:?}"), 1.0),
        ("value = \"ux\"\npoint = [2, 1, 1]".to_owned(), 2e-3),
        ("maximum = \"von-mises\"".to_owned(), 1.0),
        (format!("maximum = \"ux\"\n{within}"), 0.9e-3),
        ("maximum = \"uy\"\ngroup = \"y-max\"".to_owned(), -0.3e-3),
        ("total = \"strain-energy\"".to_owned(), 1e-3),
        (format!("total = \"strain-energy\"\n{within}"), 0.5e-3 * overlap),
        (format!("total = \"volume\"\n{within}"), overlap),
        ("total = \"mass\"".to_owned(), 10.0),
        ("reaction = \"x\"\ncomponent = \"x\"".to_owned(), -1.0),
        ("reaction = \"y\"\ncomponent = \"y\"".to_owned(), 0.0),
    ];
    let tables = cases.iter().enumerate().map(|(i, (keys, _))| format!("[quantities.q{i:02}]\n{keys}\n"));
    let text = format!("{PULLED}{}", tables.collect::<String>());
    // On the mesh itself, and on those that refinement makes of it.
    for refine in ["", "[refine]\nstrategy = \"global\"\nsteps = 1\n"] {
        let (report, stdout) = report(&format!("{text}{refine}"));
        let step = report["steps"].as_array().unwrap().last().unwrap();
        for (i, (keys, expected)) in cases.iter().enumerate() {
            let value = step["quantities"][format!("q{i:02}")]["value"].as_f64().unwrap();
            let scale = if *expected == 0.0 { 1.0 } else { expected.abs() };
            assert!((value - expected).abs() < 1e-9 * scale, "{keys}: {value}, not {expected}");
        }
        assert!(stdout.contains("Quantities"), "{stdout}");
    }
}

#[test]
fn reactions_balance_the_load_and_energy_is_half_the_work_on_every_mesh() {
    let (report, _) = report(
        &format!(
            "{BENT}[refine]\nsteps = 1\n[quantities.up]\nreaction = \"clamp\"\ncomponent = \"z\"\n\
         [quantities.tip]\naverage = \"uz\"\ngroup = \"x-max\"\n[quantities.energy]\ntotal = \"strain-energy\"\n"
        )
        .replace("[40, 6, 6]", "[10, 2, 2]"),
    );
    let steps = report["steps"].as_array().unwrap();
    assert_eq!(steps.len(), 2);
    for step in steps {
        let value = |name: &str| step["quantities"][name]["value"].as_f64().unwrap();
        assert!((value("up") - 1.0).abs() < 1e-6);
        // The force of 1 is spread evenly, so that its work is the mean displacement of its face.
        assert!((value("energy") + 0.5 * value("tip")).abs() < 1e-6 * value("energy"));
        assert!((value("energy") - step["strain_energy"].as_f64().unwrap()).abs() < 1e-9 * value("energy"));
    }
}

#[test]
fn a_probe_along_a_cantilever_follows_beam_theory() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("{BENT}[probes.axis]\nfrom = [0, 0.5, 0.5]\nto = [12, 0.5, 0.5]\npoints = 25\n");
    let (code, _, stderr) = subsolid(folder.path(), &text, &[]);
    assert_eq!(code, Some(0), "{stderr}");
    let table = std::fs::read_to_string(folder.path().join("results/probe_axis.csv")).unwrap();
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("s,x,y,z,ux,uy,uz,sxx,syy,szz,sxy,syz,sxz,von_mises"));
    let rows: Vec<Vec<Option<f64>>> = lines.map(|l| l.split(',').map(|x| x.parse().ok()).collect()).collect();
    assert_eq!((rows.len(), rows[0].len()), (25, 14));
    // Timoshenko's beam: w = -F (x^2 (3 L - x) / (6 E I) + x / (G k A)), I = 1/12, G = E/2, k = 5/6.
    let deflection = |x: f64| -(x * x * (30.0 - x) / (6.0 * 1000.0 / 12.0) + x / (500.0 * 5.0 / 6.0));
    for row in &rows[4..=20] {
        let (x, w) = (row[1].unwrap(), row[6].unwrap());
        // Linear tetrahedra of this size are a tenth too stiff in bending, and never too soft.
        assert!((0.84..1.0).contains(&(w / deflection(x))), "at {x}: {w}, beam {}", deflection(x));
    }
    assert!(rows[21..].iter().all(|row| row[1].is_some() && row[6].is_none()), "beyond the end there is nothing");
    // A further run leaves no table of a probe that it does not have.
    assert_eq!(subsolid(folder.path(), PULLED, &[]).0, Some(0));
    assert!(!folder.path().join("results/probe_axis.csv").exists());
}

#[test]
fn an_expectation_passes_or_ends_the_run_with_code_1() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!(
        "{PULLED}[quantities.tip]\naverage = \"ux\"\ngroup = \"x-max\"\n\
         [expect.tip]\nvalue = 2.01e-3\ntolerance = {{ relative = 0.01 }}\nsource = \"Hooke\"\n"
    );
    let (code, stdout, stderr) = subsolid(folder.path(), &text, &[]);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stdout.contains("pass"), "{stdout}");
    let json = |folder: &Path| -> Value {
        serde_json::from_str(&std::fs::read_to_string(folder.join("results/report.json")).unwrap()).unwrap()
    };
    let tip = &json(folder.path())["expectations"]["tip"];
    assert!((tip["deviation"].as_f64().unwrap() + 1e-5).abs() < 1e-12 && tip["passed"] == true, "{tip}");
    let (code, stdout, stderr) = subsolid(folder.path(), &text, &["expect.tip.tolerance={ absolute = 9e-6 }"]);
    assert_eq!(code, Some(1));
    assert!(
        stdout.contains("FAIL") && stderr.contains("not as expected: tip is") && stderr.contains("Hooke"),
        "{stderr}"
    );
    assert_eq!(json(folder.path())["expectations"]["tip"]["passed"], false);
}

#[test]
fn places_outside_the_mesh_are_refused_with_the_distance() {
    let (code, message) = refused(&format!("{PULLED}[quantities.tip]\nvalue = \"ux\"\npoint = [2, 0.5, 1.25]\n"));
    assert_eq!(code, Some(5));
    assert!(message.contains("quantity `tip`") && message.contains("outside the mesh"), "{message}");
    assert!(message.contains("[2, 0.5, 1]") && message.contains("2.500e-1 away"), "{message}");
    let probe = "[probes.far]\nfrom = [0, 0, 3]\nto = [2, 0, 3]\npoints = 5\n";
    let (code, message) = refused(&format!("{PULLED}{probe}"));
    assert!(
        code == Some(5) && message.contains("probe `far` lies outside") && message.contains("2.000e0"),
        "{message}"
    );
    let part = "[quantities.part]\naverage = \"sxx\"\nwithin = { min = [3, 0, 0], max = [4, 1, 1] }\n";
    let (code, message) = refused(&format!("{PULLED}{part}"));
    assert!(code == Some(5) && message.contains("holds nothing") && message.contains("[2, 1, 1]"), "{message}");
    let bare = PULLED.replace("density", "#");
    assert!(bare != PULLED);
    let (code, message) = refused(&format!("{bare}[quantities.m]\ntotal = \"mass\"\n"));
    assert!(
        code == Some(5) && message.contains("quantity `m` is a mass") && message.contains("add density"),
        "{message}"
    );
    let (code, message) = refused(&format!("{PULLED}[quantities.a]\naverage = \"ux\"\nregion = \"solit\"\n"));
    assert!(code == Some(5) && message.contains("did you mean `solid`?"), "{message}");
}

#[test]
fn tables_that_make_no_sense_are_refused_with_their_place() {
    for (table, words) in [
        ("[quantities.q]\naverage = \"uxx\"", "did you mean `ux`?"),
        ("[quantities.q]\ngroup = \"x-max\"", "does not say what it is"),
        ("[quantities.q]\naverage = \"ux\"\nmaximum = \"ux\"", "stands beside `average`"),
        ("[quantities.q]\nvalue = \"ux\"", "lacks `point`"),
        ("[quantities.q]\nreaction = \"x\"", "lacks `component`"),
        ("[quantities.q]\nreaction = \"w\"\ncomponent = \"x\"", "not a support"),
        ("[quantities.q]\naverage = \"ux\"\npoint = [0, 0, 0]", "goes with `value` only"),
        ("[quantities.q]\ntotal = \"volume\"\ngroup = \"x-max\"", "a total over cells"),
        ("[quantities.q]\naverage = \"ux\"\ngroup = \"x-max\"\nregion = \"solid\"", "faces or cells?"),
        ("[quantities.q]\nreaction = \"x\"\ncomponent = \"x\"\nregion = \"solid\"", "names a place"),
        ("[expect.q]\nvalue = 1\ntolerance = { relative = 0.1 }", "not the name of a quantity"),
        ("[expect.q]\nvalue = 1\ntolerance = { relative = 0.1 }", "add [quantities.q]"),
        ("[quantities.q]\ntotal = \"mass\"\n[expect.q]\nvalue = 1", "tolerance = { relative = 0.01 }"),
        ("[quantities.q]\ntotal = \"mass\"\n[expect.q]\nvalue = 1\ntolerance = 0.1", "{ relative = 0.01 }"),
        ("[supports.w]\ngroup = \"x-max\"\nfix = \"xyz\"", "fix = [\"x\", \"y\", \"z\"]"),
        ("[supports.w]\ngroup = \"x-max\"\nfix = [\"xy\"]", "fix = [\"x\", \"y\", \"z\"]"),
        ("[supports.w]\ngroup = \"x-max\"\ndisplacement = [0, 0, 1]", "displacement = { z = 1.0 }"),
        ("[quantities.q]\ntotal = \"mass\"\n[expect.q]\nvalue = 0\ntolerance = { relative = 0.1 }", "is relative to"),
        ("[quantities.q]\ntotal = \"mass\"\n[expect.q]\nvalue = 1\ntolerance = {}", "must name one bound"),
        ("[expect.effectivity]\nbetween = [0.9, 1.1]", "needs a known solution"),
        ("[expect.relative-error]\nbetween = [0.9, 0.1]", "the smaller first"),
        ("[expect.relative-error]\nbetween = [0.9]", "the smaller first"),
        ("[expect.relative-error]\nvalue = 0.9\nbetween = [0.8, 1.0]", "stands beside a value"),
        ("[expect.relative-error]\nsource = \"somebody\"", "lacks `value`"),
        ("[expect.strain-enrgy]\nbetween = [0.8, 1.0]", "strain-energy"),
        ("[probes.p]\nfrom = [0, 0, 0]\nto = [0, 0, 0]\npoints = 5", "is the point it starts"),
        ("[probes.p]\nfrom = [0, 0, 0]\nto = [1, 0, 0]\npoints = 1", "from 2"),
        ("[probes.\"a/b\"]\nfrom = [0, 0, 0]\nto = [1, 0, 0]\npoints = 5", "no file can take"),
    ] {
        let (code, message) = refused(&format!("{PULLED}{table}\n"));
        assert_eq!(code, Some(3), "{table}: {message}");
        assert!(message.contains(words) && message.contains("case.toml:"), "{table}: {message}");
    }
}

/// A scenario of a known solution with linear elements, on sliding planes of symmetry.
fn known(mesh: &str, exact: &str, sliding: &[(&str, &str)]) -> String {
    let supports: String = sliding
        .iter()
        .map(|(group, axis)| format!("[supports.{group}]\ngroup = \"{group}\"\nfix = [\"{axis}\"]\n"))
        .collect();
    format!(
        "{mesh}\n[analysis]\nelement = \"tet4\"\n[materials.a]\nyoungs_modulus = 1.0\npoissons_ratio = 0.3\n{supports}[exact]\n{exact}\n"
    )
}

/// Estimated and true errors of the last step, and their quotient.
fn errors(report: &Value) -> [f64; 3] {
    let error = &report["steps"].as_array().unwrap().last().unwrap()["error"];
    ["energy", "true_energy", "effectivity"].map(|key| error[key].as_f64().unwrap())
}

/// Linear elements converge with the first order, the recovered stress with a higher one, so that the estimate comes near
/// to the true error.
#[test]
fn known_solutions_are_approached_with_the_first_order() {
    let sides = [("x-min", "x"), ("x-max", "x"), ("y-min", "y"), ("y-max", "y"), ("z-min", "z"), ("z-max", "z")];
    let thirds = [("x-min", "x"), ("y-min", "y"), ("z-min", "z")];
    let plane = [("x-min", "x"), ("y-min", "y"), ("z-min", "z"), ("z-max", "z")];
    let outer = "solution = \"kirsch\"\nany = [{ group = \"x-max\" }, { group = \"y-max\" }]";
    let cube = |n: usize| {
        known(&format!("[mesh.box]\nsize = [1, 1, 1]\ncells = [{n}, {n}, {n}]"), "solution = \"smooth-cube\"", &sides)
    };
    let sphere = |n: usize| {
        let exact = "solution = \"lame-sphere\"\ngroup = \"inner\"";
        known(&format!("[mesh.sphere-shell]\nradii = [1, 2]\ncells = [{n}, {n}]"), exact, &thirds)
    };
    let plate = |n: usize| {
        let cells = format!("cells = [{}, {n}, 1]", 2 * n);
        known(&format!("[mesh.plate-with-hole]\nradius = 1\nsize = 4\nthickness = 0.5\n{cells}"), outer, &plane)
    };
    for [coarse, fine] in [[cube(6), cube(12)], [sphere(4), sphere(8)], [plate(5), plate(10)]] {
        let [a, b] = [&coarse, &fine].map(|text| errors(&report(text).0));
        let order = (a[1] / b[1]).log2();
        assert!((0.85..1.15).contains(&order), "order {order}: {a:?} {b:?}\n{fine}");
        assert!((0.8..1.15).contains(&b[2]), "effectivity {}\n{fine}", b[2]);
    }
    // a(u, u) of the cube is 9 pi^2 mu / 4, and the error is orthogonal to the solution.
    let (report, stdout) = report(&cube(6));
    let exact = 2.25 * std::f64::consts::PI.powi(2) / 2.6;
    let computed = 2.0 * report["steps"][0]["strain_energy"].as_f64().unwrap();
    let [_, error, _] = errors(&report);
    assert!((computed + error * error - exact).abs() < 1e-4 * exact, "{computed} + {error}^2, not {exact}");
    assert!(stdout.contains("effectivity"), "{stdout}");
}

/// The singular solution r^0.5445 of the L-prism, prescribed on its outer sides: red refinement converges with that order
/// in the size of the cells.
#[test]
fn the_singularity_of_the_l_prism_bounds_the_order() {
    let prism = |n: usize| {
        let sides = ["x-min", "x-max", "y-min", "y-max"].map(|g| format!("{{ group = \"{g}\" }}")).join(", ");
        let text =
            known(&format!("[mesh.l-prism]\ncells = {n}"), "solution = \"l-prism\"", &[("z-min", "z"), ("z-max", "z")]);
        format!("{text}[supports.outer]\nany = [{sides}]\nfix = \"exact\"\n")
    };
    // The error in the energy norm, and that norm of the known solution by the same quadrature.
    let errors = |n: usize| {
        let (report, _) = report(&prism(n));
        let error = &report["steps"][0]["error"];
        let [error, relative] = ["true_energy", "true_relative"].map(|key| error[key].as_f64().unwrap());
        (error, (error / relative).powi(2))
    };
    let ((coarse, _), (fine, norm)) = (errors(4), errors(8));
    let order = (coarse / fine).log2();
    assert!((0.5..0.59).contains(&order), "order {order}: {coarse}, {fine}");
    // The quadrature misses some of the singularity.
    assert!((norm / 28.172_983_101_124 - 1.0).abs() < 0.02, "{norm}");
    let (code, message) = refused(&prism(2).replace("[exact]\nsolution = \"l-prism\"", ""));
    assert!(code == Some(3) && message.contains("[exact]"), "{message}");
}

#[test]
fn a_known_solution_of_another_solid_is_refused() {
    let (code, message) = refused(&format!("{PULLED}[exact]\nsolution = \"smooth-cube\"\n"));
    assert!(code == Some(5) && message.contains("another solid") && message.contains("[2, 1, 1]"), "{message}");
    assert!(message.contains("unit cube"), "{message}");
    let (code, message) = refused(&format!("{PULLED}[exact]\nsolution = \"smoth-cube\"\n"));
    assert!(code == Some(3) && message.contains("smooth-cube"), "{message}");
}

#[test]
fn the_bundled_fichera_corner_meets_its_expectations() {
    let (report, _) = report(include_str!("../scenarios/fichera.toml"));
    let energy = &report["expectations"]["energy"];
    assert_eq!(energy["passed"], true);
    // Discrete energies under given forces are lower bounds.
    assert!(energy["deviation"].as_f64().unwrap() < 0.0);
}

/// Two bars side by side, one a thousand times stiffer, stretched alike: stress jumps where they meet, and what is asked of
/// one must not see the other's.
#[test]
fn stress_of_a_region_does_not_see_another_region() {
    let folder = tempfile::tempdir().unwrap();
    let mut parts = subsolid::mesh::generate::box_tets([3.0, 1.0, 1.0], [3, 2, 2]).unwrap().into_parts();
    let upper = |t: &[u32; 4]| t.iter().map(|&v| parts.points[v as usize].z).sum::<f64>() > 2.0;
    parts.regions = parts.tets.iter().map(|t| subsolid::mesh::RegionId(u16::from(upper(t)))).collect();
    parts.region_names = vec!["soft".to_owned(), "stiff".to_owned()];
    let mesh = subsolid::mesh::TetMesh::new(parts).unwrap();
    let mut file = String::from(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 1 \"soft\"\n3 2 \"stiff\"\n$EndPhysicalNames\n$Nodes\n",
    );
    file += &format!("{}\n", mesh.points().len());
    mesh.points().iter().enumerate().for_each(|(i, p)| file += &format!("{} {} {} {}\n", i + 1, p.x, p.y, p.z));
    file += &format!("$EndNodes\n$Elements\n{}\n", mesh.tets().len());
    for (t, tet) in mesh.tets().iter().enumerate() {
        let region = mesh.regions()[t].0 + 1;
        let [a, b, c, d] = tet.map(|v| v + 1);
        file += &format!("{} 4 2 {region} {region} {a} {b} {c} {d}\n", t + 1);
    }
    std::fs::write(folder.path().join("bars.msh"), file + "$EndElements\n").unwrap();
    let text = r#"
mesh.file = "bars.msh"
[materials]
soft = { youngs_modulus = 1.0, poissons_ratio = 0.0, group = "soft" }
stiff = { youngs_modulus = 1000.0, poissons_ratio = 0.0, group = "stiff" }
[supports.left]
plane = { normal = [1.0, 0.0, 0.0], offset = 0.0 }
fix = ["x", "y", "z"]
[supports.right]
plane = { normal = [1.0, 0.0, 0.0], offset = 3.0 }
displacement = { x = 0.03 }
[quantities]
largest = { maximum = "sxx", region = "soft" }
near = { value = "sxx", point = [1.5, 0.5, 0.45] }
side = { average = "sxx", plane = { normal = [0.0, 0.0, 1.0], offset = 0.0 } }
[refine]
strategy = "none"
"#;
    std::fs::write(folder.path().join("bars.toml"), text).unwrap();
    for element in ["tet4", "tet10"] {
        let mut command = Command::cargo_bin("subsolid").unwrap();
        command.current_dir(&folder).args([
            "run",
            "bars.toml",
            "-q",
            "--json",
            "-",
            "--set",
            &format!("analysis.element={element}"),
        ]);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        for name in ["largest", "near", "side"] {
            let value = report["steps"][0]["quantities"][name]["value"].as_f64().unwrap();
            assert!((value - 0.01).abs() < 1e-9, "{element} {name}: {value}");
        }
    }
}

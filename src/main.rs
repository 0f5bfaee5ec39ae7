//! The command line of Subsolid: arguments -> a command -> an exit code.

mod cli;

use clap::{CommandFactory as _, Parser as _};
use cli::{BoundaryName, CellsName, Cli, Command, Common, MeasureName, ModeName, ScenarioOptions, SchemeName};
use peak_alloc::PeakAlloc;
use std::collections::BTreeSet;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use subsolid::Error;
use subsolid::pipeline::choice::Cells;
use subsolid::pipeline::hexes::{HexSubdivision, compare_elements, subdivide_hexes};
use subsolid::pipeline::inspect::{Inspection, inspect};
use subsolid::pipeline::subdivide::{Subdivision, subdivide};
use subsolid::pipeline::tet_oct::{Smoothness, TetOctSubdivision, deform, smoothness, subdivide_tet_oct};
use subsolid::pipeline::verify::{Verification, verify};
use subsolid::pipeline::{MemoryProbe, RunOptions, again, check, compare, interrupt, run, variants};
use subsolid::scenario::{Deformation, Scenario};
use subsolid::subdiv::options::{Mode, Optimise, Options, QualityMeasure, Scheme};
use tracing::level_filters::LevelFilter;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Degrees from which the boundary turns, for `--select curvature`.
const CURVATURE_ANGLE: f64 = 5.0;

/// Exit codes: of solver, memory or output, and of a run that the user ends.
const FAILED: i32 = 6;
const INTERRUPTED: i32 = 130;

const MEMORY: MemoryProbe = MemoryProbe { reset: reset_peak, peak };

/// The most bytes held: those allocated at a time since the reset, or those of the pages that the program has touched at all
/// (where the system tells, as Linux does) if these are fewer. Pages are not given back between runs of one process; and what
/// is allocated may never be touched.
fn peak() -> usize {
    let resident = || {
        let text = std::fs::read_to_string("/proc/self/status").ok()?;
        let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
        Some(line.trim().strip_suffix("kB")?.trim().parse::<usize>().ok()? * 1024)
    };
    resident().unwrap_or(usize::MAX).min(ALLOCATOR.peak_usage())
}

/// Lets the peak start again from what is in use.
fn reset_peak() {
    ALLOCATOR.reset_peak_usage();
    // 5 stands for the peak. A system that refuses goes on telling that of the whole program.
    std::fs::write("/proc/self/clear_refs", "5").ok();
}

fn main() -> ExitCode {
    let command = Cli::parse().command;
    handle_signals(&command);
    match command {
        Command::Run { scenarios, resume, common, scenario_options } => {
            run_all(&scenarios, resume, &common, &scenario_options)
        }
        Command::Compare { scenario, schemes, variants: own, elements, repeat, common, scenario_options } => {
            one(&scenario, &common, &scenario_options, |s, o| {
                if !elements.is_empty() {
                    return compare_elements(s, &elements, o);
                }
                let mut chosen = if schemes { variants::schemes(s)? } else { Vec::new() };
                chosen.extend(own);
                match &chosen[..] {
                    [] => compare::compare(s, o, repeat.into()),
                    chosen => variants::compare(s, chosen, o, repeat.into()),
                }
            })
        }
        Command::Verify { folder, markdown, output, common } => {
            set_up(&common);
            let quiet = is_quiet(&common);
            finish(verify(&Verification { folder, markdown, output, json: common.json, quiet, memory: MEMORY }))
        }
        Command::Report { folder, common } => {
            set_up(&common);
            finish(again::report(&folder, is_quiet(&common)))
        }
        Command::Check { scenario, common, scenario_options } => {
            one(&scenario, &common, &scenario_options, check::check)
        }
        Command::Subdivide(arguments) => {
            set_up(&arguments.common);
            finish(match (arguments.scheme.of_tetrahedra(), arguments.scheme) {
                (Some(scheme), _) => subdivide(&subdivision(arguments, scheme)).map(drop),
                (None, SchemeName::TetOct) => subdivide_tet_oct(&tet_oct_subdivision(arguments)).map(drop),
                (None, _) => subdivide_hexes(&hex_subdivision(arguments)).map(drop),
            })
        }
        Command::Inspect { mesh, feature_angle, common } => {
            set_up(&common);
            let quiet = is_quiet(&common);
            let json = common.json;
            finish(inspect(&Inspection { mesh, feature_angle, quiet, json }))
        }
        Command::Deform { scenario, common, scenario_options } => {
            set_up(&common);
            let read = Deformation::from_file(&scenario, &scenario_options.set).map_err(Error::from);
            finish(read.and_then(|d| deform(&d, &run_options(&common, &scenario_options)).map(drop)))
        }
        Command::Smoothness { output, markdown, common } => {
            set_up(&common);
            let quiet = is_quiet(&common);
            finish(smoothness(&Smoothness { output, markdown, json: common.json, quiet }).map(drop))
        }
        Command::Schema => finish(subsolid::pipeline::print(&format!("{:#}\n", subsolid::scenario::schema()))),
        Command::Completions { shell } => completions(shell),
    }
}

/// Where memory cannot be had the standard library says so and aborts: that is an exit code here, and no dump of memory. Ctrl-C, or a
/// polite kill, asks runs to end after their step; the second time the program ends at once, as others do the first time, with no file
/// half written. Without handlers all this would still end the program.
fn handle_signals(command: &Command) {
    use signal_hook::consts::{SIGABRT, SIGINT, SIGTERM};
    use signal_hook::flag::{register, register_conditional_shutdown};
    let always = Arc::new(AtomicBool::new(true));
    let _ = register_conditional_shutdown(SIGABRT, FAILED, always);
    if !matches!(command, Command::Run { .. } | Command::Compare { .. } | Command::Verify { .. }) {
        return;
    }
    for signal in [SIGINT, SIGTERM] {
        let flag = interrupt::flag();
        let _ = register_conditional_shutdown(signal, INTERRUPTED, Arc::clone(&flag));
        let _ = register(signal, flag);
    }
}

/// What `subdivide` is told, in the library's words.
fn subdivision(arguments: cli::Subdivide, scheme: Scheme) -> Subdivision {
    let quiet = is_quiet(&arguments.common);
    let cli::Subdivide { mesh, feature_angle, edges, corners, output, frames, common: Common { json, .. }, .. } =
        arguments;
    let mode = arguments.optimise.unwrap_or(ModeName::Best).into();
    let measure = arguments.measure.unwrap_or(MeasureName::MinSine).into();
    if mode == Mode::Best && measure != QualityMeasure::MinSine {
        refuse("--measure is for the published operations: use it with --optimise paper");
    }
    let curvature = matches!(arguments.select, Some(CellsName::Curvature));
    if json.as_ref() == Some(&output) {
        refuse("--json and --output name the same file");
    }
    for (option, idle) in [
        ("--boundary is for --scheme sqrt3", arguments.boundary.is_some() && scheme != Scheme::Sqrt3),
        ("--variant is for --scheme catmull-clark", arguments.variant.is_some()),
        ("--interpolate is for --scheme catmull-clark", arguments.interpolate),
        ("--curvature-angle is for --select curvature", arguments.curvature_angle.is_some() && !curvature),
        ("--select is for one step or more", arguments.select.is_some() && arguments.steps == 0),
    ] {
        warn_if_idle(option, idle);
    }
    let boundary = arguments.boundary.unwrap_or(BoundaryName::Approximating).into();
    let optimise = Optimise { mode, measure, ..Optimise::default() };
    let options = Options { scheme, boundary, optimise, frames: false };
    let cells = match arguments.select {
        None | Some(CellsName::All) => Cells::All,
        Some(_) if options.scheme == Scheme::Red => {
            refuse("--scheme red refines all cells or none: use sqrt3 or longest-edge with --select")
        }
        Some(CellsName::Boundary) => Cells::Boundary,
        Some(CellsName::Curvature) => {
            Cells::Curvature { above: arguments.curvature_angle.unwrap_or(CURVATURE_ANGLE), below: feature_angle }
        }
        Some(CellsName::File(path)) => Cells::Listed(path),
    };
    Subdivision {
        mesh,
        options,
        steps: arguments.steps.into(),
        cells,
        feature_angle,
        edges,
        corners,
        output,
        frames,
        quiet,
        json,
    }
}

/// What `subdivide` is told about hexahedra, in the library's words.
fn hex_subdivision(arguments: cli::Subdivide) -> HexSubdivision {
    let quiet = is_quiet(&arguments.common);
    warn_of_other_schemes(&arguments);
    let cli::Subdivide { mesh, feature_angle, edges, corners, output, common: Common { json, .. }, .. } = arguments;
    if json.as_ref() == Some(&output) {
        refuse("--json and --output name the same file");
    }
    if arguments.frames.is_some() {
        refuse("--frames is for tetrahedra: a step of --scheme catmull-clark has one stage");
    }
    if !matches!(arguments.select, None | Some(CellsName::All)) {
        refuse("--scheme catmull-clark refines all cells: leave out --select");
    }
    HexSubdivision {
        mesh,
        steps: arguments.steps.into(),
        variant: arguments.variant.map(Into::into).unwrap_or_default(),
        interpolate: arguments.interpolate,
        feature_angle,
        edges,
        corners,
        output,
        quiet,
        json,
    }
}

/// What `subdivide --scheme tet-oct` is told, in the library's words.
fn tet_oct_subdivision(arguments: cli::Subdivide) -> TetOctSubdivision {
    let quiet = is_quiet(&arguments.common);
    warn_of_other_schemes(&arguments);
    let cli::Subdivide { mesh, feature_angle, edges, corners, output, common: Common { json, .. }, .. } = arguments;
    if json.as_ref() == Some(&output) {
        refuse("--json and --output name the same file");
    }
    if arguments.frames.is_some() {
        refuse("--frames is for schemes whose steps have stages: a step of --scheme tet-oct has one");
    }
    if !matches!(arguments.select, None | Some(CellsName::All)) {
        refuse("--scheme tet-oct refines all cells: leave out --select");
    }
    warn_if_idle("--variant is for --scheme catmull-clark", arguments.variant.is_some());
    warn_if_idle("--interpolate is for --scheme catmull-clark", arguments.interpolate);
    let steps = arguments.steps.into();
    TetOctSubdivision { mesh, steps, feature_angle, edges, corners, output, quiet, json }
}

/// Of options of schemes for tetrahedra that have steps in parts.
fn warn_of_other_schemes(arguments: &cli::Subdivide) {
    for (option, idle) in [
        ("--boundary is for --scheme sqrt3", arguments.boundary.is_some()),
        ("--curvature-angle is for --select curvature", arguments.curvature_angle.is_some()),
        ("--optimise is for --scheme sqrt3, red and longest-edge", arguments.optimise.is_some()),
        ("--measure is for --optimise paper", arguments.measure.is_some()),
    ] {
        warn_if_idle(option, idle);
    }
}

fn warn_if_idle(option: &str, idle: bool) {
    if idle {
        // With standard error closed there is nobody left to tell.
        let _ = writeln!(std::io::stderr(), "warning: {option}: here it has no effect");
    }
}

/// Ends with a usage error.
fn refuse(message: &str) -> ! {
    Cli::command().error(clap::error::ErrorKind::ArgumentConflict, message).exit()
}

/// Reads all scenarios before it runs the first. Then runs all, whether or not one fails; the code is that of the first
/// failure.
fn run_all(paths: &[PathBuf], resume: bool, common: &Common, options: &ScenarioOptions) -> ExitCode {
    if paths.len() > 1 {
        refuse_shared_files(paths, common);
    }
    set_up(common);
    let read = paths.iter().map(|path| Scenario::from_file(path, &options.set).map_err(|e| report(e.into())));
    let (scenarios, failures): (Vec<_>, Vec<_>) = read.partition(Result::is_ok);
    if let Some(Err(code)) = failures.into_iter().next() {
        return code;
    }
    let mut first_failure = None;
    for scenario in scenarios.into_iter().flatten() {
        let mut run_options = RunOptions { resume, ..run_options(common, options) };
        if paths.len() > 1 {
            run_options.output = options.output.as_ref().map(|folder| folder.join(scenario.name()));
        }
        if let Err(error) = run::run(&scenario, &run_options) {
            let is_last = matches!(error, Error::Interrupted { .. });
            let code = report(error);
            if is_last {
                return code;
            }
            first_failure.get_or_insert(code);
        }
    }
    first_failure.unwrap_or(ExitCode::SUCCESS)
}

/// Ends with a usage error if several scenarios would write the same files.
fn refuse_shared_files(scenarios: &[PathBuf], common: &Common) {
    if common.json.is_some() {
        refuse("--json names one file: run one scenario at a time with it");
    }
    let mut names = BTreeSet::new();
    if let Some(twin) = scenarios.iter().find(|s| !names.insert(s.file_stem())) {
        let stem = Path::new(twin.file_stem().unwrap_or_default()).display();
        refuse(&format!("two scenarios are called {stem}: their results would share a folder"));
    }
}

fn one(
    path: &Path,
    common: &Common,
    options: &ScenarioOptions,
    command: impl FnOnce(&Scenario, &RunOptions) -> Result<(), Error>,
) -> ExitCode {
    set_up(common);
    finish(read_and(path, options, &run_options(common, options), command))
}

fn read_and(
    path: &Path,
    options: &ScenarioOptions,
    run_options: &RunOptions,
    command: impl FnOnce(&Scenario, &RunOptions) -> Result<(), Error>,
) -> Result<(), Error> {
    command(&Scenario::from_file(path, &options.set)?, run_options)
}

fn run_options(common: &Common, options: &ScenarioOptions) -> RunOptions {
    let (output, json) = (options.output.clone(), common.json.clone());
    RunOptions { output, quiet: is_quiet(common), json, resume: false, memory: MEMORY }
}

/// Standard output is for the JSON alone if that goes there.
fn is_quiet(common: &Common) -> bool {
    common.quiet || common.json.as_deref() == Some(Path::new("-"))
}

/// Sets the number of threads and begins the log.
fn set_up(common: &Common) {
    if common.log != LevelFilter::OFF {
        let log = tracing_subscriber::fmt().with_max_level(common.log).with_target(false).with_ansi(false);
        log.with_writer(std::io::stderr).init();
    }
    if let Some(n) = common.threads {
        // Fails only if the pool exists already, which nothing before this call makes.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(n.into()).build_global();
    }
}

fn finish(result: Result<(), Error>) -> ExitCode {
    result.map_or_else(report, |()| ExitCode::SUCCESS)
}

/// Prints an error and gives its code.
fn report(error: Error) -> ExitCode {
    let code = error.exit_code();
    // With standard error closed there is nobody left to tell.
    let _ = writeln!(std::io::stderr(), "{:?}", miette::Report::new(error));
    ExitCode::from(code)
}

fn completions(shell: clap_complete::Shell) -> ExitCode {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "subsolid", &mut script);
    finish(subsolid::pipeline::print(&String::from_utf8_lossy(&script)))
}

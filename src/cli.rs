//! The words of the command line.

use clap::{Args, Parser, Subcommand, ValueEnum, value_parser};
use std::path::PathBuf;
use subsolid::subdiv::options::{Boundary, Scheme};

/// Finite-element simulation of linear-elastic solids represented by adaptive subdivision meshes.
#[derive(Debug, Parser)]
#[command(name = "subsolid", version, about, arg_required_else_help = true, after_help = EXIT_CODES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 ok; 1 a check failed; 2 usage; 3 scenario; 4 mesh; 5 ill-posed model; \
                          6 solver, memory or output; 7 asked tolerance not reached; 130 interrupted.\n\
                          Meshes are looked for beside the scenario, then in the folder named by SUBSOLID_DATA.";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Solve scenarios: solve, estimate, refine, repeat; write VTK files and report.json
    Run {
        /// Scenario files (TOML)
        #[arg(required = true, value_name = "SCENARIO")]
        scenarios: Vec<PathBuf>,
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        scenario_options: ScenarioOptions,
    },
    /// Run a scenario adaptively and globally; print and write what adaptivity saved
    Compare {
        /// Scenario file (TOML)
        scenario: PathBuf,
        /// Repetitions of short runs; times are medians over them. Steps below 50 ms are repeated at least nine times,
        /// unless this is 1
        #[arg(long, value_name = "N", default_value_t = 3, value_parser = value_parser!(u16).range(1..))]
        repeat: u16,
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        scenario_options: ScenarioOptions,
    },
    /// Say what a run would do, and solve nothing
    Check {
        /// Scenario file (TOML)
        scenario: PathBuf,
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        scenario_options: ScenarioOptions,
    },
    /// Refine all cells of a mesh and write it
    Subdivide {
        /// Mesh file
        mesh: PathBuf,
        /// Subdivision scheme
        #[arg(long, value_enum, default_value_t = SchemeName::Sqrt3)]
        scheme: SchemeName,
        /// Refinement steps
        #[arg(long, value_name = "N", default_value_t = 1, value_parser = value_parser!(u8).range(0..=20))]
        steps: u8,
        /// Boundary edges with a larger angle between the normals of their faces are features, in degrees
        #[arg(long, value_name = "DEG", default_value = "40", value_parser = angle)]
        feature_angle: f64,
        /// What happens to the boundary surface
        #[arg(long, value_enum, default_value_t = BoundaryName::Approximating)]
        boundary: BoundaryName,
        /// The file to write
        #[arg(short, long, value_name = "OUT")]
        output: PathBuf,
        #[command(flatten)]
        common: Common,
    },
    /// Print counts, groups, regions and quality of a mesh
    Inspect {
        /// Mesh file
        mesh: PathBuf,
        /// Boundary edges with a larger angle between the normals of their faces are features, in degrees
        #[arg(long, value_name = "DEG", default_value = "40", value_parser = angle)]
        feature_angle: f64,
        #[command(flatten)]
        common: Common,
    },
    /// Print a completion script for a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

/// Options of all commands that compute.
#[derive(Debug, Args)]
pub struct Common {
    /// Threads to compute with [default: all cores]
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print errors only
    #[arg(long, short)]
    pub quiet: bool,
    /// Write the figures to this file too; `-` is standard output, where nothing else is printed then
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Options of the commands that read scenarios.
#[derive(Debug, Args)]
pub struct ScenarioOptions {
    /// Folder of the results [default: results/<scenario's name>]; several scenarios of one `run` each get a folder in it
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Override a key of the scenario, such as refine.steps=3 (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// Names of subdivision schemes.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum SchemeName {
    /// Tetrahedral sqrt(3) subdivision
    Sqrt3,
    /// One cell into eight
    Red,
}

impl From<SchemeName> for Scheme {
    fn from(name: SchemeName) -> Self {
        match name {
            SchemeName::Sqrt3 => Self::Sqrt3,
            SchemeName::Red => Self::Red,
        }
    }
}

/// Names of boundary rules.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum BoundaryName {
    /// The surface is kept
    Fixed,
    /// The surface is smoothed between features
    Approximating,
}

impl From<BoundaryName> for Boundary {
    fn from(name: BoundaryName) -> Self {
        match name {
            BoundaryName::Fixed => Self::Fixed,
            BoundaryName::Approximating => Self::Approximating,
        }
    }
}

fn angle(text: &str) -> Result<f64, String> {
    let angle: f64 = text.parse().map_err(|_| "expected a number of degrees".to_owned())?;
    if (0.0..=180.0).contains(&angle) { Ok(angle) } else { Err("expected an angle from 0 to 180 degrees".to_owned()) }
}

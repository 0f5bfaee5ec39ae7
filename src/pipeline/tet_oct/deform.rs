//! `subsolid deform`: what is embedded in a solid follows its control points from pose to pose.

use super::super::resolve::with_features;
use super::super::{RunOptions, load, print};
use super::moves::posed;
use super::subdivide::check_count;
use crate::error::Error;
use crate::mesh::TetMesh;
use crate::mesh::read::{Shape, read_shape};
use crate::mesh::tet_oct::TetOctMesh;
use crate::output::frames::without_frames;
use crate::output::options::Compression;
use crate::output::progress::Progress;
use crate::output::pvd::write_pvd;
use crate::output::report::write_json;
use crate::output::shape::write_shape;
use crate::scenario::{Deformation, Midside};
use crate::subdiv::tet_oct::Embedding;
use glam::DVec3;
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// Why control points cannot be moved so.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum DeformError {
    /// A move of a pose is not possible.
    #[error("{name} {problem}")]
    #[diagnostic(help(
        "control points are numbered as the vertices of the mesh, and groups named as `subsolid inspect` tells"
    ))]
    Move {
        /// Which.
        name: String,
        /// Why not.
        problem: String,
    },
    /// A frame inverts cells.
    #[error("{name} is not one-to-one: it inverts {inverted} of {cells} cells of the refined control mesh")]
    #[diagnostic(help("move the control points less far, or more of them together"))]
    Folds {
        /// Which.
        name: String,
        /// Inverted cells.
        inverted: usize,
        /// All of them.
        cells: usize,
    },
}

/// What a deformation was.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeformReport {
    /// Control points.
    pub control_points: usize,
    /// Cells of the control mesh.
    pub control_cells: usize,
    /// Embedded points.
    pub points: usize,
    /// Weights that are kept.
    pub weights: usize,
    /// Frames written.
    pub frames: usize,
    /// Seconds that the weights took.
    pub seconds_weights: f64,
    /// Seconds that moving the points took, the mean over the frames.
    pub seconds_frame: f64,
    /// Seconds that the check took that a frame is one-to-one, the mean over the frames.
    pub seconds_check: f64,
}

/// Bytes that a cell of the subdivided mesh takes at least.
const BYTES: usize = 200;

/// A control mesh and what is embedded in it.
struct Setup {
    mesh: TetMesh,
    shape: Shape,
    embedding: Embedding,
    /// The control points of each pose, the mesh as it is first.
    poses: Vec<Vec<DVec3>>,
}

/// Computes the weights of all embedded points once, and writes them at each frame: `frame_NNN.vtu`, and `frames.pvd` with all of
/// them. Control points move on straight lines from pose to pose.
///
/// # Errors
/// [`Error::Mesh`] if a file cannot be read, [`Error::Embed`] if points lie outside, [`Error::Deform`] if a frame is not
/// one-to-one or a move not possible, [`Error::Output`].
pub fn deform(scenario: &Deformation, options: &RunOptions) -> Result<DeformReport, Error> {
    let progress = Progress::new(options.quiet);
    let phase = progress.phase("weights".to_owned());
    let (setup, seconds_weights) = prepare(scenario)?;
    phase.say("check the frames".to_owned());
    let clock = Instant::now();
    // All before the first is written.
    frames(scenario, &setup.poses).try_for_each(|(_, name, control)| one_to_one(&setup.embedding, name, &control))?;
    let checking = clock.elapsed().as_secs_f64();
    drop(phase);
    let folder = options.output.clone().unwrap_or_else(|| PathBuf::from("results").join(scenario.name()));
    without_frames(&folder)?;
    let (mut files, mut moving) = (Vec::new(), 0.0);
    for (time, _, control) in frames(scenario, &setup.poses) {
        let _phase = progress.phase(format!("frame {}", files.len()));
        let clock = Instant::now();
        let places = setup.embedding.places(&control);
        moving += clock.elapsed().as_secs_f64();
        let file = format!("frame_{:03}.vtu", files.len());
        write_shape(&folder.join(&file), &setup.shape, &places, time, Compression::default())?;
        files.push((time, file));
        write_pvd(&folder.join("frames.pvd"), &files)?;
    }
    let report = DeformReport {
        control_points: setup.mesh.points().len(),
        control_cells: setup.mesh.tets().len(),
        points: setup.embedding.len(),
        weights: setup.embedding.entries(),
        frames: files.len(),
        seconds_weights,
        seconds_frame: moving / files.len() as f64,
        seconds_check: checking / files.len() as f64,
    };
    if let Some(path) = &options.json {
        write_json(path, &report)?;
    }
    if !options.quiet {
        print(&format!(
            "{}\n{} points in {} control points; weights made in {:.3} s, a frame moved in {:.2} ms \
             and checked in {:.2}\n{} frames in {}\n",
            scenario.title,
            report.points,
            report.control_points,
            report.seconds_weights,
            1e3 * report.seconds_frame,
            1e3 * report.seconds_check,
            report.frames,
            folder.join("frames.pvd").display()
        ))?;
    }
    Ok(report)
}

fn one_to_one(embedding: &Embedding, name: String, control: &[DVec3]) -> Result<(), DeformError> {
    match embedding.inverted(control) {
        (0, _) => Ok(()),
        (inverted, cells) => Err(DeformError::Folds { name, inverted, cells }),
    }
}

/// Reads and embeds everything; gives the seconds that the weights took.
fn prepare(scenario: &Deformation) -> Result<(Setup, f64), Error> {
    let beside = scenario.path.parent().map(PathBuf::from).unwrap_or_default();
    let mesh = with_features(&scenario.features, load::load_source(&scenario.mesh, Midside::Straight, &beside)?.mesh)?;
    let shape = read_shape(&load::find(&scenario.embedded, &beside)?)?;
    let mut poses = vec![mesh.points().to_vec()];
    for pose in &scenario.poses {
        poses.push(posed(&mesh, pose)?);
    }
    check_count(mesh.tets().len(), scenario.steps, BYTES)?;
    let clock = Instant::now();
    let embedding = Embedding::new(&TetOctMesh::from(&mesh), scenario.steps, &shape.points)?;
    let seconds = clock.elapsed().as_secs_f64();
    Ok((Setup { mesh, shape, embedding, poses }, seconds))
}

/// The frames: their times (poses are at whole ones), names and control points.
fn frames(scenario: &Deformation, poses: &[Vec<DVec3>]) -> impl Iterator<Item = (f64, String, Vec<DVec3>)> {
    let count = scenario.frames;
    (0..=count * (poses.len() - 1)).map(move |frame| {
        let (before, share) = (frame / count, (frame % count) as f64 / count as f64);
        let after = &poses[(before + 1).min(poses.len() - 1)];
        let control = poses[before].iter().zip(after).map(|(p, q)| p.lerp(*q, share)).collect();
        let name = match before {
            _ if share > 0.0 => format!("frame {frame}, on the way to pose {:?},", scenario.poses[before].name),
            0 => "the control mesh as it is".to_owned(),
            _ => format!("pose {:?}", scenario.poses[before - 1].name),
        };
        (before as f64 + share, name, control)
    })
}

//! `subsolid smoothness`: how smooth tetrahedral/octahedral subdivision is across faces, along edges and at vertices.

use super::super::print;
use super::page;
use crate::error::Error;
use crate::fem::Space;
use crate::mesh::tet_oct::Tetrahedra;
use crate::output::atomic::{ensure_writable_dir, write_atomic};
use crate::output::options::{Compression, Units};
use crate::output::picture::{Panel, picture};
use crate::output::progress::Progress;
use crate::output::report::write_json;
use crate::output::vtk::{Fields, Values, write_vtu};
use crate::subdiv::tet_oct::smoothness::{
    CharacteristicMap, EdgeAnalysis, FaceAnalysis, Patch, VertexAnalysis, analyse_edge, analyse_face, analyse_vertex,
    random_sphere, spheres,
};
use rayon::prelude::*;
use serde::Serialize;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Most factors of the products on a face, in the cells at it, and along an edge.
const ON_FACE_FACTORS: usize = 8;
const AT_FACE_FACTORS: usize = 6;
const EDGE_FACTORS: usize = 12;

/// Valences of the edges, and numbers of neighbours of the vertices: all triangulations, and random ones.
const VALENCES: RangeInclusive<usize> = 3..=12;
const ALL_OF: RangeInclusive<usize> = 4..=10;
const RANDOM_OF: RangeInclusive<usize> = 11..=24;
const RANDOM_EACH: u64 = 10;

/// Maps of vertices with so many neighbours at most are written.
const WRITTEN: usize = 7;

/// What the command line says.
#[derive(Debug, Clone)]
pub struct Smoothness {
    /// Folder for the characteristic maps.
    pub output: PathBuf,
    /// File for the page, with its pictures in a folder of its name.
    pub markdown: Option<PathBuf>,
    /// File for the figures.
    pub json: Option<PathBuf>,
    /// Print errors only.
    pub quiet: bool,
}

/// Everything that was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SmoothnessReport {
    /// Across a face.
    pub face: FaceRecord,
    /// Along edges, by valence.
    pub edges: Vec<EdgeRecord>,
    /// At vertices, by number of neighbours.
    pub vertices: Vec<VertexRecord>,
}

/// Across a face.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceRecord {
    /// Eigenvalues, descending.
    pub eigenvalues: Vec<f64>,
    /// The values on a patch of the face.
    pub on: PatchRecord,
    /// The values in all cells at it.
    pub at: PatchRecord,
}

/// A patch of the face.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PatchRecord {
    /// Vertices that it depends on.
    pub support: usize,
    /// How far quadratic polynomials are from being mapped to such.
    pub quadratics: f64,
    /// Bounds on the joint spectral radius, by number of factors.
    pub bounds: Vec<f64>,
    /// Factors needed for a bound below 1/4.
    pub factors: Option<usize>,
}

/// Along an edge.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EdgeRecord {
    /// Tetrahedra around it.
    pub valence: usize,
    /// The double eigenvalue across the edge.
    pub lambda1: f64,
    /// The smaller of it and 1/2.
    pub lambda3: f64,
    /// The largest known spectral radius of the remainder.
    pub rho: f64,
    /// The bound on its joint spectral radius that shows it to be below lambda3, or the best there is.
    pub bound: f64,
    /// Factors needed for it.
    pub factors: Option<usize>,
    /// Factors needed where common eigenvectors of other frequencies stay in the remainder.
    pub direct_factors: Option<usize>,
    /// The worst shape of the cells of the map's annulus after the last step.
    pub worst: f64,
    /// Whether all conditions hold.
    pub passes: bool,
}

/// At vertices with one number of neighbours.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VertexRecord {
    /// Neighbours.
    pub degree: usize,
    /// Whether the configurations are random ones, not all.
    pub random: bool,
    /// Configurations.
    pub count: usize,
    /// Those for which all conditions hold.
    pub passed: usize,
    /// Range of lambda1.
    pub lambda1: [f64; 2],
    /// Range of lambda3.
    pub lambda3: [f64; 2],
    /// The least difference of lambda3 and lambda4.
    pub gap: f64,
    /// The worst shape of the cells of the maps' annuli after the last step.
    pub worst: f64,
    /// Those that fail.
    pub failures: Vec<FailedVertex>,
}

/// A configuration for which a condition does not hold.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FailedVertex {
    /// Its number among those with as many neighbours, from 1.
    pub number: usize,
    /// Tetrahedra at each edge from the vertex, descending.
    pub valences: Vec<usize>,
    /// lambda1 to lambda4.
    pub eigenvalues: [f64; 4],
    /// The worst shape of the cells of the map's annulus after the last step.
    pub worst: f64,
    /// Steps of subdivision.
    pub steps: usize,
    /// The parts of the cells there that are inverted after the last two of them.
    pub inverted: [f64; 2],
    /// What that means.
    pub verdict: Verdict,
}

/// Why a vertex does not pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// lambda3 is as large as lambda4: there is no map.
    NoMap,
    /// The inverted part of the map stays with another step.
    Folds,
    /// It falls: whether the limit folds is not decided.
    Undecided,
}

impl Verdict {
    fn of(vertex: &VertexAnalysis) -> Self {
        if !vertex.has_map() {
            Self::NoMap
        } else if vertex.map.folds() {
            Self::Folds
        } else {
            Self::Undecided
        }
    }
}

impl FailedVertex {
    fn of(number: usize, valences: &[usize], vertex: &VertexAnalysis) -> Self {
        let annulus = &vertex.map.annulus;
        let inverted = [2, 1].map(|back| annulus[annulus.len() - back].inverted);
        let [lambda1, lambda2, lambda3] = [1, 2, 3].map(|k| vertex.eigenvalues[k]);
        Self {
            number,
            valences: valences.to_vec(),
            eigenvalues: [lambda1, lambda2, lambda3, vertex.lambda4()],
            worst: vertex.map.finest().worst,
            steps: annulus.len() - 1,
            inverted,
            verdict: Verdict::of(vertex),
        }
    }
}

impl From<&FaceAnalysis> for FaceRecord {
    fn from(face: &FaceAnalysis) -> Self {
        Self { eigenvalues: face.eigenvalues.clone(), on: (&face.on).into(), at: (&face.at).into() }
    }
}

impl From<&Patch> for PatchRecord {
    fn from(patch: &Patch) -> Self {
        Self {
            support: patch.support,
            quadratics: patch.quadratics,
            bounds: patch.bounds.clone(),
            factors: patch.factors(),
        }
    }
}

impl From<&EdgeAnalysis> for EdgeRecord {
    fn from(edge: &EdgeAnalysis) -> Self {
        let best = edge.bounds.iter().copied().fold(f64::INFINITY, f64::min);
        let shown = edge.factors().map_or(best, |k| edge.bounds[k - 1]);
        Self {
            valence: edge.valence,
            lambda1: edge.lambda1,
            lambda3: edge.lambda3,
            rho: edge.rho(),
            bound: shown.max(edge.common),
            factors: edge.factors(),
            direct_factors: edge.direct_factors(),
            worst: edge.map.finest().worst,
            passes: edge.passes(),
        }
    }
}

/// A configuration: tetrahedra at each edge from the vertex, and what was found.
type Configuration = (Vec<usize>, VertexAnalysis);

impl VertexRecord {
    fn of(degree: usize, random: bool, all: &[Configuration]) -> Self {
        let range = |k: usize| {
            let values = || all.iter().map(|(_, a)| a.eigenvalues[k]);
            [values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max)]
        };
        let least = |of: &dyn Fn(&VertexAnalysis) -> f64| all.iter().map(|(_, a)| of(a)).fold(f64::INFINITY, f64::min);
        let failed = (1..).zip(all).filter(|(_, (_, a))| !a.passes());
        Self {
            degree,
            random,
            count: all.len(),
            passed: all.iter().filter(|(_, a)| a.passes()).count(),
            lambda1: range(1),
            lambda3: range(3),
            gap: least(&VertexAnalysis::gap),
            worst: least(&|a| a.map.finest().worst),
            failures: failed.map(|(number, (valences, a))| FailedVertex::of(number, valences, a)).collect(),
        }
    }
}

/// Analyses faces, edges of valence 3 to 12, and vertices: all configurations with 4 to 10 neighbours and random ones with more. Writes
/// the characteristic maps, and the page with its pictures if asked to.
///
/// # Errors
/// [`Error::Output`] if a file cannot be written, [`Error::Mesh`] if a map that passes is no mesh.
pub fn smoothness(command: &Smoothness) -> Result<SmoothnessReport, Error> {
    ensure_writable_dir(&command.output)?;
    let progress = Progress::new(command.quiet);
    let phase = progress.phase("faces".to_owned());
    let face = analyse_face(ON_FACE_FACTORS, AT_FACE_FACTORS);
    drop(phase);
    let mut edges = Vec::new();
    for valence in VALENCES {
        let _phase = progress.phase(format!("edges of {valence} tetrahedra"));
        edges.push(analyse_edge(valence, EDGE_FACTORS));
    }
    let mut panels = [Vec::new(), Vec::new()];
    for edge in &edges {
        let name = format!("edge_{:02}", edge.valence);
        panels[0].extend(write_map(&command.output, &name, format!("n = {}", edge.valence), &edge.map)?);
    }
    let mut vertices = Vec::new();
    for degree in ALL_OF {
        let _phase = progress.phase(format!("vertices with {degree} neighbours"));
        let all: Vec<Configuration> = spheres(degree).par_iter().map(|s| (s.degrees(), analyse_vertex(s))).collect();
        for (number, (valences, analysis)) in (1..).zip(all.iter().filter(|_| degree <= WRITTEN)) {
            let title = valences.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
            panels[1].extend(write_map(&command.output, &format!("vertex_{degree}_{number}"), title, &analysis.map)?);
        }
        vertices.push(VertexRecord::of(degree, false, &all));
    }
    for degree in RANDOM_OF {
        let _phase = progress.phase(format!("random vertices with {degree} neighbours"));
        let of_seed = |seed| {
            let sphere = random_sphere(degree, seed);
            (sphere.degrees(), analyse_vertex(&sphere))
        };
        let all: Vec<Configuration> = (1..=RANDOM_EACH).into_par_iter().map(of_seed).collect();
        vertices.push(VertexRecord::of(degree, true, &all));
    }
    let report = SmoothnessReport { face: (&face).into(), edges: edges.iter().map(Into::into).collect(), vertices };
    if let Some(path) = &command.markdown {
        write_page(path, &report, &panels)?;
    }
    if let Some(path) = &command.json {
        write_json(path, &report)?;
    }
    if !command.quiet {
        print(&page::summary(&report, &command.output))?;
    }
    Ok(report)
}

/// Writes a map, unless it inverts cells; gives its picture.
fn write_map(folder: &Path, name: &str, title: String, map: &CharacteristicMap) -> Result<Option<Panel>, Error> {
    if !map.is_regular() {
        return Ok(None);
    }
    let Tetrahedra { mesh, octs } = map.mesh.untagged()?;
    let numbers: Vec<f64> = octs.iter().map(|oct| oct.map_or(-1.0, f64::from)).collect();
    let cells = vec![("octahedron", Values::Scalars(&numbers))];
    let fields = Fields { time: 0.0, units: Units::default(), points: Vec::new(), cells };
    write_vtu(&folder.join(format!("{name}.vtu")), &Space::linear(&mesh), &fields, Compression::default())?;
    let surface = mesh.faces().iter().map(|f| f.vertices.map(|v| mesh.points()[v as usize])).collect();
    Ok(Some(Panel { title, surface }))
}

/// Writes the page, and its pictures into a folder of its name beside it.
fn write_page(path: &Path, report: &SmoothnessReport, panels: &[Vec<Panel>; 2]) -> Result<(), Error> {
    let folder = path.with_extension("");
    ensure_writable_dir(&folder)?;
    for (name, panels) in ["edges.svg", "vertices.svg"].into_iter().zip(panels) {
        let text = picture(panels);
        write_atomic(&folder.join(name), |w| w.write_all(text.as_bytes()))?;
    }
    let beside = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let text = page::page(report, &beside);
    Ok(write_atomic(path, |w| w.write_all(text.as_bytes()))?)
}

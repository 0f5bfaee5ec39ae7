//! The steps of a run as a page has them: what is drawn is picked, numbered anew and encoded, step by step.

use super::cells::{Drawn, drawn};
use super::edges::features;
use super::encode::{Section, Sections};
use super::shown::{Shown, Solved};
use crate::fem::von_mises;
use crate::output::OutputError;
use nalgebra::Matrix3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Most boundary faces that are drawn with the middles of their sides.
const MOST_MIDDLES: usize = 60_000;

/// A support or load that is drawn on its faces.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Mark {
    /// Its name.
    pub name: String,
    /// `support` or `load`.
    pub what: &'static str,
    /// Number of its group of boundary faces.
    #[serde(skip)]
    pub group: u32,
}

/// What a page has of the steps of a run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Steps {
    #[serde(skip)]
    pub(super) marks: Vec<Mark>,
    #[serde(skip)]
    pub(super) feature_angle: f64,
    pub(super) steps: Vec<Step>,
    /// The compressed arrays of each step.
    pub(super) texts: Vec<String>,
}

/// What a page says of a step beside its report.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Step {
    step: usize,
    points: usize,
    /// Points of a face: three corners, with the middles of sides six, else of a square.
    face_points: usize,
    /// Points of a cell: four corners, or of a cube.
    cell_points: usize,
    /// Whether middles of sides were left out.
    without_middles: bool,
    cells: usize,
    cells_drawn: usize,
    /// The distance within which points of cells became one, if cells were left out.
    merged: Option<f64>,
    /// For each set of groups that faces have, the marks on them.
    patches: Vec<Vec<usize>>,
    /// Numbers of cells by their smallest angle, in bins of two degrees.
    quality_counts: Vec<usize>,
    /// Numbers of cells by the decadic logarithm of their error, in quarters from `error_from`.
    error_counts: Vec<usize>,
    error_from: f64,
    sections: Vec<Section>,
}

impl Steps {
    /// Of a run with these supports and loads; edges where the surface turns by more than `feature_angle` degrees are drawn.
    #[must_use]
    pub fn new(marks: Vec<Mark>, feature_angle: f64) -> Self {
        Self { marks, feature_angle, steps: Vec::new(), texts: Vec::new() }
    }

    /// The steps of an earlier part of the same run, to be gone on with.
    #[must_use]
    pub fn after(self, earlier: Self) -> Self {
        Self { steps: earlier.steps, texts: earlier.texts, ..self }
    }

    /// Adds a step; `page` is named in errors.
    ///
    /// # Errors
    /// [`OutputError::Write`] if compression fails.
    pub fn add(&mut self, page: &Path, shown: &Shown<'_>, solved: &Solved<'_>) -> Result<(), OutputError> {
        let drawn = drawn(shown);
        let lines = features(shown, self.feature_angle);
        let (faces, face_points) = corners_of_many(shown);
        let without_middles = face_points != shown.face_points;
        // Middles of sides that are not drawn otherwise are no ends of lines either.
        let order = shown.order();
        let lines = if without_middles { ends_of(&lines, order) } else { pairs_of(&lines, order) };
        let points = numbered(shown.points.len(), &[&faces, &drawn.nodes]);
        let mut sections = Sections::default();
        sections.indices("ids", 1, &points.ids);
        at_points(&mut sections, &points.ids, shown, solved);
        sections.indices("faces", face_points, &points.of(&faces));
        sections.indices("face_cells", 1, &shown.face_cells);
        sections.indices("face_patches", 1, &shown.face_patches);
        in_cells(&mut sections, "face", solved, &shown.face_cells);
        sections.indices("lines", 2, &points.of(&lines));
        inside(&mut sections, &drawn, solved, &points, shown.cell_count());
        let (error_from, error_counts) = error_counts(solved.error);
        self.steps.push(Step {
            step: self.steps.len(),
            points: points.ids.len(),
            face_points,
            cell_points: drawn.points,
            without_middles,
            cells: shown.cell_count(),
            cells_drawn: drawn.nodes.len() / drawn.points,
            merged: drawn.merged,
            patches: shown.patches.iter().map(|groups| self.marks_of(groups)).collect(),
            quality_counts: quality_counts(solved.quality),
            error_counts,
            error_from,
            sections: sections.list.clone(),
        });
        self.texts.push(sections.text().map_err(|e| OutputError::write(page, e))?);
        Ok(())
    }

    fn marks_of(&self, groups: &[u32]) -> Vec<usize> {
        (0..self.marks.len()).filter(|&m| groups.contains(&self.marks[m].group)).collect()
    }
}

/// Points that are drawn: their numbers in the mesh, ascending, and the other way round.
struct Numbered {
    ids: Vec<u32>,
    places: Vec<u32>,
}

fn numbered(count: usize, lists: &[&[u32]]) -> Numbered {
    let mut places = vec![u32::MAX; count];
    lists.iter().copied().flatten().for_each(|&v| places[v as usize] = 0);
    let ids: Vec<u32> = (0..count as u32).filter(|&v| places[v as usize] == 0).collect();
    (0..).zip(&ids).for_each(|(place, &v)| places[v as usize] = place);
    Numbered { ids, places }
}

impl Numbered {
    fn of(&self, nodes: &[u32]) -> Vec<u32> {
        nodes.iter().map(|&v| self.places[v as usize]).collect()
    }
}

/// The points of the faces; of very many faces the corners alone.
fn corners_of_many(shown: &Shown<'_>) -> (Vec<u32>, usize) {
    if shown.face_points != 6 || shown.faces.len() <= 6 * MOST_MIDDLES {
        return (shown.faces.clone(), shown.face_points);
    }
    (shown.faces.chunks_exact(6).flat_map(|f| f[..3].iter().copied()).collect(), 3)
}

fn pairs_of(lines: &[u32], order: usize) -> Vec<u32> {
    lines.chunks_exact(order + 1).flat_map(|line| line.windows(2).flatten().copied()).collect()
}

fn ends_of(lines: &[u32], order: usize) -> Vec<u32> {
    lines.chunks_exact(order + 1).flat_map(|line| [line[0], line[order]]).collect()
}

fn at_points(sections: &mut Sections, ids: &[u32], shown: &Shown<'_>, solved: &Solved<'_>) {
    let places: Vec<f64> = ids.iter().flat_map(|&v| shown.points[v as usize].to_array()).collect();
    sections.values("points", 3, &places);
    let moved: Vec<f64> = ids.iter().flat_map(|&v| solved.displacement[v as usize].to_array()).collect();
    sections.values("displacement", 3, &moved);
    let stresses: Vec<[f64; 3]> = ids
        .par_iter()
        .map(|&v| {
            let s = solved.stress[v as usize];
            let [xx, yy, zz, xy, yz, xz] = s;
            let principal = if s.iter().all(|x| x.is_finite()) {
                Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).symmetric_eigenvalues()
            } else {
                nalgebra::Vector3::repeat(f64::NAN)
            };
            [von_mises(s), principal.max(), principal.min()]
        })
        .collect();
    sections.values("stress", 3, stresses.as_flattened());
}

fn in_cells(sections: &mut Sections, of: &str, solved: &Solved<'_>, cells: &[u32]) {
    let names = if of == "face" {
        ["face_error", "face_quality", "face_level"]
    } else {
        ["cell_error", "cell_quality", "cell_level"]
    };
    let values = |list: &[f64]| cells.iter().map(|&t| list[t as usize]).collect::<Vec<f64>>();
    sections.values(names[0], 1, &values(solved.error));
    sections.values(names[1], 1, &values(solved.quality));
    let levels: Vec<u8> = cells.iter().map(|&t| solved.level[t as usize]).collect();
    sections.bytes(names[2], &levels);
}

fn inside(sections: &mut Sections, drawn: &Drawn, solved: &Solved<'_>, points: &Numbered, count: usize) {
    sections.indices("cells", drawn.points, &points.of(&drawn.nodes));
    let elements = drawn.elements.clone().unwrap_or_else(|| (0..count as u32).collect());
    in_cells(sections, "cell", solved, &elements);
    if drawn.elements.is_some() {
        sections.indices("cell_ids", 1, &elements);
    }
}

/// Width of the bins of angles, in degrees, and of errors, in decades.
const ANGLE_BIN: f64 = 2.0;
const ERROR_BIN: f64 = 0.25;

fn quality_counts(angles: &[f64]) -> Vec<usize> {
    let mut counts = Vec::new();
    for angle in angles.iter().filter(|a| a.is_finite()) {
        let bin = (angle / ANGLE_BIN).max(0.0) as usize;
        counts.resize(counts.len().max(bin + 1), 0);
        counts[bin] += 1;
    }
    counts
}

/// The logarithm from which errors are counted, and the counts. Those of less than a billionth of the largest count as that.
fn error_counts(errors: &[f64]) -> (f64, Vec<usize>) {
    let largest = errors.iter().copied().filter(|e| e.is_finite()).fold(0.0, f64::max);
    if largest == 0.0 {
        return (0.0, Vec::new());
    }
    let bin = |e: f64| (e.max(1e-9 * largest).log10() / ERROR_BIN).floor() as i32;
    let bins: Vec<i32> = errors.par_iter().filter(|e| e.is_finite()).map(|&e| bin(e)).collect();
    let least = bins.iter().copied().min().unwrap_or(0);
    let mut counts = vec![0; (bin(largest) - least) as usize + 1];
    bins.iter().for_each(|b| counts[(b - least) as usize] += 1);
    (f64::from(least) * ERROR_BIN, counts)
}

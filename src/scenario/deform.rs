//! Scenarios of `subsolid deform`: a control mesh, what is embedded in it, and the poses of its control points.

use super::document::{self, Setting};
use super::error::{Fault, ScenarioError};
use super::fields::field;
use super::numbers::{Checked, integer};
use super::raw::{Integer, RawFeatures, RawMesh, RawMove, Table, Text};
use super::selector::{Selector, at_most_one};
use super::{Features, MeshSource, SET, check, read, translate};
use crate::field::Field;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A deformation to be computed, checked as far as that is possible without the mesh.
#[derive(Debug, Clone)]
pub struct Deformation {
    /// The file it was read from.
    pub path: PathBuf,
    /// `title`; the file's name without `.toml` if absent.
    pub title: String,
    /// `[mesh]`: the control mesh.
    pub mesh: MeshSource,
    /// `[features]`.
    pub features: Features,
    /// `embed.file`: what is embedded.
    pub embedded: PathBuf,
    /// `embed.steps`: how often the control mesh is refined.
    pub steps: usize,
    /// `embed.frames`: frames from one pose to the next.
    pub frames: usize,
    /// `[[pose]]`, in their order; the mesh as it is comes before the first.
    pub poses: Vec<Pose>,
}

/// Where the control points go.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// Its name; its number from 1 if absent.
    pub name: String,
    /// What is moved. Displacements add up.
    pub moves: Vec<Move>,
}

/// A displacement of control points.
#[derive(Debug, Clone, PartialEq)]
pub struct Move {
    /// Which.
    pub points: ControlPoints,
    /// The displacement in x, y and z, over the places at rest.
    pub displacement: [Field; 3],
}

/// Some of the control points.
#[derive(Debug, Clone, PartialEq)]
pub enum ControlPoints {
    /// All.
    All,
    /// By number, from 0.
    Listed(Vec<u32>),
    /// By name or place. Shapes take the points in them, inside the solid too; `group` and `normal` those of boundary faces.
    Selected(Selector),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawDeformation {
    title: Option<String>,
    mesh: Option<Table<RawMesh>>,
    features: Option<Table<RawFeatures>>,
    embed: Option<Table<RawEmbed>>,
    pose: Option<Vec<Table<RawPose>>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawEmbed {
    file: Text,
    steps: Option<Integer>,
    frames: Option<Integer>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPose {
    name: Option<String>,
    #[serde(rename = "move")]
    moves: Vec<Table<RawMove>>,
}

impl Deformation {
    /// Reads a file and applies overrides `key.path=value`.
    ///
    /// # Errors
    /// As [`super::Scenario::from_file`].
    pub fn from_file(path: &Path, overrides: &[String]) -> Result<Self, ScenarioError> {
        Self::from_text(&read(path)?, path, overrides)
    }

    /// As [`Deformation::from_file`] with the text at hand; `path` is the file it counts as.
    ///
    /// # Errors
    /// As [`super::Scenario::from_file`].
    pub fn from_text(text: &str, path: &Path, overrides: &[String]) -> Result<Self, ScenarioError> {
        let settings = Setting::all(SET, overrides);
        let name = path.display().to_string();
        let sources = document::Sources::new(&name, text, &settings).map_err(ScenarioError::Invalid)?;
        let document = sources.parse().map_err(ScenarioError::Invalid)?;
        let invalid = |fault| ScenarioError::Invalid(document.explain(fault));
        let raw = RawDeformation::deserialize(toml::Deserializer::from(document.root().clone()))
            .map_err(|e| invalid(translate::fault(&e, &document)))?;
        checked(raw, path).map_err(invalid)
    }

    /// The file's name without its extension; names the folder of the results.
    #[must_use]
    pub fn name(&self) -> String {
        self.path.file_stem().map_or_else(|| "deformation".to_owned(), |s| s.to_string_lossy().into_owned())
    }
}

fn checked(raw: RawDeformation, path: &Path) -> Checked<Deformation> {
    let Some(Table { value: embed, .. }) = raw.embed else {
        let help = "add [embed] with file = \"figure.obj\"";
        return Err(Fault::new(0..0, "the scenario has no [embed]", "no [embed] in this file").help(help));
    };
    let poses = raw.pose.unwrap_or_default();
    if poses.is_empty() {
        let help = "add [[pose]] with move = [{ group = \"z-max\", displacement = { z = 1 } }]";
        return Err(Fault::new(0..0, "the scenario has no [[pose]]", "no [[pose]] in this file").help(help));
    }
    if let Some(merge) = raw.mesh.as_ref().and_then(|m| m.value.merge.as_ref()) {
        return Err(Fault::new(merge.span(), "is for scenarios that are run", "not for deformations"));
    }
    if let Some(midside) = raw.mesh.as_ref().and_then(|m| m.value.midside.as_ref()) {
        return Err(
            Fault::new(midside.span(), "is for ten-node elements", "a control mesh has none").help("remove this")
        );
    }
    let whole = |n: Option<Integer>, range, default| n.map_or(Ok(default), |n| integer(&n, range));
    let mut deformation = Deformation {
        path: path.to_owned(),
        title: raw.title.unwrap_or_default(),
        mesh: check::mesh(raw.mesh)?,
        features: check::features(raw.features)?,
        embedded: PathBuf::from(embed.file.into_inner()),
        steps: whole(embed.steps, 0..=6, 3)?,
        frames: whole(embed.frames, 1..=1000, 10)?,
        poses: (1..).zip(poses).map(|(number, pose)| checked_pose(number, pose)).collect::<Checked<_>>()?,
    };
    if deformation.title.is_empty() {
        deformation.title = deformation.name();
    }
    Ok(deformation)
}

fn checked_pose(number: usize, Table { value: raw, .. }: Table<RawPose>) -> Checked<Pose> {
    let moves = raw.moves.into_iter().map(checked_move).collect::<Checked<_>>()?;
    Ok(Pose { name: raw.name.unwrap_or_else(|| number.to_string()), moves })
}

fn checked_move(Table { span, value: mut raw }: Table<RawMove>) -> Checked<Move> {
    let Some(given) = raw.displacement.take() else {
        let fault = Fault::new(span, "moves nothing", "which displacement?");
        return Err(fault.help("add displacement = { x = 0.1, z = \"0.2*x\" }; directions that are left out stay"));
    };
    if [&given.value.x, &given.value.y, &given.value.z].iter().all(|x| x.is_none()) {
        return Err(Fault::new(given.span, "moves nothing", "in which direction?").help("add x, y or z"));
    }
    let mut displacement = [Field::ZERO, Field::ZERO, Field::ZERO];
    for (slot, x) in displacement.iter_mut().zip([&given.value.x, &given.value.y, &given.value.z]) {
        if let Some(x) = x {
            *slot = field(x)?;
        }
    }
    let listed = raw.points.take();
    let points = match (listed, at_most_one(raw.into())?) {
        (Some(listed), Some(_)) => {
            let fault = Fault::new(listed.span(), "stands beside a selector", "which points?");
            return Err(fault.help("make two moves: their displacements add up"));
        }
        (Some(listed), None) => ControlPoints::Listed(listed.into_inner()),
        (None, Some(selector)) => ControlPoints::Selected(selector),
        (None, None) => ControlPoints::All,
    };
    Ok(Move { points, displacement })
}

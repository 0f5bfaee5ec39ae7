//! From a scenario and a mesh to a model: selectors become groups, materials find their regions, features are found.

use super::{ModelError, hints, loading, quantities, select, span};
use crate::fem::options::Element;
use crate::fem::{self, FemError, Model, Space};
use crate::field::Field;
use crate::mesh::locate::Locator;
use crate::mesh::midside::Midside;
use crate::mesh::{GroupId, Tagged, TetMesh, features, topology};
use crate::output::report::Selection;
use crate::output::table::short;
use crate::scenario::{Features, Load, LoadKind, Material, Scenario, Selector, Support, suggest};
use glam::DVec3;
use miette::Diagnostic as _;
use std::collections::BTreeSet;

/// Cosine by which a normal may miss an axis: an angle of 1e-5.
const AXIS_TOLERANCE: f64 = 5e-11;

/// A mesh and what is to be solved on it.
#[derive(Debug, Clone)]
pub struct Resolved {
    /// The mesh with a group for each support and load, and with its creases and corners.
    pub mesh: TetMesh,
    /// Nodes of its curved edges, sorted by edge.
    pub midsides: Vec<Midside>,
    /// The finite element.
    pub element: Element,
    /// Materials, supports and loads on its regions and groups.
    pub model: Model,
    /// The quantities asked for, on its regions and groups.
    pub quantities: Vec<fem::Quantity>,
    /// The index of that which refinement aims at.
    pub goal: Option<usize>,
    /// The solution that is known.
    pub exact: Option<fem::Exact>,
    /// What each selector matched.
    pub selections: Vec<Selection>,
    /// What is allowed but deserves a word.
    pub warnings: Vec<String>,
}

impl Resolved {
    /// What deserves a word before the run: of the scenario, and of the scenario on its mesh.
    pub(super) fn said<'a>(&'a self, scenario: &'a Scenario) -> impl Iterator<Item = &'a String> {
        scenario.warnings.iter().chain(&self.warnings)
    }

    /// The nodes of the elements on the input mesh.
    #[must_use]
    pub fn space(&self) -> Space<'_> {
        Space::new(&self.mesh, self.element, &self.midsides)
    }
}

/// Resolves a scenario on its mesh, with straight edges.
///
/// # Errors
/// [`ModelError`]: regions without material, no supports, selectors that match nothing, supports that contradict each
/// other, gravity without density, features that are not in the mesh.
pub fn resolve(scenario: &Scenario, mesh: TetMesh) -> Result<Resolved, ModelError> {
    resolve_curved(scenario, mesh, Vec::new())
}

/// Resolves a scenario on its mesh, of which some edges may be curved.
///
/// # Errors
/// As [`resolve`].
pub fn resolve_curved(scenario: &Scenario, mesh: TetMesh, midsides: Vec<Midside>) -> Result<Resolved, ModelError> {
    let Found { targets, model, quantities, exact } = find(scenario, Tets { mesh, midsides })?;
    let goal = scenario.adapt.goal.as_ref().and_then(|goal| quantities.iter().position(|q| q.name == *goal));
    let Targets { body: Tets { mesh, midsides }, selections, .. } = targets;
    // A known solution brings loads that the model does not list.
    let with_place = |error| with_place(scenario, error);
    let space = Space::new(&mesh, scenario.element, &midsides);
    let prescribed = fem::prescribed(&space, &model).map_err(with_place)?;
    let mut warnings =
        if exact.is_none() { loading::warnings(&space, &model, &prescribed).map_err(with_place)? } else { Vec::new() };
    warnings.extend(loading::idle_supports(&model, &prescribed));
    warnings.extend(odd_units(scenario, &mesh));
    warnings.extend(goal.and_then(|goal| loading::shared_reaction(&space, &model, &quantities[goal])));
    drop(space);
    let mesh = with_features(&scenario.features, mesh)?;
    Ok(Resolved { mesh, midsides, element: scenario.element, model, quantities, goal, exact, selections, warnings })
}

/// Young's modulus from which it is one in pascals: no material has so many megapascals.
const PASCALS: f64 = 1e8;

/// Size of a model from which its lengths are hardly metres.
const LARGE: f64 = 100.0;

/// A warning where the modulus is in pascals by its size, and lengths are not in metres; none if the scenario says what its lengths are.
pub(super) fn odd_units(scenario: &Scenario, mesh: &impl Tagged) -> Option<String> {
    let modulus = scenario.materials.iter().map(|m| m.youngs_modulus).fold(0.0, f64::max);
    let (lo, hi) = mesh.limits();
    let odd = scenario.units.length.is_none() && modulus >= PASCALS && lo.distance(hi) >= LARGE;
    odd.then(|| {
        format!(
            "a Young's modulus of {} is one in pascals, but the model spans {}, which would be metres: for lengths in millimetres give \
             moduli in megapascals (N/mm2), or say units.length",
            short(modulus, 6),
            span(mesh)
        )
    })
}

/// What a scenario's words mean on a body: groups, regions and materials found.
pub(super) struct Found<B> {
    pub targets: Targets<B>,
    pub model: Model,
    pub quantities: Vec<fem::Quantity>,
    pub exact: Option<fem::Exact>,
}

/// Finds what a scenario names on a body of any kind of cells.
///
/// # Errors
/// As [`resolve`], but for features.
pub(super) fn find<B: Body>(scenario: &Scenario, body: B) -> Result<Found<B>, ModelError> {
    let mut targets = Targets::new(body);
    let chosen = choose_materials(&scenario.materials, targets.mesh())?;
    if scenario.supports.is_empty() {
        return Err(ModelError::NoSupports);
    }
    let exact = scenario.exact.as_ref().map(|e| quantities::exact(e, &chosen, &mut targets)).transpose()?;
    let supports = scenario.supports.iter().map(|s| targets.support(s, exact)).collect::<Result<Vec<_>, _>>()?;
    let mut loads = Vec::new();
    for load in &scenario.loads {
        if let LoadKind::Gravity(_) = load.kind {
            check_density(format!("load `{}` is gravity", load.name), &load.place, &chosen)?;
        }
        loads.push(fem::Load { name: load.name.clone(), kind: targets.load(load)? });
    }
    let quantities = quantities::resolve(scenario, &chosen, &mut targets)?;
    let model = Model { materials: chosen.iter().map(|m| properties(m)).collect(), supports, loads };
    Ok(Found { targets, model, quantities, exact })
}

/// Checks that the supports stop every rigid motion of every part.
///
/// # Errors
/// [`ModelError::Supports`] names the motions that are left, and where the supports of these parts are written.
pub fn check_supports(scenario: &Scenario, problem: &Resolved) -> Result<(), ModelError> {
    fem::check_constraints(&problem.mesh, &problem.model).map_err(|error| with_place(scenario, error))
}

/// An error of supports with the places where they are written.
pub(super) fn with_place(scenario: &Scenario, error: FemError) -> ModelError {
    let blamed: Vec<&Support> = match &error {
        FemError::FreeMotion { supports, .. } => supports.iter().map(|&i| &scenario.supports[i]).collect(),
        FemError::ConflictingSupports { first, second, .. } => {
            scenario.supports.iter().filter(|s| s.name == *first || s.name == *second).collect()
        }
        _ => return ModelError::Fem(error),
    };
    let places: Vec<&str> = blamed.iter().map(|s| s.place.as_str()).collect();
    let places = if places.is_empty() { scenario.path.display().to_string() } else { places.join(" and ") };
    let help = error.help().map(|h| h.to_string()).unwrap_or_default();
    ModelError::Supports { places, error: Box::new(error), help }
}

pub(super) fn properties(m: &Material) -> fem::Material {
    fem::Material {
        youngs_modulus: m.youngs_modulus,
        poissons_ratio: m.poissons_ratio,
        density: m.density.unwrap_or(0.0),
    }
}

/// The material of each region: the one that names it, else the one that names none.
pub(super) fn choose_materials<'a>(
    materials: &'a [Material],
    mesh: &impl Tagged,
) -> Result<Vec<&'a Material>, ModelError> {
    let regions: Vec<&str> = mesh.region_names().iter().map(String::as_str).collect();
    for m in materials {
        if let Some(region) = m.group.as_ref().filter(|g| !regions.contains(&g.as_str())) {
            let (place, material, region) = (m.place.clone(), m.name.clone(), region.clone());
            let help = suggest::help(&region, "regions of this mesh", &regions);
            return Err(ModelError::UnknownRegion { place, material, region, help });
        }
    }
    let named = |region: &str| materials.iter().find(|m| m.group.as_deref() == Some(region));
    let general = materials.iter().find(|m| m.group.is_none());
    let chosen: Vec<Option<&Material>> = regions.iter().map(|r| named(r).or(general)).collect();
    if let Some(bare) = chosen.iter().position(Option::is_none) {
        return Err(no_material(mesh, &chosen, regions[bare]));
    }
    Ok(chosen.into_iter().flatten().collect())
}

fn no_material(mesh: &impl Tagged, chosen: &[Option<&Material>], example: &str) -> ModelError {
    let mut cells = vec![0_usize; chosen.len()];
    mesh.regions().iter().for_each(|r| cells[r.0 as usize] += 1);
    let bare = (0..chosen.len()).filter(|&r| chosen[r].is_none());
    let list: Vec<String> = bare.map(|r| format!("region `{}` ({} cells)", mesh.region_names()[r], cells[r])).collect();
    let help = format!(
        "add a table, for example\n[materials.steel]\nyoungs_modulus = 210e9\npoissons_ratio = 0.3\n\
         group = {example:?}   # without this line: all regions that no other material names"
    );
    ModelError::NoMaterial { regions: list.join(", "), help }
}

/// Refuses `what` asks for densities if a material has none.
pub(super) fn check_density(what: String, place: &str, chosen: &[&Material]) -> Result<(), ModelError> {
    let mut bare: Vec<String> =
        chosen.iter().filter(|m| m.density.is_none()).map(|m| format!("`{}`", m.name)).collect();
    bare.dedup();
    let materials = match bare.len() {
        0 => return Ok(()),
        1 => format!("material {} has", bare[0]),
        _ => format!("materials {} have", bare.join(", ")),
    };
    Err(ModelError::NoDensity { place: place.to_owned(), what, materials })
}

/// The coordinate axis normal to all faces of a group.
fn normal_axis(mesh: &impl Tagged, group: GroupId, support: &Support) -> Result<usize, ModelError> {
    let refuse = |problem: String, help| {
        let (place, what) = (support.place.clone(), format!("support `{}`", support.name));
        ModelError::NotSliding { place, what, problem, help }
    };
    let mut axis = None;
    for face in mesh.faces_of(group) {
        let normal = mesh.face_area(face).normalize_or_zero();
        let along = (0..3).find(|&c| normal[c].abs() >= 1.0 - AXIS_TOLERANCE);
        let Some(along) = along else {
            let at = mesh.points()[mesh.face_corners(face)[0] as usize];
            let problem = format!("a face at {at} has the normal {normal}");
            let help =
                "the normal has to be along x, y or z: turn the part, or model the whole of it instead of a half";
            return Err(refuse(problem, help));
        };
        if *axis.get_or_insert(along) != along {
            let [a, b] = [axis.unwrap_or(along), along].map(|c| ["x", "y", "z"][c]);
            let problem = format!("some faces are normal to {a}, others to {b}");
            return Err(refuse(problem, "make a support for each plane"));
        }
    }
    // The selector matched at least one face.
    Ok(axis.unwrap_or(0))
}

/// Whether faces of two groups share an edge: two vertices at least.
fn do_meet(mesh: &impl Tagged, group: GroupId, other: GroupId) -> bool {
    let corners =
        |group| -> BTreeSet<u32> { mesh.faces_of(group).flat_map(|f| mesh.face_corners(f).to_vec()).collect() };
    corners(group).intersection(&corners(other)).next().is_some()
}

/// A body of some kind of cells, on which a scenario is resolved.
pub(super) trait Body: Clone {
    /// The kind of mesh.
    type Mesh: Tagged;
    /// Whether supports can hold in the mean over their faces.
    const HOLDS_WEAKLY: bool;
    /// The mesh.
    fn mesh(&self) -> &Self::Mesh;
    /// The same body with another mesh of the same vertices and cells.
    fn with_mesh(self, mesh: Self::Mesh) -> Self;
    /// Area of boundary faces.
    fn area(&self, faces: &[usize]) -> f64;
    /// Distance of each place from the body, and the body's nearest point.
    fn nearest(&self, places: &[DVec3]) -> Vec<(f64, DVec3)>;
    /// Distance from the body from which on a load at a place is refused.
    fn outside(&self, place: DVec3) -> f64;
    /// What is wrong with cells that a quantity asks for.
    fn fault(&self, cells: &fem::Cells) -> Option<String>;
}

/// A body of tetrahedra, with the nodes of curved edges sorted by edge.
#[derive(Clone)]
pub(super) struct Tets {
    pub mesh: TetMesh,
    pub midsides: Vec<Midside>,
}

impl Body for Tets {
    type Mesh = TetMesh;

    const HOLDS_WEAKLY: bool = false;

    fn mesh(&self) -> &TetMesh {
        &self.mesh
    }

    fn with_mesh(self, mesh: TetMesh) -> Self {
        Self { mesh, ..self }
    }

    /// As the faces are: curved where their edges are.
    fn area(&self, faces: &[usize]) -> f64 {
        if self.midsides.is_empty() {
            return select::area(&self.mesh, faces.iter().copied());
        }
        let space = Space::new(&self.mesh, Element::Tet10, &self.midsides);
        faces.iter().flat_map(|&f| space.face_rule(&self.mesh.faces()[f])).map(|(_, _, area)| area.length()).sum()
    }

    fn nearest(&self, places: &[DVec3]) -> Vec<(f64, DVec3)> {
        let locator = Locator::new(&self.mesh);
        let nearest = |x: &DVec3| {
            let found = locator.nearest(*x);
            let corners = self.mesh.cell_points(found.cell).into_iter().zip(found.weights);
            (found.distance, corners.map(|(x, w)| w * x).sum())
        };
        places.iter().map(nearest).collect()
    }

    fn outside(&self, place: DVec3) -> f64 {
        fem::distance_outside(&self.mesh, place)
    }

    fn fault(&self, cells: &fem::Cells) -> Option<String> {
        let is_empty = cells.volume(&self.mesh) <= 0.0;
        is_empty.then(|| "asks for a part that holds nothing of the mesh".to_owned())
    }
}

/// The body while groups are added to its mesh.
pub(super) struct Targets<B> {
    pub(super) body: B,
    /// How many groups the mesh had at first; the others are of selectors, and nothing that a user could name.
    own: usize,
    pub(super) selections: Vec<Selection>,
}

impl<B: Body> Targets<B> {
    pub(super) fn new(body: B) -> Self {
        Self { own: body.mesh().groups().len(), body, selections: Vec::new() }
    }

    pub(super) fn mesh(&self) -> &B::Mesh {
        self.body.mesh()
    }

    pub(super) fn support(&mut self, s: &Support, exact: Option<fem::Exact>) -> Result<fem::Support, ModelError> {
        let group = self.group("support", &s.name, &s.place, &s.selector)?;
        let meets = s.meets.as_ref().map(|other| self.group("support", &s.name, &s.place, other)).transpose()?;
        let mut displacement = s.displacement.clone();
        let mut weakly = s.weak.then_some(fem::Weakly::Components);
        if s.weak && !B::HOLDS_WEAKLY {
            return Err(ModelError::Weak { place: s.place.clone(), what: format!("support `{}`", s.name) });
        }
        if s.sliding {
            match normal_axis(self.mesh(), group, s) {
                Ok(axis) => displacement[axis] = Some(Field::ZERO),
                Err(_) if B::HOLDS_WEAKLY => weakly = Some(fem::Weakly::Normal),
                Err(error) => return Err(error),
            }
        }
        if let Some(exact) = exact.filter(|_| s.exact) {
            displacement = [0, 1, 2].map(|c| Some(exact.displacement_field(c)));
        }
        if meets.is_some_and(|other| !do_meet(self.mesh(), group, other)) {
            let (place, what) = (s.place.clone(), format!("support `{}`", s.name));
            return Err(ModelError::NoEdge { place, what });
        }
        Ok(fem::Support { name: s.name.clone(), group, meets, displacement, weakly, stiffness: s.stiffness })
    }

    pub(super) fn load(&mut self, load: &Load) -> Result<fem::LoadKind, ModelError> {
        let mut group = |selector| self.group("load", &load.name, &load.place, selector);
        Ok(match &load.kind {
            LoadKind::Traction(s, t) => fem::LoadKind::Traction(group(s)?, t.clone()),
            LoadKind::Pressure(s, p) => fem::LoadKind::Pressure(group(s)?, p.clone()),
            LoadKind::Force(s, f) => fem::LoadKind::Force(group(s)?, *f),
            LoadKind::PointForce(x, f) => {
                self.check_inside(*x, load)?;
                fem::LoadKind::PointForce(*x, *f)
            }
            LoadKind::BodyForce(b) => fem::LoadKind::BodyForce(b.clone()),
            LoadKind::Gravity(g) => fem::LoadKind::Gravity(*g),
        })
    }

    /// Refuses a point outside the mesh, but for rounding.
    fn check_inside(&self, point: DVec3, load: &Load) -> Result<(), ModelError> {
        let (lo, hi) = self.mesh().limits();
        if self.body.outside(point) <= select::DEFAULT_TOLERANCE * lo.distance(hi) {
            return Ok(());
        }
        let by_distance = |a: &&DVec3, b: &&DVec3| a.distance(point).total_cmp(&b.distance(point));
        let nearest = self.mesh().points().iter().min_by(by_distance).copied().unwrap_or(point);
        let help = format!("the nearest vertex is {nearest}; the model spans {}", span(self.mesh()));
        Err(ModelError::PointOutside { place: load.place.clone(), load: load.name.clone(), point, help })
    }

    /// The group of the faces that a selector matches: the mesh's own if it names one, else a new one.
    pub(super) fn group(
        &mut self,
        what: &'static str,
        name: &str,
        place: &str,
        s: &Selector,
    ) -> Result<GroupId, ModelError> {
        let title = format!("{what} `{name}`");
        let mesh = self.body.mesh();
        let selected = select::select(mesh, s).map_err(|unknown| {
            let help = hints::unknown_group(mesh, self.own, &unknown.0);
            ModelError::UnknownGroup { place: place.to_owned(), what: title.clone(), group: unknown.0, help }
        })?;
        if !selected.contains(&true) {
            let help = hints::empty_selection(mesh, self.own, s);
            return Err(ModelError::EmptySelection { place: place.to_owned(), what: title, help });
        }
        let chosen: Vec<usize> = (0..selected.len()).filter(|&f| selected[f]).collect();
        let area = self.body.area(&chosen);
        self.selections.push(Selection { name: name.to_owned(), what, faces: chosen.len(), area });
        if let Selector::Group(existing) = s
            && let Some(id) = mesh.group_named(existing)
        {
            return Ok(id);
        }
        let (mesh, id) = mesh.clone().and_group(&format!("{what} {name}"), &selected)?;
        self.body = self.body.clone().with_mesh(mesh);
        Ok(id)
    }
}

/// The mesh with its creases and corners.
pub(super) fn with_features(tagged: &Features, mesh: TetMesh) -> Result<TetMesh, ModelError> {
    if !tagged.edges.is_empty() {
        let edges = topology::edges(mesh.tets());
        let missing = |e: &&[u32; 2]| edges.binary_search(&topology::sorted2(**e)).is_err();
        if let Some([a, b]) = tagged.edges.iter().find(missing) {
            let problem = format!("[{a}, {b}] is not an edge of the mesh");
            return Err(ModelError::Feature { key: "edges", problem });
        }
    }
    let count = mesh.points().len();
    if let Some(v) = tagged.corners.iter().find(|&&v| v as usize >= count) {
        let problem = format!("vertex {v} does not exist: the mesh has {count}");
        return Err(ModelError::Feature { key: "corners", problem });
    }
    let mesh = features::with_creases(mesh, tagged.sharp_angle(), &tagged.edges);
    if tagged.corners.is_empty() {
        return Ok(mesh);
    }
    let mut parts = mesh.into_parts();
    parts.corners.extend(&tagged.corners);
    Ok(TetMesh::new(parts)?)
}

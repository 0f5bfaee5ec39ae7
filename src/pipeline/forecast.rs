//! How large the meshes of a run will be and what memory they take, told before it runs.

use super::resolve::Resolved;
use crate::adapt::options::Marking;
use crate::error::Error;
use crate::fem::options::{Element, Method};
use crate::fem::{self, FemError};
use crate::mesh::{TetMesh, surface, topology};
use crate::scenario::{Scenario, Stop, Strategy};
use crate::subdiv::options::{Boundary, Mode, Octahedra, Scheme, SmoothBasis};
use serde::Serialize;

/// Resident bytes of an analysis that do not depend on the mesh, and those a cell of four nodes or of ten: of a mesh that was read or
/// generated, and of one that was refined, which is graded and comes to memory that earlier steps have torn up. Measured by
/// `benches/peers/memory.py` on red, adaptive and bisected meshes of the tripod and on boxes. Slender parts, whose multigrid is made
/// once more in double precision, need more.
const BASE_BYTES: f64 = 14e6;
const BYTES_A_CELL: [f64; 2] = [930.0, 1150.0];
const BYTES_A_QUADRATIC_CELL: [f64; 2] = [6300.0, 7600.0];

/// Those a cell of the mesh that a smooth solid is analysed on, where the unknowns are those of its control points: the product of the
/// matrix and the basis has a row a node too.
const BYTES_A_RESTRICTED_CELL: [f64; 2] = [1700.0, 1900.0];

/// Those a cell of ten nodes that the direct method needs more for its copy of the matrix; for four nodes they are no more than what a
/// multigrid would take.
const BYTES_A_QUADRATIC_CELL_COPIED: f64 = 5200.0;

/// The factor of a solid by nested dissection has `n^(4/3)` entries (George 1973, and Lipton, Rose and Tarjan 1979).
const FACTOR_GROWTH: f64 = 4.0 / 3.0;

/// The mesh of a step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Step {
    pub step: usize,
    pub cells: usize,
    pub nodes: usize,
    /// Three a node of the elements, which are on the edges too where they are quadratic.
    pub dofs: usize,
    /// At the peak of its analysis.
    pub bytes: u64,
    /// Whether the numbers of cells and nodes are counts; else they are estimates.
    pub exact: bool,
}

/// What a run may make.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Forecast {
    pub steps: Vec<Step>,
    /// Why there are no more steps.
    pub end: String,
    /// Memory that programs can get now, where the system tells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub free_bytes: Option<u64>,
}

impl Forecast {
    /// The forecast of a scenario from its input mesh. For the direct method the unknowns are ordered, and the factor counted, on
    /// that mesh.
    ///
    /// # Errors
    /// Those of assembly and of the ordering.
    pub(super) fn of(scenario: &Scenario, problem: &Resolved) -> Result<Self, FemError> {
        let refine = &scenario.refine;
        let mut sizes = Sizes::of(&problem.mesh);
        if scenario.solver.method == Method::Direct {
            let factor = fem::factor_numbers(&fem::assemble(&problem.space(), &problem.model)?)? as f64;
            sizes.factor = factor / sizes.dofs(scenario.element).powf(FACTOR_GROWTH);
        }
        let mut exact = true;
        let mut steps = Vec::new();
        let end = loop {
            let shown = sizes.analysed(scenario);
            let step = shown.step(steps.len(), exact, scenario);
            // Unknowns of a smooth solid may be those of its control points.
            let dofs = if is_restricted(scenario) { 3 * sizes.nodes.round() as usize } else { step.dofs };
            steps.push(Step { dofs, ..step });
            if refine.strategy == Strategy::None {
                break "refine.strategy = \"none\"".to_owned();
            }
            if steps.len() > refine.steps {
                break format!("steps = {}", refine.steps);
            }
            if let Some(most) = refine.stop.max_cells.filter(|most| shown.cells >= *most as f64) {
                break format!("max_cells = {most}");
            }
            let Some(next) = sizes.refined(scenario) else {
                break "further steps depend on the solution: the marking is by a threshold".to_owned();
            };
            let (cells, bytes) = (next.analysed(scenario).cells, next.analysed(scenario).bytes(true, scenario));
            if cells > f64::from(u32::MAX) {
                break "more cells than can be numbered".to_owned();
            }
            if let Some(most) = refine.stop.max_memory.filter(|most| bytes > *most as f64) {
                break format!("max_memory = {most}, the next step would take {}", size(bytes as u64));
            }
            sizes = next;
            // Red refinement counts exactly, all else depends on what the optimiser finds, which leaves control meshes alone.
            let as_made = refine.options.optimise.mode == Mode::Paper || scenario.smooth.is_some();
            exact &= refine.options.scheme == Scheme::Red && as_made;
        };
        Ok(Self { steps, end, free_bytes: free_bytes() })
    }

    /// The first step that takes more memory than is free.
    pub(super) fn too_large(&self) -> Option<&Step> {
        self.free_bytes.and_then(|free| self.steps.iter().find(|s| s.bytes > free))
    }
}

/// Whether the unknowns are those of the control points of a smooth solid.
fn is_restricted(scenario: &Scenario) -> bool {
    scenario.smooth.is_some_and(|s| s.basis == SmoothBasis::Control)
}

/// Counts of a mesh; estimates are no whole numbers.
#[derive(Debug, Clone, Copy)]
struct Sizes {
    cells: f64,
    nodes: f64,
    edges: f64,
    /// Triangles of the boundary.
    boundary: f64,
    /// Triangles and edges of the boundary and of interfaces between regions.
    surface: f64,
    surface_edges: f64,
    /// Numbers of the Cholesky factor for each `dofs^(4/3)`; zero if there is none.
    factor: f64,
}

impl Sizes {
    fn of(mesh: &TetMesh) -> Self {
        let surface = surface::surface_faces(mesh);
        Self {
            cells: mesh.tets().len() as f64,
            nodes: mesh.points().len() as f64,
            edges: topology::edges(mesh.tets()).len() as f64,
            boundary: mesh.faces().len() as f64,
            surface: surface.len() as f64,
            surface_edges: surface::surface_edges(&surface).len() as f64,
            factor: 0.0,
        }
    }

    fn dofs(&self, element: Element) -> f64 {
        3.0 * match element {
            Element::Tet4 => self.nodes,
            Element::Tet10 => self.nodes + self.edges,
        }
    }

    fn bytes(&self, refined: bool, scenario: &Scenario) -> f64 {
        let refined = usize::from(refined);
        let factor = 8.0 * self.factor * self.dofs(scenario.element).powf(FACTOR_GROWTH);
        let a_cell = match (scenario.element, scenario.solver.method) {
            (Element::Tet4, _) if is_restricted(scenario) => BYTES_A_RESTRICTED_CELL[refined],
            (Element::Tet4, _) => BYTES_A_CELL[refined],
            (Element::Tet10, Method::Direct) => BYTES_A_QUADRATIC_CELL[refined] + BYTES_A_QUADRATIC_CELL_COPIED,
            (Element::Tet10, _) => BYTES_A_QUADRATIC_CELL[refined],
        };
        BASE_BYTES + a_cell * self.cells + factor
    }

    fn step(&self, step: usize, exact: bool, scenario: &Scenario) -> Step {
        let [cells, nodes, dofs] = [self.cells, self.nodes, self.dofs(scenario.element)].map(|x| x.round() as usize);
        Step { step, cells, nodes, dofs, bytes: self.bytes(step > 0, scenario) as u64, exact }
    }

    /// The mesh of the next step; `None` where only the solution knows.
    fn refined(&self, scenario: &Scenario) -> Option<Self> {
        self.refined_by(scenario, scenario.refine.strategy)
    }

    fn refined_by(&self, scenario: &Scenario, strategy: Strategy) -> Option<Self> {
        let options = &scenario.refine.options;
        let all = match options.scheme {
            Scheme::Red => self.red(),
            Scheme::Sqrt3 => self.sqrt3(options.boundary),
            Scheme::LongestEdge => self.bisected(),
        };
        if strategy == Strategy::Global {
            return Some(all);
        }
        let share = share(scenario.adapt.marking, scenario.adapt.grow, scenario.element)?;
        let cells = cells_after(options.scheme, Strategy::Adaptive, self.cells, share * self.cells);
        // Nodes come with cells as they do in global refinement.
        let part = (cells - self.cells) / (all.cells - self.cells);
        let mix = |old: f64, new: f64| old + part * (new - old);
        Some(Self {
            cells,
            nodes: mix(self.nodes, all.nodes),
            edges: mix(self.edges, all.edges),
            boundary: mix(self.boundary, all.boundary),
            surface: mix(self.surface, all.surface),
            surface_edges: mix(self.surface_edges, all.surface_edges),
            factor: self.factor,
        })
    }

    /// The mesh that is analysed: this one, or what smooth subdivision makes of it. A step makes `T' = 4 T + 8 O` tetrahedra and
    /// `O' = T + 6 O` octahedra. Edges are halved and faces get three new ones; inside, a tetrahedron gets four faces, an
    /// octahedron a vertex, twelve edges and 24 faces.
    fn analysed(&self, scenario: &Scenario) -> Self {
        let Some(smooth) = scenario.smooth else { return *self };
        let (mut tets, mut octs) = (self.cells, 0.0);
        let (mut nodes, mut edges, mut faces) = (self.nodes, self.edges, (4.0 * self.cells + self.boundary) / 2.0);
        for _ in 0..smooth.steps {
            (nodes, edges, faces) =
                (nodes + edges + octs, 2.0 * edges + 3.0 * faces + 12.0 * octs, 4.0 * faces + 4.0 * tets + 24.0 * octs);
            (tets, octs) = (4.0 * tets + 8.0 * octs, tets + 6.0 * octs);
        }
        // Octahedra are cut around a diagonal, or around a vertex at their centroids.
        let (cells, new_nodes, new_edges) = match smooth.octahedra {
            Octahedra::Diagonal => (4.0, 0.0, 1.0),
            Octahedra::Centroid => (8.0, 1.0, 6.0),
        };
        let finer = 4_f64.powi(smooth.steps as i32);
        Self {
            cells: tets + cells * octs,
            nodes: nodes + new_nodes * octs,
            edges: edges + new_edges * octs,
            boundary: finer * self.boundary,
            surface: finer * self.surface,
            surface_edges: finer * self.surface_edges,
            factor: self.factor,
        }
    }

    /// Every edge is halved, every face gets three new edges and every cell one.
    fn red(&self) -> Self {
        let faces = (4.0 * self.cells + self.boundary) / 2.0;
        Self {
            cells: cells_after(Scheme::Red, Strategy::Global, self.cells, self.cells),
            nodes: self.nodes + self.edges,
            edges: 2.0 * self.edges + 3.0 * faces + self.cells,
            boundary: 4.0 * self.boundary,
            surface: 4.0 * self.surface,
            surface_edges: 2.0 * self.surface_edges + 3.0 * self.surface,
            factor: self.factor,
        }
    }

    /// Every cell gets a vertex and becomes four, every face inside becomes another cell; then every edge of the surface
    /// gets a vertex, or else every face of it. How many cells that makes at an edge was measured on the tripod.
    fn sqrt3(&self, boundary: Boundary) -> Self {
        let (new, faces, at_edge) = match boundary {
            Boundary::Fixed => (self.surface_edges, 4.0, 4.2),
            Boundary::Approximating | Boundary::Interpolating => (self.surface, 3.0, 3.3),
        };
        let flipped = 2.0 * self.cells + 0.5 * self.boundary - self.surface;
        let cells = 4.0 * self.cells + flipped + at_edge * self.surface_edges;
        let nodes = self.nodes + self.cells + new;
        Self {
            cells,
            nodes,
            // Euler: V - E + F - T hardly changes beside them.
            edges: nodes + cells + 0.5 * faces * self.boundary,
            boundary: faces * self.boundary,
            surface: faces * self.surface,
            surface_edges: 1.5 * faces * self.surface,
            factor: self.factor,
        }
    }

    /// An edge inside has about five cells, which its midpoint halves.
    fn bisected(&self) -> Self {
        let cells = cells_after(Scheme::LongestEdge, Strategy::Global, self.cells, self.cells);
        let surface_growth = (cells / self.cells).powf(2.0 / 3.0);
        let (boundary, nodes) = (surface_growth * self.boundary, self.nodes + (cells - self.cells) / 5.0);
        Self {
            cells,
            nodes,
            // Euler: V - E + F - T hardly changes beside them.
            edges: self.edges + (nodes - self.nodes) + (cells - self.cells) + 0.5 * (boundary - self.boundary),
            boundary,
            surface: surface_growth * self.surface,
            surface_edges: surface_growth * self.surface_edges,
            factor: self.factor,
        }
    }
}

/// The number of cells after `selected` of them are refined. Exact for red refinement; else measured on the tripod and the bundled
/// scenarios: neighbours take part, in bisection the more for each selected cell the fewer and the more scattered these are.
pub(super) fn cells_after(scheme: Scheme, strategy: Strategy, cells: f64, selected: f64) -> f64 {
    cells
        + match (scheme, strategy) {
            (Scheme::Red, _) => 7.0 * selected,
            (Scheme::Sqrt3, Strategy::Adaptive) => 4.4 * selected,
            (Scheme::Sqrt3, _) => 7.2 * selected,
            (Scheme::LongestEdge, Strategy::Adaptive) => 1.45 * (selected * cells).sqrt(),
            (Scheme::LongestEdge, _) => 2.6 * selected,
        }
}

/// The share of the cells that a marking selects; measured on the bundled scenarios, but for a fraction. `None` where only
/// the solution knows. Scattered cells have two neighbours in a ring that are not selected yet.
fn share(marking: Marking, rings: usize, element: Element) -> Option<f64> {
    // Errors of quadratic elements are concentrated in fewer cells.
    let spread = if element == Element::Tet4 { 0.84 } else { 0.65 };
    let marked = match marking {
        Marking::Fraction(share) => share,
        Marking::Doerfler(share) | Marking::LookAhead(share) => spread * share * share,
        Marking::Maximum(share) => (1.0 - share) * (1.0 - share) / 3.0,
        Marking::Threshold(_) => return None,
    };
    Some(1.0 - (1.0 - marked).powi(1 + 2 * rings as i32))
}

/// Bytes that the next step will need at its peak, from those of this one and the growth of the cells. Memory
/// grows with the cells but for [`BASE_BYTES`], but for the Cholesky factor.
pub(super) fn next_bytes(peak: usize, growth: f64, method: &str) -> f64 {
    let base = BASE_BYTES.min(peak as f64);
    base + (peak as f64 - base) * if method == "direct" { growth.powf(FACTOR_GROWTH) } else { growth }
}

/// Refuses a run whose mesh, or of a global one any later step, needs more memory than can be had. Runs that may end before, by a tolerance
/// or another rule, and adaptive ones, whose meshes the solution makes, begin: the loop looks at memory before each step.
///
/// # Errors
/// [`Error::TooLarge`] names the step, what it needs, and the largest step that fits.
pub(super) fn refuse_too_large(scenario: &Scenario, strategy: Strategy, problem: &Resolved) -> Result<(), Error> {
    let Some(most) = available(0) else { return Ok(()) };
    let rules = &scenario.refine.stop;
    let may_end_before = *rules != Stop::default() || scenario.adapt.goal.is_some();
    let mut sizes = Sizes::of(&problem.mesh);
    for step in 0..=scenario.refine.steps {
        let needs = sizes.analysed(scenario).bytes(step > 0, scenario);
        if needs > most as f64 {
            let help = match step {
                0 => "take a coarser mesh, or four-node elements (analysis.element = \"tet4\")".to_owned(),
                _ => format!(
                    "--set refine.steps={} fits; or let the run end by itself: --set refine.stop.max_memory=\"{:.0} MB\"",
                    step - 1,
                    most as f64 / 1e6
                ),
            };
            let what = format!("step {step} of this run needs about");
            return Err(Error::TooLarge { what, needs: size(needs as u64), most: size(most), help });
        }
        if may_end_before || strategy != Strategy::Global {
            break;
        }
        match sizes.refined_by(scenario, strategy) {
            Some(next) => sizes = next,
            None => break,
        }
    }
    Ok(())
}

/// Memory that this process can have in all when it holds `held` bytes: what is free, within the limits of the address space and of its
/// group, where the system tells (Linux).
pub(super) fn available(held: u64) -> Option<u64> {
    let free = free_bytes().map(|free| free + held);
    let number = |path: &str| std::fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let group = number("/sys/fs/cgroup/memory.max").or_else(|| number("/sys/fs/cgroup/memory/memory.limit_in_bytes"));
    [free, group, address_space()].into_iter().flatten().min()
}

/// The limit of the address space (`ulimit -v`).
fn address_space() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// Memory that programs can get without swapping, where the system tells (Linux).
pub(super) fn free_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

/// Bytes in words.
pub(super) fn size(bytes: u64) -> String {
    let bytes = bytes as f64;
    if bytes < 1e9 { format!("{:.0} MB", bytes / 1e6) } else { format!("{:.1} GB", bytes / 1e9) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate::box_tets;
    use crate::subdiv::{self, History, options::Options};

    #[test]
    fn the_memory_of_a_direct_solution_grows_faster_than_the_mesh() {
        let growth = |strategy, cells, selected| cells_after(Scheme::Red, strategy, cells, selected) / cells;
        let global = growth(Strategy::Global, 50.0, 50.0);
        // What does not depend on the mesh, and ten million bytes that do.
        let peak = 24_000_000;
        assert_eq!(next_bytes(peak, global, "amg-cg"), 94e6);
        assert!((next_bytes(peak, global, "direct") - 174e6).abs() < 1.0);
    }

    /// Counts of the schemes' own making are met exactly: all of red refinement, the nodes of the first sqrt(3) step.
    #[test]
    fn counts_are_those_of_refinement() {
        let mesh = box_tets([1.0, 2.0, 1.5], [2, 3, 2]).unwrap();
        let all = |scheme| {
            let options = Options { scheme, ..Options::default() };
            subdiv::refine(&mesh, &History::default(), &vec![true; mesh.tets().len()], &options).unwrap().mesh
        };
        let (red, sizes) = (all(Scheme::Red), Sizes::of(&mesh));
        for (forecast, made) in [(sizes.red(), Sizes::of(&red)), (sizes.red().red(), Sizes::of(&red).red())] {
            assert_eq!((forecast.cells, forecast.nodes, forecast.edges), (made.cells, made.nodes, made.edges));
            assert_eq!((forecast.boundary, forecast.surface_edges), (made.boundary, made.surface_edges));
        }
        let (sqrt3, forecast) = (Sizes::of(&all(Scheme::Sqrt3)), sizes.sqrt3(Boundary::Fixed));
        assert_eq!((forecast.nodes, forecast.boundary), (sqrt3.nodes, sqrt3.boundary));
        assert!((forecast.cells / sqrt3.cells - 1.0).abs() < 0.15, "{forecast:?} {sqrt3:?}");
        assert!((forecast.edges / sqrt3.edges - 1.0).abs() < 0.15, "{forecast:?} {sqrt3:?}");
    }

    #[test]
    fn rings_grow_a_selection_but_not_beyond_all() {
        let of = |rings| share(Marking::Fraction(0.1), rings, Element::Tet4).unwrap();
        assert!((of(0) - 0.1).abs() < 1e-12 && of(1) > 0.25 && of(100) <= 1.0);
        assert_eq!(share(Marking::Threshold(1.0), 0, Element::Tet4), None);
    }
}

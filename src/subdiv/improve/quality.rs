//! Objective "quality": large dihedral angles, first the worst of them, then their mean, and few cells at a vertex.
//!
//! Each pass works on what the pass before changed: it relieves over-full vertices, removes edges and faces, and smooths
//! for the worst cell and for the mean. The last pass ends with the few cells that all this could not help.
//!
//! Candidates are evaluated in parallel on the mesh as it stands, and those that would succeed are then carried out one
//! after the other, evaluated again; so the result does not depend on the number of threads.

use super::super::options::Optimise;
use super::super::solid::{Ring, Solid};
use super::edge_removal::{Filling, Measure};
use super::edges::Rule;
use super::freedom::{Freedom, freedoms};
use super::mean;
use super::multi_face::{find_faces, remove_faces};
use super::parallel::{self, faces_where, select, vertices_where};
use super::smooth::Smoother;

/// Steps of the smoother a visit: more of them equalise the cells at a vertex at the expense of their mean.
const STEPS: usize = 2;

/// No cell is pushed below this many degrees under the target for the sake of the mean.
const MEAN_BELOW: f64 = 4.0;

/// Repairs end after this many rounds.
const REPAIRS: usize = 3;

/// The worst sine must grow by this much for a change to be worth it.
const GAIN: f64 = 0.01;

/// What one run works with.
pub(super) struct Quality {
    /// Cells with larger sines are good enough.
    pub(super) goal: f64,
    /// Cells with smaller sines are repaired.
    pub(super) repair: f64,
    mean_floor: f64,
    pub(super) limit: usize,
    /// How far rounding may have moved vertices off their planes.
    rounding: f64,
    pub(super) freedoms: Vec<Freedom>,
    pub(super) filling: Filling,
    pub(super) smoother: Smoother,
    /// Repairs that succeeded, and that failed.
    pub(super) repaired: usize,
    pub(super) failed: usize,
}

/// Optimises the cells changed since `since` and whatever that changes. Keeps the surface as a set of points (flat parts
/// may get other triangles), creases, patches and regions; adds vertices, removes none.
pub(crate) fn optimise_quality(solid: &mut Solid, since: u32, options: &Optimise) {
    let mut run = Quality::new(options, solid, freedoms(solid));
    let mut changed = since;
    for pass in 1..=options.passes {
        changed = run.pass(solid, changed, (pass == options.passes).then_some(since));
    }
}

/// Edge removal and smoothing of interior vertices only, for cells with a sine below `goal`: a quick repair between the
/// stages of a scheme.
pub(super) fn improve_interior(solid: &mut Solid, since: u32, passes: usize, goal: f64) {
    let still = |f| if f == Freedom::Space { f } else { Freedom::Fixed };
    let freedoms = freedoms(solid).into_iter().map(still).collect();
    let mut run = Quality { goal, ..Quality::new(&Optimise::default(), solid, freedoms) };
    let mut since = since;
    for _ in 0..passes {
        let now = solid.tick();
        run.remove_edges(solid, since);
        run.smooth(solid, since);
        since = now;
    }
}

impl Quality {
    fn new(options: &Optimise, solid: &Solid, freedoms: Vec<Freedom>) -> Self {
        let sine = |degrees: f64| degrees.clamp(1.0, 60.0).to_radians().sin();
        Self {
            goal: sine(options.target_angle),
            repair: sine(options.repair_angle()),
            mean_floor: sine(options.target_angle - MEAN_BELOW),
            limit: options.valence_limit,
            rounding: 4.0 * f64::EPSILON * solid.largest_coordinate(),
            freedoms,
            filling: Filling::default(),
            smoother: Smoother::with_steps(STEPS),
            repaired: 0,
            failed: 0,
        }
    }

    /// One pass over the cells changed since `since`; returns when it began. The last pass is told when the run started.
    fn pass(&mut self, solid: &mut Solid, since: u32, last: Option<u32>) -> u32 {
        let now = solid.tick();
        self.relieve(solid, last.is_none());
        self.remove_edges(solid, since);
        self.remove_faces(solid, since);
        if last.is_some() {
            // Removed faces have left new edges.
            self.relieve(solid, false);
        }
        self.smooth(solid, since);
        self.repair(solid, last);
        self.raise_means(solid, since);
        // Around the cells that are left the mesh is another now.
        self.repair(solid, last);
        now
    }

    /// Repairs the worst cells changed since `start`, in the last pass.
    fn repair(&mut self, solid: &mut Solid, start: Option<u32>) {
        let mut changed = start;
        for _ in 0..REPAIRS {
            changed = changed.map(|since| self.repair_since(solid, since));
        }
    }

    /// Removes edges of bad cells where that improves the worst cell of the ring.
    fn remove_edges(&mut self, solid: &mut Solid, since: u32) {
        self.rule(|worst| worst + GAIN).remove_edges(solid, |solid, t| self.is_bad(solid, t, since));
    }

    /// Removes the edge if the worst sine of the new cells exceeds `floor(worst old sine)`.
    pub(super) fn improve_edge(
        &mut self,
        solid: &mut Solid,
        edge: [u32; 2],
        floor: impl Fn(f64) -> f64 + Sync,
    ) -> bool {
        let mut filling = std::mem::take(&mut self.filling);
        let done = self.rule(floor).remove_edge(solid, edge, &mut filling);
        self.filling = filling;
        done
    }

    /// Edges with cells below the goal may go if the worst new sine exceeds `floor(worst old sine)`.
    fn rule(&self, floor: impl Fn(f64) -> f64 + Sync) -> Rule<impl Fn(&Solid, &Ring) -> Option<Measure> + Sync> {
        let goal = self.goal;
        let measure = move |solid: &Solid, ring: &Ring| {
            let floor = floor(solid.worst_sine(&ring.cells)).max(0.0);
            (floor < goal).then_some(Measure::BestWorst(floor))
        };
        Rule { measure, rounding: self.rounding }
    }

    /// Removes faces of bad cells where that improves the worst cell.
    fn remove_faces(&self, solid: &mut Solid, since: u32) {
        let faces = faces_where(solid, |t| self.is_bad(solid, t, since));
        let worth = |(): &mut (), &(face, cells): &([u32; 3], [u32; 2])| {
            find_faces(solid, face, cells, self.goal, GAIN).is_some()
        };
        for (face, _) in select(faces, worth) {
            remove_faces(solid, face, self.goal, GAIN);
        }
    }

    /// Smooths the vertices of bad cells for their worst cell.
    fn smooth(&self, solid: &mut Solid, since: u32) {
        let vertices = vertices_where(solid, |t| self.is_bad(solid, t, since));
        self.sweep(solid, vertices, |smoother, solid, v, freedom| smoother.better(solid, v, freedom, self.goal));
    }

    /// Smooths the vertices of changed cells for the mean.
    fn raise_means(&self, solid: &mut Solid, since: u32) {
        let vertices = vertices_where(solid, |t| solid.is_changed(t, since));
        self.sweep(solid, vertices, |smoother, solid, v, freedom| {
            mean::better(&mut smoother.fan, solid, v, freedom, self.mean_floor)
        });
    }

    /// Moves vertices to where `propose` says.
    fn sweep<F>(&self, solid: &mut Solid, vertices: Vec<u32>, propose: F)
    where
        F: Fn(&mut Smoother, &Solid, u32, Freedom) -> Option<glam::DVec3> + Sync,
    {
        parallel::sweep(solid, &self.freedoms, vertices, || Smoother::with_steps(STEPS), propose);
    }

    /// True for a cell changed since `since` that is not good enough.
    fn is_bad(&self, solid: &Solid, t: u32, since: u32) -> bool {
        solid.is_changed(t, since) && solid.sine(t) < self.goal
    }
}

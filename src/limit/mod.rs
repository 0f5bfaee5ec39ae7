//! The limit of Catmull-Clark subdivision as a finite-element basis: on each cell of a control mesh, the functions of its
//! control points, exact near extraordinary vertices and edges too.
//!
//! What a cell's functions are depends on the connectivity and tags of its ring only (the cells that share a vertex with it),
//! so cells of like rings share their tables; after one global refinement few distinct rings remain.

mod bubbles;
mod evaluate;
mod ring;
mod spline;

pub use bubbles::Bubble;
pub use evaluate::Part;

use crate::mesh::hex::HexMesh;
use crate::subdiv::catmull_clark::Control;
use crate::subdiv::options::CatmullClark;
use bubbles::{Enriched, LocalBubble};
use evaluate::Families;
use glam::DVec3;
use rayon::prelude::*;
use ring::{Ring, Shape};
use rustc_hash::FxHashMap;

/// Functions of a cell at points of its unit cube.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// Number of functions.
    pub functions: usize,
    /// Values: all functions at the first point, then at the second, and so on.
    pub values: Vec<f64>,
    /// Derivatives along the axes of the unit cube, in the same order.
    pub gradients: Vec<DVec3>,
}

impl Table {
    /// Values of all functions at a point.
    #[must_use]
    pub fn values_at(&self, point: usize) -> &[f64] {
        &self.values[point * self.functions..(point + 1) * self.functions]
    }

    /// Derivatives of all functions at a point.
    #[must_use]
    pub fn gradients_at(&self, point: usize) -> &[DVec3] {
        &self.gradients[point * self.functions..(point + 1) * self.functions]
    }
}

/// The functions on the cells of a control mesh: those of its vertices, and the bubbles of the boundary if asked for.
#[derive(Debug)]
pub struct Basis {
    families: Families,
    vertices: usize,
    bubbles: Vec<Bubble>,
    /// Distinct rings, in the order of the first cell of each.
    classes: Vec<Class>,
    class_of: Vec<u32>,
    /// Whether a class has several cells.
    shared: Vec<bool>,
    starts: Vec<usize>,
    functions: Vec<u32>,
}

/// What the functions of a cell depend on.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Class {
    shape: Shape,
    bubbles: Vec<LocalBubble>,
}

impl Basis {
    /// The basis on a mesh that [`HexMesh::check_smoothable`] accepts; with `enriched`, bubbles lift the natural end
    /// condition of the boundary's rules.
    #[must_use]
    pub fn new(mesh: &HexMesh, variant: CatmullClark, enriched: bool) -> Self {
        let control = Control::of(mesh);
        let enrichment = enriched.then(|| Enriched::new(&control));
        let vertices = mesh.points().len();
        let of_cell = |t: usize| {
            let ring = Ring::of(&control, t as u32);
            let mut functions = ring.vertices.clone();
            let mut bubbles = Vec::new();
            if let Some(enrichment) = &enrichment {
                for (number, bubble) in enrichment.of_ring(&control, t as u32, &ring) {
                    functions.push(vertices as u32 + number);
                    bubbles.push(bubble);
                }
            }
            (Class { shape: ring.shape, bubbles }, functions)
        };
        let cells: Vec<_> = (0..mesh.cells().len()).into_par_iter().map(of_cell).collect();
        let mut numbers: FxHashMap<Class, u32> = FxHashMap::default();
        let mut basis = Self {
            families: Families::new(variant),
            vertices,
            bubbles: enrichment.map(|e| e.bubbles).unwrap_or_default(),
            classes: Vec::new(),
            class_of: Vec::with_capacity(cells.len()),
            shared: Vec::new(),
            starts: vec![0],
            functions: Vec::new(),
        };
        for (class, functions) in cells {
            let next = basis.classes.len() as u32;
            let number = *numbers.entry(class).or_insert_with_key(|class| {
                basis.classes.push(class.clone());
                next
            });
            if number == next {
                basis.shared.push(false);
            } else {
                basis.shared[number as usize] = true;
            }
            basis.class_of.push(number);
            basis.functions.extend(functions);
            basis.starts.push(basis.functions.len());
        }
        basis
    }

    /// Number of functions: vertices first, then bubbles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.vertices + self.bubbles.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The bubbles, in the order of their numbers.
    #[must_use]
    pub fn bubbles(&self) -> &[Bubble] {
        &self.bubbles
    }

    /// Number of distinct rings.
    #[must_use]
    pub fn classes(&self) -> usize {
        self.classes.len()
    }

    /// The class of cell `t`, below [`Basis::classes`].
    #[must_use]
    pub fn class(&self, t: usize) -> usize {
        self.class_of[t] as usize
    }

    /// The functions that do not vanish on cell `t`, in the order of its tables: those of vertices, then bubbles.
    #[must_use]
    pub fn cell(&self, t: usize) -> &[u32] {
        &self.functions[self.starts[t]..self.starts[t + 1]]
    }

    /// Whether a class is that of a cell inside a regular grid, or at its boundary: a tensor product of splines.
    #[must_use]
    pub fn is_regular(&self, class: usize) -> bool {
        self.classes[class].shape.regular().is_some()
    }

    /// Whether several cells are of a class.
    #[must_use]
    pub fn is_shared(&self, class: usize) -> bool {
        self.shared[class]
    }

    /// The parts of the unit cube, halved `depth` times at most, in which the functions of a class are polynomials or which are
    /// too small to be halved again.
    #[must_use]
    pub fn parts(&self, class: usize, depth: u32) -> Vec<Part> {
        let Class { shape, bubbles } = &self.classes[class];
        let projections: Vec<u8> = bubbles::projections(bubbles).collect();
        evaluate::parts(shape, &projections, depth, &self.families)
    }

    /// The functions of a class as others that do not depend on each other: each a combination of the class's; `None` where it
    /// vanishes. See [`Basis::lowered`].
    #[must_use]
    pub fn lifted(&self, class: usize) -> Vec<Option<Vec<(usize, f64)>>> {
        let Class { shape, bubbles } = &self.classes[class];
        bubbles::lifted(bubbles, shape.vertices())
    }

    /// The coefficients of a function that is given by those of [`Basis::lifted`] ones; `sum` makes a weighted sum.
    #[must_use]
    pub fn lowered<T: Copy>(&self, lifted: &[T], sum: impl Fn(&mut dyn Iterator<Item = (T, f64)>) -> T) -> Vec<T> {
        bubbles::lowered(&self.bubbles, self.vertices, lifted, sum)
    }

    /// The functions of one class at points of the unit cube.
    #[must_use]
    pub fn table(&self, class: usize, points: &[DVec3]) -> Table {
        self.classes[class].table(points, &self.families)
    }
}

impl Class {
    fn table(&self, points: &[DVec3], families: &Families) -> Table {
        let plain = evaluate::table(&self.shape, points, families);
        if self.bubbles.is_empty() {
            return plain;
        }
        bubbles::enriched_table(&self.bubbles, &plain, points, |points| evaluate::table(&self.shape, points, families))
    }
}

//! Triangulations of the sphere: the ways in which tetrahedra can meet in a vertex.

use std::collections::BTreeSet;

/// A triangulation of the sphere without double edges, as the triangle to the left of each directed edge.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sphere {
    vertices: usize,
    /// The third vertex of the triangle to the left of the edge from `a` to `b`, at `a * vertices + b`; [`NONE`] if there is no
    /// such edge.
    third: Vec<u8>,
}

const NONE: u8 = u8::MAX;

impl Sphere {
    /// Two vertices over a ring of the others.
    fn bipyramid(vertices: usize) -> Self {
        let ring = vertices as u8 - 2;
        let mut sphere = Self { vertices, third: vec![NONE; vertices * vertices] };
        for i in 0..ring {
            let next = (i + 1) % ring;
            sphere.put([i, next, ring]);
            sphere.put([next, i, ring + 1]);
        }
        sphere
    }

    fn put(&mut self, [a, b, c]: [u8; 3]) {
        for [a, b, c] in [[a, b, c], [b, c, a], [c, a, b]] {
            let place = self.place(a, b);
            self.third[place] = c;
        }
    }

    fn place(&self, a: u8, b: u8) -> usize {
        usize::from(a) * self.vertices + usize::from(b)
    }

    fn third(&self, a: u8, b: u8) -> u8 {
        self.third[self.place(a, b)]
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// Triangles, counter-clockwise seen from outside, each beginning with its smallest vertex; sorted.
    #[must_use]
    pub fn triangles(&self) -> Vec<[u8; 3]> {
        let all = self.edges().map(|[a, b]| [a, b, self.third(a, b)]);
        all.filter(|[a, b, c]| a < b && a < c).collect()
    }

    /// Directed edges, sorted.
    fn edges(&self) -> impl Iterator<Item = [u8; 2]> + '_ {
        let count = self.vertices as u8;
        let all = (0..count).flat_map(move |a| (0..count).map(move |b| [a, b]));
        all.filter(|&[a, b]| self.third(a, b) != NONE)
    }

    /// Numbers of neighbours of the vertices, descending.
    #[must_use]
    pub fn degrees(&self) -> Vec<usize> {
        let mut degrees = vec![0; self.vertices];
        self.edges().for_each(|[a, _]| degrees[usize::from(a)] += 1);
        degrees.sort_unstable_by(|a, b| b.cmp(a));
        degrees
    }

    /// The triangulation with the edge ab of the triangles abc and bad replaced by cd, if there is no edge cd yet.
    fn flipped(&self, [a, b]: [u8; 2]) -> Option<Self> {
        let (c, d) = (self.third(a, b), self.third(b, a));
        if self.third(c, d) != NONE {
            return None;
        }
        let mut flipped = self.clone();
        for (from, to) in [(a, b), (b, a)] {
            let place = self.place(from, to);
            flipped.third[place] = NONE;
        }
        flipped.put([a, d, c]);
        flipped.put([b, c, d]);
        Some(flipped)
    }

    /// The same for triangulations that differ by numbering or by reflection alone: the least of the codes that begin at a
    /// directed edge.
    fn code(&self) -> Vec<u8> {
        let codes = self.edges().flat_map(|edge| [true, false].map(|left| self.code_from(edge, left)));
        codes.min().unwrap_or_default()
    }

    /// The neighbours of the vertices around each, in the order in which a walk from a directed edge meets them, turning to the left
    /// or to the right.
    fn code_from(&self, [a, b]: [u8; 2], left: bool) -> Vec<u8> {
        let mut labels = vec![NONE; self.vertices];
        // Vertices as they are met, each with the neighbour from which its own are counted.
        let mut met = vec![(a, b), (b, a)];
        (labels[usize::from(a)], labels[usize::from(b)]) = (0, 1);
        let mut code = Vec::with_capacity(7 * self.vertices);
        let mut next = 0;
        while let Some(&(v, first)) = met.get(next) {
            next += 1;
            let mut w = first;
            loop {
                if labels[usize::from(w)] == NONE {
                    labels[usize::from(w)] = met.len() as u8;
                    met.push((w, v));
                }
                code.push(labels[usize::from(w)]);
                w = if left { self.third(v, w) } else { self.third(w, v) };
                if w == first {
                    break;
                }
            }
            code.push(NONE);
        }
        code
    }
}

/// All triangulations of the sphere with so many vertices (4 to 10 are few enough), up to numbering and reflection. Flips of edges
/// connect them all (Wagner 1936).
#[must_use]
pub fn spheres(vertices: usize) -> Vec<Sphere> {
    // Of four vertices the bipyramid over a ring of two has double edges.
    let start = if vertices == 4 { tetrahedron() } else { Sphere::bipyramid(vertices) };
    let mut known = BTreeSet::from([start.code()]);
    let mut found = vec![start];
    let mut next = 0;
    while next < found.len() {
        let sphere = found[next].clone();
        next += 1;
        for flipped in sphere.edges().filter(|[a, b]| a < b).filter_map(|edge| sphere.flipped(edge)) {
            if known.insert(flipped.code()) {
                found.push(flipped);
            }
        }
    }
    found.sort_by_cached_key(|sphere| (sphere.degrees(), sphere.code()));
    found
}

fn tetrahedron() -> Sphere {
    let mut sphere = Sphere { vertices: 4, third: vec![NONE; 16] };
    [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]].into_iter().for_each(|triangle| sphere.put(triangle));
    sphere
}

/// A triangulation with so many vertices after ten times as many random flips; the same for the same seed.
#[must_use]
pub fn random_sphere(vertices: usize, seed: u64) -> Sphere {
    let mut sphere = Sphere::bipyramid(vertices);
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    for _ in 0..10 * vertices {
        // xorshift64
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        let edges: Vec<[u8; 2]> = sphere.edges().collect();
        if let Some(flipped) = sphere.flipped(edges[(state >> 33) as usize % edges.len()]) {
            sphere = flipped;
        }
    }
    sphere
}

//! Along an edge of the control mesh.

use super::map::{CharacteristicMap, extended};
use super::reference::{Place, Reference, UNITS};
use super::spectrum::{eigenvalues, eigenvector, from_below, largest_product, quotients};
use glam::DVec3;
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;

/// What was found along an edge where `valence` tetrahedra meet.
#[derive(Debug, Clone)]
pub struct EdgeAnalysis {
    /// Number of tetrahedra around the edge.
    pub valence: usize,
    /// The double eigenvalue of the plane across the edge; that along the edge is 1/2.
    pub lambda1: f64,
    /// The smaller of the two.
    pub lambda3: f64,
    /// How far the two matrices are from having the leading eigenvectors of all frequencies in common.
    pub residual: f64,
    /// The largest eigenvalue among the leading eigenvectors of the other frequencies, which both matrices have in common: a
    /// part of the remainder whose joint spectral radius is exactly this.
    pub common: f64,
    /// Bounds from below and, for products of 1, 2, ... matrices, from above on the joint spectral radius of what is left.
    pub below: f64,
    /// See `below`.
    pub bounds: Vec<f64>,
    /// As `bounds`, where the common eigenvectors of other frequencies are left in the remainder, as in the paper.
    pub direct_bounds: Vec<f64>,
    /// The map of the leading eigenvectors.
    pub map: CharacteristicMap,
}

impl EdgeAnalysis {
    /// The largest known spectral radius of the remainder: a bound from below on its joint spectral radius.
    #[must_use]
    pub fn rho(&self) -> f64 {
        self.common.max(self.below)
    }

    /// The least number of factors that shows the joint spectral radius of the remainder to be below lambda3.
    #[must_use]
    pub fn factors(&self) -> Option<usize> {
        self.bounds.iter().position(|b| b.max(self.common) < self.lambda3).map(|k| k + 1)
    }

    /// As [`EdgeAnalysis::factors`], without taking common eigenvectors of other frequencies out first.
    #[must_use]
    pub fn direct_factors(&self) -> Option<usize> {
        self.direct_bounds.iter().position(|b| *b < self.lambda3).map(|k| k + 1)
    }

    /// Whether all conditions hold: the order of the eigenvalues, the joint spectral radius, and the map.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.lambda1 < 1.0 && self.factors().is_some() && self.map.is_regular()
    }
}

/// The vertices that the matrices act on, in orbits of the rotation around the edge.
struct Orbits<'a> {
    reference: &'a Reference,
    valence: usize,
    support: Vec<u32>,
    /// The support's places of each orbit, in the order of the rotation: one on the edge, `valence` elsewhere.
    orbits: Vec<Vec<usize>>,
}

/// The place turned by one tetrahedron around the edge.
fn turned(place: &Place) -> Place {
    let mut place = place.clone();
    place[2..].rotate_right(1);
    place
}

impl<'a> Orbits<'a> {
    fn new(reference: &'a Reference, valence: usize, support: Vec<u32>) -> Self {
        let mut orbits = Vec::new();
        let mut seen = vec![false; support.len()];
        for i in 0..support.len() {
            let mut orbit = Vec::new();
            let mut next = i;
            while !seen[next] {
                seen[next] = true;
                orbit.push(next);
                let turned = reference.at(&turned(&reference.places[support[next] as usize]));
                next = support.binary_search(&turned).unwrap_or(i);
            }
            if !orbit.is_empty() {
                orbits.push(orbit);
            }
        }
        Self { reference, valence, support, orbits }
    }

    /// `exp(2 pi i frequency j / n)`.
    fn phase(&self, frequency: usize, j: usize) -> Complex<f64> {
        Complex::from_polar(1.0, TAU * (frequency * j % self.valence) as f64 / self.valence as f64)
    }

    /// Orbits that have functions of a frequency: at others than 0 these vanish on the edge.
    fn at(&self, frequency: usize) -> Vec<&Vec<usize>> {
        self.orbits.iter().filter(|orbit| frequency == 0 || orbit.len() > 1).collect()
    }

    /// What a matrix that commutes with the rotation does to functions of a frequency.
    fn block(&self, matrix: &DMatrix<f64>, frequency: usize) -> DMatrix<Complex<f64>> {
        let orbits = self.at(frequency);
        DMatrix::from_fn(orbits.len(), orbits.len(), |p, q| {
            let entry = |(j, &column): (usize, &usize)| self.phase(frequency, j) * matrix[(orbits[p][0], column)];
            orbits[q].iter().enumerate().map(entry).sum()
        })
    }

    /// The values that a vector of a block has at the vertices of the support.
    fn unfolded(&self, vector: &DVector<Complex<f64>>, frequency: usize) -> Vec<Complex<f64>> {
        let mut values = vec![Complex::new(0.0, 0.0); self.support.len()];
        for (orbit, value) in self.at(frequency).into_iter().zip(vector.iter()) {
            orbit.iter().enumerate().for_each(|(j, &i)| values[i] = self.phase(frequency, j) * value);
        }
        values
    }

    /// The coordinate along the edge.
    fn height(&self, i: usize) -> f64 {
        let place = &self.reference.places[self.support[i] as usize];
        f64::from(place[0] - place[1])
    }
}

/// The leading eigenvector of a block, real but for a factor, and its eigenvalue.
fn leading(block: &DMatrix<Complex<f64>>) -> (f64, DVector<Complex<f64>>) {
    let largest = eigenvalues(block).into_iter().max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default();
    (largest.re, eigenvector(block, largest))
}

/// Analyses an edge with `valence` tetrahedra around it, with products of at most `factors` matrices.
///
/// S1 and S2 take the values that a piece of the edge depends on to those of its halves. Both commute with the rotation around
/// the edge, so their Fourier blocks are analysed one by one. The constants and the coordinate along the edge (frequency 0) and the
/// pair of leading eigenvectors of frequency 1 are the map; what is left is the remainder. Leading eigenvectors of the other
/// frequencies do not change along the edge either, so the matrices have them in common.
#[must_use]
pub fn analyse_edge(valence: usize, factors: usize) -> EdgeAnalysis {
    let n = valence as u32;
    let reference = Reference::new(2 + valence, (0..n).map(|j| [0, 1, 2 + j, 2 + (j + 1) % n]).collect());
    let on_edge = |a: i32| -> Place { [vec![a, UNITS - a], vec![0; valence]].concat() };
    let ends = [on_edge(UNITS / 2), on_edge(UNITS / 2 + 1)];
    let support = reference.around(&ends.each_ref().map(|place| reference.at(place)), 1);
    let orbits = Orbits::new(&reference, valence, support);
    let matrices = ends.each_ref().map(|end| reference.matrix(&orbits.support, end));

    let (mut residual, mut common, mut below, mut lambda1) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0);
    let (mut rests, mut direct) = (Vec::new(), Vec::new());
    for frequency in 0..=valence / 2 {
        let blocks = matrices.each_ref().map(|m| orbits.block(m, frequency));
        let space = if frequency == 0 {
            let column = |f: &dyn Fn(usize) -> f64| {
                DVector::from_iterator(blocks[0].nrows(), orbits.at(0).iter().map(|o| Complex::new(f(o[0]), 0.0)))
            };
            DMatrix::from_columns(&[column(&|_| 1.0), column(&|i| orbits.height(i))])
        } else {
            let (eigenvalue, vector) = leading(&blocks[0]);
            if frequency == 1 {
                lambda1 = eigenvalue;
            } else {
                common = common.max(eigenvalue.abs());
                direct.push(blocks.to_vec());
            }
            DMatrix::from_columns(&[vector])
        };
        let (rest, leak) = quotients(&blocks, &space);
        residual = residual.max(leak);
        below = below.max(from_below(&rest, factors.min(6)));
        if frequency < 2 {
            direct.push(rest.clone());
        }
        rests.push(rest);
    }
    let bound = |sets: &[Vec<DMatrix<Complex<f64>>>], k: usize| {
        sets.iter().map(|m| largest_product(m, k)).fold(0.0, f64::max).powf(1.0 / k as f64)
    };
    EdgeAnalysis {
        valence,
        lambda1,
        lambda3: lambda1.min(0.5),
        residual,
        common,
        below,
        bounds: (1..=factors).map(|k| bound(&rests, k)).collect(),
        direct_bounds: (1..=factors).map(|k| bound(&direct, k)).collect(),
        map: map(&reference, valence, &ends[0], lambda1),
    }
}

/// The map of the leading eigenvectors around a vertex of the edge.
fn map(reference: &Reference, valence: usize, centre: &Place, lambda1: f64) -> CharacteristicMap {
    let middle = reference.at(centre);
    let ring = Orbits::new(reference, valence, reference.around(&[middle], 1));
    let block = ring.block(&reference.matrix(&ring.support, centre), 1);
    let plane = ring.unfolded(&eigenvector(&block, Complex::new(lambda1, 0.0)), 1);
    let wide = Orbits::new(reference, valence, reference.around(&[middle], 3));
    let matrix = reference.matrix(&wide.support, centre);
    let inner: Vec<usize> = ring.support.iter().filter_map(|v| wide.support.binary_search(v).ok()).collect();
    let [x, y] = [|z: &Complex<f64>| z.re, |z: &Complex<f64>| z.im]
        .map(|part| extended(&matrix, &inner, &plane.iter().map(part).collect::<Vec<_>>(), lambda1));
    // As high as it is wide.
    let radius = x.iter().zip(&y).map(|(x, y)| x.hypot(*y)).fold(0.0, f64::max);
    let half = (0..wide.support.len()).map(|i| wide.height(i).abs()).fold(0.0, f64::max);
    let values: Vec<DVec3> =
        (0..wide.support.len()).map(|i| DVec3::new(x[i] / radius, y[i] / radius, wide.height(i) / half)).collect();
    CharacteristicMap::new(reference, middle, &wide.support, &values)
}

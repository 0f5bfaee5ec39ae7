//! Errors of solutions on hexahedra: estimated by the recovered stress, and true ones where the solution is known.

use super::super::loads::{integrate_cells, integrate_faces};
use super::super::{Exact, FemError, Model, SymTensor, System, TrueError, traction};
use super::rule::Quadrature;
use super::stress::material;
use super::{HexSolution, HexSpace, RecoveredStress};

/// Gauss points a direction for true errors.
const POINTS: usize = 6;

/// The estimated errors of cells.
#[derive(Debug, Clone)]
pub struct HexErrors {
    /// Squared error of each cell in the energy norm, `int (s* - s) : C^-1 : (s* - s) dV`.
    pub squared: Vec<f64>,
}

impl HexErrors {
    /// The estimate by the distance of the elements' stress from the recovered one.
    #[must_use]
    pub fn estimate(space: &HexSpace<'_>, model: &Model, solution: &HexSolution, recovered: &RecoveredStress) -> Self {
        let quadrature = Quadrature::of_stiffness(space, 3, 0);
        let squared = space.of_cells(|t| {
            let (weights, table) = quadrature.of(space, t);
            let point = |(q, weight): (usize, &f64)| {
                let error = difference(recovered.at(space, t, &table, q), solution.stress(space, model, t, &table, q));
                let volume = weight * space.frame(t, &table, q).1.determinant();
                volume * material(space, model, t).compliance_energy(error)
            };
            weights.iter().enumerate().map(point).sum::<f64>()
        });
        Self { squared }
    }

    /// Error in the energy norm.
    #[must_use]
    pub fn energy(&self) -> f64 {
        self.squared.iter().sum::<f64>().sqrt()
    }

    /// Error relative to the energy norm of the displacement, with the error's own energy added to that of the solution.
    #[must_use]
    pub fn relative(&self, strain_energy: f64) -> f64 {
        let (error, solution): (f64, f64) = (self.squared.iter().sum(), 2.0 * strain_energy);
        if error == 0.0 { 0.0 } else { (error / (error + solution)).sqrt() }
    }
}

fn difference(a: SymTensor, b: SymTensor) -> SymTensor {
    std::array::from_fn(|i| a[i] - b[i])
}

impl Exact {
    /// Adds the loads of the known solution to a system on hexahedra.
    ///
    /// # Errors
    /// None: known solutions are finite.
    pub fn add_loads_on_hexes(&self, space: &HexSpace<'_>, system: &mut System) -> Result<(), FemError> {
        integrate_cells(space, &mut system.loads, |_, x| Ok(self.body_force(x)))?;
        match self.tractions {
            Some(group) => {
                integrate_faces(space, group, &mut system.loads, |area, x| Ok(traction(self.stress(x), area)))
            }
            None => Ok(()),
        }
    }

    /// The true error of a solution on hexahedra, by quadrature over its own (limit) geometry.
    #[must_use]
    pub fn error_on_hexes(&self, space: &HexSpace<'_>, model: &Model, solution: &HexSolution) -> TrueError {
        let quadrature = Quadrature::new(space, POINTS);
        let squares = space.of_cells(|t| {
            let ((weights, table), material) = (quadrature.of(space, t), material(space, model, t));
            let mut squares = [0.0; 2];
            for (q, weight) in weights.iter().enumerate() {
                let (x, jacobian) = space.frame(t, &table, q);
                let exact = self.stress(x);
                let error = difference(exact, solution.stress(space, model, t, &table, q));
                let volume = weight * jacobian.determinant();
                squares[0] += volume * material.compliance_energy(error);
                squares[1] += volume * material.compliance_energy(exact);
            }
            squares
        });
        let [error, norm] = squares.iter().fold([0.0; 2], |sum, s| [sum[0] + s[0], sum[1] + s[1]]);
        TrueError { energy: error.sqrt(), relative: (error / norm).sqrt() }
    }
}

//! Isotropic linear elasticity: stress of strain, strain of stress, and their energies.

use super::{Material, SymTensor};
use glam::DVec3;

impl Material {
    /// Lame's first constant, `lambda = E nu / ((1 + nu)(1 - 2 nu))`.
    #[must_use]
    pub fn lambda(&self) -> f64 {
        let nu = self.poissons_ratio;
        self.youngs_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    }

    /// Lame's second constant, the shear modulus `mu = E / (2 (1 + nu))`.
    #[must_use]
    pub fn mu(&self) -> f64 {
        0.5 * self.youngs_modulus / (1.0 + self.poissons_ratio)
    }

    /// Stress of a strain, `s = C : e = lambda tr(e) I + 2 mu e`.
    #[must_use]
    pub fn stress(&self, strain: SymTensor) -> SymTensor {
        let (pressure, twice_mu) = (self.lambda() * trace(strain), 2.0 * self.mu());
        add_isotropic(strain.map(|e| twice_mu * e), pressure)
    }

    /// Strain of a stress, `e = C^-1 : s = ((1 + nu) s - nu tr(s) I) / E`.
    #[must_use]
    pub fn strain(&self, stress: SymTensor) -> SymTensor {
        let (e, nu) = (self.youngs_modulus, self.poissons_ratio);
        add_isotropic(stress.map(|s| (1.0 + nu) / e * s), -nu / e * trace(stress))
    }

    /// Twice the complementary energy density of a stress, `d : C^-1 : d`; never negative.
    #[must_use]
    pub fn compliance_energy(&self, d: SymTensor) -> f64 {
        double_contraction(d, self.strain(d))
    }
}

/// `a : b`, the sum over all nine components: the off-diagonal entries count twice.
#[must_use]
pub fn double_contraction(a: SymTensor, b: SymTensor) -> f64 {
    (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
}

/// The force on an area vector, `s n`.
#[must_use]
pub fn traction(s: SymTensor, n: DVec3) -> DVec3 {
    DVec3::new(
        s[0] * n.x + s[3] * n.y + s[5] * n.z,
        s[3] * n.x + s[1] * n.y + s[4] * n.z,
        s[5] * n.x + s[4] * n.y + s[2] * n.z,
    )
}

/// Von Mises' equivalent stress, `sqrt(3/2 dev(s) : dev(s))`.
#[must_use]
pub fn von_mises(stress: SymTensor) -> f64 {
    let deviator = add_isotropic(stress, -trace(stress) / 3.0);
    (1.5 * double_contraction(deviator, deviator)).sqrt()
}

fn trace(a: SymTensor) -> f64 {
    a[0] + a[1] + a[2]
}

/// `a + s I`.
fn add_isotropic(a: SymTensor, s: f64) -> SymTensor {
    [a[0] + s, a[1] + s, a[2] + s, a[3], a[4], a[5]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const STEEL: Material = Material { youngs_modulus: 210e9, poissons_ratio: 0.3, density: 7850.0 };

    #[test]
    fn uniaxial_stress_stretches_by_one_over_e_and_contracts_by_nu() {
        let strain = STEEL.strain([210e9, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert!((strain[0] - 1.0).abs() < 1e-15 && (strain[1] + 0.3).abs() < 1e-15 && (strain[2] + 0.3).abs() < 1e-15);
        assert!((von_mises([5.0, 0.0, 0.0, 0.0, 0.0, 0.0]) - 5.0).abs() < 1e-14);
        assert!((von_mises([0.0, 0.0, 0.0, 0.0, 2.0, 0.0]) - 2.0 * 3.0_f64.sqrt()).abs() < 1e-14);
        assert!(von_mises([7.0, 7.0, 7.0, 0.0, 0.0, 0.0]) < 1e-14);
    }

    proptest! {
        #[test]
        fn compliance_inverts_stiffness(e in proptest::array::uniform6(-1.0..1.0), nu in -0.9..0.49) {
            let material = Material { youngs_modulus: 3.0, poissons_ratio: nu, density: 0.0 };
            let stress = material.stress(e);
            let back = material.strain(stress);
            for i in 0..6 {
                prop_assert!((back[i] - e[i]).abs() < 1e-12);
            }
            let energy = double_contraction(e, stress);
            prop_assert!((material.compliance_energy(stress) - energy).abs() < 1e-11 * energy.max(1.0));
            prop_assert!(energy >= 0.0);
        }
    }
}

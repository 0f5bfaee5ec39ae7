//! The formulas of known solutions.

use super::super::{Material, SymTensor};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_4, PI};

/// u = (sin x cos y cos z, -2 cos x sin y cos z, cos x cos y sin z) in units of 1 / pi.
pub(super) fn smooth_cube(x: DVec3) -> DVec3 {
    let [(sx, cx), (sy, cy), (sz, cz)] = x.to_array().map(|x| (PI * x).sin_cos());
    DVec3::new(sx * cy * cz, -2.0 * cx * sy * cz, cx * cy * sz)
}

pub(super) fn smooth_cube_strain(x: DVec3) -> SymTensor {
    let [(sx, cx), (sy, cy), (sz, cz)] = x.to_array().map(|x| (PI * x).sin_cos());
    let own = PI * cx * cy * cz;
    [own, -2.0 * own, own, 0.5 * PI * sx * sy * cz, 0.5 * PI * cx * sy * sz, -PI * sx * cy * sz]
}

/// The displacement has no divergence and is an eigenfunction of the Laplacian.
pub(super) fn smooth_cube_force(x: DVec3, material: &Material) -> DVec3 {
    3.0 * PI * PI * material.mu() * smooth_cube(x)
}

/// Radial and tangential stress of a hollow sphere of radii 1 and 2 under an inner pressure of 1.
fn lame_sphere_principal(r: f64) -> (f64, f64) {
    ((1.0 - 8.0 / r.powi(3)) / 7.0, (1.0 + 4.0 / r.powi(3)) / 7.0)
}

pub(super) fn lame_sphere(x: DVec3) -> SymTensor {
    let r = x.length();
    let (radial, tangential) = lame_sphere_principal(r);
    let n = x / r;
    let entry = |i: usize, j: usize| (radial - tangential) * n[i] * n[j] + if i == j { tangential } else { 0.0 };
    [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(1, 2), entry(0, 2)]
}

/// The tangential strain is the radial displacement over the radius.
pub(super) fn lame_sphere_displacement(x: DVec3, material: &Material) -> DVec3 {
    let (radial, tangential) = lame_sphere_principal(x.length());
    let nu = material.poissons_ratio;
    ((1.0 - nu) * tangential - nu * radial) / material.youngs_modulus * x
}

/// A plate with a hole of radius 1 under a far tension of 1 along x, in plane strain.
pub(super) fn kirsch(x: DVec3, nu: f64) -> SymTensor {
    let q = 1.0 / (x.x * x.x + x.y * x.y);
    let angle = x.y.atan2(x.x);
    let (sin2, cos2) = (2.0 * angle).sin_cos();
    let rr = 0.5 * (1.0 - q) + 0.5 * (1.0 - 4.0 * q + 3.0 * q * q) * cos2;
    let tt = 0.5 * (1.0 + q) - 0.5 * (1.0 + 3.0 * q * q) * cos2;
    let rt = -0.5 * (1.0 + 2.0 * q - 3.0 * q * q) * sin2;
    turned([rr, tt, rt], nu * (rr + tt), angle)
}

/// Timoshenko and Goodier's plane with a hole, with Kolosov's constant 3 - 4 nu of plane strain.
pub(super) fn kirsch_displacement(x: DVec3, material: &Material) -> DVec3 {
    let (r, angle) = (x.truncate().length(), x.y.atan2(x.x));
    let (kappa, scale) = (3.0 - 4.0 * material.poissons_ratio, 1.0 / (8.0 * material.mu()));
    let ((sin, cos), (sin3, cos3)) = (angle.sin_cos(), (3.0 * angle).sin_cos());
    let (far, near) = (2.0 / r, 2.0 / r.powi(3));
    DVec3::new(
        scale * (r * (kappa + 1.0) * cos + far * ((1.0 + kappa) * cos + cos3) - near * cos3),
        scale * (r * (kappa - 3.0) * sin + far * ((1.0 - kappa) * sin + sin3) - near * sin3),
        0.0,
    )
}

/// The exponent of the singular solution at a re-entrant edge of 270 degrees that opens symmetrically: the first root of
/// a sin 2w + sin 2wa = 0 with w = 3 pi / 4, and C1 = -cos((a+1)w) / cos((a-1)w) (Williams 1952).
const EXPONENT: f64 = 0.544_483_736_782_464;

fn l_prism_ratio() -> f64 {
    let w = 3.0 * FRAC_PI_4;
    -((EXPONENT + 1.0) * w).cos() / ((EXPONENT - 1.0) * w).cos()
}

/// Distance from the edge, and the angle from the notch's middle plane, from -3 pi / 4 to 3 pi / 4.
fn l_prism_place(x: DVec3) -> (f64, f64) {
    let angle = x.y.atan2(x.x) - FRAC_PI_4;
    // Below the upper re-entrant face by rounding.
    let angle = if angle < -PI { angle + 2.0 * PI } else { angle };
    (x.truncate().length(), angle)
}

/// The L-prism in plane strain.
pub(super) fn l_prism(x: DVec3, nu: f64) -> SymTensor {
    let (a, c1, (r, t)) = (EXPONENT, l_prism_ratio(), l_prism_place(x));
    let ((sp, cp), (sm, cm)) = (((a + 1.0) * t).sin_cos(), ((a - 1.0) * t).sin_cos());
    let scale = a * r.powf(a - 1.0);
    let rr = scale * (-(a + 1.0) * cp + c1 * (3.0 - a) * cm);
    let tt = scale * (a + 1.0) * (cp + c1 * cm);
    let rt = scale * ((a + 1.0) * sp + c1 * (a - 1.0) * sm);
    turned([rr, tt, rt], nu * (rr + tt), t + FRAC_PI_4)
}

pub(super) fn l_prism_displacement(x: DVec3, material: &Material) -> DVec3 {
    let (a, c1, (r, t)) = (EXPONENT, l_prism_ratio(), l_prism_place(x));
    // 2 (lambda + 2 mu) / (lambda + mu)
    let c2 = 4.0 * (1.0 - material.poissons_ratio);
    let scale = r.powf(a) / (2.0 * material.mu());
    let ((sp, cp), (sm, cm)) = (((a + 1.0) * t).sin_cos(), ((a - 1.0) * t).sin_cos());
    let ur = scale * (-(a + 1.0) * cp + (c2 - a - 1.0) * c1 * cm);
    let ut = scale * ((a + 1.0) * sp + (c2 + a - 1.0) * c1 * sm);
    let (sin, cos) = (t + FRAC_PI_4).sin_cos();
    DVec3::new(ur * cos - ut * sin, ur * sin + ut * cos, 0.0)
}

/// A quadratic displacement, whose strain is linear.
pub(super) fn quadratic_patch(p: DVec3) -> DVec3 {
    let DVec3 { x, y, z } = p;
    DVec3::new(x * x + 2.0 * x * y - z * z, y * y - x * z + 3.0 * y * z, x * y + z * z - 2.0 * x * x)
}

pub(super) fn quadratic_patch_strain(p: DVec3) -> SymTensor {
    let DVec3 { x, y, z } = p;
    [2.0 * x + 2.0 * y, 2.0 * y + 3.0 * z, 2.0 * z, x - 0.5 * z, 1.5 * y, 0.5 * (y - 4.0 * x - 2.0 * z)]
}

pub(super) fn quadratic_patch_force(material: &Material) -> DVec3 {
    let (mu, nu) = (material.mu(), material.poissons_ratio);
    let lambda = 2.0 * mu * nu / (1.0 - 2.0 * nu);
    -DVec3::new(2.0 * lambda + 2.0 * mu, 4.0 * lambda + 6.0 * mu, 5.0 * lambda + 3.0 * mu)
}

/// Radial and tangential stress of a tube of radii 1 and 2 under an inner pressure of 1.
fn lame_cylinder_principal(r: f64) -> [f64; 2] {
    [(1.0 - 4.0 / (r * r)) / 3.0, (1.0 + 4.0 / (r * r)) / 3.0]
}

/// A tube in plane strain.
pub(super) fn lame_cylinder(x: DVec3, nu: f64) -> SymTensor {
    let [rr, tt] = lame_cylinder_principal(x.truncate().length());
    turned([rr, tt, 0.0], nu * (rr + tt), x.y.atan2(x.x))
}

/// The tangential strain is the radial displacement over the radius.
pub(super) fn lame_cylinder_displacement(x: DVec3, material: &Material) -> DVec3 {
    let [rr, tt] = lame_cylinder_principal(x.truncate().length());
    let nu = material.poissons_ratio;
    (tt - nu * (rr + nu * (rr + tt))) / material.youngs_modulus * x.with_z(0.0)
}

/// Length and height of Timoshenko's beam; the force on its end is 1 by width.
const BEAM: [f64; 2] = [8.0, 2.0];
const SECOND_MOMENT: f64 = BEAM[1] * BEAM[1] * BEAM[1] / 12.0;

/// Bending and parabolic shear, in plane strain; y is measured from the lower side.
pub(super) fn timoshenko(x: DVec3, nu: f64) -> SymTensor {
    let [length, height] = BEAM;
    let y = x.y - 0.5 * height;
    let xx = (length - x.x) * y / SECOND_MOMENT;
    [xx, 0.0, nu * xx, -0.5 / SECOND_MOMENT * (0.25 * height * height - y * y), 0.0, 0.0]
}

/// Timoshenko and Goodier's cantilever, with the moduli of plane strain.
pub(super) fn timoshenko_displacement(p: DVec3, material: &Material) -> DVec3 {
    let [length, height] = BEAM;
    let (x, y) = (p.x, p.y - 0.5 * height);
    let nu = material.poissons_ratio / (1.0 - material.poissons_ratio);
    let young = material.youngs_modulus / (1.0 - material.poissons_ratio.powi(2));
    let scale = 1.0 / (6.0 * young * SECOND_MOMENT);
    let square = height * height / 4.0;
    let along = y * ((6.0 * length - 3.0 * x) * x + (2.0 + nu) * (y * y - square));
    let across = 3.0 * nu * y * y * (length - x) + (4.0 + 5.0 * nu) * square * x + (3.0 * length - x) * x * x;
    scale * DVec3::new(along, -across, 0.0)
}

/// Plane polar stress at an angle from x in Cartesian components.
fn turned([rr, tt, rt]: [f64; 3], zz: f64, angle: f64) -> SymTensor {
    let (sin, cos) = angle.sin_cos();
    let (sin2, cos2) = (2.0 * sin * cos, cos * cos - sin * sin);
    let xx = rr * cos * cos + tt * sin * sin - rt * sin2;
    let yy = rr * sin * sin + tt * cos * cos + rt * sin2;
    [xx, yy, zz, 0.5 * (rr - tt) * sin2 + rt * cos2, 0.0, 0.0]
}

//! Residual and tangent of one element (Eqs. 4, 5 in the reference configuration).
//!
//! Momentum: `int tau : grad v dV0 = external`. Mass over a step of `dt`:
//! `int q (J - J_old) dV0 + dt int J k grad q . grad p dV0 = 0`, `k` the current mobility.
//!
//! The volumetric law is integrated at 2 x 2 points: with lambda* some hundred times the shear modulus
//! a drained skeleton is nearly incompressible, and at 3 x 3 points its quadratic element would lock.

use super::geometry::{ElementGeometry, PointGeometry};
use crate::material::PointMaterial;
use crate::material::Voigt;
use crate::material::point::DeformationGradient;
use crate::mesh::{CORNERS, NODES, UNKNOWNS};

/// Element residual and tangent; unknowns as in [`crate::mesh::Mesh::element_unknowns`].
#[derive(Debug, Clone)]
pub struct ElementSystem {
    /// Internal nodal forces (N), then fluid volumes of the step (m^3).
    pub residual: [f64; UNKNOWNS],
    /// Derivative of the residual.
    pub tangent: [[f64; UNKNOWNS]; UNKNOWNS],
}

impl Default for ElementSystem {
    fn default() -> Self {
        Self { residual: [0.0; UNKNOWNS], tangent: [[0.0; UNKNOWNS]; UNKNOWNS] }
    }
}

/// Kinematics at one point of an element.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// Deformation gradient.
    pub f: DeformationGradient,
    /// J.
    pub jacobian: f64,
    /// Spatial gradients of the displacement functions (1/m).
    pub gradient: [[f64; 2]; NODES],
    /// `N_a / r`, the hoop strain of a unit radial displacement (1/m).
    pub hoop: [f64; NODES],
    /// Spatial gradients of the pressure functions (1/m).
    pub pressure_gradient: [[f64; 2]; CORNERS],
    /// Pore pressure (Pa).
    pub pressure: f64,
    /// Spatial pressure gradient (Pa/m).
    pub grad_p: [f64; 2],
}

impl Point {
    /// Evaluates the kinematics; `x` are the element's unknowns. `None` when turned inside out.
    #[inline(always)]
    pub fn at(geometry: &PointGeometry, x: &[f64; UNKNOWNS]) -> Option<Self> {
        let (mut plane, mut u_r) = ([[1.0, 0.0], [0.0, 1.0]], 0.0);
        for a in 0..NODES {
            let g = geometry.gradient[a];
            for d in 0..2 {
                plane[0][d] += x[2 * a] * g[d];
                plane[1][d] += x[2 * a + 1] * g[d];
            }
            u_r += x[2 * a] * geometry.n[a];
        }
        let f = DeformationGradient { plane, hoop: 1.0 + u_r / geometry.radius };
        let jacobian = f.determinant();
        if !(jacobian > 0.0 && f.hoop > 0.0) {
            return None;
        }
        let inverse = f.inverse().plane;
        let push = |g: [f64; 2]| {
            [g[0] * inverse[0][0] + g[1] * inverse[1][0], g[0] * inverse[0][1] + g[1] * inverse[1][1]]
        };
        let pressure_gradient = geometry.pressure_gradient.map(push);
        let (mut pressure, mut grad_p) = (0.0, [0.0; 2]);
        for m in 0..CORNERS {
            let p = x[2 * NODES + m];
            pressure += geometry.p[m] * p;
            grad_p[0] += pressure_gradient[m][0] * p;
            grad_p[1] += pressure_gradient[m][1] * p;
        }
        Some(Self {
            f,
            jacobian,
            gradient: geometry.gradient.map(push),
            hoop: geometry.n.map(|n| n / (geometry.radius + u_r)),
            pressure_gradient,
            pressure,
            grad_p,
        })
    }
}

/// History at the start of a step, at the Gauss points of one element.
#[derive(Debug, Clone, Copy)]
pub struct PointState<'a> {
    /// J of every point.
    pub jacobian: &'a [f64],
    /// `Cv^-1` of every branch, point by point.
    pub cv_inverse: &'a [Voigt],
    /// Largest strain so far of every point; empty unless the material softens with it.
    pub past_strain: &'a [f64],
}

/// Fills `system` for the unknowns `x` at the end of a step of `dt` (s); `None` when inadmissible.
#[inline(always)]
pub fn evaluate(
    geometry: &ElementGeometry,
    material: &PointMaterial,
    x: &[f64; UNKNOWNS],
    old: PointState<'_>,
    dt: f64,
    system: &mut ElementSystem,
) -> Option<()> {
    *system = ElementSystem::default();
    let branches = material.branches();
    for (k, place) in geometry.points.iter().enumerate() {
        let point = Point::at(place, x)?;
        let history = &old.cv_inverse[k * branches..(k + 1) * branches];
        let mut elasticity = material.elasticity(&point.f, history, dt)?;
        if let Some(softening) = &material.softening {
            softening.apply(&point.f, *old.past_strain.get(k)?, &mut elasticity)?;
        }
        let (w, j, p) = (place.measure, point.jacobian, point.pressure);

        // Total Kirchhoff stress and tangent: tau - p J 1.
        let mut tau = elasticity.kirchhoff_stress;
        let mut c = elasticity.tangent;
        let pore = p * j;
        for i in 0..3 {
            tau[i] -= pore;
            for column in c[i].iter_mut().take(3) {
                *column -= pore;
            }
            c[i][i] += 2.0 * pore;
        }
        c[3][3] += pore;

        let rows = Rows::of(&point);
        momentum(&point, &rows, &tau, &c, w, system);
        coupling(&rows, &place.p, w * j, system);
        mass(&point, &rows, place, material, j - old.jacobian[k], dt, system);
    }
    for place in &geometry.volumetric {
        let point = Point::at(place, x)?;
        let (tau, stiffness) = material.volumetric_stress(point.jacobian)?;
        volumetric(&point, place.measure * tau, place.measure * stiffness, system);
    }
    Some(())
}

/// Displacement unknowns of an element.
const DISPLACEMENTS: usize = 2 * NODES;

/// Linear forms of the element's displacements at a point; whole rows, so that the loops vectorise (1/m).
struct Rows {
    /// Strains rr, zz, tt and engineering shear rz.
    strain: [[f64; DISPLACEMENTS]; 4],
    /// `d u_r / dz` and `d u_z / dr`, the two parts of the shear.
    shear: [[f64; DISPLACEMENTS]; 2],
    /// Divergence.
    divergence: [f64; DISPLACEMENTS],
}

impl Rows {
    #[inline(always)]
    fn of(point: &Point) -> Self {
        let zero = [0.0; DISPLACEMENTS];
        let (mut strain, mut shear, mut divergence) = ([zero; 4], [zero; 2], zero);
        for a in 0..NODES {
            let ([gr, gz], h) = (point.gradient[a], point.hoop[a]);
            let (r, z) = (2 * a, 2 * a + 1);
            (strain[0][r], strain[1][z], strain[2][r]) = (gr, gz, h);
            (strain[3][r], strain[3][z]) = (gz, gr);
            (shear[0][r], shear[1][z]) = (gz, gr);
            (divergence[r], divergence[z]) = (gr + h, gz);
        }
        Self { strain, shear, divergence }
    }
}

/// `row += sum_k factors[k] forms[k]`.
#[inline(always)]
fn add_forms<const K: usize>(
    row: &mut [f64; UNKNOWNS],
    factors: [f64; K],
    forms: [&[f64; DISPLACEMENTS]; K],
) {
    for j in 0..DISPLACEMENTS {
        let mut sum = row[j];
        for k in 0..K {
            sum = factors[k].mul_add(forms[k][j], sum);
        }
        row[j] = sum;
    }
}

#[inline(always)]
fn momentum(point: &Point, rows: &Rows, tau: &Voigt, c: &[[f64; 4]; 4], w: f64, system: &mut ElementSystem) {
    let Rows { strain: [rr, zz, tt, rz], shear: [r_by_z, z_by_r], .. } = rows;
    let mut cb = [[0.0; DISPLACEMENTS]; 4];
    for (cb, c) in cb.iter_mut().zip(c) {
        for j in 0..DISPLACEMENTS {
            let sum = c[0].mul_add(rr[j], c[1] * zz[j]);
            cb[j] = w * c[2].mul_add(tt[j], c[3].mul_add(rz[j], sum));
        }
    }
    for a in 0..NODES {
        let ([gr, gz], h) = (point.gradient[a], point.hoop[a]);
        let traction = [w * (gr * tau[0] + gz * tau[3]), w * (gr * tau[3] + gz * tau[1])];
        let hoop_stress = w * h * tau[2];
        system.residual[2 * a] += traction[0] + hoop_stress;
        system.residual[2 * a + 1] += traction[1];
        add_forms(
            &mut system.tangent[2 * a],
            [gr, h, gz, traction[0], traction[1], hoop_stress],
            [&cb[0], &cb[2], &cb[3], rr, r_by_z, tt],
        );
        add_forms(
            &mut system.tangent[2 * a + 1],
            [gz, gr, traction[0], traction[1]],
            [&cb[1], &cb[3], z_by_r, zz],
        );
    }
}

/// Isotropic stress `tau` with `stiffness` = J d tau / dJ, both times the volume.
#[inline(always)]
fn volumetric(point: &Point, tau: f64, stiffness: f64, system: &mut ElementSystem) {
    let rows = Rows::of(point);
    let Rows { strain: [rr, zz, tt, _], shear: [r_by_z, z_by_r], divergence } = &rows;
    for a in 0..NODES {
        let ([gr, gz], h) = (point.gradient[a], point.hoop[a]);
        system.residual[2 * a] += tau * divergence[2 * a];
        system.residual[2 * a + 1] += tau * divergence[2 * a + 1];
        add_forms(
            &mut system.tangent[2 * a],
            [stiffness * divergence[2 * a], -tau * gr, -tau * gz, -tau * h],
            [divergence, rr, z_by_r, tt],
        );
        add_forms(
            &mut system.tangent[2 * a + 1],
            [stiffness * divergence[2 * a + 1], -tau * gr, -tau * gz],
            [divergence, r_by_z, zz],
        );
    }
}

#[inline(always)]
fn coupling(rows: &Rows, p: &[f64; CORNERS], wj: f64, system: &mut ElementSystem) {
    for (row, divergence) in system.tangent.iter_mut().zip(&rows.divergence) {
        for m in 0..CORNERS {
            row[DISPLACEMENTS + m] -= wj * divergence * p[m];
        }
    }
    for m in 0..CORNERS {
        add_forms(&mut system.tangent[DISPLACEMENTS + m], [wj * p[m]], [&rows.divergence]);
    }
}

#[inline(always)]
fn mass(
    point: &Point,
    rows: &Rows,
    place: &PointGeometry,
    material: &PointMaterial,
    growth: f64,
    dt: f64,
    system: &mut ElementSystem,
) {
    let (mobility, slope) = material.darcy.referential_mobility(point.jacobian);
    let (w, wk) = (place.measure, place.measure * dt * mobility);
    let w_slope = place.measure * dt * slope * point.jacobian;
    let Rows { strain: [rr, zz, _, rz], divergence, .. } = rows;
    let g = point.grad_p;
    for m in 0..CORNERS {
        let gm = point.pressure_gradient[m];
        let along = gm[0] * g[0] + gm[1] * g[1];
        let row = DISPLACEMENTS + m;
        system.residual[row] += w * place.p[m] * growth + wk * along;
        // Both gradients are pushed forward: their product changes by -grad q . (l + l^T) . grad p.
        add_forms(
            &mut system.tangent[row],
            [
                w_slope * along,
                -2.0 * wk * gm[0] * g[0],
                -wk * (gm[0] * g[1] + gm[1] * g[0]),
                -2.0 * wk * gm[1] * g[1],
            ],
            [divergence, rr, rz, zz],
        );
        for n in 0..CORNERS {
            let gn = point.pressure_gradient[n];
            system.tangent[row][DISPLACEMENTS + n] += wk * (gm[0] * gn[0] + gm[1] * gn[1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::geometry::Geometry;
    use crate::element::shape::POINTS;
    use crate::material::IDENTITY;
    use crate::mesh::Mesh;
    use crate::parameters::MaterialParameters;

    /// The consistent tangent against central differences of the residual, 1e-6 of the largest entry
    /// of each block.
    #[test]
    fn tangent_matches_finite_differences() {
        let material = PointMaterial::new(&MaterialParameters { n0s: 0.2, ..Default::default() });
        let mesh = Mesh::tensor(&[0.0, 0.3e-3, 0.7e-3], &[0.0, 0.25e-3], 0.3e-3);
        let geometry = Geometry::new(&mesh).elements[1];
        let mut x = [0.0; UNKNOWNS];
        for (k, v) in x.iter_mut().enumerate() {
            let noise = ((k * 7919 + 13) % 101) as f64 / 101.0 - 0.5;
            *v = if k < 2 * NODES { 4e-5 * noise } else { 3e3 * noise };
        }
        let jacobian = [1.01; POINTS];
        let mut cv_inverse = vec![IDENTITY; 2 * POINTS];
        cv_inverse[3] = [1.1, 0.95, 1.0 / (1.1 * 0.95 - 0.0004), 0.02];
        let old = PointState { jacobian: &jacobian, cv_inverse: &cv_inverse, past_strain: &[] };
        let dt = 0.02;
        let mut exact = ElementSystem::default();
        evaluate(&geometry, &material, &x, old, dt, &mut exact).unwrap();
        let block = |k: usize| usize::from(k >= 2 * NODES);
        let mut largest = [[0.0_f64; 2]; 2];
        for i in 0..UNKNOWNS {
            for j in 0..UNKNOWNS {
                let l = &mut largest[block(i)][block(j)];
                *l = l.max(exact.tangent[i][j].abs());
            }
        }
        for j in 0..UNKNOWNS {
            let h = if j < 2 * NODES { 1e-10 } else { 1e-1 };
            let shifted = |s: f64| {
                let mut y = x;
                y[j] += s;
                let mut system = ElementSystem::default();
                evaluate(&geometry, &material, &y, old, dt, &mut system).unwrap();
                system.residual
            };
            let (up, down) = (shifted(h), shifted(-h));
            for i in 0..UNKNOWNS {
                let slope = (up[i] - down[i]) / (2.0 * h);
                let error = (slope - exact.tangent[i][j]).abs();
                assert!(error < 1e-6 * largest[block(i)][block(j)], "({i}, {j}): {error}");
            }
        }
    }
}

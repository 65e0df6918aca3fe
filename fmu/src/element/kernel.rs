//! Residual and tangent of one element (Eqs. 4, 5 in the reference configuration).
//!
//! Momentum: `int tau : grad v dV0 = external`. Mass over a step of `dt`:
//! `int q (J - J_old) dV0 + dt int J k grad q . grad p dV0 = 0`, `k` the current mobility.
//!
//! The volumetric law is integrated at 2 x 2 points: with lambda* some hundred times the shear modulus
//! a drained skeleton is nearly incompressible, and at 3 x 3 points its quadratic element would lock.

use super::geometry::{ElementGeometry, PointGeometry};
use crate::law::point::DeformationGradient;
use crate::law::{PointMaterial, Voigt, Voigt2};
use crate::mesh::{CORNERS, NODES, UNKNOWNS};
use crate::number::{Real, closure, each};

/// Internal nodal forces (N), then fluid volumes of the step (m^3) of one element; unknowns as in
/// [`crate::mesh::Mesh::element_unknowns`].
pub type Residual<T = f64> = [T; UNKNOWNS];

/// Derivative of an element's residual.
pub type Tangent<T = f64> = [[T; UNKNOWNS]; UNKNOWNS];

/// Kinematics at one point of an element.
#[derive(Debug, Clone, Copy)]
pub struct Point<T = f64> {
    /// Deformation gradient.
    pub f: DeformationGradient<T>,
    /// J.
    pub jacobian: T,
    /// J - 1, without the rounding of J.
    pub dilatation: T,
    /// Spatial gradients of the displacement functions (1/m).
    pub gradient: [[T; 2]; NODES],
    /// `N_a / r`, the hoop strain of a unit radial displacement (1/m).
    pub hoop: [T; NODES],
    /// Spatial gradients of the pressure functions (1/m).
    pub pressure_gradient: [[T; 2]; CORNERS],
    /// Pore pressure (Pa).
    pub pressure: T,
    /// Spatial pressure gradient (Pa/m).
    pub grad_p: [T; 2],
}

impl<T: Real> Point<T> {
    /// Evaluates the kinematics; `x` are the element's unknowns. `None` when turned inside out (in any lane).
    #[inline(always)]
    pub fn at(geometry: &PointGeometry<T>, x: &[T; UNKNOWNS]) -> Option<Self> {
        let zero = geometry.radius.constant(0.0);
        let (mut h, mut u_r) = ([[zero; 2]; 2], zero);
        for a in 0..NODES {
            let g = geometry.gradient[a];
            for d in 0..2 {
                h[0][d] = x[2 * a].mul_add(g[d], h[0][d]);
                h[1][d] = x[2 * a + 1].mul_add(g[d], h[1][d]);
            }
            u_r = x[2 * a].mul_add(geometry.n[a], u_r);
        }
        let hoop = u_r / geometry.radius;
        let plane = [[h[0][0] + 1.0, h[0][1]], [h[1][0], h[1][1] + 1.0]];
        let f = DeformationGradient { plane, hoop: hoop + 1.0 };
        let in_plane = h[0][0] + h[1][1] + (h[0][0] * h[1][1] - h[0][1] * h[1][0]);
        let dilatation = in_plane.mul_add(f.hoop, hoop);
        let jacobian = dilatation + 1.0;
        if !(jacobian.all_greater(zero) && f.hoop.all_greater(zero)) {
            return None;
        }
        let inverse = f.inverse().plane;
        let push = closure!(|g: [T; 2]| {
            [
                g[0].mul_add(inverse[0][0], g[1] * inverse[1][0]),
                g[0].mul_add(inverse[0][1], g[1] * inverse[1][1]),
            ]
        });
        let pressure_gradient = each(&geometry.pressure_gradient, push);
        let (mut pressure, mut grad_p) = (zero, [zero; 2]);
        for m in 0..CORNERS {
            let p = x[2 * NODES + m];
            pressure = geometry.p[m].mul_add(p, pressure);
            grad_p[0] = pressure_gradient[m][0].mul_add(p, grad_p[0]);
            grad_p[1] = pressure_gradient[m][1].mul_add(p, grad_p[1]);
        }
        let inverse_radius = (geometry.radius + u_r).recip();
        Some(Self {
            f,
            jacobian,
            dilatation,
            gradient: each(&geometry.gradient, push),
            hoop: each(&geometry.n, closure!(|n: T| n * inverse_radius)),
            pressure_gradient,
            pressure,
            grad_p,
        })
    }
}

/// History at the start of a step, at the Gauss points of one element.
#[derive(Debug, Clone, Copy)]
pub struct PointState<'a, T = f64> {
    /// J of every point.
    pub jacobian: &'a [T],
    /// `Cv^-1` of every branch, point by point.
    pub cv_inverse: &'a [Voigt<T>],
    /// Largest strain so far of every point; empty unless the material softens with it.
    pub past_strain: &'a [T],
}

/// Adds to `residual`, and to `tangent` where it is asked for, for the unknowns `x` at the end of a step of `dt` (s);
/// `None` when inadmissible (in any lane).
///
/// `load` reads a number of the stored `geometry`.
#[inline(always)]
pub fn evaluate<G, T: Real>(
    (geometry, load): (&ElementGeometry<G>, impl Fn(&G) -> T + Copy),
    material: &PointMaterial,
    x: &[T; UNKNOWNS],
    old: PointState<'_, T>,
    dt: f64,
    residual: &mut Residual<T>,
    mut tangent: Option<&mut Tangent<T>>,
) -> Option<()> {
    let branches = material.branches();
    // Stress of a softening point does not have the direction of the strain that softens it.
    let symmetric = material.weakening().is_none();
    for (k, place) in geometry.points.iter().enumerate() {
        let place = place.load(load);
        let point = Point::at(&place, x)?;
        let history = &old.cv_inverse[k * branches..(k + 1) * branches];
        let mut elasticity = material.elasticity(&point.f, history, dt)?;
        if let Some(softening) = material.weakening() {
            softening.apply(&point.f, (*old.past_strain.get(k)?, dt), &mut elasticity)?;
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
            c[i][i] += pore * 2.0;
        }
        c[3][3] += pore;

        let scaled = closure!(|v: Voigt<T>| each(&v, closure!(|v: T| v * w)));
        let law = (scaled(tau), each(&c, scaled));
        momentum(&point, (&law.0, &law.1), symmetric, residual, tangent.as_deref_mut());
        let growth = point.dilatation - (old.jacobian[k] - 1.0);
        mass((&point, &place), material, growth, dt, residual, tangent.as_deref_mut());
    }
    for place in &geometry.volumetric {
        let place = place.load(load);
        let point = Point::at(&place, x)?;
        let (tau, stiffness) = material.volumetric_stress(point.dilatation)?;
        let law = (place.measure * tau, place.measure * stiffness);
        volumetric(&point, law, symmetric, residual, tangent.as_deref_mut());
    }
    if let Some(tangent) = tangent.filter(|_| symmetric) {
        for i in 0..PRESSURES {
            for j in 0..i {
                tangent[j][i] = tangent[i][j];
            }
        }
    }
    Some(())
}

/// First unknown that is a pressure.
const PRESSURES: usize = 2 * NODES;

/// Stress `tau` and tangent `c`, both times the volume; where the element's tangent is symmetric, only its lower
/// half.
#[inline(always)]
fn momentum<T: Real>(
    point: &Point<T>,
    (tau, c): (&Voigt<T>, &Voigt2<T>),
    symmetric: bool,
    residual: &mut Residual<T>,
    mut tangent: Option<&mut Tangent<T>>,
) {
    for b in 0..NODES {
        let ([gr, gz], h) = (point.gradient[b], point.hoop[b]);
        // Stress by a radial and by an axial displacement of the node, and the present stress turned by it.
        let radial = closure!(|i: usize| c[i][0].mul_add(gr, c[i][2].mul_add(h, c[i][3] * gz)));
        let axial = closure!(|i: usize| c[i][1].mul_add(gz, c[i][3] * gr));
        let turned = [tau[0].mul_add(gr, tau[3] * gz), tau[3].mul_add(gr, tau[1] * gz)];
        let (radial_shear, axial_shear) = (radial(3), axial(3));
        let rr = [radial(0) + turned[0], tau[2].mul_add(h, radial(2)), radial_shear + turned[1]];
        let rz = [axial(0), axial(2), axial_shear];
        let zr = [radial(1), radial_shear];
        let zz = [axial(1) + turned[1], axial_shear + turned[0]];
        residual[2 * b] += tau[2].mul_add(h, turned[0]);
        residual[2 * b + 1] += turned[1];
        let Some(tangent) = tangent.as_deref_mut() else { continue };
        for a in if symmetric { b } else { 0 }..NODES {
            let ([gr, gz], h) = (point.gradient[a], point.hoop[a]);
            let across =
                closure!(|v: [T; 3], sum: T| gr.mul_add(v[0], h.mul_add(v[1], gz.mul_add(v[2], sum))));
            let along = closure!(|v: [T; 2], sum: T| gz.mul_add(v[0], gr.mul_add(v[1], sum)));
            let [r, z] = rows(tangent, a);
            r[2 * b] = across(rr, r[2 * b]);
            r[2 * b + 1] = across(rz, r[2 * b + 1]);
            z[2 * b] = along(zr, z[2 * b]);
            z[2 * b + 1] = along(zz, z[2 * b + 1]);
        }
    }
}

/// Isotropic stress `tau` with `stiffness` = J d tau / dJ, both times the volume.
#[inline(always)]
fn volumetric<T: Real>(
    point: &Point<T>,
    (tau, stiffness): (T, T),
    symmetric: bool,
    residual: &mut Residual<T>,
    mut tangent: Option<&mut Tangent<T>>,
) {
    for b in 0..NODES {
        let ([gr, gz], h) = (point.gradient[b], point.hoop[b]);
        let radial = (gr + h) * stiffness;
        let (rr, tt) = (radial - tau * gr, radial - tau * h);
        let (axial, shear_r, shear_z) = (gz * stiffness, -(tau * gr), -(tau * gz));
        let zz = axial + shear_z;
        residual[2 * b] += (gr + h) * tau;
        residual[2 * b + 1] += gz * tau;
        let Some(tangent) = tangent.as_deref_mut() else { continue };
        for a in if symmetric { b } else { 0 }..NODES {
            let ([gr, gz], h) = (point.gradient[a], point.hoop[a]);
            let [r, z] = rows(tangent, a);
            r[2 * b] = gr.mul_add(rr, h.mul_add(tt, r[2 * b]));
            r[2 * b + 1] = (gr + h).mul_add(axial, gz.mul_add(shear_r, r[2 * b + 1]));
            z[2 * b] = gz.mul_add(radial, gr.mul_add(shear_z, z[2 * b]));
            z[2 * b + 1] = gz.mul_add(zz, z[2 * b + 1]);
        }
    }
}

/// Radial and axial row of a node.
#[inline(always)]
fn rows<T>(tangent: &mut [[T; UNKNOWNS]; UNKNOWNS], node: usize) -> [&mut [T; UNKNOWNS]; 2] {
    let (above, below) = tangent.split_at_mut(2 * node + 1);
    [&mut above[2 * node], &mut below[0]]
}

/// Fluid volumes, and how they depend on the displacements as well as the forces on the pressures.
#[inline(always)]
fn mass<T: Real>(
    (point, place): (&Point<T>, &PointGeometry<T>),
    material: &PointMaterial,
    growth: T,
    dt: f64,
    residual: &mut Residual<T>,
    mut tangent: Option<&mut Tangent<T>>,
) {
    let (mobility, slope) = material.darcy.referential_mobility(point.jacobian);
    let (w, wk) = (place.measure, place.measure * mobility * dt);
    let w_slope = place.measure * slope * point.jacobian * dt;
    let wj = w * point.jacobian;
    let g = point.grad_p;
    for m in 0..CORNERS {
        let gm = point.pressure_gradient[m];
        let along = gm[0] * g[0] + gm[1] * g[1];
        let row = PRESSURES + m;
        let share = wj * place.p[m];
        residual[row] += w * place.p[m] * growth + wk * along;
        let Some(tangent) = tangent.as_deref_mut() else { continue };
        // Both gradients are pushed forward: their product changes by -grad q . (l + l^T) . grad p.
        let divergence = w_slope.mul_add(along, share);
        let rr = divergence - wk * gm[0] * g[0] * 2.0;
        let zz = divergence - wk * gm[1] * g[1] * 2.0;
        let rz = -(wk * (gm[0] * g[1] + gm[1] * g[0]));
        for a in 0..NODES {
            let ([gr, gz], h) = (point.gradient[a], point.hoop[a]);
            let fluid = &mut tangent[row];
            fluid[2 * a] = gr.mul_add(rr, gz.mul_add(rz, h.mul_add(divergence, fluid[2 * a])));
            fluid[2 * a + 1] = gz.mul_add(zz, gr.mul_add(rz, fluid[2 * a + 1]));
            tangent[2 * a][row] -= share * (gr + h);
            tangent[2 * a + 1][row] -= share * gz;
        }
        for n in 0..CORNERS {
            let gn = point.pressure_gradient[n];
            tangent[row][PRESSURES + n] += wk * (gm[0] * gn[0] + gm[1] * gn[1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::geometry::Geometry;
    use crate::element::shape::POINTS;
    use crate::law::IDENTITY;
    use crate::law::parameters::MaterialParameters;
    use crate::mesh::Mesh;

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
        let (mut residual, mut exact) = ([0.0; UNKNOWNS], [[0.0; UNKNOWNS]; UNKNOWNS]);
        let at = (&geometry, |g: &f64| *g);
        evaluate(at, &material, &x, old, dt, &mut residual, Some(&mut exact)).unwrap();
        let block = |k: usize| usize::from(k >= 2 * NODES);
        let mut largest = [[0.0_f64; 2]; 2];
        for i in 0..UNKNOWNS {
            for j in 0..UNKNOWNS {
                let l = &mut largest[block(i)][block(j)];
                *l = l.max(exact[i][j].abs());
            }
        }
        for j in 0..UNKNOWNS {
            let h = if j < 2 * NODES { 1e-10 } else { 1e-1 };
            let shifted = |s: f64| {
                let mut y = x;
                y[j] += s;
                let mut residual = [0.0; UNKNOWNS];
                evaluate(at, &material, &y, old, dt, &mut residual, None).unwrap();
                residual
            };
            let (up, down) = (shifted(h), shifted(-h));
            for i in 0..UNKNOWNS {
                let slope = (up[i] - down[i]) / (2.0 * h);
                let error = (slope - exact[i][j]).abs();
                assert!(error < 1e-6 * largest[block(i)][block(j)], "({i}, {j}): {error}");
            }
        }
    }
}

//! Residual and tangent of one cell (Eqs. 4, 5 in the reference configuration).
//!
//! The weak form is that of [`crate::element::kernel`]; here, too, the volumetric law is integrated with
//! one point fewer per direction, 2 x 2 x 2, because a drained skeleton would lock at 3 x 3 x 3 points.

use super::geometry::{CellGeometry, PointGeometry};
use super::point::{SolidMaterial, determinant, inverse};
use super::shape::{CORNERS, GAUSS_POINTS, NODES, Shape, UNKNOWNS, VOLUMETRIC_POINTS};
use super::{PLACE, Tensor, Voigt, Voigt2};

/// Nodes padded to whole vectors.
const PADDED: usize = 28;
/// Nodes per vector.
const LANES: usize = 4;
/// A number for every node.
type Nodal = [[f64; LANES]; PADDED / LANES];
/// A vector for every node, by components.
type NodalVector = [Nodal; 3];

const ZERO: Nodal = [[0.0; LANES]; PADDED / LANES];

/// Cell residual and tangent: three displacements node by node, then the pressures.
#[derive(Debug, Clone)]
pub struct CellSystem {
    /// Internal nodal forces (N), then fluid volumes of the step (m^3).
    pub residual: [f64; UNKNOWNS],
    /// Derivative of the residual, by columns: `tangent[column][row]`.
    pub tangent: [[f64; UNKNOWNS]; UNKNOWNS],
    sums: Sums,
}

/// Sums over the integration points, laid out for vector instructions.
#[derive(Debug, Clone)]
struct Sums {
    /// Force `i` at node `a` by displacement `j` of node `b`: `[a][i][j]`, b by lanes; b >= a only.
    uu: [[[Nodal; 3]; 3]; NODES],
    /// Force by pressure m: `[m][i]`, nodes by lanes.
    up: [NodalVector; CORNERS],
    /// Fluid volume m by displacement: `[m][j]`, nodes by lanes.
    pu: [NodalVector; CORNERS],
    pp: [[f64; CORNERS]; CORNERS],
    force: NodalVector,
    volume: [f64; CORNERS],
}

impl Default for Sums {
    fn default() -> Self {
        Self {
            uu: [[[ZERO; 3]; 3]; NODES],
            up: [[ZERO; 3]; CORNERS],
            pu: [[ZERO; 3]; CORNERS],
            pp: [[0.0; CORNERS]; CORNERS],
            force: [ZERO; 3],
            volume: [0.0; CORNERS],
        }
    }
}

impl Default for CellSystem {
    fn default() -> Self {
        Self { residual: [0.0; UNKNOWNS], tangent: [[0.0; UNKNOWNS]; UNKNOWNS], sums: Sums::default() }
    }
}

/// Kinematics at one point of a cell.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// Deformation gradient.
    pub f: Tensor,
    /// J.
    pub jacobian: f64,
    /// `d xi / d x`, x the deformed position (1/m).
    pub inverse: Tensor,
    /// Pore pressure (Pa).
    pub pressure: f64,
    /// Spatial pressure gradient (Pa/m).
    pub grad_p: [f64; 3],
}

impl Point {
    /// Evaluates the kinematics; `x` are the cell's unknowns. `None` when turned inside out.
    #[inline]
    pub fn at(geometry: &PointGeometry, shape: &Shape, x: &[f64; UNKNOWNS]) -> Option<Self> {
        let mut slope = [[0.0; 3]; 3];
        for (u, dn) in x.as_chunks::<3>().0.iter().zip(&shape.dn) {
            for i in 0..3 {
                for e in 0..3 {
                    slope[i][e] += u[i] * dn[e];
                }
            }
        }
        let mut f = product(&slope, &geometry.inverse);
        (0..3).for_each(|i| f[i][i] += 1.0);
        let jacobian = determinant(&f);
        if jacobian.is_nan() || jacobian <= 0.0 {
            return None;
        }
        let inverse = product(&geometry.inverse, &inverse(&f, jacobian));
        let (mut pressure, mut slope) = (0.0, [0.0; 3]);
        for m in 0..CORNERS {
            let p = x[3 * NODES + m];
            pressure += shape.p[m] * p;
            (0..3).for_each(|e| slope[e] += shape.dp[m][e] * p);
        }
        Some(Self { f, jacobian, inverse, pressure, grad_p: through(&slope, &inverse) })
    }
}

/// History at the start of a step, at the Gauss points of one cell.
#[derive(Debug, Clone, Copy)]
pub struct PointState<'a> {
    /// J of every point.
    pub jacobian: &'a [f64],
    /// `Cv^-1` of every branch, point by point.
    pub cv_inverse: &'a [Voigt],
}

/// Fills `system` for the unknowns `x` at the end of a step of `dt` (s); `None` when inadmissible.
pub fn evaluate(
    geometry: &CellGeometry,
    material: &SolidMaterial,
    x: &[f64; UNKNOWNS],
    old: PointState<'_>,
    dt: f64,
    system: &mut CellSystem,
) -> Option<()> {
    let arch = pulp::Arch::new();
    let sums = &mut system.sums;
    *sums = Sums::default();
    let branches = material.branches();
    for (k, (place, shape)) in geometry.points.iter().zip(&*GAUSS_POINTS).enumerate() {
        let point = Point::at(place, shape, x)?;
        let history = &old.cv_inverse[k * branches..(k + 1) * branches];
        let elasticity = material.elasticity(&point.f, history, dt)?;
        let (tau, c) =
            total(elasticity.kirchhoff_stress, elasticity.tangent, point.pressure * point.jacobian);
        let growth = point.jacobian - old.jacobian[k];
        let (mobility, slope) = material.darcy.referential_mobility(point.jacobian);
        let flow = Seepage { growth, mobility: dt * mobility, slope: dt * slope * point.jacobian };
        arch.dispatch(Add {
            point: &point,
            shape,
            w: place.measure,
            tau: &tau,
            c: &c,
            flow: Some(flow),
            sums,
        });
    }
    for (place, shape) in geometry.volumetric.iter().zip(&*VOLUMETRIC_POINTS) {
        let point = Point::at(place, shape, x)?;
        let (tau, stiffness) = material.volumetric_stress(point.jacobian - 1.0)?;
        let (tau, c) = isotropic(tau, stiffness);
        arch.dispatch(Add { point: &point, shape, w: place.measure, tau: &tau, c: &c, flow: None, sums });
    }
    system.gather();
    Some(())
}

/// Total Kirchhoff stress and tangent `tau - p J 1`; `pore` is p J.
fn total(mut tau: Voigt, mut c: Voigt2, pore: f64) -> (Voigt, Voigt2) {
    for i in 0..3 {
        tau[i] -= pore;
        c[i].iter_mut().take(3).for_each(|v| *v -= pore);
        c[i][i] += 2.0 * pore;
        c[i + 3][i + 3] += pore;
    }
    (tau, c)
}

/// Isotropic stress `tau` with `stiffness` = J d tau / dJ, as a stress and a spatial tangent.
fn isotropic(tau: f64, stiffness: f64) -> (Voigt, Voigt2) {
    let mut c = [[0.0; 6]; 6];
    for i in 0..3 {
        c[i].iter_mut().take(3).for_each(|v| *v = stiffness);
        c[i][i] -= 2.0 * tau;
        c[i + 3][i + 3] = -tau;
    }
    ([tau, tau, tau, 0.0, 0.0, 0.0], c)
}

/// Storage and seepage at a point.
#[derive(Clone, Copy)]
struct Seepage {
    /// Change of J over the step.
    growth: f64,
    /// `dt J k`.
    mobility: f64,
    /// `J d(dt J k) / dJ`.
    slope: f64,
}

/// Adds one point, compiled for the machine's vector instructions.
struct Add<'a> {
    point: &'a Point,
    shape: &'a Shape,
    w: f64,
    tau: &'a Voigt,
    c: &'a Voigt2,
    flow: Option<Seepage>,
    sums: &'a mut Sums,
}

impl pulp::NullaryFnOnce for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { point, shape, w, tau, c, flow, sums } = self;
        let mut g = [ZERO; 3];
        for (a, dn) in shape.dn.iter().enumerate() {
            let through = through(dn, &point.inverse);
            (0..3).for_each(|d| g[d][a / LANES][a % LANES] = through[d]);
        }
        momentum(&g, w, tau, c, sums);
        if let Some(flow) = flow {
            mass(&g, point, shape, w, flow, sums);
        }
    }
}

/// `R_ai = tau_ik g_ak`, `K_aibj = g_ak (C_ikjl + delta_ij tau_kl) g_bl`.
#[inline(always)]
fn momentum(g: &NodalVector, w: f64, tau: &Voigt, c: &Voigt2, sums: &mut Sums) {
    for i in 0..3 {
        let t: [f64; 3] = std::array::from_fn(|k| w * tau[PLACE[i][k]]);
        add_combination(&mut sums.force[i], t, g, 0);
    }
    // For a force i, direction k and displacement j: the lanes of all nodes b.
    let mut cg = [[[ZERO; 3]; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                let factors = std::array::from_fn(|l| {
                    let geometric = if i == j { tau[PLACE[k][l]] } else { 0.0 };
                    w * (c[PLACE[i][k]][PLACE[j][l]] + geometric)
                });
                add_combination(&mut cg[i][j][k], factors, g, 0);
            }
        }
    }
    for a in 0..NODES {
        let ga: [f64; 3] = std::array::from_fn(|k| g[k][a / LANES][a % LANES]);
        for i in 0..3 {
            for j in 0..3 {
                add_combination(&mut sums.uu[a][i][j], ga, &cg[i][j], a / LANES);
            }
        }
    }
}

/// `sum += factors . v` for the lanes from `first` on.
#[inline(always)]
fn add_combination(sum: &mut Nodal, factors: [f64; 3], v: &NodalVector, first: usize) {
    for block in first..PADDED / LANES {
        for lane in 0..LANES {
            let s = &mut sum[block][lane];
            *s = factors[0].mul_add(v[0][block][lane], *s);
            *s = factors[1].mul_add(v[1][block][lane], *s);
            *s = factors[2].mul_add(v[2][block][lane], *s);
        }
    }
}

#[inline(always)]
fn mass(g: &NodalVector, point: &Point, shape: &Shape, w: f64, flow: Seepage, sums: &mut Sums) {
    let wk = w * flow.mobility;
    let gp = point.grad_p;
    let gm: [[f64; 3]; CORNERS] = std::array::from_fn(|m| through(&shape.dp[m], &point.inverse));
    let mut along_p = ZERO;
    add_combination(&mut along_p, gp, g, 0);
    for m in 0..CORNERS {
        let along = dot(&gm[m], &gp);
        sums.volume[m] += w * shape.p[m] * flow.growth + wk * along;
        for n in 0..CORNERS {
            sums.pp[m][n] += wk * dot(&gm[m], &gm[n]);
        }
        let mut along_m = ZERO;
        add_combination(&mut along_m, gm[m], g, 0);
        let storage = w * point.jacobian * shape.p[m];
        let row = storage + w * flow.slope * along;
        for i in 0..3 {
            let (up, pu) = (&mut sums.up[m][i], &mut sums.pu[m][i]);
            let (by_m, by_p) = (-wk * gp[i], -wk * gm[m][i]);
            for block in 0..PADDED / LANES {
                for lane in 0..LANES {
                    let ga = g[i][block][lane];
                    up[block][lane] = (-storage).mul_add(ga, up[block][lane]);
                    let s = row.mul_add(ga, pu[block][lane]);
                    let s = by_m.mul_add(along_m[block][lane], s);
                    pu[block][lane] = by_p.mul_add(along_p[block][lane], s);
                }
            }
        }
    }
}

impl CellSystem {
    /// Collects the sums into residual and tangent.
    fn gather(&mut self) {
        let Self { residual, tangent, sums } = self;
        for a in 0..NODES {
            for i in 0..3 {
                let row = 3 * a + i;
                residual[row] = sums.force[i].as_flattened()[a];
                for j in 0..3 {
                    let values = sums.uu[a][i][j].as_flattened();
                    for b in a..NODES {
                        tangent[3 * b + j][row] = values[b];
                        // K_uu is symmetric.
                        tangent[row][3 * b + j] = values[b];
                    }
                }
                for m in 0..CORNERS {
                    tangent[3 * NODES + m][row] = sums.up[m][i].as_flattened()[a];
                    tangent[row][3 * NODES + m] = sums.pu[m][i].as_flattened()[a];
                }
            }
        }
        for m in 0..CORNERS {
            residual[3 * NODES + m] = sums.volume[m];
            for n in 0..CORNERS {
                tangent[3 * NODES + n][3 * NODES + m] = sums.pp[m][n];
            }
        }
    }
}

/// Row vector times matrix.
#[inline(always)]
fn through(v: &[f64; 3], m: &Tensor) -> [f64; 3] {
    std::array::from_fn(|d| v[0] * m[0][d] + v[1] * m[1][d] + v[2] * m[2][d])
}

#[inline(always)]
fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn product(a: &Tensor, b: &Tensor) -> Tensor {
    std::array::from_fn(|i| through(&a[i], b))
}

#[cfg(test)]
mod tests {
    use super::super::IDENTITY;
    use super::super::forest::COARSE;
    use super::super::geometry::Geometry;
    use super::super::mesh::Mesh;
    use super::super::shape::POINTS;
    use super::*;
    use crate::law::parameters::MaterialParameters;
    use crate::mesh::parameters::GeometryParameters;

    /// Goal: the tangent is consistent. Set-up: a curved cell, irregular displacements of a few per cent,
    /// flown branches, seepage. Reference: central differences of the residual. Tolerance: 1e-6 of the
    /// largest entry of each block.
    #[test]
    fn tangent_matches_finite_differences() {
        let material = SolidMaterial::new(&MaterialParameters { n0s: 0.2, ..Default::default() });
        let mesh = Mesh::new(&GeometryParameters::default(), COARSE);
        let geometry = Geometry::new(&mesh).cells[2];
        let mut x = [0.0; UNKNOWNS];
        for (k, v) in x.iter_mut().enumerate() {
            let noise = ((k * 7919 + 13) % 101) as f64 / 101.0 - 0.5;
            *v = if k < 3 * NODES { 4e-5 * noise } else { 3e3 * noise };
        }
        let jacobian = [1.01; POINTS];
        let mut cv_inverse = vec![IDENTITY; 2 * POINTS];
        cv_inverse[3] = [1.1, 0.95, 0.96, 0.02, -0.03, 0.01];
        let old = PointState { jacobian: &jacobian, cv_inverse: &cv_inverse };
        let dt = 0.02;
        let mut exact = Box::<CellSystem>::default();
        evaluate(&geometry, &material, &x, old, dt, &mut exact).unwrap();
        let block = |k: usize| usize::from(k >= 3 * NODES);
        let mut largest = [[0.0_f64; 2]; 2];
        for j in 0..UNKNOWNS {
            for i in 0..UNKNOWNS {
                let l = &mut largest[block(i)][block(j)];
                *l = l.max(exact.tangent[j][i].abs());
            }
        }
        let mut system = Box::<CellSystem>::default();
        for j in 0..UNKNOWNS {
            let h = if j < 3 * NODES { 1e-10 } else { 1e-1 };
            let mut shifted = |s: f64| {
                let mut y = x;
                y[j] += s;
                evaluate(&geometry, &material, &y, old, dt, &mut system).unwrap();
                system.residual
            };
            let (up, down) = (shifted(h), shifted(-h));
            for i in 0..UNKNOWNS {
                let slope = (up[i] - down[i]) / (2.0 * h);
                let error = (slope - exact.tangent[j][i]).abs();
                assert!(error < 1e-6 * largest[block(i)][block(j)], "({i}, {j}): {error}");
            }
        }
    }
}

//! Boundary value problems on any mesh of the element: prescribed unknowns and nodal loads, solved by Newton's method.

use poropunch::Statistics;
use poropunch::element::{Body, History, Stage, undeformed};
use poropunch::law::PointMaterial;
use poropunch::mesh::{CORNERS, Mesh, NODES};
use poropunch::parameters::{LinearSolverKind, MaterialParameters};
use poropunch::solver::linear::{LinearSolver, Singular};
use poropunch::solver::newton::{self, Aim, NewtonFailure, System, Workspace};
use poropunch::specimen::sample::Sample;
use std::f64::consts::TAU;

/// A mesh whose corners go where `place` says; sides stay straight.
pub fn warped(mut mesh: Mesh, place: impl Fn([f64; 2]) -> [f64; 2]) -> Mesh {
    for element in &mut mesh.elements {
        element.corners = element.corners.map(&place);
        for (k, node) in element.nodes.iter().enumerate() {
            let shape = Functions::at([(k % 3) as f64 - 1.0, (k / 3) as f64 - 1.0]);
            mesh.nodes[*node as usize] =
                std::array::from_fn(|d| (0..CORNERS).map(|m| shape.linear[m] * element.corners[m][d]).sum());
        }
    }
    mesh
}

/// Quadratic and linear functions of the reference square with their derivatives, written from their definition.
#[derive(Debug, Clone, Copy)]
pub struct Functions {
    /// Biquadratic, `3 j + i`.
    pub quadratic: [f64; NODES],
    /// Their derivatives.
    pub quadratic_slope: [[f64; 2]; NODES],
    /// Bilinear, `2 j + i`.
    pub linear: [f64; CORNERS],
    /// Their derivatives.
    pub linear_slope: [[f64; 2]; CORNERS],
}

impl Functions {
    /// At a place of the reference square.
    pub fn at([x, y]: [f64; 2]) -> Self {
        let q = |x: f64| [0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)];
        let dq = |x: f64| [x - 0.5, -2.0 * x, x + 0.5];
        let (l, dl) = (|x: f64| [0.5 * (1.0 - x), 0.5 * (1.0 + x)], [-0.5, 0.5]);
        Self {
            quadratic: std::array::from_fn(|k| q(x)[k % 3] * q(y)[k / 3]),
            quadratic_slope: std::array::from_fn(|k| {
                [dq(x)[k % 3] * q(y)[k / 3], q(x)[k % 3] * dq(y)[k / 3]]
            }),
            linear: std::array::from_fn(|k| l(x)[k % 2] * l(y)[k / 2]),
            linear_slope: std::array::from_fn(|k| [dl[k % 2] * l(y)[k / 2], l(x)[k % 2] * dl[k / 2]]),
        }
    }
}

/// Functions, their gradients by (R, Z), place and measure `2 pi R dA` at a quadrature point.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// (R, Z).
    pub at: [f64; 2],
    /// Functions of the displacement.
    pub n: [f64; NODES],
    /// Their gradients.
    pub gradient: [[f64; 2]; NODES],
    /// Functions of the pressure.
    pub p: [f64; CORNERS],
    /// Their gradients.
    pub pressure_gradient: [[f64; 2]; CORNERS],
    /// Measure.
    pub measure: f64,
}

impl Place {
    /// Of an element with these corners.
    pub fn new(corners: &[[f64; 2]; CORNERS], xi: [f64; 2], weight: f64) -> Self {
        let f = Functions::at(xi);
        let at: [f64; 2] = std::array::from_fn(|d| (0..CORNERS).map(|m| f.linear[m] * corners[m][d]).sum());
        let j: [[f64; 2]; 2] = std::array::from_fn(|d| {
            std::array::from_fn(|e| (0..CORNERS).map(|m| f.linear_slope[m][e] * corners[m][d]).sum())
        });
        let det = j[0][0] * j[1][1] - j[0][1] * j[1][0];
        let pull =
            |g: [f64; 2]| [(g[0] * j[1][1] - g[1] * j[1][0]) / det, (g[1] * j[0][0] - g[0] * j[0][1]) / det];
        Self {
            at,
            n: f.quadratic,
            gradient: f.quadratic_slope.map(pull),
            p: f.linear,
            pressure_gradient: f.linear_slope.map(pull),
            measure: TAU * at[0] * weight * det,
        }
    }

    /// Displacement, its gradient, pressure and its gradient of an element's unknowns.
    pub fn fields(&self, x: &[f64]) -> Fields {
        let mut f = Fields::default();
        for a in 0..NODES {
            for i in 0..2 {
                f.u[i] += self.n[a] * x[2 * a + i];
                for d in 0..2 {
                    f.grad_u[i][d] += self.gradient[a][d] * x[2 * a + i];
                }
            }
        }
        for m in 0..CORNERS {
            f.p += self.p[m] * x[2 * NODES + m];
            for d in 0..2 {
                f.grad_p[d] += self.pressure_gradient[m][d] * x[2 * NODES + m];
            }
        }
        f
    }
}

/// Displacement and pressure at a point.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fields {
    /// (u_r, u_z).
    pub u: [f64; 2],
    /// Its gradient by (R, Z).
    pub grad_u: [[f64; 2]; 2],
    /// Pore pressure.
    pub p: f64,
    /// Its gradient.
    pub grad_p: [f64; 2],
}

impl Fields {
    /// In-plane deformation gradient, hoop stretch and J at the distance R from the axis.
    pub fn deformation(&self, radius: f64) -> ([[f64; 2]; 2], f64, f64) {
        let g = &self.grad_u;
        let f = [[1.0 + g[0][0], g[0][1]], [g[1][0], 1.0 + g[1][1]]];
        let hoop = 1.0 + self.u[0] / radius;
        (f, hoop, (f[0][0] * f[1][1] - f[0][1] * f[1][0]) * hoop)
    }
}

/// Abscissae and weights of the five-point Gauss rule.
pub const GAUSS_5: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

/// A body with prescribed unknowns and nodal loads; residuals are not scaled, so its units should make them of order one.
pub struct Problem {
    /// Mesh, integration points, structure.
    pub sample: Sample,
    /// Laws.
    pub material: PointMaterial,
    /// What unknowns are held at.
    pub prescribed: Vec<Option<f64>>,
    /// Nodal forces (N) and fluid volumes (m^3) from outside.
    pub loads: Vec<f64>,
    linear: LinearSolver,
    work: Workspace,
    branches: usize,
}

impl Problem {
    /// Nothing prescribed but `u_r = 0` on the axis, no loads.
    pub fn new(mesh: Mesh, parameters: &MaterialParameters) -> Self {
        let axis: Vec<usize> = mesh.axis().map(|n| mesh.displacement(n)).collect();
        let sample = Sample::from_mesh(mesh).expect("few unknowns");
        let (unknowns, entries) = (sample.mesh.unknowns(), sample.map.pattern.rows.len());
        let mut prescribed = vec![None; unknowns];
        axis.into_iter().for_each(|unknown| prescribed[unknown] = Some(0.0));
        Self {
            material: PointMaterial::new(parameters),
            prescribed,
            loads: vec![0.0; unknowns],
            linear: LinearSolver::new(sample.structure.clone(), LinearSolverKind::default()),
            work: Workspace::new(unknowns, entries),
            branches: parameters.branches.len(),
            sample,
        }
    }

    /// Laws on the mesh.
    pub fn body(&self) -> Body<'_> {
        self.sample.body(&self.material)
    }

    /// The undeformed history.
    pub fn undeformed(&self) -> History {
        undeformed(self.sample.mesh.elements.len(), self.branches)
    }

    /// Internal forces and fluid volumes of a stage, without loads.
    pub fn internal(&self, x: &[f64], old: &History, dt: f64) -> (Vec<f64>, Vec<f64>) {
        let mut residual = vec![0.0; x.len()];
        let mut values = vec![0.0; self.sample.map.pattern.rows.len()];
        let stage = Stage { x, old, dt };
        self.body().assemble(&stage, &mut residual, Some(&mut values)).expect("an admissible state");
        (residual, values)
    }

    /// Moves `x` to the end of a backward Euler step.
    ///
    /// # Errors
    /// Why there is no solution.
    pub fn step(&mut self, x: &mut [f64], old: &History, dt: f64) -> Result<(), NewtonFailure> {
        let mut system = Loaded {
            body: self.sample.body(&self.material),
            stage: (old, dt),
            prescribed: &self.prescribed,
            loads: &self.loads,
            scale: vec![1.0; x.len()],
            linear: &mut self.linear,
            statistics: Statistics::default(),
        };
        newton::solve(&mut system, &mut self.work, x, 1e-12).map(drop)
    }

    /// History at the end of a step.
    pub fn advanced(&self, x: &[f64], old: &History, dt: f64) -> History {
        let mut new = old.clone();
        self.body().update(&Stage { x, old, dt }, 1.0, &mut new).expect("an admissible state");
        new
    }

    /// Calls with every point of a 5 x 5 rule, its element, and that element's unknowns of `x`.
    pub fn at_points(&self, x: &[f64], mut visit: impl FnMut(usize, &Place, &Fields)) {
        for (element, e) in self.sample.mesh.elements.iter().enumerate() {
            let x_e = self.sample.map.gather(element, x);
            for (a, wa) in GAUSS_5 {
                for (b, wb) in GAUSS_5 {
                    let place = Place::new(&e.corners, [a, b], wa * wb);
                    visit(element, &place, &place.fields(&x_e));
                }
            }
        }
    }
}

struct Loaded<'a> {
    body: Body<'a>,
    stage: (&'a History, f64),
    prescribed: &'a [Option<f64>],
    loads: &'a [f64],
    scale: Vec<f64>,
    linear: &'a mut LinearSolver,
    statistics: Statistics,
}

impl System for Loaded<'_> {
    fn evaluate(
        &mut self,
        x: &[f64],
        residual: &mut [f64],
        mut values: Option<&mut [f64]>,
    ) -> Result<f64, usize> {
        let (stage, body) = (Stage { x, old: self.stage.0, dt: self.stage.1 }, &self.body);
        body.assemble(&stage, residual, values.as_deref_mut()).map_err(|failed| failed.element)?;
        let pattern = &self.body.map.pattern;
        if let Some(values) = values {
            for column in 0..x.len() {
                let (first, rows) = pattern.column(column);
                for (value, &row) in values[first..].iter_mut().zip(rows) {
                    if self.prescribed[row as usize].is_some() {
                        *value = if row as usize == column { 1.0 } else { 0.0 };
                    }
                }
            }
        }
        let mut square = 0.0;
        for (k, r) in residual.iter_mut().enumerate() {
            match self.prescribed[k] {
                Some(value) => *r = x[k] - value,
                None => {
                    *r -= self.loads[k];
                    square += *r * *r;
                }
            }
        }
        Ok(square.sqrt())
    }

    fn correct(&mut self, values: &[f64], correction: &mut [f64], _: Aim) -> Result<(), Singular> {
        self.linear.solve(values, correction)
    }

    fn scale(&self) -> &[f64] {
        &self.scale
    }

    fn statistics(&mut self) -> &mut Statistics {
        &mut self.statistics
    }
}

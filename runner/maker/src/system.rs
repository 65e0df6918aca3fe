//! The equations of one step: weak forms of Eqs. 4 and 5 with their tangent, contact and drainage of the surfaces.

use crate::boundary::{Boundary, Drainage};
use crate::contact::{Face, Touch};
use crate::element::{self, GaussPoint, SidePoint};
use crate::error::Failure;
use crate::law::{Laws, Past, Point};
use crate::linear::Pattern;
use crate::mesh::{Fineness, Mesh, Side};
use crate::specimen::Specimen;
use crate::time::Formula;
use crate::weak::Local;

/// A triangle with a place for its entries.
struct Cell {
    nodes: [usize; 6],
    points: [GaussPoint; element::POINTS],
}

/// A side with a place for its entries.
struct Strip {
    side: Side,
    points: [SidePoint; 3],
    /// Penalty (Pa/m) on the face, permeance (m/(Pa s)) elsewhere.
    stiffness: f64,
}

/// Unknowns at one time: displacements of all nodes (m), then pressures of all corners over [`System::pressure_unit`].
pub type Unknowns = Vec<f64>;

/// What is remembered of one time.
#[derive(Debug, Clone)]
pub struct Memory {
    /// All integration points of the triangles.
    pub points: Vec<Past>,
    /// All integration points of the face.
    pub touches: Vec<Touch>,
}

/// One step.
pub struct Step<'a> {
    /// Formula in time.
    pub formula: Formula,
    /// Memory of the beginning.
    pub last: &'a Memory,
    /// Memory of one step earlier.
    pub before: &'a Memory,
    /// Factor on all moduli and viscosities at its end.
    pub stiffening: f64,
}

impl Step<'_> {
    /// What a point of the face remembers of the beginning, and of one step earlier.
    fn touches(&self, point: usize) -> (&Touch, &Touch) {
        (&self.last.touches[point], &self.before.touches[point])
    }
}

/// Residual and tangent.
#[derive(Debug, Default)]
pub struct Equations {
    /// Residuals of the free unknowns.
    pub residual: Vec<f64>,
    /// Entries of the tangent, if wanted.
    pub tangent: Vec<f64>,
    /// Derivative of the residual by the punch's depth, and of the force by the unknowns (N/m).
    pub by_depth: Vec<f64>,
    /// Force on the punch (N).
    pub force: f64,
    /// Its derivative by the depth at fixed unknowns (N/m).
    pub force_by_depth: f64,
}

/// The discretised specimen.
pub struct System {
    /// The mesh.
    pub mesh: Mesh,
    laws: Laws,
    face: Face,
    face_permeance: f64,
    open_permeance: f64,
    cells: Vec<Cell>,
    strips: Vec<Strip>,
    drains: Vec<Strip>,
    /// Number of every free unknown in the equations.
    pub equation: Vec<Option<usize>>,
    /// Pattern of the tangent.
    pub pattern: Pattern,
    places: Vec<Vec<u32>>,
    free: usize,
    pressure_unit: f64,
    /// Radius of the punch (m).
    pub punch_radius: f64,
}

/// Penalty times the side's length over the instantaneous shear modulus: as stiff as rounding allows.
const PENALTY: f64 = 1e4;

impl System {
    /// Discretises a specimen.
    ///
    /// # Errors
    /// When memory is exhausted.
    pub fn new(
        specimen: &Specimen,
        laws: Laws,
        face: Face,
        boundary: &Boundary,
        fine: &Fineness,
    ) -> Result<Self, Failure> {
        let (mesh, g) = (Mesh::new(&specimen.geometry, fine), &specimen.geometry);
        let modulus = laws.material.instantaneous_modulus();
        let nodes = mesh.nodes.len();
        let tiny = 1e-9 * g.sample_radius;
        let mut fixed = vec![false; 2 * nodes + mesh.corners];
        for (i, x) in mesh.nodes.iter().enumerate() {
            let bottom = x[1] < tiny - g.sample_height;
            fixed[2 * i] = bottom || x[0] < tiny;
            fixed[2 * i + 1] = bottom;
            if i < mesh.corners {
                let drained = |d: Drainage| d == Drainage::Free;
                fixed[2 * nodes + i] = (x[1] > -tiny && x[0] > g.punch_radius - tiny)
                    || (bottom && drained(boundary.bottom))
                    || (x[0] > g.sample_radius - tiny && drained(boundary.side));
            }
        }
        let mut free = 0;
        let mut number = |&fixed: &bool| {
            free += usize::from(!fixed);
            (!fixed).then_some(free.wrapping_sub(1))
        };
        let equation: Vec<Option<usize>> = fixed.iter().map(&mut number).collect();
        let strip =
            |s: &Side, stiffness: f64| Strip { side: *s, points: element::side_points(&mesh, s), stiffness };
        let length = |s: &Side| {
            (mesh.nodes[s[1]][0] - mesh.nodes[s[0]][0]).hypot(mesh.nodes[s[1]][1] - mesh.nodes[s[0]][1])
        };
        let strips: Vec<Strip> = mesh.face.iter().map(|s| strip(s, PENALTY * modulus / length(s))).collect();
        let mut drains = Vec::new();
        for (sides, drainage) in [(&mesh.bottom, boundary.bottom), (&mesh.lateral, boundary.side)] {
            if let Drainage::Permeance(permeance) = drainage
                && permeance > 0.0
            {
                drains.extend(sides.iter().map(|s| strip(s, permeance)));
            }
        }
        let cells: Vec<Cell> =
            mesh.triangles.iter().map(|t| Cell { nodes: *t, points: element::points(&mesh, t) }).collect();
        let displacements =
            |n: &[usize]| n.iter().flat_map(|&n| [equation[2 * n], equation[2 * n + 1]]).collect();
        let unknowns = |n: &[usize], corners: usize| {
            let mut all: Vec<Option<usize>> = displacements(n);
            all.extend(n[..corners].iter().map(|&n| equation[2 * nodes + n]));
            all
        };
        let lists: Vec<Vec<Option<usize>>> = cells
            .iter()
            .map(|c| unknowns(&c.nodes, 3))
            .chain(strips.iter().chain(&drains).map(|s| unknowns(&s.side, 2)))
            .collect();
        let (pattern, places) = Pattern::new(free, &lists)?;
        let mobility = laws.material.permeability / laws.material.fluid_viscosity;
        Ok(Self {
            face,
            face_permeance: boundary.face,
            // An open point drains as if through a film far thinner than any triangle.
            open_permeance: 100.0 * mobility / (fine.near * g.punch_radius),
            pressure_unit: modulus / (0.1 * g.punch_radius),
            punch_radius: g.punch_radius,
            laws,
            cells,
            strips,
            drains,
            equation,
            pattern,
            places,
            free,
            mesh,
        })
    }

    /// The undeformed specimen.
    pub fn rest(&self) -> (Unknowns, Memory) {
        let past = Past::new(self.laws.material.branches.len());
        let points = vec![past; self.cells.len() * element::POINTS];
        // A test begins when the face touches.
        let touches = vec![Touch { closed: true, ..Touch::default() }; 3 * self.strips.len()];
        (vec![0.0; self.equation.len()], Memory { points, touches })
    }

    /// A force that is small for this specimen: of its equilibrium under a hundredth of the punch's radius (N).
    pub fn force_unit(&self) -> f64 {
        0.08 * self.laws.material.equilibrium.shear_modulus() * self.punch_radius * self.punch_radius
    }

    /// Mean height of the surface under the face (m).
    pub fn surface(&self, x: &[f64]) -> f64 {
        let heights = self.strips.iter().flat_map(|s| {
            s.points
                .iter()
                .map(|g| (g.weight, (0..3).map(|a| g.shape[a] * x[2 * s.side[a] + 1]).sum::<f64>()))
        });
        let (area, volume) = heights.fold((0.0, 0.0), |(a, v), (w, u)| (a + w, v + w * u));
        volume / area
    }

    /// Residual, and tangent if `tangent`, of a step at these unknowns and this depth of the punch (m); writes what
    /// is to be remembered of its end.
    ///
    /// # Errors
    /// When a point has no response.
    pub fn assemble(
        &self,
        x: &[f64],
        depth: f64,
        step: &Step<'_>,
        tangent: bool,
        now: &mut Memory,
        eq: &mut Equations,
    ) -> Result<(), Failure> {
        eq.residual.clear();
        eq.residual.resize(self.free, 0.0);
        eq.by_depth.clear();
        eq.by_depth.resize(self.free, 0.0);
        eq.tangent.clear();
        if tangent {
            eq.tangent.resize(self.pattern.entries(), 0.0);
        }
        (eq.force, eq.force_by_depth) = (0.0, 0.0);
        for (i, cell) in self.cells.iter().enumerate() {
            self.add_cell(i, cell, x, step, tangent, &mut now.points, eq)?;
        }
        let face = self.face.at(&step.last.touches);
        for (i, strip) in self.strips.iter().enumerate() {
            self.add_face(face, i, strip, x, depth, step, tangent, &mut now.touches, eq);
        }
        for (i, strip) in self.drains.iter().enumerate() {
            self.add_drain(i, strip, x, step, tangent, eq);
        }
        Ok(())
    }

    /// The branches of the contact law on which the points of the face are.
    pub fn branches(&self, x: &[f64], depth: f64, step: &Step<'_>) -> Vec<u8> {
        let face = self.face.at(&step.last.touches);
        let point = |(i, g): (usize, (&Strip, &SidePoint))| {
            let (strip, g) = g;
            let at = |d: usize| (0..3).map(|a| g.shape[a] * x[2 * strip.side[a] + d]).sum::<f64>();
            face.respond(strip.stiffness, step.touches(i), at(1) + depth, at(0), &step.formula).0.branch
        };
        self.strips.iter().flat_map(|s| s.points.iter().map(move |g| (s, g))).enumerate().map(point).collect()
    }

    #[expect(clippy::too_many_arguments)]
    fn add_cell(
        &self,
        index: usize,
        cell: &Cell,
        x: &[f64],
        step: &Step<'_>,
        tangent: bool,
        now: &mut [Past],
        eq: &mut Equations,
    ) -> Result<(), Failure> {
        let nodes = self.mesh.nodes.len();
        let unit = self.pressure_unit;
        let mut residual = [0.0; 15];
        let mut matrix = [[0.0; 15]; 15];
        for (k, g) in cell.points.iter().enumerate() {
            let mut f = [1.0, 0.0, 0.0, 1.0, 1.0];
            for a in 0..6 {
                let (ur, uz) = (x[2 * cell.nodes[a]], x[2 * cell.nodes[a] + 1]);
                f[0] += ur * g.gradient[a][0];
                f[1] += ur * g.gradient[a][1];
                f[2] += uz * g.gradient[a][0];
                f[3] += uz * g.gradient[a][1];
                f[4] += ur * g.shape[a] / g.radius;
            }
            let at = index * element::POINTS + k;
            let point = Point { last: &step.last.points[at], before: &step.before.points[at] };
            let r = self.laws.respond(&f, point, &step.formula, step.stiffening, &mut now[at])?;
            let p: [f64; 3] = std::array::from_fn(|q| unit * x[2 * nodes + cell.nodes[q]]);
            let local = Local::new(g, &f, &r, &p);
            local.add_residual(g, &r, step.formula.gamma, unit, &mut residual);
            if tangent {
                local.add_tangent(g, &r, step.formula.gamma, unit, &mut matrix);
            }
        }
        let unknowns = cell
            .nodes
            .iter()
            .flat_map(|&n| [2 * n, 2 * n + 1])
            .chain((0..3).map(|q| 2 * nodes + cell.nodes[q]));
        for (value, unknown) in residual.iter().zip(unknowns) {
            if let Some(e) = self.equation[unknown] {
                eq.residual[e] += value;
            }
        }
        if tangent {
            for (value, &place) in matrix.iter().flatten().zip(&self.places[index]) {
                if place != u32::MAX {
                    eq.tangent[place as usize] += value;
                }
            }
        }
        Ok(())
    }

    #[expect(clippy::too_many_arguments)]
    fn add_face(
        &self,
        face: Face,
        index: usize,
        strip: &Strip,
        x: &[f64],
        depth: f64,
        step: &Step<'_>,
        tangent: bool,
        now: &mut [Touch],
        eq: &mut Equations,
    ) {
        let nodes = self.mesh.nodes.len();
        let places = &self.places[self.cells.len() + index];
        for (k, g) in strip.points.iter().enumerate() {
            let at = |d: usize| (0..3).map(|a| g.shape[a] * x[2 * strip.side[a] + d]).sum::<f64>();
            let (last, before) = step.touches(3 * index + k);
            let (t, touch) =
                face.respond(strip.stiffness, (last, before), at(1) + depth, at(0), &step.formula);
            now[3 * index + k] = touch;
            eq.force += t.normal * g.weight;
            eq.force_by_depth += t.normal_slope * g.weight;
            for a in 0..3 {
                let w = g.shape[a] * g.weight;
                if let Some(e) = self.equation[2 * strip.side[a]] {
                    eq.residual[e] += t.radial * w;
                }
                if let Some(e) = self.equation[2 * strip.side[a] + 1] {
                    eq.residual[e] += t.normal * w;
                    eq.by_depth[e] += t.normal_slope * w;
                }
                for b in (0..3).filter(|_| tangent) {
                    let w = w * g.shape[b];
                    let mut add =
                        |row: usize, column: usize, value: f64| add_at(eq, places[8 * row + column], value);
                    add(2 * a, 2 * b, t.radial_slope * w);
                    add(2 * a + 1, 2 * b + 1, t.normal_slope * w);
                }
            }
            let permeance = if last.closed { self.face_permeance } else { self.open_permeance };
            if permeance > 0.0 {
                self.add_flux(strip, g, permeance * step.formula.gamma, x, places, tangent, nodes, eq);
            }
        }
    }

    fn add_drain(
        &self,
        index: usize,
        strip: &Strip,
        x: &[f64],
        step: &Step<'_>,
        tangent: bool,
        eq: &mut Equations,
    ) {
        let places = &self.places[self.cells.len() + self.strips.len() + index];
        for g in &strip.points {
            let outflow = strip.stiffness * step.formula.gamma;
            self.add_flux(strip, g, outflow, x, places, tangent, self.mesh.nodes.len(), eq);
        }
    }

    /// Outflow in proportion to the pore pressure, with the sign of the mass balance's residual.
    #[expect(clippy::too_many_arguments)]
    fn add_flux(
        &self,
        strip: &Strip,
        g: &SidePoint,
        outflow: f64,
        x: &[f64],
        places: &[u32],
        tangent: bool,
        nodes: usize,
        eq: &mut Equations,
    ) {
        let unit = self.pressure_unit;
        let pressure: f64 = (0..2).map(|q| g.linear[q] * x[2 * nodes + strip.side[q]]).sum();
        for q in 0..2 {
            let w = -unit * unit * outflow * g.weight * g.linear[q];
            if let Some(e) = self.equation[2 * nodes + strip.side[q]] {
                eq.residual[e] += w * pressure;
            }
            for s in (0..2).filter(|_| tangent) {
                add_at(eq, places[8 * (6 + q) + 6 + s], w * g.linear[s]);
            }
        }
    }
}

fn add_at(eq: &mut Equations, place: u32, value: f64) {
    if place != u32::MAX {
        eq.tangent[place as usize] += value;
    }
}

//! Tangents for tests and benches: linear poroelasticity, Q2 displacement and Q1 pressure, on tensor grids
//! graded towards a punch's edge; axisymmetric or three-dimensional.

use faer::sparse::{SparseColMat, Triplet};

/// What to assemble.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Elements along each axis; a last entry of 0 means axisymmetric (r, z).
    pub elements: [usize; 3],
    /// Permeability times step size; 0 (undrained) leaves the pressure block empty.
    pub permeability: f64,
    /// Relative size of a random unsymmetric disturbance of the displacement block.
    pub disturbance: f64,
}

/// An assembled tangent with the structure it came from.
pub struct System {
    pub unknowns: usize,
    pub elements: Vec<Vec<u32>>,
    pub centroids: Vec<[f64; 3]>,
    pub rank: Vec<u8>,
    pub matrix: SparseColMat<usize, f64>,
}

/// Shear modulus 1; first Lame constant of a nearly incompressible drained skeleton.
const LAME: f64 = 30.0;

/// Grid lines on [0, 1] that get closer by a constant factor towards 0.4 (the punch's edge).
fn graded(n: usize) -> Vec<f64> {
    let left = (n * 2).div_ceil(5).clamp(1, n);
    let ratio = 1.0 + 4.0 / n as f64;
    let side = |m: usize| -> Vec<f64> {
        let total: f64 = (0..m).map(|i| ratio.powi(i as i32)).sum();
        (0..=m).map(|k| (0..k).map(|i| ratio.powi(i as i32)).sum::<f64>() / total).collect()
    };
    let (near, far) = (side(left), side(n - left));
    let mut lines: Vec<f64> = near.iter().rev().map(|s| 0.4 * (1.0 - s)).collect();
    lines.extend(far.iter().skip(1).map(|s| 0.4 + 0.6 * s));
    if n == left {
        lines.iter_mut().for_each(|x| *x /= 0.4);
    }
    lines
}

/// Values and derivatives of the Q2 and Q1 shape functions in one direction, nodes at -1, 0, 1 and -1, 1.
fn shapes(x: f64) -> ([f64; 3], [f64; 3], [f64; 2], [f64; 2]) {
    let quadratic = [x * (x - 1.0) / 2.0, 1.0 - x * x, x * (x + 1.0) / 2.0];
    let slope = [x - 0.5, -2.0 * x, x + 0.5];
    (quadratic, slope, [(1.0 - x) / 2.0, (1.0 + x) / 2.0], [-0.5, 0.5])
}

/// Small reproducible random numbers in [-1, 1).
struct Random(u64);
impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

impl Case {
    /// Axisymmetric tangent of about this many unknowns.
    pub fn axisymmetric(unknowns: usize, permeability: f64) -> Self {
        let n = (unknowns as f64 / 9.0).sqrt().round() as usize;
        Self { elements: [n, n, 0], permeability, disturbance: 0.02 }
    }

    /// Three-dimensional tangent of about this many unknowns.
    pub fn solid(unknowns: usize, permeability: f64) -> Self {
        let n = ((unknowns as f64 / 25.0).cbrt() - 0.3).round() as usize;
        Self { elements: [n, n, n], permeability, disturbance: 0.02 }
    }

    /// Assembles the tangent.
    pub fn assemble(&self) -> System {
        let dim = if self.elements[2] == 0 { 2 } else { 3 };
        let n: Vec<usize> = self.elements[..dim].to_vec();
        let lines: Vec<Vec<f64>> = n.iter().map(|&n| graded(n)).collect();
        let flat = |index: &[usize], size: &dyn Fn(usize) -> usize| {
            (0..dim).rev().fold(0, |sum, d| sum * size(d) + index[d])
        };
        let digits = |mut i: usize, base: &dyn Fn(usize) -> usize| -> Vec<usize> {
            (0..dim)
                .map(|d| {
                    let digit = i % base(d);
                    i /= base(d);
                    digit
                })
                .collect()
        };
        let q2_size = |d: usize| 2 * n[d] + 1;
        let q1_size = |d: usize| n[d] + 1;
        let q2_nodes: usize = (0..dim).map(q2_size).product();
        let q1_nodes: usize = (0..dim).map(q1_size).product();
        let unknowns = dim * q2_nodes + q1_nodes;

        // Bottom and punch fixed, axis and sides sliding, free surface drained.
        let fixed: Vec<bool> = (0..unknowns)
            .map(|u| {
                if u < dim * q2_nodes {
                    let at = digits(u / dim, &q2_size);
                    let top = at[dim - 1] == 2 * n[dim - 1];
                    let punch = top && (0..dim - 1).all(|d| lines[d][at[d].div_ceil(2)] <= 0.41);
                    let component = u % dim;
                    let side = at[component] == 0 || at[component] == 2 * n[component];
                    at[dim - 1] == 0 || punch || (component < dim - 1 && side)
                } else {
                    let at = digits(u - dim * q2_nodes, &q1_size);
                    let punch = (0..dim - 1).all(|d| lines[d][at[d]] <= 0.41);
                    at[dim - 1] == n[dim - 1] && !punch
                }
            })
            .collect();

        let mut random = Random(1);
        let mut triplets = Vec::new();
        let (mut elements, mut centroids) = (Vec::new(), Vec::new());
        for cell in 0..n.iter().product() {
            let cell = digits(cell, &|d| n[d]);
            let mut local = Vec::new();
            for a in 0..3_usize.pow(dim as u32) {
                let at: Vec<usize> = digits(a, &|_| 3).iter().zip(&cell).map(|(i, c)| i + 2 * c).collect();
                local.extend((0..dim).map(|c| (flat(&at, &q2_size) * dim + c) as u32));
            }
            for a in 0..1 << dim {
                let at: Vec<usize> = digits(a, &|_| 2).iter().zip(&cell).map(|(i, c)| i + c).collect();
                local.push((dim * q2_nodes + flat(&at, &q1_size)) as u32);
            }
            let bounds: Vec<[f64; 2]> =
                (0..dim).map(|d| [lines[d][cell[d]], lines[d][cell[d] + 1]]).collect();
            let tangent = self.element(&bounds);
            for (i, &row) in local.iter().enumerate() {
                for (j, &column) in local.iter().enumerate() {
                    let (row, column) = (row as usize, column as usize);
                    let free = !fixed[row] && !fixed[column];
                    let displacement = row < dim * q2_nodes && column < dim * q2_nodes;
                    let noise = if displacement { 1.0 + self.disturbance * random.next() } else { 1.0 };
                    let value = if free { tangent[i * local.len() + j] * noise } else { 0.0 };
                    triplets.push(Triplet::new(
                        row,
                        column,
                        if row == column && !free { 1.0 } else { value },
                    ));
                }
            }
            let mut centroid = [0.0; 3];
            (0..dim).for_each(|d| centroid[d] = (bounds[d][0] + bounds[d][1]) / 2.0);
            centroids.push(centroid);
            elements.push(local);
        }
        let matrix =
            SparseColMat::try_new_from_triplets(unknowns, unknowns, &triplets).expect("valid indices");
        let rank = (0..unknowns).map(|u| u8::from(u >= dim * q2_nodes)).collect();
        System { unknowns, elements, centroids, rank, matrix }
    }

    /// Element tangent by rows: displacement unknowns (node by node), then pressures.
    fn element(&self, bounds: &[[f64; 2]]) -> Vec<f64> {
        let dim = bounds.len();
        let gauss = [(-0.6_f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6_f64.sqrt(), 5.0 / 9.0)];
        let (nodes, corners) = (3_usize.pow(dim as u32), 1 << dim);
        let size = dim * nodes + corners;
        let mut k = vec![0.0; size * size];
        for point in 0..nodes {
            let mut weight = 1.0;
            let mut one_dimensional = Vec::new();
            let mut scale = Vec::new();
            let mut radius = 1.0;
            let mut rest = point;
            for (d, b) in bounds.iter().enumerate() {
                let (x, w) = gauss[rest % 3];
                rest /= 3;
                one_dimensional.push(shapes(x));
                scale.push(2.0 / (b[1] - b[0]));
                weight *= w * (b[1] - b[0]) / 2.0;
                if d == 0 {
                    radius = b[0] + (x + 1.0) / 2.0 * (b[1] - b[0]);
                }
            }
            if dim == 2 {
                weight *= radius;
            }
            let product = |a: usize, base: usize, slope: Option<usize>| -> f64 {
                let mut a = a;
                let mut value = 1.0;
                for (d, (q, dq, l, dl)) in one_dimensional.iter().enumerate() {
                    let i = a % base;
                    a /= base;
                    let (f, df) = if base == 3 { (q[i], dq[i]) } else { (l[i], dl[i]) };
                    value *= if slope == Some(d) { df * scale[d] } else { f };
                }
                value
            };
            // Strain columns: tensor components (d, e) and, axisymmetric, the hoop strain.
            let gradient: Vec<Vec<f64>> =
                (0..nodes).map(|a| (0..dim).map(|d| product(a, 3, Some(d))).collect()).collect();
            let hoop: Vec<f64> =
                (0..nodes).map(|a| if dim == 2 { product(a, 3, None) / radius } else { 0.0 }).collect();
            let divergence = |a: usize, c: usize| gradient[a][c] + if c == 0 { hoop[a] } else { 0.0 };
            for (a, ga) in gradient.iter().enumerate() {
                for (b, gb) in gradient.iter().enumerate() {
                    let dot: f64 = ga.iter().zip(gb).map(|(x, y)| x * y).sum();
                    for c in 0..dim {
                        for e in 0..dim {
                            let mut value = LAME * divergence(a, c) * divergence(b, e) + ga[e] * gb[c];
                            if c == e {
                                value += dot;
                            }
                            if c == 0 && e == 0 {
                                value += 2.0 * hoop[a] * hoop[b];
                            }
                            k[(a * dim + c) * size + b * dim + e] += weight * value;
                        }
                    }
                }
                for b in 0..corners {
                    let pressure = product(b, 2, None);
                    for c in 0..dim {
                        let value = -weight * divergence(a, c) * pressure;
                        k[(a * dim + c) * size + dim * nodes + b] += value;
                        k[(dim * nodes + b) * size + a * dim + c] += value;
                    }
                }
            }
            for a in 0..corners {
                for b in 0..corners {
                    let dot: f64 = (0..dim).map(|d| product(a, 2, Some(d)) * product(b, 2, Some(d))).sum();
                    k[(dim * nodes + a) * size + dim * nodes + b] -= weight * self.permeability * dot;
                }
            }
        }
        k
    }
}

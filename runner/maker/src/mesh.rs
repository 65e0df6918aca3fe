//! Six-node triangles by longest-edge bisection (Rivara, 1984), as small as wanted at the punch's edge.

use crate::specimen::Geometry;
use std::collections::HashMap;

/// How fine the mesh is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fineness {
    /// Longest side of a triangle at the punch's edge, as a part of the punch's radius.
    pub edge: f64,
    /// Growth of the longest side with the distance from there.
    pub growth: f64,
    /// Longest side under the punch and near it, as a part of the punch's radius.
    pub near: f64,
}

impl Default for Fineness {
    fn default() -> Self {
        Self { edge: 0.008, growth: 0.5, near: 0.2 }
    }
}

/// A triangle's corners, counter-clockwise, then the midpoints of the sides 01, 12, 20.
pub type Triangle = [usize; 6];

/// Side of a triangle on the boundary: its ends, then its midpoint.
pub type Side = [usize; 3];

/// The meridian half-plane `0 <= r <= radius`, `-height <= z <= 0`.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// Nodes (r, z) (m); corners before midpoints.
    pub nodes: Vec<[f64; 2]>,
    /// Number of nodes that are corners; these carry a pressure.
    pub corners: usize,
    /// Triangles.
    pub triangles: Vec<Triangle>,
    /// Sides on the top within the punch's radius, from the axis outwards.
    pub face: Vec<Side>,
    /// Sides on the bottom.
    pub bottom: Vec<Side>,
    /// Sides on the lateral surface.
    pub lateral: Vec<Side>,
}

impl Mesh {
    /// Meshes a specimen.
    pub fn new(geometry: &Geometry, fineness: &Fineness) -> Self {
        let radius = geometry.punch_radius;
        let wanted = |at: [f64; 2]| {
            let from_edge = (at[0] - radius).hypot(at[1]) / radius;
            let size = fineness.edge + fineness.growth * from_edge;
            // Below and beside the punch the strain is large, further away it decays with the distance.
            let cap = fineness.near * (1.0 + (at[0].hypot(at[1]) / radius - 1.2).max(0.0));
            radius * size.min(cap)
        };
        let mut bisection = Bisection::coarse(geometry);
        while bisection.refine(&wanted) {}
        bisection.finish(geometry)
    }
}

/// Corners while they are refined.
struct Bisection {
    points: Vec<[f64; 2]>,
    triangles: Vec<[usize; 3]>,
}

/// A side by its ends, the same from both triangles.
fn key(a: usize, b: usize) -> (usize, usize) {
    (a.min(b), a.max(b))
}

fn middle(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
}

impl Bisection {
    /// Nearly square cells, cut along alternating diagonals; one line of cells ends at the punch's edge.
    fn coarse(geometry: &Geometry) -> Self {
        let radius = geometry.punch_radius;
        // Cells of the punch's radius; far away they grow.
        let lines = |from: f64, to: f64| {
            let mut ends = vec![from];
            let mut size = radius;
            while let Some(&last) = ends.last()
                && last < to
            {
                size = size.max(0.2 * last);
                let rest = ((to - last) / size).round().max(1.0);
                ends.push(if rest < 2.0 { to } else { last + (to - last) / rest });
            }
            ends
        };
        let mut r = vec![0.0];
        r.extend(lines(radius, geometry.sample_radius));
        let z: Vec<f64> = lines(0.0, geometry.sample_height).into_iter().map(|z| -z).collect();
        let at = |i: usize, j: usize| j * r.len() + i;
        let points: Vec<[f64; 2]> = z.iter().flat_map(|&z| r.iter().map(move |&r| [r, z])).collect();
        let mut triangles = Vec::new();
        for j in 0..z.len() - 1 {
            for i in 0..r.len() - 1 {
                let [a, b, c, d] = [at(i, j + 1), at(i + 1, j + 1), at(i + 1, j), at(i, j)];
                match (i + j) % 2 {
                    0 => triangles.extend([[a, b, c], [a, c, d]]),
                    _ => triangles.extend([[a, b, d], [b, c, d]]),
                }
            }
        }
        Self { points, triangles }
    }

    fn length(&self, a: usize, b: usize) -> f64 {
        let (p, q) = (self.points[a], self.points[b]);
        (p[0] - q[0]).hypot(p[1] - q[1])
    }

    /// Local number of the longest side, from corner `i` to the next; ties by the ends' numbers.
    fn longest(&self, t: &[usize; 3]) -> usize {
        let order = |i: usize| {
            let (a, b) = (t[i], t[(i + 1) % 3]);
            ((self.length(a, b) * 1e12).round(), key(a, b))
        };
        (1..3).fold(0, |best, i| if order(i) > order(best) { i } else { best })
    }

    /// One pass over all triangles that are too large; false when there is none.
    fn refine(&mut self, wanted: &impl Fn([f64; 2]) -> f64) -> bool {
        let mut marked: HashMap<(usize, usize), usize> = HashMap::new();
        for t in &self.triangles {
            let i = self.longest(t);
            let target = (0..3).map(|i| wanted(middle(self.points[t[i]], self.points[t[(i + 1) % 3]])));
            let target = target.fold(f64::INFINITY, f64::min);
            if self.length(t[i], t[(i + 1) % 3]) > target {
                marked.insert(key(t[i], t[(i + 1) % 3]), usize::MAX);
            }
        }
        if marked.is_empty() {
            return false;
        }
        // A triangle with a marked side is bisected along its longest one first, so that mark that one, too.
        loop {
            let before = marked.len();
            for t in &self.triangles {
                if (0..3).any(|i| marked.contains_key(&key(t[i], t[(i + 1) % 3]))) {
                    let i = self.longest(t);
                    marked.insert(key(t[i], t[(i + 1) % 3]), usize::MAX);
                }
            }
            if marked.len() == before {
                break;
            }
        }
        let mut sides: Vec<_> = marked.keys().copied().collect();
        sides.sort_unstable();
        for (a, b) in sides {
            marked.insert((a, b), self.points.len());
            self.points.push(middle(self.points[a], self.points[b]));
        }
        let mut todo = std::mem::take(&mut self.triangles);
        while let Some(t) = todo.pop() {
            let i = self.longest(&t);
            let [a, b, c] = [t[i], t[(i + 1) % 3], t[(i + 2) % 3]];
            match marked.get(&key(a, b)) {
                Some(&m) => todo.extend([[a, m, c], [m, b, c]]),
                None => self.triangles.push(t),
            }
        }
        true
    }

    /// Adds the midpoints and finds the boundary.
    fn finish(self, geometry: &Geometry) -> Mesh {
        let corners = self.points.len();
        let mut nodes = self.points;
        let mut midpoints: HashMap<(usize, usize), usize> = HashMap::new();
        let mut uses: HashMap<(usize, usize), usize> = HashMap::new();
        let mut triangles = Vec::with_capacity(self.triangles.len());
        for t in &self.triangles {
            let mut six = [t[0], t[1], t[2], 0, 0, 0];
            for i in 0..3 {
                let side = key(t[i], t[(i + 1) % 3]);
                six[3 + i] = *midpoints.entry(side).or_insert_with(|| {
                    nodes.push(middle(nodes[side.0], nodes[side.1]));
                    nodes.len() - 1
                });
                *uses.entry(side).or_default() += 1;
            }
            triangles.push(six);
        }
        let tiny = 1e-9 * geometry.sample_radius;
        let boundary = |wanted: &dyn Fn([f64; 2]) -> bool, along: usize| {
            let on = |&(&(a, b), &m): &(&(usize, usize), &usize)| uses[&(a, b)] == 1 && wanted(nodes[m]);
            let mut sides: Vec<Side> = midpoints.iter().filter(on).map(|(&(a, b), &m)| [a, b, m]).collect();
            for s in &mut sides {
                if nodes[s[0]][along] > nodes[s[1]][along] {
                    s.swap(0, 1);
                }
            }
            sides.sort_by(|a, b| nodes[a[2]][along].total_cmp(&nodes[b[2]][along]));
            sides
        };
        let face = boundary(&|x| x[1].abs() < tiny && x[0] < geometry.punch_radius, 0);
        let bottom = boundary(&|x| (x[1] + geometry.sample_height).abs() < tiny, 0);
        let lateral = boundary(&|x| (x[0] - geometry.sample_radius).abs() < tiny, 1);
        Mesh { corners, triangles, face, bottom, lateral, nodes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_fill_the_rectangle_and_meet_at_the_edge() {
        let geometry = Geometry { punch_radius: 2e-3, sample_radius: 10.3e-3, sample_height: 7.1e-3 };
        let mesh = Mesh::new(&geometry, &Fineness::default());
        let area: f64 = mesh
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = [0, 1, 2].map(|i| mesh.nodes[t[i]]);
                0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
            })
            .inspect(|&area| assert!(area > 0.0))
            .sum();
        assert!((area / (10.3e-3 * 7.1e-3) - 1.0).abs() < 1e-12);
        let length = |s: &Side| mesh.nodes[s[1]][0] - mesh.nodes[s[0]][0];
        assert!((mesh.face.iter().map(length).sum::<f64>() - 2e-3).abs() < 1e-12);
        assert!(mesh.face.last().map(length).unwrap() < 0.01 * 2e-3);
        println!("{} triangles, {} nodes", mesh.triangles.len(), mesh.nodes.len());
    }
}

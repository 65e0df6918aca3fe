//! Quadrilaterals of the parts of the mesh.

use super::grading::layers;
use super::presets::{Resolution, Zone};
use crate::mesh::parameters::GeometryParameters;

/// Corners (R, Z): lower left, lower right, upper left, upper right of the reference square.
pub type Quad = [[f64; 2]; 4];

/// Rectangles between grid lines, row by row; none is kept, so that they can be counted first.
pub fn tensor(radii: Vec<f64>, heights: Vec<f64>) -> impl Iterator<Item = Quad> {
    let columns = radii.len() - 1;
    (0..columns * (heights.len() - 1)).map(move |k| {
        let (r, z) = (&radii[k % columns..], &heights[k / columns..]);
        [[r[0], z[0]], [r[1], z[0]], [r[0], z[1]], [r[1], z[1]]]
    })
}

/// Square rings around the punch's edge, and a rectangular grid around them.
pub fn indentation(
    geometry: &GeometryParameters,
    resolution: &Resolution,
) -> impl Iterator<Item = Quad> + use<> {
    let (a, b, h) = (geometry.punch_radius, geometry.sample_radius, geometry.sample_height);
    let n = resolution.divisions;
    // Half-width of the largest ring: it must leave room on all sides.
    let half = (0.5 * a).min(0.5 * (b - a)).min(0.5 * h);
    let cell = half / n as f64;
    let line = |k: usize| a - half + k as f64 * cell;

    let inner = (((a - half) / (1.5 * cell)).ceil() as usize).max(1);
    let mut radii: Vec<f64> = (0..inner).map(|k| (a - half) * k as f64 / inner as f64).collect();
    radii.extend((0..2 * n).map(line));
    radii.push(a + half);
    radii.extend(layers(b - a - half, cell, resolution.outer_growth).into_iter().map(|x| a + half + x));
    let mut heights: Vec<f64> =
        layers(h - half, cell, resolution.outer_growth).into_iter().map(|x| h - half - x).rev().collect();
    heights[0] = 0.0;
    heights.extend((0..n).map(|k| h - half + k as f64 * cell));
    heights.push(h);

    let inside_rings = move |quad: &Quad| {
        let (r, z) = (0.5 * (quad[0][0] + quad[3][0]), 0.5 * (quad[0][1] + quad[3][1]));
        (r - a).abs() < half && z > h - half
    };
    let grid = tensor(radii, heights).filter(move |quad| !inside_rings(quad));
    grid.chain(rings([a, h], half, resolution))
}

/// A grid that is even where the contact's edge may run, `from` a radius up to the punch's, and coarsens away from there.
pub fn growing_contact(
    geometry: &GeometryParameters,
    from: f64,
    zone: &Zone,
) -> impl Iterator<Item = Quad> + use<> {
    let (a, b, h) = (geometry.punch_radius, geometry.sample_radius, geometry.sample_height);
    let elements = ((a - from) / zone.size).ceil().max(1.0);
    let inner = layers(from, zone.size, zone.growth).into_iter().rev();
    let mut radii: Vec<f64> = inner.map(|x| (from - x).max(0.0)).collect();
    if let Some(axis) = radii.first_mut() {
        *axis = 0.0;
    }
    radii.extend((0..=elements as usize).map(|k| from + (a - from) * k as f64 / elements));
    radii.extend(layers(b - a, zone.size, zone.growth).into_iter().map(|x| a + x));
    let mut heights: Vec<f64> = layers(h, zone.size, zone.growth).into_iter().map(|x| h - x).rev().collect();
    heights[0] = 0.0;
    heights.push(h);
    tensor(radii, heights)
}

/// A grid for a sample between two plates, fine towards its side and both plates.
///
/// At both rims its corner is a fan: where the side of a bonded sample folds over and lies down on the plate, the
/// right angle between them opens to a straight one, and every element takes only a slice of it.
pub fn platen(geometry: &GeometryParameters, zone: &Zone) -> impl Iterator<Item = Quad> + use<> {
    let (b, h) = (geometry.sample_radius, geometry.sample_height);
    // Distances from the rims, along the plates and along the side.
    let inwards = layers(b, zone.size, zone.growth);
    let along = layers(0.5 * h, zone.size, zone.growth);
    let cells = FAN.min(along.len()).min(inwards.len());
    let [across, up] = [&inwards, &along].map(|x| [&[0.0], &x[..cells]].concat());
    let fans = [fan([b, h], -1.0, &across, &up), fan([b, 0.0], 1.0, &across, &up)];
    let (width, height) = (across[cells], up[cells]);
    let in_fan = move |quad: &Quad| {
        let (r, z) = (0.5 * (quad[0][0] + quad[3][0]), 0.5 * (quad[0][1] + quad[3][1]));
        b - r < width && z.min(h - z) < height
    };
    let mut radii: Vec<f64> = inwards.into_iter().map(|x| b - x).rev().collect();
    radii[0] = 0.0;
    radii.push(b);
    let lower = std::iter::once(0.0).chain(along.iter().copied());
    let upper = along.iter().rev().skip(1).map(|x| h - x).chain([h]);
    let grid = tensor(radii, lower.chain(upper).collect()).filter(move |quad| !in_fan(quad));
    grid.chain(fans.into_iter().flatten())
}

/// Cells of the grid along either side of a fan.
const FAN: usize = 2;

/// Rings around a rim, the innermost collapsed to it, that replace the cells between lines at the distances `across`
/// and `along` the side, which runs upwards (1) or downwards (-1) from there.
fn fan(rim: [f64; 2], upwards: f64, across: &[f64], along: &[f64]) -> Vec<Quad> {
    let (width, height) = (across[across.len() - 1], along[along.len() - 1]);
    let inner = along.iter().map(|&z| [-width, upwards * z]);
    let far = across.iter().rev().skip(1).map(|&r| [-r, upwards * height]);
    let mut perimeter: Vec<[f64; 2]> = inner.chain(far).collect();
    if upwards > 0.0 {
        // Seen from the rim, the perimeter runs counter-clockwise.
        perimeter.reverse();
    }
    let point = |size: f64, d: [f64; 2]| [rim[0] + size * d[0], rim[1] + size * d[1]];
    let mut quads = Vec::new();
    for s in across.windows(2) {
        let (s, t) = (s[0] / width, s[1] / width);
        for d in perimeter.windows(2) {
            quads.push([point(s, d[0]), point(t, d[0]), point(s, d[1]), point(t, d[1])]);
        }
    }
    quads
}

/// Rings between half-squares around `edge`, the innermost collapsed to it.
fn rings(edge: [f64; 2], half: f64, resolution: &Resolution) -> impl Iterator<Item = Quad> + use<> {
    let n = resolution.divisions;
    // Directions of the perimeter's nodes: down the inner side, along the bottom, up the outer side.
    let at = |k: usize| -1.0 + k as f64 / n as f64;
    let perimeter: Vec<[f64; 2]> = (0..n)
        .map(|k| [-1.0, -(k as f64) / n as f64])
        .chain((0..2 * n).map(|k| [at(k), -1.0]))
        .chain((0..=n).map(|k| [1.0, at(k)]))
        .collect();
    let mut sizes = vec![0.0];
    sizes.extend(layers(half, resolution.edge_size, resolution.growth));
    let point = move |size: f64, d: [f64; 2]| [edge[0] + size * d[0], edge[1] + size * d[1]];
    let sides = perimeter.len() - 1;
    (0..sides * (sizes.len() - 1)).map(move |k| {
        let (s, d) = (&sizes[k / sides..], &perimeter[k % sides..]);
        // Seen from the edge, the perimeter runs counter-clockwise.
        [point(s[0], d[0]), point(s[1], d[0]), point(s[0], d[1]), point(s[1], d[1])]
    })
}

/// Signed area of a quadrilateral.
#[cfg(test)]
pub fn area(q: &Quad) -> f64 {
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    0.5 * (cross(q[0], q[1]) + cross(q[1], q[3]) + cross(q[3], q[2]) + cross(q[2], q[0]))
}

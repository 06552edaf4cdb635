//! How far two surfaces are from one another: the geometric error of a simplified mesh, measured as Metro does
//! [Cignoni1998], by the distances from points all over one surface to the nearest point of the other.

use super::Mesh;
use super::bvh::Bvh;
use glam::Vec3;
use rayon::prelude::*;

/// Triangles that are measured together: the sums do not depend on the number of threads.
const CHUNK: usize = 512;

/// Distances from the points of one surface to another surface, in one unit of length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Mean over the area.
    pub mean: f64,
    /// Root of the mean over the area of the squared distance.
    pub rms: f64,
    /// Largest distance of a sample or a vertex: the one-sided Hausdorff distance.
    pub max: f64,
}

impl Deviation {
    /// The same in the unit `length`.
    pub fn over(self, length: f64) -> Self {
        let Self { mean, rms, max } = self;
        Self { mean: mean / length, rms: rms / length, max: max / length }
    }
}

/// How far two meshes are from one another, in the unit of their coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// From the first mesh to the second.
    pub forward: Deviation,
    /// From the second to the first.
    pub backward: Deviation,
    /// The diagonal of the first mesh's bounding box, to compare with.
    pub diagonal: f64,
}

impl Distance {
    /// Both directions with equal weight, and the larger maximum: the Hausdorff distance.
    pub fn symmetric(&self) -> Deviation {
        let (a, b) = (self.forward, self.backward);
        Deviation {
            mean: 0.5 * (a.mean + b.mean),
            rms: (0.5 * (a.rms * a.rms + b.rms * b.rms)).sqrt(),
            max: a.max.max(b.max),
        }
    }
}

/// Measures two meshes, which [`Mesh::check`] has found good, at all their vertices and at `samples` points of
/// each, evenly spread over its area; where they move, as the shutter opens. Points are rounded to single
/// precision: the distance between equal meshes is not 0 but some 10⁻⁸ of the largest coordinate.
pub fn distance(a: &Mesh, b: &Mesh, samples: usize) -> Distance {
    let [bvh_a, bvh_b] = [a, b].map(|mesh| {
        let (positions, triangles) = (mesh.positions.clone(), mesh.triangles.clone());
        Bvh::new(&Mesh { positions, triangles, ..Mesh::default() })
    });
    let [least, most] = bvh_a.reach.map(Vec3::as_dvec3);
    Distance {
        forward: deviation(a, &bvh_b, samples),
        backward: deviation(b, &bvh_a, samples),
        diagonal: least.distance(most),
    }
}

fn deviation(from: &Mesh, to: &Bvh, samples: usize) -> Deviation {
    let ends = samples_before(from, samples);
    let chunks: Vec<[f64; 3]> = from
        .triangles
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(chunk, triangles)| {
            let first = chunk * CHUNK;
            let (mut sum, mut squares, mut largest) = (0.0, 0.0, 0.0_f64);
            let mut leaf = 0;
            for (&triangle, samples) in triangles.iter().zip(ends[first..].windows(2)) {
                let corners = from.corners(triangle, 0.0);
                for sample in samples[0]..samples[1] {
                    let squared = to.squared_distance(point(corners, sample), &mut leaf);
                    sum += squared.sqrt();
                    squares += squared;
                    largest = largest.max(squared);
                }
            }
            [sum, squares, largest]
        })
        .collect();
    let largest = used_vertices(from)
        .par_chunks(CHUNK)
        .map(|vertices| {
            let mut leaf = 0;
            let squared = |&vertex: &Vec3| to.squared_distance(vertex, &mut leaf);
            vertices.iter().map(squared).fold(0.0, f64::max)
        })
        .reduce(|| 0.0, f64::max);
    // In the order of the chunks, whichever was finished first.
    let [sum, squares, largest] = chunks.into_iter().fold([0.0, 0.0, largest], |all, chunk| {
        [all[0] + chunk[0], all[1] + chunk[1], all[2].max(chunk[2])]
    });
    let samples = samples as f64;
    Deviation { mean: sum / samples, rms: (squares / samples).sqrt(), max: largest.sqrt() }
}

/// How many samples come before each triangle, and all at the end. Sample k lies (k + ½)/samples of the area from
/// the beginning; where no triangle has an area, all count alike.
fn samples_before(mesh: &Mesh, samples: usize) -> Vec<usize> {
    let areas = mesh.triangles.iter().map(|&triangle| {
        let [a, b, c] = mesh.corners(triangle, 0.0).map(Vec3::as_dvec3);
        (b - a).cross(c - a).length()
    });
    let total: f64 = areas.clone().sum();
    let count = mesh.triangles.len() as f64;
    let mut before = 0.0;
    let shares = areas.map(|area| if total > 0.0 { area / total } else { 1.0 / count });
    let starts = shares.map(|share| {
        let start = before;
        before += share;
        ((start * samples as f64 + 0.5) as usize).min(samples)
    });
    starts.chain([samples]).collect()
}

/// The vertices that triangles need, neighbours near one another where the triangles are.
fn used_vertices(mesh: &Mesh) -> Vec<Vec3> {
    let mut is_new = vec![true; mesh.positions.len()];
    let vertices = mesh.triangles.as_flattened().iter().map(|&vertex| vertex as usize);
    vertices
        .filter(|&vertex| std::mem::replace(&mut is_new[vertex], false))
        .map(|vertex| mesh.positions[vertex])
        .collect()
}

/// Point `sample` of the sequence R₂ [Roberts2018], any stretch of which is spread evenly over the square, folded
/// into a triangle.
fn point([a, b, c]: [Vec3; 3], sample: usize) -> Vec3 {
    let [mut u, mut v] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3]
        .map(|step| (sample as f64 * step).fract());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    let [a, b, c] = [a, b, c].map(Vec3::as_dvec3);
    (a + u * (b - a) + v * (c - a)).as_vec3()
}

#[cfg(test)]
mod tests;

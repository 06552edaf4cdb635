//! Models that Shutterlab makes itself, by formulas: for experiments on simplification that need no files. They have
//! detail at several scales, along and across the motion, and 50,000 to a million faces.
//!
//! Sines and powers are those of `libm`, so that the models are the same bit for bit on every machine.

use crate::mesh::Mesh;
use crate::mesh::weld::weld;
use glam::DVec3;
use libm::{cos, pow, sin};
use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

/// The model called `name`, one of [`MADE`](shutterlab_stimuli::assets::MADE): about the origin, a few units wide.
pub fn model(name: &str) -> Option<Mesh> {
    let mesh = match name {
        "knot23" => knot([2, 3], [1200, 60], |u, v| 0.08 * sin(36.0 * u) + 0.05 * cos(6.0 * v)),
        "knot34" => knot([3, 4], [2400, 80], |u, v| 0.10 * sin(90.0 * u + 5.0 * v)),
        "knot52" => knot([5, 2], [3000, 48], |u, v| 0.12 * cos(8.0 * v) + 0.03 * sin(400.0 * u)),
        "knot37" => knot([3, 7], [2000, 64], |u, v| 0.08 * sin(60.0 * u) * cos(4.0 * v)),
        "bumps" => sphere(110, |n| 0.12 * waves(n, 5.0) + 0.04 * waves(n, 12.0)),
        "spikes" => {
            let points = spread(300);
            sphere(180, |n| 0.35 * spikes(n, &points, 900.0))
        }
        "fractal" => sphere(280, |n| fractal(n, 3.0, 6, 0.16)),
        "asteroid" => {
            let craters = spread(40);
            sphere(200, |n| fractal(n, 2.0, 5, 0.25) - 0.12 * spikes(n, &craters, 30.0))
        }
        "rings" => sphere(160, |n| 0.03 * sin(60.0 * n.y) + 0.05 * waves(n, 4.0)),
        "meridians" => sphere(160, |n| {
            let around = libm::atan2(n.z, n.x);
            0.04 * sin(48.0 * around) * (1.0 - n.y * n.y) + 0.05 * waves(n, 4.0)
        }),
        "gear12" => gear(12, 0.0, [960, 60]),
        "gear40" => gear(40, 0.0, [3200, 72]),
        "gear25" => gear(25, 0.5, [2000, 64]),
        "screw" => gear(9, 3.0, [900, 240]),
        "hills" => terrain(700, |p| fractal(p, 2.0, 7, 0.5)),
        "dunes" => terrain(400, |p| {
            let bent = 14.0 * (p.x + 0.15 * waves(p, 3.0));
            0.10 * sin(bent) + 0.012 * sin(8.0 * bent) + 0.1 * waves(p, 2.0)
        }),
        "ridge" => terrain(300, |p| 0.7 * libm::exp(-6.0 * p.z * p.z) + fractal(p, 4.0, 5, 0.15)),
        "comb" => comb(),
        "brush" => ball_of_hairs(700, 0.5, 0.1),
        "fringe" => fringe(),
        "hedgehog" => ball_of_hairs(1500, 0.3, 0.0),
        _ => return None,
    };
    Some(mesh)
}

/// Patches of a surface that are put together.
#[derive(Default)]
struct Patches(Mesh);

impl Patches {
    /// Adds the surface that (u, v) ↦ `at`, both from 0 to 1, is over so many cells, which comes back to its beginning
    /// where it is `closed`. Its outer side is that of ∂u × ∂v.
    fn add(&mut self, cells: [u32; 2], closed: [bool; 2], at: impl Fn(f64, f64) -> DVec3) {
        let first = self.0.positions.len() as u32;
        let [columns, rows] = [0, 1].map(|k| cells[k] + u32::from(!closed[k]));
        let part = |k: u32, of: u32| f64::from(k) / f64::from(of);
        for j in 0..rows {
            let points = (0..columns).map(|i| at(part(i, cells[0]), part(j, cells[1])).as_vec3());
            self.0.positions.extend(points);
        }
        for j in 0..cells[1] {
            for i in 0..cells[0] {
                let vertex = |i: u32, j: u32| first + j % rows * columns + i % columns;
                let [a, b] = [vertex(i, j), vertex(i + 1, j)];
                let [d, c] = [vertex(i, j + 1), vertex(i + 1, j + 1)];
                self.0.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }

    /// A hair from `root` to `tip`, thinner and thinner, that bends sideways by `bend` half way.
    fn add_hair(&mut self, root: DVec3, tip: DVec3, radius: f64, bend: DVec3) {
        let along = (tip - root).normalize();
        let across = along.any_orthonormal_vector();
        let aside = along.cross(across);
        self.add([7, 24], [true, false], |u, v| {
            let (sine, cosine) = libm::sincos(TAU * u);
            let ring = (across * cosine + aside * sine) * (radius * (1.0 - v));
            root.lerp(tip, v) + bend * sin(PI * v) + ring
        });
    }

    /// The patches, joined where they meet.
    fn mesh(self) -> Mesh {
        let (positions, places) = weld(&self.0.positions);
        let corners =
            self.0.triangles.iter().map(|face| face.map(|vertex| places[vertex as usize]));
        let triangles = corners.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        Mesh { positions, triangles, ..Mesh::default() }
    }
}

/// A tube along a torus knot that winds `turns` times about the axis z and through the hole; its radius is 0.4 plus
/// what `detail` says of the angles along and around it.
fn knot(turns: [u32; 2], cells: [u32; 2], detail: impl Fn(f64, f64) -> f64) -> Mesh {
    let [about, through] = turns.map(f64::from);
    let place = |u: f64| {
        let (sine, cosine) = libm::sincos(about * u);
        let (up, out) = libm::sincos(through * u);
        let outward = DVec3::new(cosine, sine, 0.0);
        let normal = outward * out + DVec3::Z * up;
        (outward * 2.0 + normal, normal)
    };
    let mut patches = Patches::default();
    patches.add(cells, [true, true], |u, v| {
        let (u, v) = (TAU * u, TAU * v);
        let (centre, normal) = place(u);
        let along = (place(u + 1e-5).0 - place(u - 1e-5).0).normalize();
        let (sine, cosine) = libm::sincos(v);
        centre + (normal * cosine + normal.cross(along) * sine) * (0.4 + detail(u, v))
    });
    patches.mesh()
}

/// A sphere of radius 1, higher by `height` in each direction, over the six sides of a cube.
fn sphere(cells: u32, height: impl Fn(DVec3) -> f64) -> Mesh {
    let mut patches = Patches::default();
    for side in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
        // The sides meet in the same points, to the last bit.
        let u_axis = DVec3::new(side.y, side.z, side.x).abs();
        let v_axis = side.cross(u_axis);
        patches.add([cells; 2], [false; 2], |u, v| {
            let [u, v] = [u, v].map(|part| libm::tan(0.25 * PI * (2.0 * part - 1.0)));
            let direction = (side + u_axis * u + v_axis * v).normalize();
            direction * (1.0 + height(direction))
        });
    }
    patches.mesh()
}

/// A wheel about the axis z with a bore, whose teeth turn by `helix` of their pitch from one side to the other.
fn gear(teeth: u32, helix: f64, cells: [u32; 2]) -> Mesh {
    let mut patches = Patches::default();
    let teeth = f64::from(teeth);
    patches.add(cells, [true, true], |u, v| {
        // About a rectangle: rim, side, bore, side.
        let (around, part) = (4.0 * v, libm::modf(4.0 * v).0);
        let [rim, bore] = [1.0, 0.35];
        let (radius, z) = match around as u32 {
            0 => (rim, -0.3 + 0.6 * part),
            1 => (rim + (bore - rim) * part, 0.3),
            2 => (bore, 0.3 - 0.6 * part),
            _ => (bore + (rim - bore) * part, -0.3),
        };
        let phase = TAU * (teeth * u + helix * z / 0.6);
        let tooth = 0.5 + 0.5 * (4.0 * sin(phase)).clamp(-1.0, 1.0);
        let outside = pow((radius - bore) / (rim - bore), 8.0);
        // Spokes and grooves on the sides.
        let groove = 0.04 * sin(20.0 * radius) * sin(PI * (radius - bore) / (rim - bore));
        let (sine, cosine) = libm::sincos(TAU * u);
        let radius = radius + 1.6 / teeth * tooth * outside;
        DVec3::new(radius * cosine, radius * sine, z + groove * z.signum())
    });
    patches.mesh()
}

/// Land of side 2, tilted towards who looks along −z.
fn terrain(cells: u32, height: impl Fn(DVec3) -> f64) -> Mesh {
    let mut patches = Patches::default();
    let (sine, cosine) = libm::sincos(PI / 3.6);
    patches.add([cells; 2], [false; 2], |u, v| {
        let [x, z] = [2.0 * u - 1.0, 1.0 - 2.0 * v];
        let y = 0.5 * height(DVec3::new(x, 0.0, z));
        DVec3::new(x, y * cosine - z * sine, y * sine + z * cosine)
    });
    patches.mesh()
}

/// A bar with three rows of straight hairs.
fn comb() -> Mesh {
    let mut patches = Patches::default();
    patches.add([160, 24], [false, true], |u, v| {
        let (sine, cosine) = libm::sincos(TAU * v);
        // The ends are closed.
        let thick = 0.12 * (1.0 - pow(2.0 * u - 1.0, 24.0));
        DVec3::new(2.0 * u - 1.0, 0.8 + thick * sine, thick * cosine)
    });
    for k in 0..240 {
        let x = -0.95 + 1.9 * f64::from(k / 3) / 79.0;
        let z = 0.06 * f64::from(k % 3 - 1);
        let root = DVec3::new(x, 0.75, z);
        patches.add_hair(root, root - DVec3::Y * 1.5, 0.008, DVec3::ZERO);
    }
    patches.mesh()
}

/// Long hairs that hang down in waves.
fn fringe() -> Mesh {
    let mut patches = Patches::default();
    for k in 0..500 {
        let along = f64::from(k) / 499.0;
        let bend = DVec3::new(0.12 * sin(37.0 * along), 0.0, 0.12 * cos(53.0 * along));
        let root = DVec3::new(2.0 * along - 1.0, 0.8 + 0.05 * sin(91.0 * along), 0.0);
        let tip = DVec3::new(root.x + 0.1 * sin(19.0 * along), -0.8, 0.1 * cos(71.0 * along));
        patches.add_hair(root, tip, 0.01, bend);
    }
    patches.mesh()
}

/// A sphere of radius ½ with hairs all over, longer by `length`.
fn ball_of_hairs(hairs: u32, length: f64, bend: f64) -> Mesh {
    let mut patches = Patches(sphere(48, |n| 0.05 * waves(n, 6.0) - 0.5));
    for (k, direction) in (0..).zip(spread(hairs)) {
        let longer = length * (0.8 + 0.2 * sin(7.0 * f64::from(k)));
        let aside = direction.any_orthonormal_vector() * bend;
        patches.add_hair(direction * 0.45, direction * (0.5 + longer), 0.012, aside);
    }
    patches.mesh()
}

/// So many directions, spread evenly over the sphere, along a spiral.
fn spread(count: u32) -> Vec<DVec3> {
    let golden_angle = PI * (3.0 - 5.0f64.sqrt());
    let direction = |k: u32| {
        let height = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
        let radius = (1.0 - height * height).sqrt();
        let (sine, cosine) = libm::sincos(golden_angle * f64::from(k));
        DVec3::new(radius * cosine, height, radius * sine)
    };
    (0..count).map(direction).collect()
}

/// Eight plane waves in directions that are spread evenly, about −1 to 1.
fn waves(at: DVec3, frequency: f64) -> f64 {
    static DIRECTIONS: LazyLock<Vec<DVec3>> = LazyLock::new(|| spread(8));
    let wave = |(k, direction): (u32, &DVec3)| {
        sin(frequency * direction.dot(at) + 2.4 * f64::from(k) + frequency)
    };
    (0..).zip(DIRECTIONS.iter()).map(wave).sum::<f64>() / 3.0
}

/// Waves in `octaves`, each half as high as the one before.
fn fractal(at: DVec3, frequency: f64, octaves: i32, amplitude: f64) -> f64 {
    let octave = |k: i32| pow(0.5, k.into()) * waves(at, frequency * pow(2.1, k.into()));
    amplitude * (0..octaves).map(octave).sum::<f64>()
}

/// Spikes of height 1 at `points`, the narrower the more `sharpness`.
fn spikes(at: DVec3, points: &[DVec3], sharpness: f64) -> f64 {
    let nearest = points.iter().map(|point| point.dot(at)).fold(-1.0, f64::max);
    libm::exp(sharpness * (nearest - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::topology::Topology;
    use shutterlab_stimuli::assets::MADE;

    /// Each is there, of the size that is promised, and no triangle has a corner twice; what is closed is so, outside out.
    #[test]
    fn every_model_is_made() {
        for name in MADE {
            let mesh = model(name).unwrap();
            mesh.check(name).unwrap();
            let faces = mesh.triangles.len();
            assert!((50_000..=1_000_000).contains(&faces), "{name}: {faces}");
            assert!(mesh.triangles.iter().all(|[a, b, c]| a != b && b != c && c != a), "{name}");
            let (_, radius) = mesh.bounding_sphere();
            assert!((0.5..4.0).contains(&radius), "{name}: {radius}");
            let volume: f64 = mesh
                .triangles
                .iter()
                .map(|&triangle| mesh.corners(triangle, 0.0).map(|p| p.as_dvec3()))
                .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
                .sum();
            let borders = Topology::of(&mesh).border_edges;
            let open = ["hills", "dunes", "ridge", "comb", "brush", "fringe", "hedgehog"];
            if open.contains(&name) {
                assert!(borders > 0, "{name}");
            } else {
                assert!(borders == 0 && volume > 0.0, "{name}: {borders} {volume}");
            }
        }
        assert_eq!(model("knot"), None);
    }
}

//! Quadrics: the sum of squared distances to planes as a function of the place [GarlandHeckbert1997].
//!
//! A quadric is kept relative to its vertex. Its numbers are then of the size of the edges about the
//! vertex, whatever the size and place of the mesh, so that single precision is enough to store them; sums
//! and solutions are computed in double precision.

use glam::{DVec3, Vec3};

/// E(x) = xᵀA x + 2 bᵀx + c, with x relative to the vertex that it belongs to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quadric {
    /// A: xx, yy, zz, xy, xz, yz.
    a: [f32; 6],
    b: [f32; 3],
    c: f32,
}

/// The sum of quadrics relative to one place, while a contraction is considered.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sum {
    a: [f64; 6],
    b: DVec3,
    c: f64,
}

/// How much a solution is drawn towards its guess, as a part of the sum of the weights: enough that a flat
/// piece, whose planes leave the place open, has one.
pub const STIFFNESS: f64 = 1e-5;

impl Quadric {
    /// Adds `weight` times the squared distance to the plane through the vertex with the unit normal `normal`.
    pub fn add_plane(&mut self, normal: Vec3, weight: f32) {
        let Vec3 { x, y, z } = normal;
        let plane = [x * x, y * y, z * z, x * y, x * z, y * z];
        self.a.iter_mut().zip(plane).for_each(|(sum, value)| *sum += weight * value);
    }
}

impl Sum {
    /// Adds `quadric`, whose vertex is at `at`, relative to the place of this sum.
    #[inline]
    pub fn add(&mut self, quadric: &Quadric, at: DVec3) {
        let a = quadric.a.map(f64::from);
        let b = DVec3::new(quadric.b[0].into(), quadric.b[1].into(), quadric.b[2].into());
        self.a.iter_mut().zip(a).for_each(|(sum, value)| *sum += value);
        // E(x − at) = xᵀA x + 2 (b − A at)ᵀx + c − 2 bᵀat + atᵀA at.
        let shifted = times(&a, at);
        self.b += b - shifted;
        self.c += f64::from(quadric.c) + at.dot(shifted) - 2.0 * b.dot(at);
    }

    /// Adds the sum of quadrics relative to the same place.
    pub fn add_sum(&mut self, other: &Self) {
        self.a.iter_mut().zip(other.a).for_each(|(sum, value)| *sum += value);
        self.b += other.b;
        self.c += other.c;
    }

    /// Adds 2 bᵀx + c.
    pub fn add_linear(&mut self, b: DVec3, c: f64) {
        self.b += b;
        self.c += c;
    }

    /// Subtracts (gᵀx + d)² / weight.
    pub fn subtract_square(&mut self, g: DVec3, d: f64, weight: f64) {
        let DVec3 { x, y, z } = g;
        let products = [x * x, y * y, z * z, x * y, x * z, y * z];
        self.a.iter_mut().zip(products).for_each(|(sum, value)| *sum -= value / weight);
        self.b -= d * g / weight;
        self.c -= d * d / weight;
    }

    /// The sum of the weights of the planes, as their normals have length 1.
    #[inline]
    pub fn weight(&self) -> f64 {
        self.a[0] + self.a[1] + self.a[2]
    }

    /// E at `x`, not below 0.
    #[inline]
    pub fn error(&self, x: DVec3) -> f64 {
        (x.dot(times(&self.a, x)) + 2.0 * self.b.dot(x) + self.c).max(0.0)
    }

    /// Where E is least, drawn towards `guess` by `stiffness`, from 0 to 1, in the directions that the planes leave
    /// open; nothing if there are no planes.
    #[inline]
    pub fn minimum(&self, guess: DVec3, stiffness: f64) -> Option<DVec3> {
        let own = stiffness * self.weight();
        let [xx, yy, zz, xy, xz, yz] = self.a.map(|value| (1.0 - stiffness) * value);
        let (xx, yy, zz) = (xx + own, yy + own, zz + own);
        let right = -(self.b + times(&self.a, guess));
        // The inverse by its cofactors: A is semidefinite and the stiffness above 0, so it has one.
        let [c_xx, c_yy, c_zz] = [yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy];
        let [c_xy, c_xz, c_yz] = [xz * yz - xy * zz, xy * yz - xz * yy, xy * xz - xx * yz];
        let determinant = xx * c_xx + xy * c_xy + xz * c_xz;
        let solution = guess + times(&[c_xx, c_yy, c_zz, c_xy, c_xz, c_yz], right) / determinant;
        solution.is_finite().then_some(solution)
    }

    /// The quadric of a vertex at `at`.
    pub fn quadric(&self, at: DVec3) -> Quadric {
        Quadric {
            a: self.a.map(|value| value as f32),
            b: (self.b + times(&self.a, at)).as_vec3().to_array(),
            c: self.error(at) as f32,
        }
    }
}

/// A x.
#[inline]
fn times(a: &[f64; 6], x: DVec3) -> DVec3 {
    let [xx, yy, zz, xy, xz, yz] = *a;
    DVec3::new(
        xx * x.x + xy * x.y + xz * x.z,
        xy * x.x + yy * x.y + yz * x.z,
        xz * x.x + yz * x.y + zz * x.z,
    )
}

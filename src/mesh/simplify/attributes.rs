//! Normals and texture coordinates at the wedges of a surface, and their quadrics [Hoppe1999].
//!
//! Over each triangle an attribute s is linear in the place x. The squared difference to that, summed over
//! the triangles about a wedge and weighted by their areas, is quadratic in x and s. Given x, the best s
//! follows, so that what is left is a quadric of the place alone, to be added to that of the surface.

use super::quadric::{Quadric, Sum};
use crate::mesh::{MAX_COORDINATE, Mesh};
use glam::{DVec3, Vec2, Vec3};

/// Three of the normal, two of the texture coordinates.
const COUNT: usize = 5;

/// The values at a wedge, each as long as it matters beside a distance, in units of the surface.
pub type Values = [f32; COUNT];

/// How far a surface has to go, in diagonals of its bounding box, for an error as large as that of a normal
/// which is wrong by its length.
const NORMAL_LENGTH: f32 = 0.01;

/// The same for texture coordinates that are wrong by the whole picture.
const TEXTURE_LENGTH: f32 = 0.1;

/// How attributes become values.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    normal: f32,
    texture: f32,
}

impl Scale {
    /// For a surface whose bounding box has the diagonal `diagonal`, in units of the surface.
    pub fn new(mesh: &Mesh, diagonal: f32) -> Self {
        let length = |is_there, length: f32| if is_there { length * diagonal } else { 0.0 };
        Self {
            normal: length(mesh.normals.is_some(), NORMAL_LENGTH),
            texture: length(mesh.texture_coordinates.is_some(), TEXTURE_LENGTH),
        }
    }

    /// Carries no normals.
    pub fn drop_normals(&mut self) {
        self.normal = 0.0;
    }

    /// Whether there are normals.
    pub fn has_normals(&self) -> bool {
        self.normal > 0.0
    }

    /// Whether there are texture coordinates.
    pub fn has_texture(&self) -> bool {
        self.texture > 0.0
    }

    /// Whether there is anything.
    pub fn has_values(&self) -> bool {
        self.has_normals() || self.has_texture()
    }

    /// The values of a vertex.
    pub fn values(&self, mesh: &Mesh, vertex: usize) -> Values {
        let normal = mesh.normals.as_ref().map_or(Vec3::ZERO, |normals| normals[vertex]);
        let texture = mesh.texture_coordinates.as_ref().map_or(Vec2::ZERO, |list| list[vertex]);
        let (normal, texture) = (normal.normalize_or_zero() * self.normal, texture * self.texture);
        [normal.x, normal.y, normal.z, texture.x, texture.y]
    }

    /// The unit normal and the texture coordinates of values.
    pub fn attributes(&self, values: &Values) -> (Vec3, Vec2) {
        let [x, y, z, u, v] = *values;
        let texture = if self.texture > 0.0 { Vec2::new(u, v) / self.texture } else { Vec2::ZERO };
        let most = Vec2::splat(MAX_COORDINATE);
        let texture = texture.clamp(-most, most);
        (Vec3::new(x, y, z).normalize_or_zero(), texture)
    }
}

/// The sum of squared differences of a wedge's values, relative to its place and values:
/// `place`(x) + Σ (weight·s² − 2 s (g·x + d)).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AttributeQuadric {
    place: Quadric,
    weight: f32,
    gradients: [Vec3; COUNT],
    differences: [f32; COUNT],
}

/// The sum of such, relative to one place and one set of values.
#[derive(Clone, Copy, Debug, Default)]
pub struct AttributeSum {
    place: Sum,
    weight: f64,
    gradients: [DVec3; COUNT],
    differences: [f64; COUNT],
}

impl AttributeQuadric {
    /// Adds a triangle with a corner at the wedge and the others at `edges` from there, whose values differ
    /// by `differences` from those of the wedge.
    pub fn add_triangle(&mut self, edges: [Vec3; 2], differences: [Values; 2]) {
        let normal = edges[0].cross(edges[1]);
        let (weight, squared) = (normal.length(), normal.length_squared());
        if squared == 0.0 {
            return;
        }
        let basis = [edges[1].cross(normal) / squared, normal.cross(edges[0]) / squared];
        self.weight += weight;
        for attribute in 0..COUNT {
            let [b, c] = differences.map(|values| values[attribute]);
            let gradient = basis[0] * b + basis[1] * c;
            self.gradients[attribute] += weight * gradient;
            self.place.add_plane(gradient, weight);
        }
    }
}

impl AttributeSum {
    /// Adds the quadric of a wedge that is at `at` and has `values`, both relative to this sum's.
    pub fn add(&mut self, quadric: &AttributeQuadric, at: DVec3, values: [f64; COUNT]) {
        self.place.add(&quadric.place, at);
        let weight = f64::from(quadric.weight);
        self.weight += weight;
        for (attribute, value) in values.into_iter().enumerate() {
            let gradient = quadric.gradients[attribute].as_dvec3();
            let difference = f64::from(quadric.differences[attribute]) - gradient.dot(at);
            self.gradients[attribute] += gradient;
            self.differences[attribute] += difference + weight * value;
            self.place.add_linear(gradient * value, value * (2.0 * difference + weight * value));
        }
    }

    /// What the values cost that are best at each place, as a function of the place.
    pub fn best(&self) -> Sum {
        let mut sum = self.place;
        if self.weight > 0.0 {
            for (gradient, difference) in self.gradients.iter().zip(self.differences) {
                sum.subtract_square(*gradient, difference, self.weight);
            }
        }
        sum
    }

    /// What the sum's own values cost at each place.
    pub fn here(&self) -> Sum {
        self.place
    }

    /// The best values at `x`.
    pub fn values(&self, x: DVec3) -> [f64; COUNT] {
        std::array::from_fn(|attribute| match self.weight {
            0.0 => 0.0,
            weight => (self.gradients[attribute].dot(x) + self.differences[attribute]) / weight,
        })
    }

    /// The quadric of a wedge at this place with these values.
    pub fn quadric(&self) -> AttributeQuadric {
        AttributeQuadric {
            place: self.place.quadric(DVec3::ZERO),
            weight: self.weight as f32,
            gradients: self.gradients.map(|gradient| gradient.as_vec3()),
            differences: self.differences.map(|difference| difference as f32),
        }
    }
}

/// a − b, in double precision.
pub fn difference(a: &Values, b: &Values) -> [f64; COUNT] {
    std::array::from_fn(|attribute| f64::from(a[attribute]) - f64::from(b[attribute]))
}

/// a + b.
pub fn sum(a: &Values, b: [f64; COUNT]) -> Values {
    std::array::from_fn(|attribute| (f64::from(a[attribute]) + b[attribute]) as f32)
}

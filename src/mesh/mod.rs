//! Indexed triangle meshes whose vertices may move while the shutter is open, each along a straight
//! line, and the hierarchy that rays search them with.

pub mod bvh;
pub mod distance;
pub mod ray;
pub mod simplify;
pub mod topology;
pub mod upload;
pub mod weld;

use glam::{Vec2, Vec3};

/// WGSL twin of [`bvh`] and [`ray`].
pub const BVH_WGSL: &str = include_str!("bvh.wgsl");

/// Most vertices, and most triangles, of a mesh: a few gigabytes with their hierarchy, and well within
/// what 32-bit indices count.
pub const MAX_ELEMENTS: usize = 1 << 26;

/// Largest coordinate, in metres: volumes and determinants of such lengths stay finite in an `f32`.
pub const MAX_COORDINATE: f32 = 1e9;

/// Triangles over shared vertices. Metres, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertices; as the shutter opens, if they move.
    pub positions: Vec<Vec3>,
    /// Where the vertices are as the shutter closes, if they move. In between they move linearly.
    pub end_positions: Option<Vec<Vec3>>,
    /// Shading normal per vertex, of any length. Zero stands for the normal of the face.
    pub normals: Option<Vec<Vec3>>,
    /// Texture coordinates per vertex, v upwards from the lower edge of the picture.
    pub texture_coordinates: Option<Vec<Vec2>>,
    /// Three vertices each. Triangles without area are allowed.
    pub triangles: Vec<[u32; 3]>,
}

/// A mesh cannot be used. Each message names the file, the field, the value and what was allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// Too few or too many of something.
    #[error("{file}: {field}: {count}: {allowed} are allowed")]
    Count {
        /// The file.
        file: String,
        /// What was counted.
        field: &'static str,
        /// How many there are.
        count: usize,
        /// How many there may be.
        allowed: String,
    },
    /// A number that is not finite or too large.
    #[error("{file}: {field} of vertex {vertex}: {value}: {allowed}")]
    Vertex {
        /// The file.
        file: String,
        /// What the number is.
        field: &'static str,
        /// The vertex, from 0.
        vertex: usize,
        /// Its value.
        value: String,
        /// What was allowed.
        allowed: String,
    },
    /// A triangle of a vertex that there is not.
    #[error("{file}: triangle {triangle}: vertex {vertex}: vertices 0 to {last} are allowed")]
    Index {
        /// The file.
        file: String,
        /// The triangle, from 0.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// The last vertex.
        last: usize,
    },
}

impl Mesh {
    /// The vertices of triangle `triangle` at `time`, which runs from 0 as the shutter opens to 1 as it
    /// closes.
    pub fn corners(&self, triangle: [u32; 3], time: f32) -> [Vec3; 3] {
        let start = triangle.map(|vertex| self.positions[vertex as usize]);
        match &self.end_positions {
            None => start,
            Some(end) => std::array::from_fn(|corner| {
                between(start[corner], end[triangle[corner] as usize], time)
            }),
        }
    }

    /// The vertices at `time`, as [`Mesh::corners`] has them.
    pub fn vertices_at(&self, time: f32) -> impl Iterator<Item = Vec3> {
        (0..self.positions.len()).map(move |vertex| match &self.end_positions {
            None => self.positions[vertex],
            Some(end) => between(self.positions[vertex], end[vertex], time),
        })
    }

    /// The corners of the bounding box, as the shutter opens.
    pub fn bounds(&self) -> [Vec3; 2] {
        [Vec3::min, Vec3::max]
            .map(|of| self.positions.iter().copied().reduce(of).unwrap_or_default())
    }

    /// The diagonal of the bounding box, as the shutter opens.
    pub fn diagonal(&self) -> f32 {
        let [min, max] = self.bounds();
        min.distance(max)
    }

    /// The unit normal of each vertex as the shutter opens: the mean of the normals around it, weighted by the
    /// areas of their faces. Zero where no face with an area is.
    pub fn area_weighted_normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::ZERO; self.positions.len()];
        for &triangle in &self.triangles {
            let [a, b, c] = self.corners(triangle, 0.0);
            let twice_area = (b - a).cross(c - a);
            triangle.iter().for_each(|&vertex| normals[vertex as usize] += twice_area);
        }
        normals.iter().map(|normal| normal.normalize_or_zero()).collect()
    }

    /// The middle of the bounding box and the distance of the farthest vertex from it, as the shutter opens.
    pub fn bounding_sphere(&self) -> (Vec3, f32) {
        let [min, max] = self.bounds();
        let middle = 0.5 * (min + max);
        let squares = self.positions.iter().map(|p| p.distance_squared(middle));
        (middle, squares.fold(0.0, f32::max).sqrt())
    }

    /// Checks what all users of a mesh rely on; `file` is where it came from.
    ///
    /// # Errors
    /// No triangle, too many vertices or triangles, a list per vertex of another length than
    /// the positions, an index out of range, or a number that is not finite or too large.
    pub fn check(&self, file: &str) -> Result<(), MeshError> {
        let vertices = self.positions.len();
        let count = |field, count, range: std::ops::RangeInclusive<usize>| {
            if range.contains(&count) {
                return Ok(());
            }
            let allowed = match (range.start(), range.end()) {
                (low, high) if low == high => low.to_string(),
                (low, high) => format!("{low} to {high}"),
            };
            Err(MeshError::Count { file: file.into(), field, count, allowed })
        };
        count("vertices", vertices, 1..=MAX_ELEMENTS)?;
        count("triangles", self.triangles.len(), 1..=MAX_ELEMENTS)?;
        for (field, list) in [
            ("positions at the shutter's closing", self.end_positions.as_ref().map(Vec::len)),
            ("normals", self.normals.as_ref().map(Vec::len)),
            ("texture coordinates", self.texture_coordinates.as_ref().map(Vec::len)),
        ] {
            count(field, list.unwrap_or(vertices), vertices..=vertices)?;
        }

        let outside = |value: f32| value.is_nan() || value.abs() > MAX_COORDINATE;
        let vectors = |field, list: &[Vec3]| match list
            .iter()
            .position(|vector| vector.to_array().into_iter().any(outside))
        {
            None => Ok(()),
            Some(vertex) => Err(bad_vertex(file, field, vertex, &list[vertex])),
        };
        vectors("position", &self.positions)?;
        vectors("position at the shutter's closing", self.end_positions.as_deref().unwrap_or(&[]))?;
        vectors("normal", self.normals.as_deref().unwrap_or(&[]))?;
        let coordinates = self.texture_coordinates.as_deref().unwrap_or(&[]);
        if let Some(vertex) = coordinates.iter().position(|at| outside(at.x) || outside(at.y)) {
            return Err(bad_vertex(file, "texture coordinate", vertex, &coordinates[vertex]));
        }

        for (triangle, indices) in self.triangles.iter().enumerate() {
            if let Some(&vertex) = indices.iter().find(|&&vertex| vertex as usize >= vertices) {
                let (file, last) = (file.into(), vertices - 1);
                return Err(MeshError::Index { file, triangle, vertex, last });
            }
        }
        Ok(())
    }
}

fn bad_vertex(
    file: &str,
    field: &'static str,
    vertex: usize,
    value: &dyn std::fmt::Display,
) -> MeshError {
    MeshError::Vertex {
        file: file.into(),
        field,
        vertex,
        value: value.to_string(),
        allowed: format!("numbers from -{MAX_COORDINATE:e} to {MAX_COORDINATE:e} are allowed"),
    }
}

/// Linear interpolation. In this form each product and the sum round monotonically, so that a box's
/// corner never passes a vertex on its way, not even by a rounding error.
fn between<V>(start: V, end: V, time: f32) -> V
where
    V: std::ops::Mul<f32, Output = V> + std::ops::Add<Output = V>,
{
    start * (1.0 - time) + end * time
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2], [2, 2, 0]],
            ..Mesh::default()
        }
    }

    fn message(change: impl Fn(&mut Mesh)) -> String {
        let mut mesh = mesh();
        change(&mut mesh);
        mesh.check("a.ply").unwrap_err().to_string()
    }

    #[test]
    fn a_mesh_with_a_degenerate_triangle_passes() {
        let full = Mesh {
            end_positions: Some(vec![Vec3::ONE; 3]),
            normals: Some(vec![Vec3::ZERO; 3]),
            texture_coordinates: Some(vec![Vec2::ONE; 3]),
            ..mesh()
        };
        assert_eq!(full.check("a.ply"), Ok(()));
    }

    #[test]
    fn errors_name_file_field_value_and_what_was_allowed() {
        for (found, expected) in [
            (message(|m| m.triangles.clear()), "triangles: 0: 1 to 67108864 are allowed"),
            (message(|m| m.positions.clear()), "vertices: 0: 1 to 67108864 are allowed"),
            (message(|m| m.normals = Some(vec![])), "normals: 0: 3 are allowed"),
            (
                message(|m| m.end_positions = Some(vec![Vec3::ZERO; 4])),
                "positions at the shutter's closing: 4: 3 are allowed",
            ),
            (
                message(|m| m.triangles[1] = [0, 3, 1]),
                "triangle 1: vertex 3: vertices 0 to 2 are allowed",
            ),
            (
                message(|m| m.positions[2].y = f32::NAN),
                "position of vertex 2: [0, NaN, 0]: numbers from -1e9 to 1e9 are allowed",
            ),
            (
                message(|m| m.end_positions = Some(vec![Vec3::splat(-2e9); 3])),
                "position at the shutter's closing of vertex 0: [-2000000000, -2000000000, \
                 -2000000000]: numbers from -1e9 to 1e9 are allowed",
            ),
            (
                message(|m| {
                    m.texture_coordinates =
                        Some(vec![Vec2::ZERO, Vec2::new(f32::INFINITY, 0.0), Vec2::ZERO])
                }),
                "texture coordinate of vertex 1: [inf, 0]: numbers from -1e9 to 1e9 are allowed",
            ),
        ] {
            assert_eq!(found, format!("a.ply: {expected}"));
        }
    }

    /// Of two faces at a right angle, one with twice the other's area.
    #[test]
    fn larger_faces_turn_normals_more() {
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, 2.0 * Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE],
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 0, 4]],
            ..Mesh::default()
        };
        let between = Vec3::new(1.0, 0.0, 2.0).normalize();
        let known = [between, Vec3::Z, between, Vec3::X, Vec3::ZERO];
        let normals = mesh.area_weighted_normals();
        assert!(normals.iter().zip(known).all(|(n, k)| n.abs_diff_eq(k, 1e-6)), "{normals:?}");
    }

    #[test]
    fn corners_move_linearly_from_opening_to_closing() {
        let moving = Mesh { end_positions: Some(vec![Vec3::splat(4.0); 3]), ..mesh() };
        assert_eq!(moving.corners([1, 0, 2], 0.0), [Vec3::X, Vec3::ZERO, Vec3::Y]);
        assert_eq!(moving.corners([1, 0, 2], 0.25)[0], Vec3::new(1.75, 1.0, 1.0));
        assert_eq!(moving.corners([1, 0, 2], 1.0), [Vec3::splat(4.0); 3]);
        assert_eq!(mesh().corners([1, 0, 2], 0.25), mesh().corners([1, 0, 2], 0.0));
    }
}

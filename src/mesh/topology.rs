//! What a mesh consists of: its shells and borders, and the faces that are none.

use super::{Mesh, weld::weld};
use serde::Serialize;

/// Counts of a mesh. Vertices at one point are one, so that seams of a texture are no borders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Topology {
    /// All triangles.
    pub faces: usize,
    /// All vertices, as they are listed.
    pub vertices: usize,
    /// Faces that hang together by their points make a shell.
    pub shells: usize,
    /// Edges of one face.
    pub border_edges: usize,
    /// Edges of more than two faces.
    pub non_manifold_edges: usize,
    /// Faces with a corner twice. They count in nothing else.
    pub degenerate_faces: usize,
    /// Faces with the corners of another, in the same turn. They count in nothing else.
    pub duplicate_faces: usize,
}

impl Topology {
    /// Counts `mesh`, which [`Mesh::check`] has found good, as the shutter opens.
    pub fn of(mesh: &Mesh) -> Self {
        let (points, places) = weld(&mesh.positions);
        let mut faces: Vec<[u32; 3]> =
            mesh.triangles.iter().map(|face| face.map(|vertex| places[vertex as usize])).collect();
        faces.retain(|[a, b, c]| a != b && b != c && c != a);
        let degenerate_faces = mesh.triangles.len() - faces.len();
        for face in &mut faces {
            let least = (0..3).min_by_key(|&corner| face[corner]).unwrap_or_default();
            face.rotate_left(least);
        }
        faces.sort_unstable();
        faces.dedup();

        let mut edges: Vec<[u32; 2]> = faces
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        let (mut border_edges, mut non_manifold_edges) = (0, 0);
        let mut shells = Shells::of(points.len());
        for same in edges.chunk_by(|a, b| a == b) {
            border_edges += usize::from(same.len() == 1);
            non_manifold_edges += usize::from(same.len() > 2);
            shells.join(same[0]);
        }
        let mut used: Vec<u32> =
            faces.as_flattened().iter().map(|&point| shells.root(point)).collect();
        used.sort_unstable();
        used.dedup();
        Self {
            faces: mesh.triangles.len(),
            vertices: mesh.positions.len(),
            shells: used.len(),
            border_edges,
            non_manifold_edges,
            degenerate_faces,
            duplicate_faces: mesh.triangles.len() - degenerate_faces - faces.len(),
        }
    }
}

/// A forest of points in which each shell is a tree.
struct Shells(Vec<u32>);

impl Shells {
    fn of(points: usize) -> Self {
        Self((0..points as u32).collect())
    }

    fn root(&mut self, mut point: u32) -> u32 {
        while self.0[point as usize] != point {
            // Halving the path keeps it short.
            let above = self.0[point as usize];
            self.0[point as usize] = self.0[above as usize];
            point = above;
        }
        point
    }

    fn join(&mut self, [a, b]: [u32; 2]) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn of(points: usize, triangles: &[[u32; 3]]) -> Topology {
        let positions = (0..points).map(|k| Vec3::new(k as f32, (k * k) as f32, 1.0)).collect();
        Topology::of(&Mesh { positions, triangles: triangles.to_vec(), ..Mesh::default() })
    }

    #[test]
    fn a_tetrahedron_is_closed_and_a_fin_is_not_manifold() {
        let tetrahedron = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
        let closed = Topology { faces: 4, vertices: 4, shells: 1, ..Topology::default() };
        assert_eq!(of(4, &tetrahedron), closed);
        let with_fin = [&tetrahedron[..], &[[0, 1, 4]]].concat();
        let expected =
            Topology { faces: 5, vertices: 6, border_edges: 2, non_manifold_edges: 1, ..closed };
        assert_eq!(of(6, &with_fin), expected);
    }

    #[test]
    fn faces_that_are_none_count_apart() {
        let triangles = [[0, 1, 2], [2, 0, 1], [0, 2, 1], [1, 1, 2], [3, 4, 5]];
        let expected = Topology {
            faces: 5,
            vertices: 7,
            shells: 2,
            border_edges: 3,
            degenerate_faces: 1,
            duplicate_faces: 1,
            ..Topology::default()
        };
        assert_eq!(of(7, &triangles), expected);
    }

    #[test]
    fn a_seam_is_no_border() {
        let positions =
            [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X, Vec3::ONE, Vec3::Y, Vec3::ONE].to_vec();
        let mesh = Mesh { positions, triangles: vec![[0, 1, 2], [3, 4, 5]], ..Mesh::default() };
        let found = Topology::of(&mesh);
        assert_eq!((found.shells, found.border_edges, found.vertices), (1, 4, 7));
    }
}

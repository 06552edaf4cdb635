//! What reader and writer know of the mesh as it grows, beside the mesh: the corners at each vertex.

/// How many of the vertices that come in a split have their neighbours in the list of those nearby.
const NEARBY: usize = 2;

/// The corners, three times the face and which of the three, at each vertex that is there.
#[derive(Debug, Default)]
pub struct Front {
    fans: Vec<Vec<u32>>,
    faces: u32,
}

impl Front {
    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.fans.len()
    }

    /// The corners at a vertex.
    pub fn fan(&self, vertex: u32) -> &[u32] {
        &self.fans[vertex as usize]
    }

    /// Adds a vertex without corners.
    pub fn add_vertex(&mut self) {
        self.fans.push(vec![]);
    }

    /// Adds a face between vertices that are there.
    pub fn add_face(&mut self, triangle: [u32; 3]) {
        for (vertex, corner) in triangle.into_iter().zip(3 * self.faces..) {
            self.fans[vertex as usize].push(corner);
        }
        self.faces += 1;
    }

    /// Adds a vertex that takes from `old` those corners that go.
    pub fn split(&mut self, old: u32, goes: &[bool]) {
        let fan = std::mem::take(&mut self.fans[old as usize]);
        let (mut new, mut stays) = (vec![], vec![]);
        for (corner, &goes) in fan.into_iter().zip(goes) {
            if goes { &mut new } else { &mut stays }.push(corner);
        }
        self.fans[old as usize] = stays;
        self.fans.push(new);
    }

    /// The vertices that a face which comes with splits is likely to have, and a face that each is at: the
    /// vertices of the `pairs` and their neighbours.
    pub fn nearby(&self, pairs: &[(u32, u32)], triangles: &[[u32; 3]]) -> Vec<(u32, u32)> {
        let pairs = &pairs[pairs.len().saturating_sub(NEARBY)..];
        let last = self.faces - 1;
        let mut nearby: Vec<_> =
            pairs.iter().flat_map(|&(new, old)| [(new, last), (old, last)]).collect();
        // In a closed fan every neighbour is the next of one corner.
        for on in [1, 2] {
            for vertex in pairs.iter().flat_map(|&(new, old)| [new, old]) {
                nearby.extend(self.fan(vertex).iter().map(|&corner| {
                    let triangle = triangles[corner as usize / 3];
                    (triangle[(corner as usize + on) % 3], corner / 3)
                }));
            }
        }
        nearby
    }
}

/// Where the new vertex is expected: opposite the old one, seen from where both were one.
pub fn mirrored(before: f32, after: f32) -> f32 {
    before + (before - after)
}

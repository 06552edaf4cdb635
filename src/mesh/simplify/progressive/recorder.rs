//! Writes contractions down as they happen, from fine to coarse, and turns them into splits, from coarse to
//! fine.

use super::{Layout, ProgressiveMesh, Split, VertexSplit};
use crate::mesh::Mesh;
use crate::mesh::simplify::cluster::Contraction;
use crate::mesh::simplify::rounds::{Round, in_order};
use crate::mesh::simplify::surface::Surface;
use glam::{Vec2, Vec3};

/// A contraction, or what the input had too much.
struct Step {
    /// How many merges there were up to it.
    merges: usize,
    /// How many faces had gone.
    faces: usize,
    /// The error after it.
    error: f32,
}

/// One vertex went into another.
struct Merge {
    removed: u32,
    kept: u32,
    /// Where its corners end in the list of all.
    corners: usize,
}

/// What happened so far.
pub struct Recorder {
    layout: Layout,
    values: Vec<f32>,
    triangles: Vec<[u32; 3]>,
    error: f32,
    /// From fine to coarse.
    steps: Vec<Step>,
    merges: Vec<Merge>,
    /// For each merge the numbers of the kept vertex before it.
    merge_values: Vec<f32>,
    corners: Vec<u32>,
    faces: Vec<u32>,
    /// Multiples of the speed and the steps that had been done.
    speeds: Vec<(f32, u32)>,
}

impl Recorder {
    /// Begins with `mesh`, of which `surface` was made: what that left out is the first step.
    pub fn new<const F: usize>(mesh: &Mesh, surface: &Surface<F>) -> Self {
        let has_smooth = surface.wedges.as_ref().is_some_and(|wedges| wedges.scale.has_normals());
        let layout = Layout { is_flat: mesh.normals.is_some() && !has_smooth, ..Layout::of(mesh) };
        let mut values = Vec::with_capacity(layout.stride() * mesh.positions.len());
        for (vertex, &position) in mesh.positions.iter().enumerate() {
            let end = mesh.end_positions.as_ref().map_or(position, |end| end[vertex]);
            let normal = mesh.normals.as_ref().map_or(Vec3::ZERO, |list| list[vertex]);
            let texture = mesh.texture_coordinates.as_ref().map_or(Vec2::ZERO, |list| list[vertex]);
            layout.pack([position, end], normal, texture, &mut values);
        }
        let mut recorder = Self {
            layout,
            values,
            triangles: mesh.triangles.clone(),
            error: 0.0,
            steps: vec![],
            merges: vec![],
            merge_values: vec![],
            corners: vec![],
            faces: vec![],
            speeds: vec![],
        };
        recorder.clean(surface);
        recorder
    }

    /// The step from the input to the surface: faces without area and doubles go, and vertices that are alike
    /// become one.
    fn clean<const F: usize>(&mut self, surface: &Surface<F>) {
        let mut is_left = vec![false; self.triangles.len()];
        surface.faces.iter().for_each(|&face| is_left[face as usize] = true);
        let faces = 0..self.triangles.len() as u32;
        self.faces.extend(faces.filter(|&face| !is_left[face as usize]));
        // To which vertex and from which a corner goes.
        let mut moves: Vec<(u32, u32, u32)> = vec![];
        for (triangle, &face) in surface.faces.iter().enumerate() {
            for corner in 0..3 {
                let from = self.triangles[face as usize][corner];
                let to = surface.vertex(triangle, corner);
                if from != to {
                    moves.push((to, from, 3 * face + corner as u32));
                }
            }
        }
        moves.sort_unstable();
        for alike in moves.chunk_by(|a, b| a.0 == b.0) {
            let corners =
                |own: &[(u32, u32, u32)]| own.iter().map(|&(.., corner)| corner).collect();
            let others = alike.chunk_by(|a, b| a.1 == b.1).map(|own| (own[0].1, corners(own)));
            let mut left: Vec<(u32, Vec<u32>)> =
                [(alike[0].0, vec![])].into_iter().chain(others).collect();
            // Two and two, then the halves: to write a split down takes time with the corners at its vertex.
            while left.len() > 1 {
                let mut halved = vec![];
                let mut all = left.into_iter();
                while let Some((kept, mut own)) = all.next() {
                    if let Some((removed, corners)) = all.next() {
                        corners.iter().for_each(|&corner| self.move_corner(corner, kept));
                        let same = self.row(kept).to_vec();
                        self.merge(removed, kept, &same);
                        own.extend(corners);
                    }
                    halved.push((kept, own));
                }
                left = halved;
            }
        }
        if !self.faces.is_empty() || !self.merges.is_empty() {
            self.step(0.0);
        }
    }

    /// Adds what was done in a round to `surface`, on which it has not been carried out yet.
    pub fn add<const F: usize>(&mut self, surface: &Surface<F>, round: &Round<F>) {
        let mut next: Vec<[usize; 3]> = vec![[0; 3]; round.logs.len()];
        let mut after = vec![];
        for (cluster, contraction) in in_order(&round.logs) {
            let log = &round.logs[cluster];
            let members = &round.members[round.starts[cluster]..];
            let face = |triangle: u32| surface.faces[members[triangle as usize] as usize];
            let [faces, corners, wedges] = &mut next[cluster];
            let take = |from: &mut usize, count: u32| {
                *from += count as usize;
                *from - count as usize..*from
            };
            let faces = &log.faces[take(faces, contraction.faces)];
            let corners = &log.corners[take(corners, contraction.corners)];
            let wedges = &log.wedges[take(wedges, contraction.wedges)];
            self.faces.extend(faces.iter().map(|&triangle| face(triangle)));
            let corners = || corners.iter().map(|&corner| 3 * face(corner / 3) + corner % 3);
            let keyframes = place(contraction, surface.unit);
            let first = cluster * round.size;
            match &surface.wedges {
                None => {
                    let vertex = |point: u32| surface.vertices[first + point as usize];
                    let (removed, kept) = (vertex(contraction.removed), vertex(contraction.kept));
                    after.clear();
                    self.layout.pack(keyframes, Vec3::ZERO, Vec2::ZERO, &mut after);
                    corners().for_each(|corner| self.move_corner(corner, kept));
                    self.merge(removed, kept, &after);
                }
                Some(all) => {
                    let first = all.starts[first] as usize;
                    for (removed, kept, values) in wedges {
                        let vertex = |wedge: &u32| all.vertices[first + *wedge as usize];
                        let (removed, kept) = (vertex(removed), vertex(kept));
                        let (normal, texture) = all.scale.attributes(values);
                        after.clear();
                        self.layout.pack(keyframes, normal, texture, &mut after);
                        let own = corners().filter(|corner| {
                            self.triangles[*corner as usize / 3][*corner as usize % 3] == removed
                        });
                        for corner in own.collect::<Vec<_>>() {
                            self.move_corner(corner, kept);
                        }
                        self.merge(removed, kept, &after);
                    }
                }
            }
            self.step(contraction.squared_error.sqrt() * surface.unit);
        }
    }

    /// The limit of a multiple of the speed is reached.
    pub fn reached(&mut self, speed: f32) {
        self.speeds.push((speed, self.steps.len() as u32));
    }

    fn row(&self, vertex: u32) -> &[f32] {
        let stride = self.layout.stride();
        &self.values[vertex as usize * stride..][..stride]
    }

    fn move_corner(&mut self, corner: u32, to: u32) {
        self.triangles[corner as usize / 3][corner as usize % 3] = to;
        self.corners.push(corner);
    }

    fn merge(&mut self, removed: u32, kept: u32, after: &[f32]) {
        let stride = self.layout.stride();
        let row = &mut self.values[kept as usize * stride..][..stride];
        self.merge_values.extend(&*row);
        row.copy_from_slice(after);
        self.merges.push(Merge { removed, kept, corners: self.corners.len() });
    }

    fn step(&mut self, error: f32) {
        self.error = self.error.max(error);
        let (merges, faces) = (self.merges.len(), self.faces.len());
        self.steps.push(Step { merges, faces, error: self.error });
    }

    /// The record at its coarsest.
    pub fn finish(self) -> ProgressiveMesh {
        let stride = self.layout.stride();
        let input = [self.values.len() / stride, self.triangles.len()];
        let vertex_ids = order(input[0], self.merges.iter().map(|merge| merge.removed));
        let face_ids = order(input[1], self.faces.iter().copied());
        let [vertex_of, face_of] = [&vertex_ids, &face_ids].map(|ids| {
            let mut numbers = vec![0; ids.len()];
            ids.iter().zip(0..).for_each(|(&id, number)| numbers[id as usize] = number);
            numbers
        });
        let triangle = |&face: &u32| self.triangles[face as usize].map(|v| vertex_of[v as usize]);
        let row = |&vertex: &u32| &self.values[vertex as usize * stride..][..stride];
        let steps = self.steps.len() as u32;
        let mut mesh = ProgressiveMesh {
            layout: self.layout,
            input: input.map(|count| count as u32),
            base_faces: (input[1] - self.faces.len()) as u32,
            base_error: self.error,
            values: vertex_ids.iter().flat_map(row).copied().collect(),
            triangles: face_ids.iter().map(triangle).collect(),
            vertex_ids,
            face_ids,
            splits: Vec::with_capacity(self.steps.len()),
            vertex_splits: Vec::with_capacity(self.merges.len()),
            split_values: Vec::with_capacity(self.merge_values.len()),
            corners: Vec::with_capacity(self.corners.len()),
            done: 0,
            speeds: self.speeds.iter().map(|&(speed, done)| (speed, steps - done)).collect(),
        };
        for step in (0..self.steps.len()).rev() {
            let before = step.checked_sub(1).map(|before| &self.steps[before]);
            let (merges, faces, error) =
                before.map_or((0, 0, 0.0), |before| (before.merges, before.faces, before.error));
            for merge in (merges..self.steps[step].merges).rev() {
                let first = merge.checked_sub(1).map_or(0, |before| self.merges[before].corners);
                let Merge { kept, corners: end, .. } = self.merges[merge];
                let start = mesh.corners.len();
                let own = self.corners[first..end].iter();
                mesh.corners
                    .extend(own.map(|corner| 3 * face_of[*corner as usize / 3] + corner % 3));
                mesh.corners[start..].sort_unstable();
                mesh.split_values.extend(&self.merge_values[merge * stride..][..stride]);
                let (old, corners) = (vertex_of[kept as usize], mesh.corners.len() as u32);
                mesh.vertex_splits.push(VertexSplit { old, corners });
            }
            let (vertices, faces) = (mesh.vertex_splits.len() as u32, (input[1] - faces) as u32);
            mesh.splits.push(Split { vertices, faces, error });
        }
        mesh
    }
}

/// The numbers below `count`: first those that have not `gone`, then those that have, the last first.
fn order(count: usize, gone: impl DoubleEndedIterator<Item = u32> + Clone) -> Vec<u32> {
    let mut is_gone = vec![false; count];
    gone.clone().for_each(|number| is_gone[number as usize] = true);
    let stayed = (0..count as u32).filter(|&number| !is_gone[number as usize]);
    stayed.chain(gone.rev()).collect()
}

fn place<const F: usize>(contraction: &Contraction<F>, unit: f32) -> [Vec3; 2] {
    [contraction.position[0] * unit, contraction.position[F - 1] * unit]
}

//! The surface while it is simplified: points, which are the places of vertices, and the triangles between
//! them; what each point may do, and its quadric.
//!
//! Vertices at one place are one point. At a seam of the texture a point has several *wedges*, one for each
//! set of normals and texture coordinates there.

use super::attributes::{AttributeQuadric, Scale};
use super::morton;
use super::quadric::Quadric;
use super::wedges::Wedges;
use super::{Attributes, SimplifyError};
use crate::mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;

/// What a point may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Its triangles make one disc of one material: it may go anywhere.
    Interior,
    /// It is on the boundary, of which two edges meet here: it goes along them.
    Boundary,
    /// It is on a seam, of which two edges meet here: it goes along them.
    Seam,
    /// Neither: it stays, and others may go into it.
    Fixed,
    /// In a cluster: it has triangles outside, which nobody sees, so nothing may go into it either.
    Locked,
}

/// A surface of points with a place in each of `F` keyframes.
#[derive(Clone, Debug)]
pub struct Surface<const F: usize> {
    /// Where the points are, in units of `unit`.
    pub positions: Vec<[Vec3; F]>,
    /// Their quadrics.
    pub quadrics: Vec<[Quadric; F]>,
    /// What they may do.
    pub kinds: Vec<Kind>,
    /// A vertex of the input that is there.
    pub vertices: Vec<u32>,
    /// The points of the triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Which face of the input each is.
    pub faces: Vec<u32>,
    /// What the points carry, if they do.
    pub wedges: Option<Wedges>,
    /// The unit of the positions in the mesh's: a power of two about as large as the mesh, so that nothing is
    /// rounded.
    pub unit: f32,
    /// How many rounds of contraction there were.
    pub rounds: u32,
}

/// Weight of the planes that hold boundaries and seams, beside those of the surface.
const BOUNDARY_WEIGHT: f32 = 10.0;

impl<const F: usize> Surface<F> {
    /// The surface of `mesh`, whose keyframes are its positions and, if `F` is 2, its positions at the end.
    /// Faces with a corner twice are left out, and all but one of those that have the same corners in the
    /// same turn.
    ///
    /// Edges between faces of different `groups`, normals or texture coordinates are seams. Normals that make
    /// almost every edge one are those of the faces, and are left out: they follow from the faces.
    ///
    /// # Errors
    /// No face is left.
    pub fn new(
        mesh: &Mesh,
        groups: Option<&[u32]>,
        attributes: Attributes,
    ) -> Result<Self, SimplifyError> {
        let unit = unit(mesh);
        let mut scale = Scale::new(mesh, mesh.diagonal() / unit);
        let mut surface = Self::with_scale(mesh, groups, unit, scale);
        if let Some(wedges) = &surface.wedges
            && mesh.normals.is_some()
            && wedges.vertices.len() > 2 * surface.vertices.len()
        {
            scale.drop_normals();
            surface = Self::with_scale(mesh, groups, unit, scale);
        }
        if surface.triangles.is_empty() {
            let (count, allowed) = (mesh.triangles.len(), "a face needs three different corners");
            return Err(SimplifyError::value(
                "faces",
                format!("all {count} without area"),
                allowed,
            ));
        }
        surface.inspect();
        if attributes == Attributes::Quadrics
            && let Some(wedges) = &mut surface.wedges
        {
            wedges.quadrics = vec![AttributeQuadric::default(); wedges.values.len()];
            for (triangle, points) in surface.triangles.iter().enumerate() {
                wedges.add_triangle(triangle, points.map(|p| surface.positions[p as usize][0]));
            }
        }
        Ok(surface)
    }

    fn with_scale(mesh: &Mesh, groups: Option<&[u32]>, unit: f32, scale: Scale) -> Self {
        let inverse = 1.0 / unit;
        let keyframes: [&[Vec3]; F] = std::array::from_fn(|frame| match &mesh.end_positions {
            Some(end) if frame == 1 => &end[..],
            _ => &mesh.positions[..],
        });
        // Adding zero makes -0 a 0.
        let position = |vertex: u32| keyframes.map(|k| k[vertex as usize] * inverse + Vec3::ZERO);
        let values = |vertex: u32| scale.values(mesh, vertex as usize).map(|value| value + 0.0);
        let bits = |vertex: u32| {
            let values = values(vertex).map(f32::to_bits);
            (position(vertex).map(|p| p.to_array().map(f32::to_bits)), values, vertex)
        };

        let count = mesh.positions.len();
        let mut is_needed = vec![false; count];
        mesh.triangles.as_flattened().iter().for_each(|&v| is_needed[v as usize] = true);
        let mut order = morton::order(count, 0, |vertex| position(vertex as u32)[0]);
        order.retain(|&(_, vertex)| is_needed[vertex as usize]);
        let mut points = vec![0; count];
        let (mut vertices, mut positions) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let has_wedges = scale.has_values() || groups.is_some();
        let mut wedge_of = vec![0; if has_wedges { count } else { 0 }];
        let (mut starts, mut wedge_vertices) = (vec![], vec![]);
        for run in order.chunk_by_mut(|a, b| a.0 == b.0) {
            if run.len() > 1 {
                run.sort_unstable_by_key(|&(_, vertex)| bits(vertex));
            }
            let first = positions.len();
            for &(_, vertex) in &*run {
                let here = position(vertex);
                let is_new = positions[first..].last() != Some(&here);
                if is_new {
                    vertices.push(vertex);
                    positions.push(here);
                }
                points[vertex as usize] = positions.len() as u32 - 1;
                if has_wedges {
                    if is_new {
                        starts.push(wedge_vertices.len() as u32);
                    }
                    let last = wedge_vertices.last();
                    if is_new || last.is_none_or(|&last| values(last) != values(vertex)) {
                        wedge_vertices.push(vertex);
                    }
                    wedge_of[vertex as usize] = wedge_vertices.len() as u32 - 1;
                }
            }
        }
        starts.push(wedge_vertices.len() as u32);

        let mut faces: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        let corners =
            |face: u32| mesh.triangles[face as usize].map(|vertex| points[vertex as usize]);
        faces.retain(|&face| {
            let [a, b, c] = corners(face);
            a != b && b != c && c != a
        });
        let triangles = faces.iter().map(|&face| corners(face)).collect();
        let wedges = has_wedges.then(|| Wedges {
            corners: faces
                .iter()
                .map(|&face| mesh.triangles[face as usize].map(|vertex| wedge_of[vertex as usize]))
                .collect(),
            groups: faces
                .iter()
                .map(|&face| groups.map_or(0, |groups| groups[face as usize]))
                .collect(),
            starts,
            values: wedge_vertices.iter().map(|&vertex| values(vertex)).collect(),
            vertices: wedge_vertices,
            quadrics: vec![],
            scale,
        });
        let (quadrics, kinds) = (vec![], vec![]);
        Self { positions, quadrics, kinds, vertices, triangles, faces, wedges, unit, rounds: 0 }
    }

    /// The vertex of the input at a corner of a triangle.
    pub fn vertex(&self, triangle: usize, corner: usize) -> u32 {
        match &self.wedges {
            None => self.vertices[self.triangles[triangle][corner] as usize],
            Some(wedges) => wedges.vertices[wedges.corners[triangle][corner] as usize],
        }
    }

    /// Leaves out the triangles that are not to be kept.
    pub fn retain_triangles(&mut self, keep: impl Fn(usize) -> bool) {
        fn retain<T>(list: &mut Vec<T>, keep: impl Fn(usize) -> bool) {
            let mut places = 0..;
            list.retain(|_| places.next().is_some_and(&keep));
        }
        retain(&mut self.faces, &keep);
        if let Some(wedges) = &mut self.wedges {
            retain(&mut wedges.corners, &keep);
            retain(&mut wedges.groups, &keep);
        }
        retain(&mut self.triangles, &keep);
    }

    /// Finds out what each point may do, and its quadric. Leaves out triangles that are there before with the
    /// same corners in the same turn.
    fn inspect(&mut self) {
        let mut fans = Fans::new(self.positions.len(), &self.triangles);
        let points = 0..self.positions.len() as u32;
        let is_plain = |point: u32| {
            is_closed_fan(fans.of(point), &self.triangles)
                && self.wedges.as_ref().is_none_or(|wedges| {
                    let differ = |point: &u32| wedges.differ(fans.of(*point));
                    let around = fans.of(point).iter().map(|&corner| self.others(corner)[0]);
                    !differ(&point) && !around.into_iter().any(|other| differ(&other))
                })
        };
        let open: Vec<u32> =
            points.clone().into_par_iter().filter(|&point| !is_plain(point)).collect();
        // A triangle that is there twice closes no fan.
        let mut duplicates: Vec<u32> =
            open.iter().flat_map(|&point| self.duplicates(point, fans.of(point))).collect();
        if !duplicates.is_empty() {
            duplicates.sort_unstable();
            self.retain_triangles(|t| duplicates.binary_search(&(t as u32)).is_err());
            if let Some(wedges) = &mut self.wedges {
                let all = (0..wedges.values.len() as u32).collect();
                wedges.compact(&vec![true; self.positions.len()], all);
            }
            fans = Fans::new(self.positions.len(), &self.triangles);
        }
        (self.kinds, self.quadrics) = points
            .into_par_iter()
            .map(|point| {
                let (corners, mut quadrics) = (fans.of(point), self.planes(fans.of(point)));
                let kind = if open.binary_search(&point).is_err() {
                    Kind::Interior
                } else {
                    self.open_kind(point, corners, &mut quadrics)
                };
                (kind, quadrics)
            })
            .unzip();
    }

    /// The other two points of a corner's triangle, in turn.
    fn others(&self, corner: u32) -> [u32; 2] {
        let triangle = self.triangles[corner as usize / 3];
        [1, 2].map(|on| triangle[(corner as usize + on) % 3])
    }

    /// The triangles whose least point is `point` that are there before.
    fn duplicates(&self, point: u32, corners: &[u32]) -> Vec<u32> {
        let turned = |&corner: &u32| {
            let [b, c] = self.others(corner);
            (point < b && point < c).then_some(((b, c), corner / 3))
        };
        let mut known: Vec<_> = corners.iter().filter_map(turned).collect();
        known.sort_unstable();
        let again = known.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        again.map(|pair| pair[1].1).collect()
    }

    /// The planes of the triangles at `corners`.
    fn planes(&self, corners: &[u32]) -> [Quadric; F] {
        let mut quadrics = [Quadric::default(); F];
        for &corner in corners {
            for (frame, quadric) in quadrics.iter_mut().enumerate() {
                let normal = self.normal(self.triangles[corner as usize / 3], frame);
                let double_area = normal.length();
                if double_area > 0.0 {
                    quadric.add_plane(normal / double_area, double_area);
                }
            }
        }
        quadrics
    }

    /// What a point may do whose triangles do not make a closed fan of one wedge; adds planes to hold a boundary
    /// or a seam.
    fn open_kind(&self, point: u32, corners: &[u32], quadrics: &mut [Quadric; F]) -> Kind {
        // The edges from here, each with a triangle that it belongs to.
        let mut spokes: Vec<(u32, u32)> = vec![];
        for &corner in corners {
            spokes.extend(self.others(corner).map(|other| (other, corner / 3)));
        }
        spokes.sort_unstable();
        let (mut boundary, mut seam, mut is_manifold) = (0, 0, true);
        for edge in spokes.chunk_by(|a, b| a.0 == b.0) {
            match *edge {
                [_] => boundary += 1,
                [a, b] if !self.is_seam([point, a.0], [a.1, b.1]) => continue,
                [_, _] => seam += 1,
                _ => is_manifold = false,
            }
            for &(other, triangle) in edge {
                for (frame, quadric) in quadrics.iter_mut().enumerate() {
                    self.hold(quadric, point, other, triangle, frame);
                }
            }
        }
        match (boundary, seam) {
            _ if !is_manifold || fan_count(&spokes) != 1 => Kind::Fixed,
            (0, 0) => Kind::Interior,
            (2, 0) => Kind::Boundary,
            (0, 2) => Kind::Seam,
            _ => Kind::Fixed,
        }
    }

    /// Whether the edge between two points is a seam between two triangles.
    fn is_seam(&self, edge: [u32; 2], triangles: [u32; 2]) -> bool {
        let Some(wedges) = &self.wedges else { return false };
        let wedge = |triangle: u32, point: u32| {
            let corner = self.triangles[triangle as usize].iter().position(|&p| p == point);
            corner.map(|corner| wedges.corners[triangle as usize][corner])
        };
        let [a, b] = triangles;
        edge.into_iter().any(|point| wedge(a, point) != wedge(b, point))
            || wedges.groups[a as usize] != wedges.groups[b as usize]
    }

    /// Adds the plane through the edge from `point` to `other` that stands on `triangle`.
    fn hold(&self, quadric: &mut Quadric, point: u32, other: u32, triangle: u32, frame: usize) {
        let edge = self.positions[other as usize][frame] - self.positions[point as usize][frame];
        let across = edge.cross(self.normal(self.triangles[triangle as usize], frame));
        let length = across.length();
        if length > 0.0 {
            let weight = BOUNDARY_WEIGHT * edge.length_squared();
            quadric.add_plane(across / length, weight);
        }
    }

    /// Twice the area, along the normal.
    fn normal(&self, triangle: [u32; 3], frame: usize) -> Vec3 {
        let [a, b, c] = triangle.map(|point| self.positions[point as usize][frame]);
        (b - a).cross(c - a)
    }

    /// The mesh of what is left, without the vertices that no triangle needs, in the order of the input, and
    /// the faces of the input that are left.
    pub fn mesh(&self) -> (Mesh, Vec<u32>) {
        let (corners, vertices) = match &self.wedges {
            None => (&self.triangles, &self.vertices),
            Some(wedges) => (&wedges.corners, &wedges.vertices),
        };
        let mut order: Vec<u32> = (0..self.triangles.len() as u32).collect();
        order.par_sort_unstable_by_key(|&triangle| self.faces[triangle as usize]);
        // The point of each wedge (or point) that is needed.
        let mut point_of = vec![u32::MAX; vertices.len()];
        let points = self.triangles.as_flattened().iter();
        for (&wedge, &point) in corners.as_flattened().iter().zip(points) {
            point_of[wedge as usize] = point;
        }
        let all = 0..vertices.len() as u32;
        let mut used: Vec<u32> = all.filter(|&w| point_of[w as usize] != u32::MAX).collect();
        used.par_sort_unstable_by_key(|&wedge| vertices[wedge as usize]);
        let mut new = vec![0; vertices.len()];
        for (place, &wedge) in used.iter().enumerate() {
            new[wedge as usize] = place as u32;
        }
        let position = |frame: usize| {
            let point = |wedge: &u32| point_of[*wedge as usize] as usize;
            used.iter().map(move |wedge| self.positions[point(wedge)][frame] * self.unit)
        };
        let mut mesh = Mesh {
            positions: position(0).collect(),
            end_positions: (F == 2).then(|| position(F - 1).collect()),
            triangles: order
                .iter()
                .map(|&t| corners[t as usize].map(|wedge| new[wedge as usize]))
                .collect(),
            ..Mesh::default()
        };
        if let Some(wedges) = &self.wedges {
            let values = used.iter().map(|&wedge| &wedges.values[wedge as usize]);
            let attributes = values.map(|values| wedges.scale.attributes(values));
            let (normals, texture_coordinates): (Vec<_>, Vec<_>) = attributes.unzip();
            mesh.normals = wedges.scale.has_normals().then_some(normals);
            mesh.texture_coordinates = wedges.scale.has_texture().then_some(texture_coordinates);
        }
        (mesh, order.iter().map(|&t| self.faces[t as usize]).collect())
    }
}

/// A power of two about as large as the largest coordinate.
fn unit(mesh: &Mesh) -> f32 {
    let all = mesh.positions.iter().chain(mesh.end_positions.iter().flatten());
    let largest = all.fold(0.0, |largest: f32, p| largest.max(p.abs().max_element()));
    // Smaller meshes would not survive the inverse.
    f32::from_bits(largest.max(1e-30).to_bits() & 0xff80_0000)
}

/// Whether the triangles at `corners` follow one another once around their point, all turned alike.
fn is_closed_fan(corners: &[u32], triangles: &[[u32; 3]]) -> bool {
    let sides = |corner: u32| {
        let triangle = triangles[corner as usize / 3];
        [1, 2].map(|on| triangle[(corner as usize + on) % 3])
    };
    let Some(&first) = corners.first() else { return false };
    let [start, mut at] = sides(first);
    // Larger fans take the long way, which does not search.
    if corners.len() > 32 {
        return false;
    }
    for _ in 1..corners.len() {
        let mut next = corners.iter().map(|&corner| sides(corner)).filter(|side| side[0] == at);
        match (next.next(), next.next()) {
            (Some([_, end]), None) if at != start => at = end,
            _ => return false,
        }
    }
    at == start
}

/// How many fans of triangles there are, each connected by edges that two triangles share; `spokes` are the
/// edges with their triangles, sorted.
fn fan_count(spokes: &[(u32, u32)]) -> usize {
    // Walks from a triangle over its edges to the next; short lists, so searching is quick.
    let mut left: Vec<u32> = spokes.iter().map(|spoke| spoke.1).collect();
    left.sort_unstable();
    left.dedup();
    let triangles = left.len();
    let other_side = |edge: u32, triangle: u32| {
        let first = spokes.partition_point(|spoke| spoke.0 < edge);
        let edge = spokes[first..].iter().take_while(|spoke| spoke.0 == edge);
        edge.map(|spoke| spoke.1).find(|&other| other != triangle)
    };
    let mut of_triangle: Vec<(u32, u32)> = spokes.iter().map(|&(edge, t)| (t, edge)).collect();
    of_triangle.sort_unstable();
    let mut seen = vec![false; triangles];
    let mut fans = 0;
    for start in 0..triangles {
        if seen[start] {
            continue;
        }
        fans += 1;
        let mut stack = vec![start];
        while let Some(index) = stack.pop() {
            if std::mem::replace(&mut seen[index], true) {
                continue;
            }
            for &(triangle, edge) in &of_triangle[2 * index..2 * index + 2] {
                if let Some(next) = other_side(edge, triangle)
                    && let Ok(next) = left.binary_search(&next)
                {
                    stack.push(next);
                }
            }
        }
    }
    fans
}

/// The corners (three times the triangle, and which of the three) at each point.
struct Fans {
    starts: Vec<u32>,
    corners: Vec<u32>,
}

impl Fans {
    fn new(points: usize, triangles: &[[u32; 3]]) -> Self {
        let mut starts = vec![0; points + 1];
        for &point in triangles.as_flattened() {
            starts[point as usize + 1] += 1;
        }
        for point in 0..points {
            starts[point + 1] += starts[point];
        }
        let mut corners = vec![0; 3 * triangles.len()];
        let mut next = starts.clone();
        for (corner, &point) in triangles.as_flattened().iter().enumerate() {
            let place = &mut next[point as usize];
            corners[*place as usize] = corner as u32;
            *place += 1;
        }
        Self { starts, corners }
    }

    fn of(&self, point: u32) -> &[u32] {
        &self.corners
            [self.starts[point as usize] as usize..self.starts[point as usize + 1] as usize]
    }
}

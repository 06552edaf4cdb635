//! Tests of the hierarchy against brute force, and of what it promises about its shape.

use super::*;
use crate::sampling::random::{StreamKey, unit};
use std::f32::consts::TAU;

/// Numbers in [0, 1), as many as one asks for.
pub struct Numbers {
    key: StreamKey,
    drawn: u32,
}

impl Numbers {
    pub fn new(seed: u64) -> Self {
        Self { key: StreamKey::new(seed, "mesh", 0, 0, 0), drawn: 0 }
    }

    fn next(&mut self) -> f32 {
        self.drawn += 1;
        unit(self.key.words(self.drawn, 0, 0)[0])
    }

    fn index(&mut self, count: usize) -> usize {
        (self.next() * count as f32) as usize
    }

    /// In the cube from −1 to 1.
    fn point(&mut self) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| 2.0 * self.next() - 1.0))
    }

    /// Triangles of any size, some without area, some twice, some flat along an axis.
    pub fn soup(&mut self, count: usize, moves: bool) -> Mesh {
        let mut positions: Vec<Vec3> = vec![];
        for _ in 0..count {
            let (centre, size) = (self.point(), 0.7 * self.next().powi(4));
            let mut corners: [Vec3; 3] = std::array::from_fn(|_| centre + size * self.point());
            match self.index(8) {
                0 => corners[1] = corners[2],
                1 => corners = corners.map(|corner| Vec3::new(corner.x, centre.y, corner.z)),
                2 if !positions.is_empty() => corners.copy_from_slice(&positions[..3]),
                _ => {}
            }
            positions.extend(corners);
        }
        let end = positions.iter().map(|&start| start + 0.5 * self.point()).collect();
        Mesh {
            end_positions: moves.then_some(end),
            triangles: (0..count as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
            positions,
            ..Mesh::default()
        }
    }

    /// Towards a corner, a point of an edge, a point of a triangle, or along an axis.
    fn ray(&mut self, mesh: &Mesh) -> Ray {
        let time = [0.0, 1.0, self.next()][self.index(3)];
        let triangle = mesh.triangles[self.index(mesh.triangles.len())];
        let [a, b, c] = mesh.corners(triangle, time);
        let (u, v) = (self.next(), self.next());
        let target = match self.index(4) {
            0 => a,
            1 => a.lerp(b, u),
            _ => a.lerp(b, u).lerp(c, v),
        };
        let origin = 3.0 * self.point();
        let axis = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X][self.index(4)];
        let (origin, direction) = match self.index(4) {
            0 => (target - 2.0 * axis, axis),
            1 => (target, self.point()),
            _ => (origin, target - origin),
        };
        let end = [f32::INFINITY, 2.0 * self.next()][self.index(2)];
        Ray { origin, direction, time, between: [0.2 * self.next(), end] }
    }
}

fn brute_force(mesh: &Mesh, bvh: &Bvh, ray: &Ray) -> Option<f32> {
    let frame = RayFrame::new(ray, bvh.reach);
    let meet =
        |&triangle| frame.meet_one(mesh.corners(triangle, ray.time)).map(|(distance, _)| distance);
    mesh.triangles.iter().filter_map(meet).min_by(f32::total_cmp)
}

#[test]
fn the_search_finds_what_brute_force_finds() {
    let mut numbers = Numbers::new(1);
    let mut hits = 0;
    for round in 0..120 {
        let mesh = {
            let count = 1 + numbers.index(300);
            numbers.soup(count, round % 3 > 0)
        };
        let bvh = Bvh::new(&mesh);
        for _ in 0..150 {
            let ray = numbers.ray(&mesh);
            let truth = brute_force(&mesh, &bvh, &ray);
            let found = bvh.nearest(&ray);
            assert_eq!(found.map(|hit| hit.distance), truth, "{ray:?}");
            assert_eq!(bvh.any(&ray), truth.is_some(), "{ray:?}");
            let Some(hit) = found else { continue };
            hits += 1;
            let corners = mesh.corners(mesh.triangles[hit.triangle as usize], ray.time);
            let [u, v, w] = hit.barycentrics;
            let place = u * corners[0] + v * corners[1] + w * corners[2];
            let along = ray.origin + hit.distance * ray.direction;
            assert!(place.abs_diff_eq(along, 2e-4), "{place} {along} {ray:?}");
            assert!((u + v + w - 1.0).abs() < 1e-5 && u.min(v).min(w) >= 0.0, "{hit:?}");
        }
    }
    assert!(hits > 5000, "{hits}");
}

/// The squared distance of a point from a triangle, by the part of space that the point lies in [Ericson2005, §5.1.5].
fn squared_distance(corners: [Vec3; 3], point: Vec3) -> f64 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let p = point.as_dvec3();
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let [d1, d2] = [ab, ac].map(|edge| edge.dot(p - a));
    let [d3, d4] = [ab, ac].map(|edge| edge.dot(p - b));
    let [d5, d6] = [ab, ac].map(|edge| edge.dot(p - c));
    let (u, v, w) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    let nearest = if d1 <= 0.0 && d2 <= 0.0 {
        a
    } else if d3 >= 0.0 && d4 <= d3 {
        b
    } else if w <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        a + ab * (d1 / (d1 - d3))
    } else if d6 >= 0.0 && d5 <= d6 {
        c
    } else if v <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        a + ac * (d2 / (d2 - d6))
    } else if u <= 0.0 && d4 >= d3 && d5 >= d6 {
        b + bc * ((d4 - d3) / (d4 - d3 + d5 - d6))
    } else {
        a + (ab * v + ac * w) / (u + v + w)
    };
    p.distance_squared(nearest)
}

#[test]
fn the_nearest_triangle_is_as_far_as_brute_force_finds() {
    let mut numbers = Numbers::new(8);
    for round in 0..60 {
        let mut mesh = {
            let count = 1 + numbers.index(300);
            numbers.soup(count, false)
        };
        if round % 3 == 0 {
            // As thin as paper, to a hundred thousandth of their length.
            mesh.positions.iter_mut().for_each(|p| p.x *= 1e-5);
        }
        let bvh = Bvh::new(&mesh);
        let mut leaf = 0;
        for k in 0..100 {
            let point = match k % 3 {
                0 => mesh.positions[numbers.index(mesh.positions.len())] + 1e-3 * numbers.point(),
                1 => mesh.positions[numbers.index(mesh.positions.len())],
                _ => 2.0 * numbers.point(),
            };
            let corners = mesh.triangles.iter().map(|&triangle| mesh.corners(triangle, 0.0));
            let truth = corners.map(|c| squared_distance(c, point)).fold(f64::INFINITY, f64::min);
            let found = bvh.squared_distance(point, &mut leaf);
            // Boxes are told apart in single precision.
            assert!(
                (found.sqrt() - truth.sqrt()).abs() < 1e-6 * truth.sqrt() + 1e-14,
                "{found} {truth}"
            );
            // Wherever one looks first.
            assert_eq!(bvh.squared_distance(point, &mut 0), found);
        }
    }
}

/// The children of a node, each with the lower and the upper corner of its box at `time`.
fn children(bvh: &Bvh, node: u32, time: f32) -> Vec<(u32, Vec3, Vec3)> {
    let at = node as usize;
    let Node { planes, children } = bvh.nodes[at];
    let planes = bvh.end_planes.get(at).map_or(planes, |end| {
        std::array::from_fn(|plane| between(planes[plane], end[plane], time))
    });
    let corner =
        |lane: usize, k: usize| Vec3::from_array([0, 1, 2].map(|axis| planes[k + axis][lane]));
    (0..4)
        .map(|lane| (children[lane], corner(lane, 0), corner(lane, 3)))
        .filter(|(_, min, max)| min.cmple(*max).all())
        .collect()
}

/// The triangles below a child.
fn below(bvh: &Bvh, child: u32) -> Vec<u32> {
    match child & LEAF {
        0 => children(bvh, child, 0.0)
            .into_iter()
            .flat_map(|(child, ..)| below(bvh, child))
            .collect(),
        _ => bvh.leaves[(child & !LEAF) as usize].triangles.to_vec(),
    }
}

/// At any time, to the last bit, and not much larger than needed at the ends of the shutter.
#[test]
fn boxes_hold_their_triangles_at_all_times() {
    let mut numbers = Numbers::new(2);
    let mesh = numbers.soup(500, true);
    let bvh = Bvh::new(&mesh);
    for node in 0..bvh.nodes.len() as u32 {
        for time in [0.0, 1.0, 0.5, numbers.next(), numbers.next(), numbers.next()] {
            for (child, min, max) in children(&bvh, node, time) {
                let inside = below(&bvh, child);
                let corners = || {
                    let corners = |&k: &u32| mesh.corners(mesh.triangles[k as usize], time);
                    inside.iter().flat_map(corners)
                };
                let least = corners().fold(Vec3::INFINITY, Vec3::min);
                let most = corners().fold(Vec3::NEG_INFINITY, Vec3::max);
                assert!(min.cmple(least).all() && max.cmpge(most).all(), "{node} at {time}");
                assert!(time.fract() > 0.0 || (min, max) == (least, most), "{node} at {time}");
            }
        }
    }
}

/// A sphere of squares around the axis, its poles closed by triangles.
pub fn sphere(around: u32, down: u32, place: impl Fn(Vec3) -> Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut positions = vec![place(Vec3::Y), place(Vec3::NEG_Y)];
    let mut triangles = vec![];
    let ring = |row: u32, column: u32| 2 + row * around + column % around;
    for row in 0..down {
        let (sine, cosine) = (TAU / 2.0 * (row + 1) as f32 / (down + 1) as f32).sin_cos();
        for column in 0..around {
            let (east, north) = (TAU * column as f32 / around as f32).sin_cos();
            positions.push(place(Vec3::new(sine * east, cosine, sine * north)));
            let (next, this) = (ring(row, column + 1), ring(row, column));
            if row == 0 {
                triangles.push([0, this, next]);
            }
            if row + 1 == down {
                triangles.push([1, next, this]);
            } else {
                let (below, aside) = (ring(row + 1, column), ring(row + 1, column + 1));
                triangles.extend([[this, below, next], [next, below, aside]]);
            }
        }
    }
    (positions, triangles)
}

/// From inside a closed mesh, every ray meets it, also along edges and through corners, also far from
/// the origin, where coordinates are coarse.
#[test]
fn no_ray_slips_through_a_closed_mesh() {
    let mut numbers = Numbers::new(3);
    for (offset, moves) in [(0.0, false), (300.0, false), (0.0, true), (300.0, true)] {
        let centre = Vec3::new(offset, -0.3 * offset, 0.7 * offset);
        let travel = Vec3::new(0.9, 0.2, -0.4);
        let (positions, triangles) = sphere(40, 25, |p| centre + p);
        let (end, _) = sphere(40, 25, |p| centre + travel + 1.3 * p);
        let mesh =
            Mesh { positions, end_positions: moves.then_some(end), triangles, ..Mesh::default() };
        mesh.check("sphere").unwrap();
        let bvh = Bvh::new(&mesh);
        for &triangle in &mesh.triangles {
            let time = numbers.next();
            let [a, b, c] = mesh.corners(triangle, time);
            let inside = centre + if moves { travel * time } else { Vec3::ZERO };
            let origin = inside + 0.4 * numbers.point();
            for target in [a, a.lerp(b, numbers.next()), c.lerp(b, 0.5), (a + b + c) / 3.0] {
                let direction = target - origin;
                let ray = Ray { origin, direction, time, between: [0.0, f32::INFINITY] };
                let hit = bvh.nearest(&ray).unwrap_or_else(|| panic!("{ray:?}"));
                assert!((hit.distance - 1.0).abs() < 1e-3, "{hit:?}");
            }
        }
    }
}

#[test]
fn the_hierarchy_is_the_same_for_any_number_of_threads() {
    let mesh = Numbers::new(4).soup(30_000, true);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Bvh::new(&mesh))
    };
    assert!(with(1) == with(4));
}

/// The most children that ever wait while the search goes through what is below `node`.
fn waiting(bvh: &Bvh, node: u32) -> usize {
    let children = children(bvh, node, 0.0);
    let inner = children.iter().filter(|(child, ..)| child & LEAF == 0);
    children.len() - 1 + inner.map(|&(child, ..)| waiting(bvh, child)).max().unwrap_or(0)
}

/// Each triangle half as large as the one before: the heuristic alone would peel them off one by one.
#[test]
fn no_hierarchy_is_deeper_than_the_stack() {
    let corners = [Vec3::X, Vec3::Y, Vec3::Z];
    let scales = (-120..=27).map(|power| 2.0_f32.powi(power));
    let positions: Vec<Vec3> =
        scales.flat_map(|scale| corners.map(|corner| scale * (corner + 2.0))).collect();
    let triangles = (0..positions.len() as u32 / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]);
    let triangles: Vec<[u32; 3]> = triangles.flat_map(|triangle| [triangle; 40]).collect();
    let mesh = Mesh { positions, triangles, ..Mesh::default() };
    mesh.check("nest").unwrap();
    let bvh = Bvh::new(&mesh);
    let waiting_here = waiting(&bvh, 0);
    assert!(waiting_here > 20 && waiting_here <= STACK, "{waiting_here}");
    // All at one place, there is nothing to choose by.
    let same = Mesh { triangles: vec![[0, 1, 2]; 1000], ..mesh };
    let bvh = Bvh::new(&same);
    assert!(bvh.leaves.len() == 256 && waiting(&bvh, 0) <= STACK);
}

#[test]
fn a_mesh_at_rest_has_one_box_per_child_and_every_triangle_in_one_leaf() {
    let mesh = Numbers::new(5).soup(1001, false);
    let bvh = Bvh::new(&mesh);
    assert!(bvh.end_planes.is_empty() && bvh.end_corners.is_empty());
    let mut all = vec![];
    for leaf in &bvh.leaves {
        for (lane, &triangle) in leaf.triangles.iter().enumerate() {
            let corners = mesh.corners(mesh.triangles[triangle as usize], 0.0);
            for (corner, lanes) in corners.iter().zip(&leaf.corners) {
                assert_eq!(lanes.map(|along| along[lane]), corner.to_array());
            }
        }
        let mut triangles = leaf.triangles.to_vec();
        triangles.dedup();
        all.extend(triangles);
    }
    all.sort_unstable();
    assert!(all.into_iter().eq(0..1001));
    // As WGSL counts them.
    assert_eq!((size_of::<Node>(), size_of::<Leaf>()), (7 * 16, 10 * 16));
}

//! Building the hierarchy: from the root down, each node is cut where the surface area heuristic,
//! evaluated at the borders of a few bins, expects the least work [Wald2007]. This binary hierarchy is
//! then folded: a node's grandchildren become its children, and its leaves hold up to four triangles
//! [Dammertz2008].
//!
//! The area of a moving box is its mean over the shutter; its extents are linear in time, so Simpson's
//! rule is exact. No step depends on the number of threads: halves are built side by side, and
//! each in the order of its own slice.

use super::{Bvh, Corners, LEAF, Leaf, MAX_DEPTH, Mesh, Node, Planes};
use crate::mesh::MAX_COORDINATE;
use glam::{Vec3, Vec4};

/// More triangles are always cut, fewer never: four cost no more than one, or than a node.
const MAX_LEAF: usize = 4;
const BINS: usize = 16;
/// Smaller slices are not worth a thread.
const PARALLEL: usize = 8192;

pub(super) fn build(mesh: &Mesh) -> Bvh {
    match &mesh.end_positions {
        None => build_over(mesh, [&mesh.positions]),
        Some(end) => build_over(mesh, [&mesh.positions, end]),
    }
}

/// Over `KEYS` sets of positions: one for a mesh at rest, those at opening and closing for another.
fn build_over<const KEYS: usize>(mesh: &Mesh, positions: [&Vec<Vec3>; KEYS]) -> Bvh {
    let mut items: Vec<Item<KEYS>> = (0..)
        .zip(&mesh.triangles)
        .map(|(triangle, &vertices)| Item {
            boxes: Boxes(positions.map(|positions| {
                let corners = vertices.map(|vertex| positions[vertex as usize]);
                [
                    corners[0].min(corners[1]).min(corners[2]),
                    corners[0].max(corners[1]).max(corners[2]),
                ]
            })),
            face: Face { vertices, triangle },
        })
        .collect();
    let root = Tree::new(&mut items, 0, MAX_DEPTH);
    let corner = |pick: fn(Vec3, Vec3) -> Vec3, which: usize| {
        root.boxes.0.iter().map(|corners| corners[which]).fold(root.boxes.0[0][which], pick)
    };
    let mut bvh = Bvh {
        nodes: vec![],
        end_planes: vec![],
        leaves: vec![],
        end_corners: vec![],
        reach: [corner(Vec3::min, 0), corner(Vec3::max, 1)],
    };
    Store { items: &items, positions, bvh: &mut bvh }.node(&root);
    bvh
}

/// Writes the wide hierarchy.
struct Store<'a, const KEYS: usize> {
    items: &'a [Item<KEYS>],
    positions: [&'a Vec<Vec3>; KEYS],
    bvh: &'a mut Bvh,
}

impl<const KEYS: usize> Store<'_, KEYS> {
    /// The node of `tree`, and all that is below; returns its place.
    fn node(&mut self, tree: &Tree<KEYS>) -> u32 {
        let children = tree.up_to_four();
        let place = self.bvh.nodes.len();
        // Beyond all else, and the wrong way round: no ray enters it. Were one to, leaf 0 does no harm.
        const NOWHERE: [Vec3; 2] =
            [Vec3::splat(4.0 * MAX_COORDINATE), Vec3::splat(-4.0 * MAX_COORDINATE)];
        let planes = |key: usize| -> Planes {
            std::array::from_fn(|plane| {
                Vec4::from_array(std::array::from_fn(|lane| {
                    let corners = children.get(lane).map_or(NOWHERE, |child| child.boxes.0[key]);
                    corners[plane / 3][plane % 3]
                }))
            })
        };
        self.bvh.nodes.push(Node { planes: planes(0), children: [LEAF; 4] });
        if KEYS > 1 {
            self.bvh.end_planes.push(planes(KEYS - 1));
        }
        for (lane, child) in children.into_iter().enumerate() {
            self.bvh.nodes[place].children[lane] = match child.content {
                Content::Faces { first, count } => self.leaf(first, count) | LEAF,
                Content::Children(_) => self.node(child),
            };
        }
        place as u32
    }

    fn leaf(&mut self, first: usize, count: usize) -> u32 {
        let place = self.bvh.leaves.len() as u32;
        let faces: [Face; 4] =
            std::array::from_fn(|lane| self.items[first + lane.min(count - 1)].face);
        let corners = self.positions.map(|positions| -> Corners {
            std::array::from_fn(|corner| {
                let [a, b, c, d] = faces.map(|face| positions[face.vertices[corner] as usize]);
                [0, 1, 2].map(|axis| Vec4::new(a[axis], b[axis], c[axis], d[axis]))
            })
        });
        let triangles = faces.map(|face| face.triangle);
        self.bvh.leaves.push(Leaf { corners: corners[0], triangles });
        if KEYS > 1 {
            self.bvh.end_corners.push(corners[KEYS - 1]);
        }
        place
    }
}

/// Lower and upper corners, at opening and, if there is motion, closing.
#[derive(Clone, Copy)]
struct Boxes<const KEYS: usize>([[Vec3; 2]; KEYS]);

impl<const KEYS: usize> Boxes<KEYS> {
    const EMPTY: Self = Self([[Vec3::INFINITY, Vec3::NEG_INFINITY]; KEYS]);

    fn with(self, other: &Self) -> Self {
        Self(std::array::from_fn(|key| {
            let ([min, max], [other_min, other_max]) = (self.0[key], other.0[key]);
            [min.min(other_min), max.max(other_max)]
        }))
    }

    /// Half the surface area, on average over the shutter.
    fn area(&self) -> f32 {
        let half = |extent: Vec3| extent.x * extent.y + extent.y * extent.z + extent.z * extent.x;
        let extents = self.0.map(|[min, max]| max - min);
        let (start, end) = (extents[0], extents[KEYS - 1]);
        if KEYS == 1 {
            return half(start);
        }
        (half(start) + 4.0 * half(0.5 * (start + end)) + half(end)) / 6.0
    }

    /// The centre in the middle of the shutter, times a constant.
    fn centre(&self) -> Vec3 {
        self.0.iter().map(|[min, max]| min + max).sum()
    }
}

/// A triangle's vertices and its place in the mesh.
#[derive(Clone, Copy)]
struct Face {
    vertices: [u32; 3],
    triangle: u32,
}

struct Item<const KEYS: usize> {
    boxes: Boxes<KEYS>,
    face: Face,
}

struct Tree<const KEYS: usize> {
    boxes: Boxes<KEYS>,
    content: Content<KEYS>,
}

enum Content<const KEYS: usize> {
    Faces { first: usize, count: usize },
    Children(Box<[Tree<KEYS>; 2]>),
}

impl<const KEYS: usize> Tree<KEYS> {
    /// The tree of `items`, of which the first is face `first`, not deeper than `depth`.
    fn new(items: &mut [Item<KEYS>], first: usize, depth: usize) -> Self {
        let boxes = items.iter().fold(Boxes::EMPTY, |all, item| all.with(&item.boxes));
        let Some(left) = cut(items, depth) else {
            let content = Content::Faces { first, count: items.len() };
            return Self { boxes, content };
        };
        let is_parallel = items.len() >= PARALLEL;
        let (low, high) = items.split_at_mut(left);
        let mut low = || Self::new(low, first, depth - 1);
        let mut high = || Self::new(high, first + left, depth - 1);
        let (low, high) = if is_parallel { rayon::join(low, high) } else { (low(), high()) };
        Self { boxes, content: Content::Children(Box::new([low, high])) }
    }

    /// The children of the wide node that takes this one's place. Both children give way to their own if
    /// they have any, which halves the depth; then the largest do while there is room.
    fn up_to_four(&self) -> Vec<&Self> {
        let mut children = vec![];
        match &self.content {
            Content::Faces { .. } => return vec![self],
            Content::Children(pair) => {
                for child in pair.iter() {
                    match &child.content {
                        Content::Faces { .. } => children.push(child),
                        Content::Children(pair) => children.extend(pair.iter()),
                    }
                }
            }
        }
        while children.len() < 4 {
            let inner = |place: &usize| matches!(children[*place].content, Content::Children(_));
            let area = |place: &usize| children[*place].boxes.area();
            let largest =
                (0..children.len()).filter(inner).max_by(|a, b| area(a).total_cmp(&area(b)));
            let Some(place) = largest else { break };
            let Content::Children(pair) = &children[place].content else { break };
            children.splice(place..=place, pair.iter());
        }
        children
    }
}

/// Orders `items` into two parts and returns the length of the first, unless they are to be a leaf.
fn cut<const KEYS: usize>(items: &mut [Item<KEYS>], depth: usize) -> Option<usize> {
    let count = items.len();
    if count <= MAX_LEAF {
        return None;
    }
    let centres = items.iter().fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[min, max], item| {
        let centre = item.boxes.centre();
        [min.min(centre), max.max(centre)]
    });
    let bins = Binning::new(centres);
    if let Some((axis, border)) = bins.best(items) {
        let first = |item: &Item<KEYS>| bins.bin(item.boxes.centre())[axis] < border;
        let left = items.iter().filter(|item| first(item)).count();
        // What the parts still need even if all further cuts halve them.
        if left.max(count - left) <= MAX_LEAF << (depth - 1) {
            let mut ordered = 0;
            for at in 0..count {
                if first(&items[at]) {
                    items.swap(at, ordered);
                    ordered += 1;
                }
            }
            return Some(left);
        }
    }
    // All centres are one, or the heuristic's cut would end too deep: halves along the longest axis.
    let axis = (centres[1] - centres[0]).max_position();
    items.select_nth_unstable_by(count / 2, |a, b| {
        let [a, b] = [a, b].map(|item| (item.boxes.centre()[axis], item.face.triangle));
        a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
    });
    Some(count / 2)
}

/// Which of the equal slabs between the outermost centres a centre lies in, along each axis.
struct Binning {
    origin: Vec3,
    scale: Vec3,
}

impl Binning {
    fn new([min, max]: [Vec3; 2]) -> Self {
        let extent = max - min;
        let scale = Vec3::splat(BINS as f32) / extent;
        // An axis without extent has one bin.
        Self { origin: min, scale: Vec3::select(scale.is_finite_mask(), scale, Vec3::ZERO) }
    }

    fn bin(&self, centre: Vec3) -> [usize; 3] {
        let place = (centre - self.origin) * self.scale;
        place.to_array().map(|place| (place as usize).min(BINS - 1))
    }

    /// The cut of least Σ area × count of the parts: its axis and the first bin of the second part.
    /// None where all centres share one bin on every axis.
    fn best<const KEYS: usize>(&self, items: &[Item<KEYS>]) -> Option<(usize, usize)> {
        let mut bins = [[(Boxes::<KEYS>::EMPTY, 0_usize); BINS]; 3];
        for item in items {
            for (bins, bin) in bins.iter_mut().zip(self.bin(item.boxes.centre())) {
                bins[bin] = (bins[bin].0.with(&item.boxes), bins[bin].1 + 1);
            }
        }
        let mut best: Option<(f32, usize, usize)> = None;
        for (axis, bins) in bins.iter().enumerate() {
            // Σ area × count of what lies in and behind each bin.
            let mut behind = [(0.0, 0); BINS];
            let mut all = (Boxes::EMPTY, 0);
            for border in (1..BINS).rev() {
                all = (all.0.with(&bins[border].0), all.1 + bins[border].1);
                behind[border] = (all.0.area() * all.1 as f32, all.1);
            }
            let mut before = (Boxes::EMPTY, 0);
            for border in 1..BINS {
                before = (before.0.with(&bins[border - 1].0), before.1 + bins[border - 1].1);
                if before.1 == 0 || behind[border].1 == 0 {
                    continue;
                }
                let cost = before.0.area() * before.1 as f32 + behind[border].0;
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, axis, border));
                }
            }
        }
        best.map(|(_, axis, border)| (axis, border))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_area_of_a_moving_box_is_its_mean_over_the_shutter() {
        let start = [Vec3::new(1.0, 2.0, 3.0), Vec3::new(2.0, 5.0, 3.5)];
        let end = [Vec3::new(-4.0, 2.0, 0.0), Vec3::new(5.0, 2.5, 7.0)];
        let at = |time: f32| [0, 1].map(|corner| start[corner].lerp(end[corner], time));
        const STEPS: u32 = 10_000;
        let mean = (0..STEPS)
            .map(|step| f64::from(Boxes([at((step as f32 + 0.5) / STEPS as f32)]).area()))
            .sum::<f64>()
            / f64::from(STEPS);
        let area = f64::from(Boxes([start, end]).area());
        assert!((area / mean - 1.0).abs() < 1e-6, "{area} {mean}");
        // 1 × 3 × ½: 3 + 1.5 + 0.5.
        assert_eq!(Boxes([start]).area(), 5.0);
        assert_eq!(Boxes([start, start]).area(), 5.0);
    }
}

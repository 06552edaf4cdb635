//! Edge contraction within a cluster of points, cheapest first.
//!
//! A cluster is contracted by itself: points with a triangle that reaches out of it stay as they are. What
//! was done is a list of contractions, of which any first part can be carried out.

mod allowed;

use super::Settings;
use super::attributes::{self, AttributeQuadric, AttributeSum, Values};
use super::direction::Seen;
use super::quadric::{Quadric, STIFFNESS, Sum};
use super::surface::Kind;
use crate::mesh::MAX_COORDINATE;
use glam::{DVec3, Vec3};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// No point, triangle or corner.
const NONE: u32 = u32::MAX;

/// Edges of points with more triangles than this together stay, or a fan of a million would take for ever.
const MOST_TRIANGLES: u32 = 4096;

/// Point `removed` goes into point `kept`, both counted in the cluster.
#[derive(Clone, Debug)]
pub struct Contraction<const F: usize> {
    /// Order among those of all clusters: the cost, or that of one before it, if larger.
    pub key: u32,
    pub removed: u32,
    pub kept: u32,
    /// Where `kept` is afterwards.
    pub position: [Vec3; F],
    /// How many triangles vanish: so many follow in [`Log::faces`].
    pub faces: u32,
    /// How many corners go to other wedges: so many follow in [`Log::corners`].
    pub corners: u32,
    /// Mean squared distance to the planes that are replaced.
    pub squared_error: f32,
    /// How many wedges go into others with it: so many follow in [`Log::wedges`].
    pub wedges: u32,
}

/// A wedge goes into another, both counted in the cluster, which has these values afterwards.
pub type WedgeContraction = (u32, u32, Values);

/// What was done in a cluster.
#[derive(Clone, Debug, Default)]
pub struct Log<const F: usize> {
    pub contractions: Vec<Contraction<F>>,
    pub wedges: Vec<WedgeContraction>,
    /// Triangles of the cluster.
    pub faces: Vec<u32>,
    /// Three times the triangle of the cluster, and which of its corners.
    pub corners: Vec<u32>,
}

/// What a cluster is made of.
pub struct Part<'a, const F: usize> {
    pub positions: &'a [[Vec3; F]],
    pub quadrics: &'a [[Quadric; F]],
    pub kinds: &'a [Kind],
    /// Which points have a triangle that reaches out of the cluster.
    pub is_locked: &'a [bool],
    /// The triangles that lie in it, and the number of its first point in them.
    pub triangles: &'a [[u32; 3]],
    pub first: u32,
    pub wedges: Option<PartOfWedges<'a>>,
}

/// The wedges of a cluster.
pub struct PartOfWedges<'a> {
    pub values: &'a [Values],
    /// None if values are averaged.
    pub quadrics: &'a [AttributeQuadric],
    /// For each point and for the one after the last its first wedge, counted as those of the triangles.
    pub starts: &'a [u32],
    /// The wedges of the triangles.
    pub corners: Vec<[u32; 3]>,
    pub groups: Vec<u32>,
}

struct ClusterWedges<'a> {
    values: Vec<Values>,
    quadrics: Vec<AttributeQuadric>,
    starts: &'a [u32],
    corners: Vec<[u32; 3]>,
    groups: Vec<u32>,
}

/// Points of one cluster and the triangles that lie in it wholly.
pub struct Cluster<'a, const F: usize> {
    settings: &'a Settings<'a>,
    unit: f32,
    positions: Vec<[Vec3; F]>,
    quadrics: Vec<[Quadric; F]>,
    kinds: Vec<Kind>,
    seen: Vec<Seen>,
    /// The point that a point has gone into, or itself.
    parents: Vec<u32>,
    /// The first corner at each point, how many there are, and the next after each corner and the one before.
    heads: Vec<u32>,
    degrees: Vec<u32>,
    next: Vec<u32>,
    previous: Vec<u32>,
    /// The points of each triangle; [`NONE`] of those that have vanished.
    triangles: Vec<[u32; 3]>,
    wedges: Option<ClusterWedges<'a>>,
    heap: BinaryHeap<Reverse<Candidate>>,
    /// Costs above this are of no interest.
    horizon: u32,
    /// By point: the last mark that was set.
    marks: Vec<u32>,
    mark: u32,
}

/// An edge that may be contracted.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// The bits of the cost, which is not negative: in the order of the costs.
    key: u32,
    a: u32,
    b: u32,
}

/// What a contraction would do.
struct Plan<const F: usize> {
    removed: u32,
    kept: u32,
    position: [Vec3; F],
    key: u32,
    squared_error: f32,
    /// Up to two wedges that go into others.
    wedges: [Option<WedgeContraction>; 2],
    /// How the kept point is seen there, once it was looked at.
    seen: Option<Seen>,
}

impl<'a, const F: usize> Cluster<'a, F> {
    /// A cluster in units of `unit`; no contraction that costs more than `horizon` says is considered.
    pub fn new(settings: &'a Settings<'a>, unit: f32, horizon: u32, part: Part<'a, F>) -> Self {
        let count = part.positions.len();
        let triangles: Vec<_> =
            part.triangles.iter().map(|t| t.map(|point| point - part.first)).collect();
        let kinds = part.kinds.iter().zip(part.is_locked);
        let mut cluster = Self {
            settings,
            unit,
            positions: part.positions.to_vec(),
            quadrics: part.quadrics.to_vec(),
            kinds: kinds.map(|(&kind, &is)| if is { Kind::Locked } else { kind }).collect(),
            seen: vec![],
            parents: (0..count as u32).collect(),
            heads: vec![NONE; count],
            degrees: vec![0; count],
            next: vec![NONE; 3 * triangles.len()],
            previous: vec![NONE; 3 * triangles.len()],
            triangles,
            wedges: part.wedges.map(|part| {
                let first = part.starts[0];
                ClusterWedges {
                    values: part.values.to_vec(),
                    quadrics: part.quadrics.to_vec(),
                    starts: part.starts,
                    corners: part
                        .corners
                        .into_iter()
                        .map(|corners| corners.map(|wedge| wedge - first))
                        .collect(),
                    groups: part.groups,
                }
            }),
            heap: BinaryHeap::new(),
            horizon,
            marks: vec![0; count],
            mark: 0,
        };
        for corner in 0..cluster.next.len() {
            let point = cluster.triangles[corner / 3][corner % 3];
            cluster.link(point, corner as u32);
        }
        if settings.motion.is_some() {
            cluster.seen = part.positions.iter().map(|p| settings.look(p, unit)).collect();
        }
        cluster.fill_heap();
        cluster
    }

    fn fill_heap(&mut self) {
        let mut candidates = vec![];
        for a in 0..self.positions.len() as u32 {
            self.each_neighbour(a, |cluster, b| {
                if b > a
                    && let Some(Plan { key, .. }) = cluster.plan(a, b)
                    && key <= cluster.horizon
                {
                    candidates.push(Reverse(Candidate { key, a, b }));
                }
            });
        }
        self.heap = candidates.into();
    }

    /// Contracts edges, cheapest first, until no allowed one is left below the horizon or `faces` triangles
    /// are gone.
    pub fn run(mut self, faces: usize) -> Log<F> {
        let (mut log, mut gone, mut key) = (Log::default(), 0, 0);
        while gone < faces
            && let Some(Reverse(candidate)) = self.heap.pop()
        {
            let (a, b) = (self.whereabouts(candidate.a), self.whereabouts(candidate.b));
            if a == b {
                continue;
            }
            let Some(mut plan) = self.plan(a, b) else { continue };
            // Costs only grow as quadrics are added: what is in the heap is a lower bound.
            if plan.key > candidate.key {
                if plan.key <= self.horizon {
                    self.heap.push(Reverse(Candidate { key: plan.key, a, b }));
                }
                continue;
            }
            if !self.is_allowed(&mut plan) {
                continue;
            }
            key = plan.key.max(key);
            let before = (log.faces.len(), log.corners.len());
            self.contract(&plan, &mut log);
            let vanished = log.faces.len() - before.0;
            gone += vanished;
            log.wedges.extend(plan.wedges.iter().flatten());
            log.contractions.push(Contraction {
                key,
                removed: plan.removed,
                kept: plan.kept,
                position: plan.position,
                faces: vanished as u32,
                corners: (log.corners.len() - before.1) as u32,
                squared_error: plan.squared_error,
                wedges: plan.wedges.iter().flatten().count() as u32,
            });
        }
        log
    }

    /// The point that `point` has gone into.
    fn whereabouts(&mut self, mut point: u32) -> u32 {
        while self.parents[point as usize] != point {
            let parent = self.parents[point as usize];
            self.parents[point as usize] = self.parents[parent as usize];
            point = parent;
        }
        point
    }

    /// What the contraction of the edge between `a` and `b` would be, by what both may do.
    fn plan(&self, a: u32, b: u32) -> Option<Plan<F>> {
        use Kind::{Boundary, Fixed, Interior, Locked, Seam};
        let (removed, kept, is_free) = match (self.kinds[a as usize], self.kinds[b as usize]) {
            // The one with fewer triangles goes, so that little has to be rewritten.
            (Interior, Interior) | (Boundary, Boundary) | (Seam, Seam) => {
                match self.degrees[a as usize] > self.degrees[b as usize] {
                    true => (b, a, true),
                    false => (a, b, true),
                }
            }
            (Locked, _) | (_, Locked) => return None,
            (Fixed, Fixed) | (Boundary, Seam) | (Seam, Boundary) => return None,
            (Interior, _) | (_, Fixed) => (a, b, false),
            (_, Interior) | (Fixed, _) => (b, a, false),
        };
        let (r, k) = (removed as usize, kept as usize);
        if self.degrees[r] + self.degrees[k] > MOST_TRIANGLES {
            return None;
        }
        let origins = self.positions[k];
        let mut wedges = self.wedges.as_ref().map(|wedges| self.wedge_pairs(wedges, removed, kept));
        let edges: [DVec3; F] =
            std::array::from_fn(|frame| (self.positions[r][frame] - origins[frame]).as_dvec3());
        let surfaces: [Sum; F] = std::array::from_fn(|frame| {
            let mut sum = Sum::default();
            sum.add(&self.quadrics[k][frame], DVec3::ZERO);
            sum.add(&self.quadrics[r][frame], edges[frame]);
            sum
        });
        // Those of the values are of the first keyframe.
        let attributes = wedges.as_mut().map(|pairs| self.attribute_sums(pairs, edges[0], is_free));
        let mut sums = surfaces;
        for sum in attributes.iter().flatten().flatten() {
            sums[0].add_sum(&if is_free { sum.best() } else { sum.here() });
        }
        let at = match self.kinds[k] {
            _ if !is_free => [DVec3::ZERO; F],
            Interior => best(&sums, &edges),
            // What is straight stays straight to the last bit.
            _ => least(&sums, [[DVec3::ZERO; F], edges, best(&sums, &edges)]),
        };
        let position: [Vec3; F] = std::array::from_fn(|frame| origins[frame] + at[frame].as_vec3());
        let farthest = position.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
        if farthest * self.unit > MAX_COORDINATE {
            return None;
        }
        let cost = error(&sums, &at);
        let distance = error(&surfaces, &at);
        let weight: f64 = surfaces.iter().map(Sum::weight).sum();
        if is_free && let (Some(sums), Some(pairs)) = (attributes, &mut wedges) {
            for (pair, sum) in pairs.iter_mut().zip(sums) {
                if let (Some((_, _, values)), Some(sum)) = (pair, sum) {
                    *values = attributes::sum(values, sum.values(at[0]));
                }
            }
        }
        let squared_error = if weight > 0.0 { (distance / weight) as f32 } else { 0.0 };
        if squared_error > self.settings.squared_error {
            return None;
        }
        let factor = match &self.seen[..] {
            [] => 1.0,
            seen => self.settings.weight.of_edge(&seen[a as usize], &seen[b as usize]),
        };
        let key = (cost as f32 * factor).to_bits();
        let wedges = wedges.unwrap_or_default();
        Some(Plan { removed, kept, position, key, squared_error, wedges, seen: None })
    }

    /// The wedges of `removed` at its edge to `kept`, those of `kept` that they go into, and the values of
    /// these.
    fn wedge_pairs(
        &self,
        wedges: &ClusterWedges,
        removed: u32,
        kept: u32,
    ) -> [Option<WedgeContraction>; 2] {
        let mut pairs = [None; 2];
        for corner in self.corners(removed) {
            let triangle = corner as usize / 3;
            if let Some(other) = self.triangles[triangle].iter().position(|&point| point == kept) {
                let from = wedges.corners[triangle][corner as usize % 3];
                let to = wedges.corners[triangle][other];
                let pair = Some((from, to, wedges.values[to as usize]));
                match pairs {
                    [None, _] => pairs[0] = pair,
                    [first, None] if first != pair => pairs[1] = pair,
                    _ => {}
                }
            }
        }
        pairs
    }

    /// What the values cost at pairs of wedges, relative to the kept point and its values; of means nothing,
    /// which are told here.
    fn attribute_sums(
        &self,
        pairs: &mut [Option<WedgeContraction>; 2],
        edge: DVec3,
        is_free: bool,
    ) -> [Option<AttributeSum>; 2] {
        let mut sums = [None; 2];
        let Some(wedges) = &self.wedges else { return sums };
        for (pair, sum) in pairs.iter_mut().zip(&mut sums) {
            let Some((removed, kept, values)) = pair else { continue };
            let (r, k) = (*removed as usize, *kept as usize);
            let difference = attributes::difference(&wedges.values[r], &wedges.values[k]);
            if wedges.quadrics.is_empty() {
                if is_free {
                    *values = attributes::sum(values, difference.map(|value| 0.5 * value));
                }
            } else {
                let sum = sum.insert(AttributeSum::default());
                sum.add(&wedges.quadrics[k], DVec3::ZERO, [0.0; _]);
                sum.add(&wedges.quadrics[r], edge, difference);
            }
        }
        sums
    }

    /// Carries the plan out.
    fn contract(&mut self, plan: &Plan<F>, log: &mut Log<F>) {
        let (r, k) = (plan.removed as usize, plan.kept as usize);
        let ends = [self.positions[k], self.positions[r]];
        if let Some(wedges) = &mut self.wedges {
            for &pair in plan.wedges.iter().flatten() {
                let places = ends.map(|end| end[0]);
                merge_wedges(
                    &mut wedges.quadrics,
                    &mut wedges.values,
                    pair,
                    places,
                    plan.position[0],
                );
            }
        }
        for (frame, to) in plan.position.iter().enumerate() {
            self.quadrics[k][frame] = merged(
                (&self.quadrics[k][frame], ends[0][frame]),
                (&self.quadrics[r][frame], ends[1][frame]),
                to.as_dvec3(),
            );
        }
        self.positions[k] = plan.position;
        if !self.seen.is_empty() {
            let look = || self.settings.look(&plan.position, self.unit);
            self.seen[k] = plan.seen.unwrap_or_else(look);
        }
        self.parents[r] = plan.kept;

        let mut corner = self.heads[r];
        while corner != NONE {
            let following = self.next[corner as usize];
            let triangle = corner as usize / 3;
            if self.triangles[triangle].contains(&plan.kept) {
                let points = std::mem::replace(&mut self.triangles[triangle], [NONE; 3]);
                log.faces.push(triangle as u32);
                for (point, corner) in points.into_iter().zip(3 * triangle as u32..) {
                    self.unlink(point, corner);
                }
            } else {
                log.corners.push(corner);
                self.triangles[triangle][corner as usize % 3] = plan.kept;
                if let Some(wedges) = &mut self.wedges {
                    let wedge = &mut wedges.corners[triangle][corner as usize % 3];
                    let pair = plan.wedges.iter().flatten().find(|pair| pair.0 == *wedge);
                    *wedge = pair.map_or(*wedge, |pair| pair.1);
                }
                self.unlink(plan.removed, corner);
                self.link(plan.kept, corner);
            }
            corner = following;
        }
    }

    /// Puts `corner` into the list of `point`.
    fn link(&mut self, point: u32, corner: u32) {
        let next = std::mem::replace(&mut self.heads[point as usize], corner);
        self.next[corner as usize] = next;
        self.previous[corner as usize] = NONE;
        if next != NONE {
            self.previous[next as usize] = corner;
        }
        self.degrees[point as usize] += 1;
    }

    /// Takes `corner` out of the list of `point`.
    fn unlink(&mut self, point: u32, corner: u32) {
        let [next, previous] = [self.next[corner as usize], self.previous[corner as usize]];
        match previous {
            NONE => self.heads[point as usize] = next,
            _ => self.next[previous as usize] = next,
        }
        if next != NONE {
            self.previous[next as usize] = previous;
        }
        self.degrees[point as usize] -= 1;
    }

    /// Calls `visit` once with each neighbour of `point`.
    fn each_neighbour(&mut self, point: u32, mut visit: impl FnMut(&mut Self, u32)) {
        self.mark += 1;
        let mark = self.mark;
        let mut corner = self.heads[point as usize];
        while corner != NONE {
            for other in self.others(corner) {
                if std::mem::replace(&mut self.marks[other as usize], mark) != mark {
                    visit(self, other);
                }
            }
            corner = self.next[corner as usize];
        }
    }

    fn corners(&self, point: u32) -> impl Iterator<Item = u32> + use<'_, 'a, F> {
        let first = self.heads[point as usize];
        std::iter::successors((first != NONE).then_some(first), |&corner| {
            let next = self.next[corner as usize];
            (next != NONE).then_some(next)
        })
    }

    /// The other two points of a corner's triangle, in turn.
    fn others(&self, corner: u32) -> [u32; 2] {
        let triangle = self.triangles[corner as usize / 3];
        [triangle[(corner as usize + 1) % 3], triangle[(corner as usize + 2) % 3]]
    }
}

/// The sum of the quadrics of two points, for a point at `to`.
pub fn merged(a: (&Quadric, Vec3), b: (&Quadric, Vec3), to: DVec3) -> Quadric {
    let mut sum = Sum::default();
    for (quadric, at) in [a, b] {
        sum.add(quadric, at.as_dvec3() - to);
    }
    sum.quadric(DVec3::ZERO)
}

/// Merges a wedge at `places[1]` into one at `places[0]`, which is at `to` afterwards.
pub fn merge_wedges(
    quadrics: &mut [AttributeQuadric],
    values: &mut [Values],
    (removed, kept, new): WedgeContraction,
    places: [Vec3; 2],
    to: Vec3,
) {
    let (r, k) = (removed as usize, kept as usize);
    if !quadrics.is_empty() {
        let mut sum = AttributeSum::default();
        for (wedge, place) in [k, r].into_iter().zip(places) {
            let at = place.as_dvec3() - to.as_dvec3();
            sum.add(&quadrics[wedge], at, attributes::difference(&values[wedge], &new));
        }
        quadrics[k] = sum.quadric();
    }
    values[k] = new;
}

/// How much the places of a point in two keyframes are drawn to the middles of the edge, as a part of the weights:
/// where the surface leaves them open they are the same place of it in both, or what lies between would slide.
const STIFFNESS_OF_TWO: f64 = 0.05;

/// Where each sum is least near its edge, which goes from the origin to where `edges` says.
#[inline]
pub fn best<const F: usize>(sums: &[Sum; F], edges: &[DVec3; F]) -> [DVec3; F] {
    let stiffness = if F == 1 { STIFFNESS } else { STIFFNESS_OF_TWO };
    let middles = edges.map(|edge| 0.5 * edge);
    let mut places = middles;
    for frame in 0..F {
        let most = 4.0 * edges[frame].length_squared();
        let place = sums[frame].minimum(middles[frame], stiffness);
        match place.filter(|place| place.distance_squared(middles[frame]) <= most) {
            Some(place) => places[frame] = place,
            None => return least(sums, [[DVec3::ZERO; F], *edges, middles]),
        }
    }
    places
}

/// The first of the places where the sums are least.
fn least<const F: usize>(sums: &[Sum; F], places: [[DVec3; F]; 3]) -> [DVec3; F] {
    let [a, b, c] = places;
    let better = |a, b| if error(sums, &b) < error(sums, &a) { b } else { a };
    better(better(a, b), c)
}

/// The error of all sums together.
pub fn error<const F: usize>(sums: &[Sum; F], places: &[DVec3; F]) -> f64 {
    sums.iter().zip(places).map(|(sum, &place)| sum.error(place)).sum()
}

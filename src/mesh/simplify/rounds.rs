//! Rounds of contraction: clusters of neighbouring points are contracted side by side up to one cost, the same
//! for all; in the next round the clusters lie elsewhere.
//!
//! Clusters depend on the surface alone, not on how many threads there are, and so does the result.

use super::cluster::{self, Cluster, Contraction, Log, Part, PartOfWedges};
use super::progressive::recorder::Recorder;
use super::quadric::Sum;
use super::surface::Surface;
use super::{Settings, morton};
use glam::DVec3;
use rayon::prelude::*;

/// Points of a cluster, about: a cluster fits into a core's cache.
const CLUSTER: usize = 4096;

/// Points below which a cluster is not divided.
const LEAST_CLUSTER: usize = 512;

/// Clusters that there are at least, if they are large enough, for as many threads.
const CLUSTERS: usize = 16;

/// In a round that is to take away a part of the triangles, clusters are contracted up to the cost that this
/// many times the part of all edges stays below. More makes fewer rounds and a coarser result, as what lies
/// between clusters falls behind: on a head of 268,686 faces the root of the mean squared distance at 8,946 is
/// 3 % larger at 1.5 and 6 % at 1.7, for a tenth of the time at most.
const QUANTILE: f32 = 1.2;

/// What was done in a round, with what it takes to name it in the whole surface.
pub struct Round<const F: usize> {
    /// Points of a cluster.
    pub size: usize,
    /// The triangles of the clusters, one after the other, and where each begins.
    pub members: Vec<u32>,
    pub starts: Vec<usize>,
    pub logs: Vec<Log<F>>,
}

impl<const F: usize> Surface<F> {
    /// Contracts edges until there are `faces` triangles or fewer, or no edge may be contracted. Tells the
    /// recorder of it, and returns the largest error, in the mesh's unit.
    pub(super) fn contract(
        &mut self,
        settings: &Settings,
        faces: usize,
        mut recorder: Option<&mut Recorder>,
    ) -> f32 {
        let mut squared_error = 0.0f32;
        // When cheap edges no longer do, all are looked at, and when clusters no longer do, there is but one.
        let (mut all_costs, mut one_cluster) = (false, false);
        while self.triangles.len() > faces {
            if self.rounds > 0 {
                self.reorder(self.rounds);
            }
            self.rounds += 1;
            let before = self.triangles.len();
            let size = if one_cluster { self.positions.len() } else { self.cluster_size() };
            let is_whole = self.positions.len() <= size;
            let goal = before - faces;
            let horizon =
                if all_costs || is_whole { f32::MAX } else { self.horizon(settings, goal) };
            let most = if is_whole { goal } else { usize::MAX };
            let mut round = self.contract_clusters(settings, size, horizon.to_bits(), most);
            cut(&mut round.logs, goal);
            let contractions = || round.logs.iter().flat_map(|log| &log.contractions);
            let removed: usize = contractions().map(|c| c.faces as usize).sum();
            squared_error = contractions().map(|c| c.squared_error).fold(squared_error, f32::max);
            if let Some(recorder) = &mut recorder {
                recorder.add(self, &round);
            }
            self.apply(size, &round.logs);
            if is_whole && removed == 0 {
                break;
            }
            if removed == 0 || removed < before / 50 {
                one_cluster = all_costs;
                all_costs = true;
            }
        }
        squared_error.sqrt() * self.unit
    }

    fn cluster_size(&self) -> usize {
        (self.positions.len() / CLUSTERS).clamp(LEAST_CLUSTER, CLUSTER)
    }

    /// The cost up to which clusters are contracted if `goal` triangles are to go.
    fn horizon(&self, settings: &Settings, goal: usize) -> f32 {
        let step = (self.triangles.len() / 4096).max(1);
        let edges = self.triangles.iter().step_by(step).map(|&[a, b, _]| [a as usize, b as usize]);
        let mut costs: Vec<f32> = edges.map(|edge| self.cost(settings, edge)).collect();
        costs.sort_unstable_by(f32::total_cmp);
        let part = QUANTILE * (goal as f32 / self.triangles.len() as f32).min(0.5);
        costs[((part * costs.len() as f32) as usize).min(costs.len() - 1)]
    }

    /// What the contraction of an edge would cost, if both points may go anywhere and carry nothing.
    fn cost(&self, settings: &Settings, edge: [usize; 2]) -> f32 {
        let [a, b] = edge.map(|point| &self.positions[point]);
        let edges: [DVec3; F] = std::array::from_fn(|frame| (b[frame] - a[frame]).as_dvec3());
        let sums: [Sum; F] = std::array::from_fn(|frame| {
            let mut sum = Sum::default();
            sum.add(&self.quadrics[edge[0]][frame], DVec3::ZERO);
            sum.add(&self.quadrics[edge[1]][frame], edges[frame]);
            sum
        });
        let cost = cluster::error(&sums, &cluster::best(&sums, &edges));
        let seen = |position| settings.look(position, self.unit);
        cost as f32 * settings.weight.of_edge(&seen(a), &seen(b))
    }

    fn contract_clusters(
        &self,
        settings: &Settings,
        size: usize,
        horizon: u32,
        goal: usize,
    ) -> Round<F> {
        let cluster_of = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|point| point as usize / size);
            (a == b && b == c).then_some(a)
        };
        let clusters = self.positions.len().div_ceil(size);
        let mut is_locked = vec![false; self.positions.len()];
        let mut starts = vec![0; clusters + 1];
        for triangle in &self.triangles {
            match cluster_of(triangle) {
                Some(cluster) => starts[cluster + 1] += 1,
                None => triangle.iter().for_each(|&point| is_locked[point as usize] = true),
            }
        }
        for cluster in 0..clusters {
            starts[cluster + 1] += starts[cluster];
        }
        let mut members = vec![0u32; starts[clusters]];
        let mut next = starts.clone();
        for (index, triangle) in self.triangles.iter().enumerate() {
            if let Some(cluster) = cluster_of(triangle) {
                members[next[cluster]] = index as u32;
                next[cluster] += 1;
            }
        }
        let logs = (0..clusters)
            .into_par_iter()
            .map(|cluster| {
                let points = cluster * size..self.positions.len().min((cluster + 1) * size);
                let members = &members[starts[cluster]..starts[cluster + 1]];
                let triangles: Vec<_> =
                    members.iter().map(|&t| self.triangles[t as usize]).collect();
                let part = Part {
                    positions: &self.positions[points.clone()],
                    quadrics: &self.quadrics[points.clone()],
                    kinds: &self.kinds[points.clone()],
                    is_locked: &is_locked[points.clone()],
                    triangles: &triangles,
                    first: points.start as u32,
                    wedges: self.wedges.as_ref().map(|all| {
                        let own = all.of_points(points.clone());
                        PartOfWedges {
                            values: &all.values[own.clone()],
                            quadrics: all.quadrics.get(own).unwrap_or_default(),
                            starts: &all.starts[points.start..=points.end],
                            corners: members.iter().map(|&t| all.corners[t as usize]).collect(),
                            groups: members.iter().map(|&t| all.groups[t as usize]).collect(),
                        }
                    }),
                };
                Cluster::new(settings, self.unit, horizon, part).run(goal)
            })
            .collect();
        Round { size, members, starts, logs }
    }

    /// Carries out what the clusters did, and leaves out the points and triangles that have gone.
    fn apply(&mut self, size: usize, logs: &[Log<F>]) {
        let mut forward: Vec<u32> = (0..self.positions.len() as u32).collect();
        let all_wedges = self.wedges.as_mut().map(|all| all.apply(size, logs, &self.positions));
        forward
            .par_chunks_mut(size)
            .zip(self.positions.par_chunks_mut(size))
            .zip(self.quadrics.par_chunks_mut(size))
            .zip(logs)
            .enumerate()
            .for_each(|(cluster, (((forward, positions), quadrics), log))| {
                for contraction in &log.contractions {
                    let (r, k) = (contraction.removed as usize, contraction.kept as usize);
                    for frame in 0..F {
                        quadrics[k][frame] = cluster::merged(
                            (&quadrics[k][frame], positions[k][frame]),
                            (&quadrics[r][frame], positions[r][frame]),
                            contraction.position[frame].as_dvec3(),
                        );
                    }
                    positions[k] = contraction.position;
                    forward[r] = (cluster * size) as u32 + contraction.kept;
                }
                // A point goes where that goes which it went into.
                for contraction in log.contractions.iter().rev() {
                    let r = contraction.removed as usize;
                    forward[r] = forward[forward[r] as usize - cluster * size];
                }
            });
        self.triangles.par_iter_mut().for_each(|triangle| {
            *triangle = triangle.map(|point| forward[point as usize]);
        });
        let is_left: Vec<bool> =
            self.triangles.iter().map(|&[a, b, c]| a != b && b != c && c != a).collect();
        self.retain_triangles(|triangle| is_left[triangle]);
        let mut is_needed = vec![false; self.positions.len()];
        self.triangles.as_flattened().iter().for_each(|&point| is_needed[point as usize] = true);
        if let (Some(wedges), Some(wedge_forward)) = (&mut self.wedges, all_wedges) {
            wedges.compact(&is_needed, wedge_forward);
        }

        // Points that are still themselves, and needed, move up.
        let mut new = 0;
        for (point, forward) in forward.iter_mut().enumerate() {
            if *forward == point as u32 && is_needed[point] {
                *forward = new;
                self.positions[new as usize] = self.positions[point];
                self.quadrics[new as usize] = self.quadrics[point];
                self.kinds[new as usize] = self.kinds[point];
                self.vertices[new as usize] = self.vertices[point];
                new += 1;
            }
        }
        self.positions.truncate(new as usize);
        self.quadrics.truncate(new as usize);
        self.kinds.truncate(new as usize);
        self.vertices.truncate(new as usize);
        self.triangles.par_iter_mut().for_each(|triangle| {
            *triangle = triangle.map(|point| forward[point as usize]);
        });
    }

    /// Puts the points into the order of the round's curve.
    fn reorder(&mut self, round: u32) {
        let order = morton::order(self.positions.len(), round, |point| self.positions[point][0]);
        let mut new = vec![0; order.len()];
        for (place, &(_, point)) in order.iter().enumerate() {
            new[point as usize] = place as u32;
        }
        fn gather<T: Copy + Send + Sync>(from: &mut Vec<T>, order: &[(u64, u32)]) {
            *from = order.par_iter().map(|&(_, point)| from[point as usize]).collect();
        }
        if let Some(wedges) = &mut self.wedges {
            wedges.reorder(&order);
        }
        gather(&mut self.positions, &order);
        gather(&mut self.quadrics, &order);
        gather(&mut self.kinds, &order);
        gather(&mut self.vertices, &order);
        self.triangles.par_iter_mut().for_each(|triangle| {
            *triangle = triangle.map(|point| new[point as usize]);
        });
    }
}

/// Leaves of what clusters did the first contractions, in the order of their keys, that together take away
/// `faces` triangles, if they do.
fn cut<const F: usize>(logs: &mut [Log<F>], faces: usize) {
    let mut counts = vec![0; logs.len()];
    let mut gone = 0;
    for (cluster, contraction) in in_order(logs) {
        if gone >= faces {
            break;
        }
        gone += contraction.faces as usize;
        counts[cluster] += 1;
    }
    logs.iter_mut().zip(counts).for_each(|(log, count)| log.contractions.truncate(count));
}

/// The contractions of all clusters in the order of their keys, with the number of the cluster.
pub fn in_order<const F: usize>(logs: &[Log<F>]) -> impl Iterator<Item = (usize, &Contraction<F>)> {
    let mut order: Vec<(u32, u32, u32)> = vec![];
    for (cluster, log) in logs.iter().enumerate() {
        let own = log.contractions.iter().zip(0..);
        order.extend(own.map(|(contraction, place)| (contraction.key, cluster as u32, place)));
    }
    order.par_sort_unstable();
    order.into_iter().map(|(_, cluster, place)| {
        (cluster as usize, &logs[cluster as usize].contractions[place as usize])
    })
}

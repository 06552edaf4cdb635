//! Which contractions a cluster allows.

use super::{Cluster, NONE, Plan};
use crate::mesh::simplify::detail::perimeter_px;
use crate::mesh::simplify::surface::Kind;
use glam::Vec3;

/// A face may turn by up to 75° in a contraction, or it counts as flipped.
const LEAST_COSINE: f32 = 0.25;

impl<const F: usize> Cluster<'_, F> {
    /// Whether the surface stays what it is: the link condition [Dey1999], no flipped face, boundaries
    /// along themselves, and nothing larger on the screen than the limit allows.
    pub(super) fn is_allowed(&mut self, plan: &mut Plan<F>) -> bool {
        let (removed, kept) = (plan.removed, plan.kept);
        let (ring_of_kept, ring_of_both) = (self.mark + 1, self.mark + 2);
        self.mark += 2;
        // The neighbours of the kept point.
        let mut shared = 0;
        let mut corner = self.heads[kept as usize];
        while corner != NONE {
            let others = self.others(corner);
            for other in others {
                self.marks[other as usize] = ring_of_kept;
            }
            shared += usize::from(others.contains(&removed));
            corner = self.next[corner as usize];
        }
        if shared != if self.kinds[removed as usize] == Kind::Boundary { 1 } else { 2 } {
            return false;
        }
        // Nor does the last triangle of a shell vanish: of its three edges none is inside.
        if shared == 1 && self.degrees[removed as usize] == 1 && self.degrees[kept as usize] == 1 {
            return false;
        }
        // Neighbours of both have to be those of the triangles at the edge.
        let mut common = 0;
        let mut corner = self.heads[removed as usize];
        while corner != NONE {
            let others = self.others(corner);
            let mut in_both = 0;
            for other in others {
                let mark = &mut self.marks[other as usize];
                if *mark == ring_of_kept {
                    *mark = ring_of_both;
                    common += 1;
                }
                in_both += usize::from(*mark == ring_of_both);
            }
            // The kept point may have a triangle with the same two.
            if in_both == 2 && !others.contains(&kept) && self.has_triangle(kept, others) {
                return false;
            }
            corner = self.next[corner as usize];
        }
        common == shared
            && self.keeps_wedges(plan)
            && self.keeps_facing(removed, kept, plan)
            && self.keeps_facing(kept, removed, plan)
            && self.keeps_limit(plan)
    }

    /// Whether each wedge has one to go into, and seams are contracted along themselves.
    fn keeps_wedges(&self, plan: &Plan<F>) -> bool {
        let Some(wedges) = &self.wedges else { return true };
        let (removed, kept) = (plan.removed as usize, plan.kept as usize);
        let pairs: Vec<_> = plan.wedges.iter().flatten().collect();
        if self.kinds[removed] == Kind::Seam {
            let mut at_edge = self.corners(plan.removed).map(|corner| corner as usize / 3);
            let mut next = || at_edge.find(|&t| self.triangles[t].contains(&plan.kept));
            let (Some(a), Some(b)) = (next(), next()) else { return false };
            if pairs.len() == 1 && wedges.groups[a] == wedges.groups[b] {
                return false;
            }
        }
        // Of a point that moves all wedges have to be told.
        let moves = plan.position != self.positions[kept];
        let count = (wedges.starts[kept + 1] - wedges.starts[kept]) as usize;
        let is_clear = match pairs[..] {
            [a, b] => a.0 != b.0 && !(moves && a.1 == b.1),
            _ => true,
        };
        if !is_clear || (moves && pairs.len() != count) {
            return false;
        }
        self.corners(plan.removed).all(|corner| {
            let wedge = wedges.corners[corner as usize / 3][corner as usize % 3];
            pairs.iter().any(|pair| pair.0 == wedge)
        })
    }

    fn has_triangle(&self, point: u32, others: [u32; 2]) -> bool {
        self.corners(point).any(|corner| {
            let these = self.others(corner);
            others.iter().all(|other| these.contains(other))
        })
    }

    /// The others of the triangles at `point`, but for those at `other` too.
    fn staying(&self, point: u32, other: u32) -> impl Iterator<Item = [u32; 2]> {
        let others = self.corners(point).map(|corner| self.others(corner));
        others.filter(move |others| !others.contains(&other))
    }

    /// Whether the triangles at `point`, but for those at `other` too, keep facing as they do with their corner where
    /// the plan puts it.
    fn keeps_facing(&self, point: u32, other: u32, plan: &Plan<F>) -> bool {
        self.staying(point, other).all(|[b, c]| {
            (0..F).all(|frame| {
                let at = |point: u32| self.positions[point as usize][frame];
                let side = at(c) - at(b);
                let before = (at(b) - at(point)).cross(side);
                let after = (at(b) - plan.position[frame]).cross(side);
                let lengths = before.length() * after.length();
                before.dot(after) >= LEAST_COSINE * lengths
                    && (lengths > 0.0 || before == Vec3::ZERO)
            })
        })
    }

    /// Whether no triangle becomes larger on the screen than the limit allows, unless it was so before.
    fn keeps_limit(&self, plan: &mut Plan<F>) -> bool {
        let Some(limit) = self.settings.limit else { return true };
        let seen = self.settings.look(&plan.position, self.unit);
        plan.seen = Some(seen);
        [(plan.removed, plan.kept), (plan.kept, plan.removed)].into_iter().all(|(point, other)| {
            self.staying(point, other).all(|[b, c]| {
                let at = |point: u32| self.seen[point as usize];
                let after = [seen, at(b), at(c)];
                let speed = after.iter().map(|s| s.speed_px).fold(f32::INFINITY, f32::min);
                let perimeter = perimeter_px(&after);
                perimeter <= limit.at(speed)
                    || perimeter <= perimeter_px(&[at(point), at(b), at(c)])
            })
        })
    }
}

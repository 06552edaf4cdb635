//! Rays against triangles without gaps: a ray that meets an edge or a vertex of a closed mesh hits one
//! of the triangles around it, whatever the rounding.
//!
//! Watertight intersection [Woop2013]: the triangle is moved and sheared so that the ray runs along +z
//! from the origin; the signs of the three edge functions U, V, W at (0, 0) decide, and neighbours
//! compute the same number for the edge they share. Where one is 0 in single precision, double
//! precision decides.

use glam::{Vec3, Vec4};

/// A ray at an instant of the shutter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it begins.
    pub origin: Vec3,
    /// Where it goes: finite and not zero. Distances count in lengths of this vector.
    pub direction: Vec3,
    /// From 0, the opening of the shutter, to 1, its closing.
    pub time: f32,
    /// Hits beyond the first and before the second distance count; the first is not negative.
    pub between: [f32; 2],
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The triangle, as the mesh counts them.
    pub triangle: u32,
    /// In lengths of the ray's direction.
    pub distance: f32,
    /// Weights of the triangle's corners, which add up to 1.
    pub barycentrics: [f32; 3],
}

/// What all triangles and boxes need to know of one ray. Four of either are met at a time, one in each
/// lane of a vector.
pub(super) struct RayFrame {
    pub between: [f32; 2],
    /// The axis along which the ray goes farthest comes last.
    axes: [usize; 3],
    /// The origin along each of `axes`.
    origin: [Vec4; 3],
    /// S_x, S_y, S_z of the paper.
    shear: [Vec4; 3],
    inverse_direction: [Vec4; 3],
    /// At which of [`Planes`] the ray enters and leaves along x, y and z.
    crossed: [[usize; 2]; 3],
    /// The origin, moved ahead and back by what rounding can move a triangle.
    origin_for_near: [Vec4; 3],
    origin_for_far: [Vec4; 3],
}

/// Four boxes: their lower x, y and z, then the upper.
pub type Planes = [Vec4; 6];

/// Four triangles: the x, y and z of their first corners, then of the second and the third.
pub type Corners = [[Vec4; 3]; 3];

impl RayFrame {
    /// The frame of `ray` for triangles and boxes between the corners `min` and `max`.
    pub fn new(ray: &Ray, [min, max]: [Vec3; 2]) -> Self {
        let Ray { origin, direction, between, .. } = *ray;
        let z = direction.abs().max_position();
        let [x, y] = if direction[z] < 0.0 { [z + 2, z + 1] } else { [z + 1, z + 2] };
        let axes = [x % 3, y % 3, z];
        let shear = Vec3::new(direction[axes[0]], direction[axes[1]], 1.0) / direction[z];
        // Section 3.3 [Woop2013], with the largest of the lengths in place of each axis's own.
        let reach = (min - origin).abs().max((max - origin).abs()).max_element();
        let slack = Vec3::splat(reach * (10.0 * 0.5 * f32::EPSILON));
        // Finite, so that a ray along a face of a box gives 0 there and not 0·∞; its sign tells 0 from −0.
        let inverse_direction = direction.recip().clamp(Vec3::MIN, Vec3::MAX);
        let ahead = slack.copysign(inverse_direction);
        let lanes = |vector: Vec3| vector.to_array().map(Vec4::splat);
        Self {
            between,
            axes,
            origin: axes.map(|axis| Vec4::splat(origin[axis])),
            shear: lanes(shear),
            inverse_direction: lanes(inverse_direction),
            crossed: [0, 1, 2].map(|axis| match inverse_direction[axis] < 0.0 {
                false => [axis, axis + 3],
                true => [axis + 3, axis],
            }),
            origin_for_near: lanes(origin + ahead),
            origin_for_far: lanes(origin - ahead),
        }
    }

    /// The nearest hit with one of four triangles, from either side: its lane, distance and barycentrics.
    /// `along` tells where a corner of [`Corners`] lies along an axis.
    #[inline]
    pub fn meet(&self, along: impl Fn(usize, usize) -> Vec4) -> Option<(usize, f32, [f32; 3])> {
        let [a, b, c] = [0, 1, 2].map(|corner| {
            let [x, y, z] = [0, 1, 2].map(|k| along(corner, self.axes[k]) - self.origin[k]);
            [x - self.shear[0] * z, y - self.shear[1] * z, self.shear[2] * z]
        });
        let sides = [(c, b), (a, c), (b, a)];
        let mut edges = sides.map(|(p, q)| p[0] * q[1] - p[1] * q[0]);
        let zero = |edge: Vec4| edge.cmpeq(Vec4::ZERO);
        if (zero(edges[0]) | zero(edges[1]) | zero(edges[2])).any() {
            edges = [0, 1, 2].map(|k| {
                let (p, q) = sides[k];
                let [px, py, qx, qy] = [p[0], p[1], q[0], q[1]].map(Vec4::as_dvec4);
                Vec4::select(zero(edges[k]), (px * qy - py * qx).as_vec4(), edges[k])
            });
        }
        let [u, v, w] = edges;
        let determinant = u + v + w;
        let apart = u.min(v).min(w).cmplt(Vec4::ZERO) & u.max(v).max(w).cmpgt(Vec4::ZERO);
        let missed = apart | zero(determinant);
        if missed.all() {
            return None;
        }
        let distance = (u * a[2] + v * b[2] + w * c[2]) / determinant;
        let [from, to] = self.between;
        let between = distance.cmpgt(Vec4::splat(from)) & distance.cmplt(Vec4::splat(to));
        let met = between & !missed;
        if !met.any() {
            return None;
        }
        let distances = Vec4::select(met, distance, Vec4::INFINITY);
        let nearest = distances.min_element();
        let lane = distances.cmpeq(Vec4::splat(nearest)).bitmask().trailing_zeros() as usize;
        Some((lane, nearest, edges.map(|edge| edge[lane] / determinant[lane])))
    }

    /// Distance and barycentrics of the hit with the triangle of `corners`.
    #[cfg(test)]
    pub fn meet_one(&self, corners: [Vec3; 3]) -> Option<(f32, [f32; 3])> {
        let lanes = corners.map(|corner| corner.to_array().map(Vec4::splat));
        self.meet(|corner, axis| lanes[corner][axis])
            .map(|(_, distance, barycentrics)| (distance, barycentrics))
    }

    /// Which of four boxes the ray enters before the end of its distances, as bits, and where. Errs only
    /// on the side of entering [Ize2013]. `plane` tells one of [`Planes`].
    #[inline]
    pub fn enter(&self, plane: impl Fn(usize) -> Vec4) -> (u32, Vec4) {
        let slab = |axis: usize| {
            let [first, last] = self.crossed[axis];
            let inverse = self.inverse_direction[axis];
            let enters = (plane(first) - self.origin_for_near[axis]) * inverse;
            let leaves = (plane(last) - self.origin_for_far[axis]) * inverse;
            (enters, leaves)
        };
        let [x, y, z] = [slab(0), slab(1), slab(2)];
        let [from, to] = self.between.map(Vec4::splat);
        let near = x.0.max(y.0).max(z.0.max(from));
        let far = x.1.min(y.1).min(z.1.min(to));
        // 1 + 2γ₃: what rounding can take from the distance of a slab.
        (near.cmple(far * (1.0 + 3.0 * f32::EPSILON)).bitmask(), near)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{StreamKey, unit};

    fn ray(origin: Vec3, direction: Vec3) -> Ray {
        Ray { origin, direction, time: 0.0, between: [0.0, f32::INFINITY] }
    }

    fn frame(ray: &Ray) -> RayFrame {
        RayFrame::new(ray, [Vec3::ZERO, Vec3::ONE])
    }

    fn meet(ray: &Ray, corners: [Vec3; 3]) -> Option<(f32, [f32; 3])> {
        frame(ray).meet_one(corners)
    }

    /// Where the ray enters a box.
    fn enter(frame: &RayFrame, min: Vec3, max: Vec3) -> Option<f32> {
        let planes = [min.x, min.y, min.z, max.x, max.y, max.z];
        let (lanes, near) = frame.enter(|plane| Vec4::splat(planes[plane]));
        assert!(lanes == 0 || lanes == 15, "{lanes}");
        (lanes == 15).then_some(near.x)
    }

    #[test]
    fn the_nearest_of_four_triangles_is_met_and_every_box_of_its_own() {
        let forward = ray(Vec3::new(0.25, 0.25, 0.0), Vec3::Z);
        let depths = [3.0, -1.0, 2.0, 5.0];
        let flat = |x: f32, y: f32| [Vec4::splat(x), Vec4::splat(y), Vec4::from_array(depths)];
        let corners = [flat(0.0, 0.0), flat(1.0, 0.0), flat(0.0, 1.0)];
        assert_eq!(
            frame(&forward).meet(|corner, axis| corners[corner][axis]),
            Some((2, 2.0, [0.5, 0.25, 0.25]))
        );
        let [zero, one] = [Vec4::ZERO, Vec4::ONE];
        let depth = Vec4::from_array(depths);
        let boxes = [zero, zero, depth, one, one, depth + 0.5];
        let (lanes, near) = frame(&forward).enter(|plane| boxes[plane]);
        assert_eq!(lanes, 0b1101);
        assert!(near.abs_diff_eq(depth, 1e-5) || near.y == 0.0, "{near}");
        let (lanes, _) = frame(&Ray { between: [0.0, 2.5], ..forward }).enter(|plane| boxes[plane]);
        assert_eq!(lanes, 0b0100);
    }

    #[test]
    fn a_hit_by_hand() {
        let corners =
            [Vec3::new(0.0, 0.0, 2.0), Vec3::new(4.0, 0.0, 2.0), Vec3::new(0.0, 4.0, 2.0)];
        // At (1, 2, 2): a quarter of the second corner, a half of the third. Twice the direction halves
        // the distance.
        let forward = ray(Vec3::new(1.0, 2.0, -4.0), Vec3::Z * 2.0);
        assert_eq!(meet(&forward, corners), Some((3.0, [0.25, 0.25, 0.5])));
        let [a, b, c] = corners;
        assert_eq!(meet(&forward, [a, c, b]), Some((3.0, [0.25, 0.5, 0.25])));
        let backward = ray(Vec3::new(1.0, 2.0, 3.0), -Vec3::Z);
        assert_eq!(meet(&backward, corners), Some((1.0, [0.25, 0.25, 0.5])));
        for miss in [
            ray(Vec3::new(1.0, 2.0, -4.0), -Vec3::Z),
            ray(Vec3::new(2.5, 2.0, -4.0), Vec3::Z),
            ray(Vec3::new(0.0, 0.0, 2.0), Vec3::X),
            Ray { between: [0.0, 3.0], ..forward },
            Ray { between: [3.0, 4.0], ..forward },
        ] {
            assert_eq!(meet(&miss, corners), None, "{miss:?}");
        }
    }

    #[test]
    fn triangles_without_area_are_not_hit() {
        let forward = ray(Vec3::new(0.5, 0.5, -1.0), Vec3::Z);
        for corners in [[0.0, 0.0, 1.0], [0.0, 0.5, 1.0], [0.5; 3]] {
            assert_eq!(meet(&forward, corners.map(|x| Vec3::new(x, x, 0.0))), None);
        }
    }

    #[test]
    fn rays_along_the_faces_of_a_box_enter_it() {
        let enters = |origin: [f32; 3], direction: Vec3| {
            enter(&frame(&ray(Vec3::from(origin), direction)), Vec3::ZERO, Vec3::ONE)
        };
        for direction in [Vec3::X, Vec3::new(1.0, -0.0, 0.0), Vec3::new(1.0, 0.0, -0.0)] {
            for (y, z) in [(0.0, 0.5), (1.0, 1.0), (0.5, 0.0), (0.0, 1.0)] {
                let near = enters([-1.0, y, z], direction);
                assert!(near.is_some_and(|near| (near - 1.0).abs() < 1e-5), "{near:?}");
                assert_eq!(enters([2.0, y, z], direction), None);
            }
            assert_eq!(enters([-1.0, 1.001, 0.5], direction), None);
        }
        assert_eq!(enters([0.5; 3], Vec3::Y), Some(0.0));
    }

    /// Also where rounding decides whether the triangle is hit: within 1e-7 of an edge that is the border
    /// of the box, from so near that the box alone would be told apart more finely.
    #[test]
    fn a_ray_that_meets_a_triangle_enters_its_box() {
        let key = StreamKey::new(1, "ray", 0, 0, 0);
        let mut met = 0;
        for draw in 0..100_000 {
            let numbers = |block| key.words(draw, 0, block).map(|word| 2.0 * unit(word) - 1.0);
            let [from, to, x, z] = numbers(0);
            let [along, beyond, size, _] = numbers(1);
            let above = Vec3::from_slice(&numbers(2)[..3]) * 10.0_f32.powf(4.0 * size);
            let corners =
                [Vec3::new(0.0, 0.0, from), Vec3::new(0.0, 0.0, to), Vec3::new(-x.abs(), 0.0, z)];
            let target = corners[0].lerp(corners[1], 0.5 + 0.5 * along) + 1e-7 * beyond * Vec3::X;
            let ray = ray(target + above, -above);
            let [min, max] =
                [Vec3::min, Vec3::max].map(|of| corners.into_iter().reduce(of).unwrap());
            let frame = RayFrame::new(&ray, [min, max]);
            if frame.meet_one(corners).is_some() {
                met += 1;
                assert!(enter(&frame, min, max).is_some(), "{corners:?} {ray:?}");
            }
        }
        assert!((30_000..70_000).contains(&met), "{met}");
    }
}

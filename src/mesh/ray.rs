//! Rays against triangles without gaps: a ray that meets an edge or a vertex of a closed mesh hits one
//! of the triangles around it, whatever the rounding.
//!
//! Watertight intersection [Woop2013]: the triangle is moved and sheared so that the ray runs along +z
//! from the origin; the signs of the three edge functions U, V, W at (0, 0) decide, and neighbours
//! compute the same number for the edge they share. Where one is 0 in single precision, double
//! precision decides.

use glam::{Vec2, Vec3};

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

/// What all triangles and boxes need to know of one ray.
pub(super) struct RayFrame {
    pub ray: Ray,
    /// The axis along which the ray goes farthest comes last.
    axes: [usize; 3],
    /// S_x, S_y, S_z of the paper.
    shear: Vec3,
    inverse_direction: Vec3,
    /// The origin, moved ahead and back by what rounding can move a triangle.
    origin_for_near: Vec3,
    origin_for_far: Vec3,
}

impl RayFrame {
    /// The frame of `ray` for triangles and boxes between the corners `min` and `max`.
    pub fn new(ray: &Ray, min: Vec3, max: Vec3) -> Self {
        let Ray { origin, direction, .. } = *ray;
        let z = direction.abs().max_position();
        let [x, y] = if direction[z] < 0.0 { [z + 2, z + 1] } else { [z + 1, z + 2] };
        let axes = [x % 3, y % 3, z];
        // Section 3.3 [Woop2013], with the largest of the lengths in place of each axis's own.
        let reach = (min - origin).abs().max((max - origin).abs()).max_element();
        let slack = Vec3::splat(reach * (10.0 * 0.5 * f32::EPSILON));
        // The sign of the reciprocal tells 0 from −0 as the slabs need it.
        let inverse_direction = direction.recip();
        let ahead = slack.copysign(inverse_direction);
        Self {
            ray: *ray,
            axes,
            shear: Vec3::new(direction[axes[0]], direction[axes[1]], 1.0) / direction[z],
            inverse_direction,
            origin_for_near: origin + ahead,
            origin_for_far: origin - ahead,
        }
    }

    /// Distance and barycentrics of the hit with the triangle of `corners`, from either side.
    pub fn meet(&self, corners: [Vec3; 3]) -> Option<(f32, [f32; 3])> {
        let [x, y, z] = self.axes;
        let [a, b, c] = corners.map(|corner| {
            let corner = corner - self.ray.origin;
            let along = corner[z];
            let across = Vec2::new(corner[x], corner[y]) - self.shear.truncate() * along;
            across.extend(self.shear.z * along)
        });
        let sides = [(c, b), (a, c), (b, a)].map(|(p, q)| (p.truncate(), q.truncate()));
        let mut edges = sides.map(|(p, q)| p.perp_dot(q));
        if edges.contains(&0.0) {
            edges = sides.map(|(p, q)| p.as_dvec2().perp_dot(q.as_dvec2()) as f32);
        }
        let [u, v, w] = edges;
        if u.min(v).min(w) < 0.0 && u.max(v).max(w) > 0.0 {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        let weights = edges.map(|edge| edge / determinant);
        let distance = weights[0] * a.z + weights[1] * b.z + weights[2] * c.z;
        let [from, to] = self.ray.between;
        (from < distance && distance < to).then_some((distance, weights))
    }

    /// Where the ray enters the box, if it does before `end`. Errs only on the side of entering
    /// [Ize2013]. An axis that the ray keeps still on the border of a slab gives 0·∞, which is no
    /// number and loses every comparison, so that this axis does not count.
    pub fn enter(&self, min: Vec3, max: Vec3, end: f32) -> Option<f32> {
        let mut near = self.ray.between[0];
        let mut far = end;
        for axis in 0..3 {
            let inverse = self.inverse_direction[axis];
            let [first, last] =
                if inverse < 0.0 { [max[axis], min[axis]] } else { [min[axis], max[axis]] };
            let enters = (first - self.origin_for_near[axis]) * inverse;
            let leaves = (last - self.origin_for_far[axis]) * inverse;
            near = if enters > near { enters } else { near };
            far = if leaves < far { leaves } else { far };
        }
        // 1 + 2γ₃: what rounding can take from the distance of a slab.
        (near <= far * (1.0 + 3.0 * f32::EPSILON)).then_some(near)
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
        RayFrame::new(ray, Vec3::ZERO, Vec3::ONE)
    }

    #[test]
    fn a_hit_by_hand() {
        let corners =
            [Vec3::new(0.0, 0.0, 2.0), Vec3::new(4.0, 0.0, 2.0), Vec3::new(0.0, 4.0, 2.0)];
        // At (1, 2, 2): a quarter of the second corner, a half of the third. Twice the direction halves
        // the distance.
        let forward = ray(Vec3::new(1.0, 2.0, -4.0), Vec3::Z * 2.0);
        assert_eq!(frame(&forward).meet(corners), Some((3.0, [0.25, 0.25, 0.5])));
        let [a, b, c] = corners;
        assert_eq!(frame(&forward).meet([a, c, b]), Some((3.0, [0.25, 0.5, 0.25])));
        let backward = ray(Vec3::new(1.0, 2.0, 3.0), -Vec3::Z);
        assert_eq!(frame(&backward).meet(corners), Some((1.0, [0.25, 0.25, 0.5])));
        for miss in [
            ray(Vec3::new(1.0, 2.0, -4.0), -Vec3::Z),
            ray(Vec3::new(2.5, 2.0, -4.0), Vec3::Z),
            ray(Vec3::new(0.0, 0.0, 2.0), Vec3::X),
            Ray { between: [0.0, 3.0], ..forward },
            Ray { between: [3.0, 4.0], ..forward },
        ] {
            assert_eq!(frame(&miss).meet(corners), None, "{miss:?}");
        }
    }

    #[test]
    fn triangles_without_area_are_not_hit() {
        let forward = ray(Vec3::new(0.5, 0.5, -1.0), Vec3::Z);
        for corners in [[0.0, 0.0, 1.0], [0.0, 0.5, 1.0], [0.5; 3]] {
            assert_eq!(frame(&forward).meet(corners.map(|x| Vec3::new(x, x, 0.0))), None);
        }
    }

    #[test]
    fn rays_along_the_faces_of_a_box_enter_it() {
        let enters = |origin: [f32; 3], direction: Vec3| {
            frame(&ray(Vec3::from(origin), direction)).enter(Vec3::ZERO, Vec3::ONE, f32::INFINITY)
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
            let frame = RayFrame::new(&ray, min, max);
            if frame.meet(corners).is_some() {
                met += 1;
                assert!(frame.enter(min, max, f32::INFINITY).is_some(), "{corners:?} {ray:?}");
            }
        }
        assert!((30_000..70_000).contains(&met), "{met}");
    }
}

//! Vertices that lie at one point, made one.

use glam::Vec3;
use std::collections::HashMap;

/// The different points among `positions`, in the order in which they first appear, and for each of
/// `positions` its place among them. Points are the same if their coordinates are equal.
pub fn weld(positions: &[Vec3]) -> (Vec<Vec3>, Vec<u32>) {
    let mut points = vec![];
    let mut places = HashMap::new();
    let indices = positions
        .iter()
        .map(|&position| {
            // −0 is 0.
            let bits = (position + Vec3::ZERO).to_array().map(f32::to_bits);
            *places.entry(bits).or_insert_with(|| {
                points.push(position);
                points.len() as u32 - 1
            })
        })
        .collect();
    (points, indices)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_points_are_one() {
        let next = Vec3::new(f32::from_bits(1), 0.0, 0.0);
        let (points, indices) = weld(&[Vec3::X, Vec3::ZERO, next, -Vec3::ZERO, Vec3::X]);
        assert_eq!(points, [Vec3::X, Vec3::ZERO, next]);
        assert_eq!(indices, [0, 1, 2, 1, 0]);
        assert_eq!(weld(&[]), (vec![], vec![]));
    }
}

//! Warps of uniform numbers into directions, and the angles of directions. Angles are in turns; the
//! polynomials are the same on both devices, which brings the twins together.

use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;

/// (sin 2πu, cos 2πu) for u ∈ [0, 1], to 4·10⁻⁷: Taylor polynomials on the eighth of a turn about
/// the nearest quarter.
pub fn sin_cos_turns(u: f32) -> (f32, f32) {
    let quarter = (4.0 * u + 0.5) as u32 as f32;
    let a = (4.0 * u - quarter) * FRAC_PI_2;
    let a2 = a * a;
    let sin = a * (1.0 + a2 * (-1.0 / 6.0 + a2 * (1.0 / 120.0 + a2 * (-1.0 / 5040.0))));
    let cos = 1.0 + a2 * (-0.5 + a2 * (1.0 / 24.0 + a2 * (-1.0 / 720.0 + a2 * (1.0 / 40320.0))));
    match quarter as u32 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// The angle of (x, y) in turns, from −½ to ½, to 5·10⁻⁸; 0 at the origin. The polynomial interpolates
/// atan(√s)/(2π√s) at the Chebyshev points of [0, 1].
pub fn atan2_turns(y: f32, x: f32) -> f32 {
    let (large, small) = (x.abs().max(y.abs()), x.abs().min(y.abs()));
    let a = small / large.max(1e-30);
    let s = a * a;
    let upper = 0.015_706_787 + s * (-0.009_363_046 + s * (0.003_784_787 + s * -0.000_725_713_4));
    let eighth = a
        * (0.159_154_92
            + s * (-0.053_049_23 + s * (0.031_778_406 + s * (-0.022_286_93 + s * upper))));
    let quarter = if y.abs() > x.abs() { 0.25 - eighth } else { eighth };
    let half = if x < 0.0 { 0.5 - quarter } else { quarter };
    if y < 0.0 { -half } else { half }
}

/// A direction about the unit normal `n` with density cos θ / π per steradian: `n` plus a uniform
/// point of the unit sphere, normalised (Lambert's cosine law by projection; no tangent frame).
pub fn cosine_hemisphere(n: Vec3, u: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = sin_cos_turns(u[1]);
    let sum = n + Vec3::new(r * cos, r * sin, z);
    // Opposite to the normal the sum vanishes: then any direction of the plane's rim will do, and
    // the normal, of measure zero too, is the one that cannot fail.
    let length_squared = sum.length_squared();
    if length_squared < 1e-12 { n } else { sum * (1.0 / length_squared.sqrt()) }
}

/// A uniform point of the unit disk: squares about the middle of [0, 1)² become circles [ShirleyChiu1997], so
/// that what is even stays even.
pub fn concentric_disk(u: [f32; 2]) -> Vec2 {
    let [x, y] = u.map(|u| 2.0 * u - 1.0);
    let (radius, turns) = if x.abs() > y.abs() {
        (x, 0.125 * (y / x))
    } else if y != 0.0 {
        (y, 0.25 - 0.125 * (x / y))
    } else {
        return Vec2::ZERO;
    };
    let (sin, cos) = sin_cos_turns(turns);
    radius * Vec2::new(cos, sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{StreamKey, unit};
    use std::f32::consts::TAU;

    #[test]
    fn the_polynomials_are_sine_and_cosine() {
        for i in 0..=100_000 {
            let u = i as f32 / 100_000.0;
            let (sin, cos) = sin_cos_turns(u);
            let (true_sin, true_cos) = (f64::from(u) * std::f64::consts::TAU).sin_cos();
            let error = (f64::from(sin) - true_sin).abs().max((f64::from(cos) - true_cos).abs());
            assert!(error < 4e-7, "{u}: {error}");
        }
    }

    #[test]
    fn the_polynomial_is_the_arc_tangent() {
        for i in 0..100_000 {
            let angle = (f64::from(i) / 100_000.0 - 0.5) * std::f64::consts::TAU;
            for length in [1e-6, 1.0, 30.0] {
                let (x, y) = ((length * angle.cos()) as f32, (length * angle.sin()) as f32);
                let truth = f64::from(y).atan2(f64::from(x)) / std::f64::consts::TAU;
                let error = (f64::from(atan2_turns(y, x)) - truth).abs();
                assert!(error < 5e-8, "{angle}: {error}");
            }
        }
        assert_eq!(atan2_turns(0.0, 0.0), 0.0);
    }

    /// Bins of equal area hold equal parts of a fine grid, and neighbours stay neighbours.
    #[test]
    fn the_disk_is_filled_evenly() {
        const SIDE: u32 = 512;
        let at = |i: u32, j: u32| concentric_disk([i, j].map(|k| (k as f32 + 0.5) / SIDE as f32));
        let mut bins = [0_u32; 64];
        for (i, j) in (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| (i, j))) {
            let point = at(i, j);
            assert!(point.length() < 1.0);
            let ring = (8.0 * point.length_squared()) as usize;
            let turn = point.y.atan2(point.x) / TAU + 0.5;
            bins[8 * ring + (8.0 * turn).min(7.0) as usize] += 1;
            let step = 2.0 * 2.0 / SIDE as f32;
            assert!(i == 0 || at(i - 1, j).distance(point) < step, "{i} {j}");
            assert!(j == 0 || at(i, j - 1).distance(point) < step, "{i} {j}");
        }
        let expected = f64::from(SIDE * SIDE) / 64.0;
        let is_even = |&n: &u32| (f64::from(n) / expected - 1.0).abs() < 0.05;
        assert!(bins.iter().all(is_even), "{bins:?}");
        assert_eq!(concentric_disk([0.5; 2]), Vec2::ZERO);
    }

    /// χ² of the sampler against its density: bins of equal probability in cos² θ (uniform under the
    /// cosine law) and azimuth. 64 bins, 63 degrees of freedom: above 117 comes once in 30 000.
    #[test]
    fn the_cosine_law_holds() {
        let key = StreamKey::new(1, "warp", 0, 0, 0);
        for n in [Vec3::Y, Vec3::NEG_Z, Vec3::new(0.6, 0.48, -0.64)] {
            let tangent = n.any_orthonormal_vector();
            let bitangent = n.cross(tangent);
            let mut bins = [0_u32; 64];
            const DRAWS: u32 = 64_000;
            for i in 0..DRAWS {
                let [a, b, ..] = key.words(i, 0, 0);
                let d = cosine_hemisphere(n, [unit(a), unit(b)]);
                assert!((d.length() - 1.0).abs() < 1e-5 && d.dot(n) >= 0.0);
                let ring = (8.0 * d.dot(n) * d.dot(n)).min(7.0) as usize;
                let turn = d.dot(bitangent).atan2(d.dot(tangent)) / TAU + 0.5;
                bins[8 * ring + (8.0 * turn).min(7.0) as usize] += 1;
            }
            let expected = f64::from(DRAWS) / 64.0;
            let chi_squared: f64 =
                bins.iter().map(|&n| (f64::from(n) - expected).powi(2) / expected).sum();
            assert!(chi_squared < 117.0, "{n}: {chi_squared}");
        }
    }
}

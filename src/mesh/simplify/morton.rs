//! The order of points along a curve that fills space: what is near on the surface is near in memory.

use glam::Vec3;
use rayon::prelude::*;

/// Bits per axis.
const BITS: u32 = 21;

/// The points 0 to `count` − 1 in the order of their places along Morton's curve, each with its place on the
/// curve. Every `shift` puts the planes at which the curve jumps elsewhere.
pub fn order(count: usize, shift: u32, position: impl Fn(usize) -> Vec3 + Sync) -> Vec<(u64, u32)> {
    let bounds = || (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = (0..count)
        .into_par_iter()
        .map(&position)
        .fold(bounds, |(low, high), p| (low.min(p), high.max(p)))
        .reduce(bounds, |a, b| (a.0.min(b.0), a.1.max(b.1)));
    // A Kronecker sequence in three dimensions, from the root of x⁴ = x + 1.
    let offset = Vec3::new(0.819_172_5, 0.671_043_6, 0.549_700_5) * shift as f32;
    let offset = offset - offset.floor();
    let scale = 1.0 / (high - low).max_element().max(f32::MIN_POSITIVE);
    let cells = (1u32 << (BITS - 1)) as f32;
    let mut keyed: Vec<(u64, u32)> = (0..count)
        .into_par_iter()
        .map(|point| {
            let cell = ((position(point) - low) * scale + offset) * cells;
            let [x, y, z] = cell.to_array().map(|c| spread((c as u32).min((1 << BITS) - 1)));
            (x | y << 1 | z << 2, point as u32)
        })
        .collect();
    keyed.par_sort_unstable();
    keyed
}

/// The bits of `x`, each with two zeros before the next.
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x);
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

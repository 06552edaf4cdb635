//! Random numbers that any frame, shard or prefix of samples can draw alone, and the warps that
//! turn them into directions and texels. Each `.wgsl` file is the twin of the Rust file beside it.

pub mod median_cut;
pub mod random;
pub mod sampler;
pub mod warp;

/// WGSL twin of [`random`].
pub const RANDOM_WGSL: &str = include_str!("random.wgsl");
/// WGSL twin of [`sampler`].
pub const SAMPLER_WGSL: &str = include_str!("sampler.wgsl");
/// WGSL twin of [`warp`].
pub const WARP_WGSL: &str = include_str!("warp.wgsl");

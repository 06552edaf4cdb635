//! How surfaces reflect: patterns of albedo, coats, and what a path finds where it meets something.

pub mod bsdf;
pub mod direct;
pub mod material;
pub mod surface;

/// WGSL twin of [`bsdf`].
pub const BSDF_WGSL: &str = include_str!("bsdf.wgsl");
/// WGSL twin of [`direct`].
pub const DIRECT_WGSL: &str = include_str!("direct.wgsl");
/// WGSL twin of [`material`].
pub const MATERIAL_WGSL: &str = include_str!("material.wgsl");
/// WGSL twin of [`surface`].
pub const SURFACE_WGSL: &str = include_str!("surface.wgsl");

//! How surfaces reflect: how much of each colour, and where to.

pub mod bsdf;
pub mod material;

/// WGSL twin of [`bsdf`].
pub const BSDF_WGSL: &str = include_str!("bsdf.wgsl");
/// WGSL twin of [`material`].
pub const MATERIAL_WGSL: &str = include_str!("material.wgsl");

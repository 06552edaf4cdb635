//! How surfaces reflect. Lambertian throughout, so a surface is its albedo.

pub mod material;

/// WGSL twin of [`material`].
pub const MATERIAL_WGSL: &str = include_str!("material.wgsl");

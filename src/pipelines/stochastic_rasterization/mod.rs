//! Hierarchical stochastic rasterization [Munkberg2011]: each sample of a pixel has its own point, its own instant of the
//! shutter interval and, if the camera has a lens, its own point of that, as with distribution ray tracing, but the
//! triangles are brought to the samples.
//!
//! Method:
//! 1. the shutter interval is cut into segments so short that within each every vertex goes straight and evenly in
//!    homogeneous coordinates (x·z, y·z, z); what moves straight needs but one ([`motion`]);
//! 2. the image is cut into tiles. In which of them a moving triangle can be seen, and when, is told by the planes
//!    through the camera and a tile's sides, to which its corners have distances linear in time, and by its edges,
//!    whose functions are quadratic ([`bounds`]). Neither needs the triangle to be in front of the camera. A
//!    lens sees it from the corners of the square around the lens and from between them ([`motion::Views`]);
//! 3. tile by tile, from front to back, a triangle goes through the slices of time that it is seen in. One that lies
//!    behind all that a slice holds is left out [Boulos2010]; elsewhere the samples of the pixels that it sweeps over
//!    meanwhile are tested, each at its own instant;
//! 4. what each sample sees is shaded by the lights alone.
//!
//! The samples are those of distribution ray tracing, number by number.
//!
//! On a graphics device (`compute.rs`) the planes tell alone: for models of 70,000 faces and more, edges would spare a
//! twentieth of the triangles in tiles and less of the tests, two fifths for one of 968. Triangles come in layers of
//! depth, in any order within them; a slice of time is that of the next few samples of each pixel.

#[cfg(feature = "gpu")]
pub mod bins;
pub mod bounds;
#[cfg(feature = "gpu")]
pub mod compute;
pub mod motion;
pub mod reference;
#[cfg(test)]
mod tests;

/// Width and height of a tile, in pixels.
pub const TILE: u32 = 8;

/// Layers of depth on a graphics device.
#[cfg(feature = "gpu")]
const LAYERS: u32 = 4;

/// Slices of time that samples are sorted into, for so many samples in each pixel: one or two samples each.
pub fn slices(samples: u32) -> u32 {
    (samples / 2).clamp(1, 32)
}

/// WGSL twin of [`motion`], with what shaders need to know of tiles.
#[cfg(feature = "gpu")]
fn moving_wgsl() -> String {
    let constants = format!("const TILE = {TILE}u;\nconst LAYERS = {LAYERS}u;\n");
    constants + include_str!("moving.wgsl")
}

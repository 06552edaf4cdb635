//! Distribution ray tracing (Cook, Porter and Carpenter 1984): each sample of a pixel is one path, with its
//! own point in the pixel and its own instant of the shutter interval, at which all that moves stands still.
//!
//! Method, for sample s of a pixel:
//! 1. draw a point of the pixel (box filter), an instant of the shutter interval (by its profile) and, if the camera
//!    has a lens, a point of it;
//! 2. follow the ray; at each of at most five surface hits, look at every light without extent, draw a
//!    light direction from the environment (next-event estimation) and one from the surface to go on;
//! 3. weigh the two by the balance heuristic (Veach and Guibas 1995): the light sample adds
//!    f · L cos θ / (p_light + p_surface), and light met by going on adds
//!    f cos θ / p_surface · L · p_surface / (p_light + p_surface);
//! 4. nothing is clamped, and there is no roulette: the fifth hit still sees the light.
//!
//! | symbol | here |
//! |---|---|
//! | shutter instant | `shutter` ∈ [−½, ½], the part of the interval from its middle |
//! | block 0 of a sample's words | x, y in the pixel, instant, shift of the camera's look at the sky |
//! | block 1 + k | two for the light sample at hit k, two for the direction to go on |
//!
//! The scalar twin in [`mod@reference`] is the specification; `trace.wgsl` follows it line by line
//! with the same random words.

#[cfg(feature = "gpu")]
pub mod compute;
pub mod reference;
#[cfg(test)]
mod tests;

/// Surface hits along a path.
pub const MAX_HITS: u32 = 5;

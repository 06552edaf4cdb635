//! The accumulation buffer (Haeberli and Akeley 1990): whole images at instants of the shutter interval, averaged.
//!
//! Method, for N images:
//! 1. image k shows the instant that the part (k + ½)/N of the light has come through by, at the centres of N equal
//!    shares, so that the joins between frames weigh no more than any other instant;
//! 2. all of it is seen through one point of the pixel and, if the camera has a lens, from one point of it; both differ
//!    from image to image and are with the instants evenly spread in five dimensions;
//! 3. triangles are rasterized, and what is seen in each pixel is shaded by the lights alone;
//! 4. radiance is added up in linear single precision.
//!
//! All pixels have their instants in common, so that too few of them show as separate images, never as noise.

#[cfg(feature = "gpu")]
pub mod drawing;
pub mod reference;
#[cfg(feature = "gpu")]
pub mod render;

use super::frame::FrameParams;
use crate::sampling::random::{StreamKey, unit};
use crate::sampling::sampler;
use crate::sampling::warp::concentric_disk;
use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat3, Vec2, Vec3};

/// One of the images, as both devices read it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Image {
    /// The point of the pixel that it is seen through, from 0 to 1.
    pub in_pixel: [f32; 2],
    /// The point of the lens, a unit disk, that it is seen from.
    pub lens: Vec2,
    /// Its instant, as part of the shutter interval from its middle.
    pub shutter: f32,
    /// Looks the environment up a little aside.
    pub word: u32,
    /// Fills up to a multiple of 16 bytes.
    padding: [u32; 2],
}

impl Image {
    /// Takes (x·z, y·z, z), as the middle of the lens sees a point, to where this image has it: at the centre of a pixel
    /// what its rays go through.
    fn shift(&self, params: &FrameParams) -> Affine3A {
        let to_centre = Vec2::from(self.in_pixel.map(|at| 0.5 - at));
        let [near, with_depth] = params.camera.parallax(self.lens);
        let shear = Mat3::from_cols(Vec3::X, Vec3::Y, (to_centre + with_depth).extend(1.0));
        Affine3A::from_mat3_translation(shear, near.extend(0.0))
    }
}

/// The images of a frame that is made of `count`.
fn images(params: &FrameParams, count: u32) -> Vec<Image> {
    let shutter = params.shutter();
    let image = |k: u32| {
        // The first four dimensions of Sobol', which with k/N make a set that is even in all five.
        let [[_, v, x, word], [y, u, ..]] =
            sampler::first_blocks(params.sampler(), StreamKey(params.key), count, 0, k);
        let share = (k as f32 + 0.5) / count as f32;
        Image {
            in_pixel: [x, y].map(unit),
            lens: concentric_disk([u, v].map(unit)),
            shutter: shutter.instant(share),
            word,
            padding: [0; 2],
        }
    };
    (0..count).map(image).collect()
}

//! Samples gathered into an image: box reconstruction over one pixel, in the order of the samples.

pub mod measure;

use crate::scene::environment::luminance;
use glam::{Vec4, Vec4Swizzles};
use shutterlab_stimuli::LinearImage;

/// The sums that a Monte Carlo pipeline gathers over the samples of each pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples in each pixel.
    pub samples: u32,
    /// Per pixel, row by row from the top left: Σ radiance, and Σ luminance².
    pub sums: Vec<Vec4>,
}

impl Film {
    /// The mean of the samples.
    pub fn image(&self) -> LinearImage {
        let scale = 1.0 / self.samples as f32;
        let pixels = self.sums.iter().map(|sum| (sum.xyz() * scale).to_array()).collect();
        LinearImage { width: self.width, height: self.height, pixels }
    }

    /// Per pixel, the mean of the samples' luminance and the estimated variance of that mean. It
    /// takes at least two samples.
    pub fn luminance_statistics(&self) -> Vec<(f64, f64)> {
        let n = f64::from(self.samples);
        let statistics = |sum: &Vec4| {
            let mean = f64::from(luminance(sum.xyz())) / n;
            let variance = (f64::from(sum.w) / n - mean * mean).max(0.0) / (n - 1.0);
            (mean, variance)
        };
        self.sums.iter().map(statistics).collect()
    }
}

//! A stimulus: one cell of a grid, with every parameter that its pixels depend on.

use crate::frames::Transfer;
use crate::scene::{Material, Scene};
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

/// One cell of a grid, resolved: the same stimulus gives the same image on any renderer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stimulus {
    /// The level names, joined in the order of the axes: `M2-S2-T5-A3`.
    pub id: String,
    /// Level name per axis.
    pub levels: IndexMap<String, String>,
    /// How it is rendered.
    pub method: Method,
    /// Surface pattern of the sphere.
    pub material: Material,
    /// Screen velocity of the sphere's centre, in degrees of visual angle per second.
    pub speed_deg_per_s: f64,
    /// Velocity of the sphere, in metres per second.
    pub speed_m_per_s: f64,
    /// Part of the frame time that the shutter is open, centred on the frame's time; 0 is an instant.
    pub shutter_open_fraction: f64,
    /// Camera paths per pixel.
    pub samples: u32,
    /// Seed of all noise of the grid.
    pub seed: u64,
    /// What sets this stimulus's noise apart from that of others: its level names without the
    /// number of samples, so that fewer samples are a prefix of more.
    pub noise_stream: String,
    /// Which realisation of the noise this is, from 0.
    pub exemplar: u32,
    /// Size, length and encoding.
    pub image: ImageFormat,
    /// Pixels per degree of visual angle.
    pub pixels_per_degree: f64,
    /// What happens when the sphere leaves the view.
    pub edge: Edge,
    /// What is in view.
    pub scene: Scene,
}

/// Rendering methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Path tracing with samples spread over the shutter interval (Cook, Porter and Carpenter 1984).
    DistributionRayTracing,
}

/// Size, length and encoding of a sequence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageFormat {
    /// Width of a frame.
    pub width_px: u32,
    /// Height of a frame.
    pub height_px: u32,
    /// Frames per second.
    pub fps: f64,
    /// Number of frames.
    pub frames: u32,
    /// Exposure as a power of two.
    pub exposure_stops: f64,
    /// Encoding of the 8-bit frames.
    pub transfer: Transfer,
}

/// What happens when the sphere leaves the view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Edge {
    /// Nothing: it passes once.
    Once,
    /// When sphere and streak are wholly outside, it comes back in on the other side.
    Wrap,
    /// It turns back where it would begin to leave the view.
    Bounce,
}

/// Where the sphere is during one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpherePath {
    /// x of the centre at the frame's time, in metres, before any bounce.
    pub x_m: f64,
    /// Change of x from the opening of the shutter to its closing, in metres.
    pub travel_m: f64,
    /// Angle rolled about −z at the frame's time, in radians.
    pub angle_rad: f64,
    /// |x| at which the sphere turns back, if it does.
    pub bounce_m: Option<f64>,
}

impl Stimulus {
    /// Where the sphere is during frame `frame`.
    ///
    /// At time t it has covered x(t) = v·(t − half the sequence's length). With `wrap` the period
    /// is 2·(half the view's width + radius + v/fps), and whole periods are taken off per frame,
    /// so that no shutter interval contains the jump; the angle follows the unwrapped distance.
    pub fn sphere_path(&self, frame: u32) -> SpherePath {
        let radius = self.scene.sphere.radius_m;
        let ImageFormat { fps, frames, .. } = self.image;
        let covered = self.speed_m_per_s * (f64::from(frame) - f64::from(frames) / 2.0) / fps;
        let half_view = self.half_view_width_m();
        let (x_m, bounce_m) = match self.edge {
            Edge::Once => (covered, None),
            Edge::Wrap => {
                let period = 2.0 * (half_view + radius + self.speed_m_per_s / fps);
                (covered - period * (covered / period).round(), None)
            }
            Edge::Bounce => {
                let turn = half_view - radius;
                // Four turns are a whole period; within it the renderer mirrors at ±turn.
                let period = 4.0 * turn;
                (covered - period * (covered / period).round(), Some(turn))
            }
        };
        // A bouncing sphere rolls back: its angle is that of its mirrored place, which the renderer
        // derives from x, so x and angle must agree before mirroring.
        let rolled = if bounce_m.is_some() { x_m } else { covered };
        SpherePath {
            x_m,
            travel_m: self.speed_m_per_s * self.shutter_open_fraction / fps,
            angle_rad: (rolled / radius) % std::f64::consts::TAU,
            bounce_m,
        }
    }

    /// Half the width of the view at the sphere's distance, in metres.
    pub fn half_view_width_m(&self) -> f64 {
        let width = self.image.width_px;
        0.5 * f64::from(width) / self.scene.camera.pixels_per_metre(width)
    }
}

//! A stimulus: one cell of a grid, with every parameter that its pixels depend on.

use crate::frames::{EncodedImage, LinearImage, Transfer};
use crate::scene::{Camera, Material, Scene};
use crate::stereo::{Convergence, EyeNoise, Stereo};
use crate::viewing::Viewing;
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
    /// The same in pixels per second.
    pub speed_px_per_s: f64,
    /// Velocity of the sphere, in metres per second.
    pub speed_m_per_s: f64,
    /// Part of the frame time that the shutter is open, centred on the frame's time; 0 is an instant.
    pub shutter_open_fraction: f64,
    /// What the shutter lets through while it is open.
    pub shutter_profile: ShutterProfile,
    /// Camera paths per pixel.
    pub samples: u32,
    /// Where in pixel, shutter time and light they fall.
    pub sampler: Sampler,
    /// Seed of all noise of the grid.
    pub seed: u64,
    /// What sets this stimulus's noise apart from that of others: its level names, with nested
    /// sampling without the number of samples, so that fewer samples are a prefix of more.
    pub noise_stream: String,
    /// Which realisation of the noise this is, from 0.
    pub exemplar: u32,
    /// Size, length and encoding.
    pub image: ImageFormat,
    /// How large the image appears.
    pub viewing: Viewing,
    /// Pixels per degree of visual angle, that is: per image width over its angle.
    pub pixels_per_degree: f64,
    /// What happens when the sphere leaves the view.
    pub trajectory: Trajectory,
    /// Two eyes, or one.
    pub stereo: Option<Stereo>,
    /// What is in view.
    pub scene: Scene,
}

impl ShutterProfile {
    /// All light from opening to closing.
    pub(crate) fn full() -> Self {
        Self::Box {}
    }
}

/// What one eye sees of a stimulus.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The camera in its place.
    pub camera: Camera,
    /// Where the camera's axis meets the image, in pixels to the right of its centre.
    pub shift_px: f64,
    /// Which noise it has: views with the same number have the same.
    pub noise: u32,
}

/// Where in the pixel, the shutter interval and the light the samples fall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sampler {
    /// Independent random numbers.
    Random,
    /// Correlated multi-jittered (Kensler 2013): knows the number of samples.
    Stratified,
    /// Owen-scrambled Sobol' (Burley 2020).
    Sobol,
}

/// How much light the shutter lets through over its interval. Fractions are of the interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum ShutterProfile {
    /// All of it, from opening to closing.
    Box {},
    /// Opens and closes linearly.
    Trapezoid {
        /// Length of either ramp, up to a half.
        ramp_fraction: f64,
    },
    /// A Gaussian about the middle, cut off at the ends.
    Gaussian {
        /// Its standard deviation.
        sigma_fraction: f64,
    },
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
pub enum Trajectory {
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
    /// Name of its sequence folder: the id, and the number of the exemplar where it is not the first.
    pub fn folder_name(&self) -> String {
        match self.exemplar {
            0 => self.id.clone(),
            exemplar => format!("{}-E{exemplar}", self.id),
        }
    }

    /// Where the sphere is during frame `frame`.
    ///
    /// At time t it has covered x(t) = v·(t − half the sequence's length). With `wrap` the period
    /// is 2·(half the view's width + radius + v/fps), and whole periods are taken off per frame,
    /// so that no shutter interval contains the jump; the angle follows the unwrapped distance. The
    /// shadow may reach into the view from a sphere that is outside: it comes in with the jump.
    pub fn sphere_path(&self, frame: u32) -> SpherePath {
        let radius = self.scene.sphere.radius_m;
        let ImageFormat { fps, frames, .. } = self.image;
        let covered = self.speed_m_per_s * (f64::from(frame) - f64::from(frames) / 2.0) / fps;
        let half_view = self.half_view_width_m();
        let (x_m, bounce_m) = match self.trajectory {
            Trajectory::Once => (covered, None),
            Trajectory::Wrap => {
                let period = 2.0 * (half_view + radius + self.speed_m_per_s / fps);
                (covered - period * (covered / period).round(), None)
            }
            Trajectory::Bounce => {
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

    /// What the eyes see: one view, or left and right.
    pub fn views(&self) -> Vec<View> {
        let camera = &self.scene.camera;
        let Some(stereo) = &self.stereo else {
            return vec![View { camera: camera.clone(), shift_px: 0.0, noise: 0 }];
        };
        let half = 0.5e-3 * stereo.interocular_mm;
        let axis_shift_px = half * camera.pixels_per_metre(self.image.width_px);
        let view = |side: f64, eye: u32| {
            let offset = camera.right().map(|component| side * half * component);
            let moved = |point: [f64; 3]| std::array::from_fn(|i| point[i] + offset[i]);
            let position_m = moved(camera.position_m);
            let (look_at_m, shift_px) = match stereo.convergence {
                Convergence::ToeIn => (camera.look_at_m, 0.0),
                Convergence::OffAxis => (moved(camera.look_at_m), side * axis_shift_px),
            };
            let noise = match stereo.noise {
                EyeNoise::Independent => eye,
                EyeNoise::Shared => 0,
            };
            View { camera: Camera { position_m, look_at_m, ..camera.clone() }, shift_px, noise }
        };
        vec![view(-1.0, 0), view(1.0, 1)]
    }

    /// Width and height of a frame, all views in it.
    pub fn frame_size_px(&self) -> [u32; 2] {
        let ImageFormat { width_px, height_px, .. } = self.image;
        self.stereo
            .as_ref()
            .map_or([width_px, height_px], |stereo| stereo.layout.size_px([width_px, height_px]))
    }

    /// The frame made of the linear images of the [`Stimulus::views`], encoded.
    pub fn encode(&self, views: &[LinearImage]) -> EncodedImage {
        let encode =
            |image: &LinearImage| image.encode(self.image.exposure_stops, self.image.transfer);
        match (&self.stereo, views) {
            (Some(stereo), [left, right]) => stereo.layout.compose([left, right], encode),
            _ => encode(&views[0]),
        }
    }

    /// Half the width of the view at the sphere's distance, in metres.
    pub fn half_view_width_m(&self) -> f64 {
        let width = self.image.width_px;
        0.5 * f64::from(width) / self.scene.camera.pixels_per_metre(width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Grid, Selection};

    fn stimulus(speed: &str, trajectory: Trajectory) -> Stimulus {
        let mut grid = Grid::load("rolling-sphere-mono").unwrap();
        grid.trajectory = trajectory;
        let select = format!("material=checker,speed={speed},shutter=T5,samples=A1");
        grid.stimuli(&Selection::parse(&[select], &grid).unwrap()).unwrap().remove(0)
    }

    /// The numbers of the thesis's geometry: 640 px over 14.4°, a 50 mm lens on 36 mm, 3 m away.
    #[test]
    fn the_thesis_geometry_holds() {
        let near = |value: f64, known: f64| {
            assert!((value - known).abs() < 1e-3 * known, "{value} {known}")
        };
        for (speed, metres_per_second) in [("S1", 0.75664), ("S2", 1.51327), ("S3", 2.26991)] {
            let stimulus = stimulus(speed, Trajectory::Wrap);
            near(stimulus.speed_m_per_s, metres_per_second);
            near(stimulus.pixels_per_degree, 44.44);
            near(stimulus.half_view_width_m(), 1.0896);
            near(stimulus.scene.camera.pixels_per_metre(640), 293.697);
        }
    }

    #[test]
    fn the_sphere_is_in_the_middle_at_half_time_at_any_speed() {
        for trajectory in [Trajectory::Once, Trajectory::Wrap, Trajectory::Bounce] {
            for speed in ["S1", "S2", "S3"] {
                let path = stimulus(speed, trajectory).sphere_path(60);
                assert_eq!((path.x_m, path.angle_rad), (0.0, 0.0));
            }
        }
    }

    /// From one frame to the next the sphere goes on by v/fps, or it jumps by a whole period. Where
    /// it jumps nothing is lost: had it gone on, and had it come in a frame earlier, it would have
    /// been out of view for the whole shutter time.
    #[test]
    fn the_sphere_is_never_seen_to_jump() {
        for speed in ["S1", "S2", "S3"] {
            let stimulus = stimulus(speed, Trajectory::Wrap);
            let step = stimulus.speed_m_per_s / stimulus.image.fps;
            let outside = stimulus.half_view_width_m() + stimulus.scene.sphere.radius_m;
            let mut jumps = 0;
            for frame in 1..stimulus.image.frames {
                let (before, after) =
                    (stimulus.sphere_path(frame - 1), stimulus.sphere_path(frame));
                if (after.x_m - before.x_m - step).abs() > 1e-9 {
                    jumps += 1;
                    let gone_on = before.x_m + step - before.travel_m / 2.0;
                    let come_earlier = after.x_m - step + after.travel_m / 2.0;
                    assert!(gone_on > outside && come_earlier < -outside, "{speed}: {before:?}");
                }
            }
            assert!(jumps > 0, "{speed}");
        }
    }

    /// Rolling without slipping: the angle is the distance over the radius, jumps or not.
    #[test]
    fn the_sphere_rolls_without_slipping() {
        let stimulus = stimulus("S3", Trajectory::Wrap);
        let step = stimulus.speed_m_per_s / stimulus.image.fps / stimulus.scene.sphere.radius_m;
        for frame in 1..stimulus.image.frames {
            let turned =
                stimulus.sphere_path(frame).angle_rad - stimulus.sphere_path(frame - 1).angle_rad;
            let whole_turns = (turned - step) / std::f64::consts::TAU;
            assert!((whole_turns - whole_turns.round()).abs() < 1e-9, "{frame}: {turned}");
        }
    }

    #[test]
    fn a_bouncing_sphere_stays_in_view() {
        let stimulus = stimulus("S3", Trajectory::Bounce);
        let turn = stimulus.half_view_width_m() - stimulus.scene.sphere.radius_m;
        for frame in 0..stimulus.image.frames {
            let path = stimulus.sphere_path(frame);
            assert_eq!(path.bounce_m, Some(turn));
            // Mirrored once at ±turn, as the renderer does, it is within ±turn.
            assert!(path.x_m.abs() <= 2.0 * turn + 1e-9, "{frame}: {path:?}");
        }
    }
}

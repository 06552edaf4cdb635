//! A stimulus: one cell of a grid, with every parameter that its pixels depend on.

use crate::assets::{Kind, made};
use crate::frames::{EncodedImage, LinearImage, Transfer};
use crate::scene::object::dot;
use crate::scene::{
    Camera, Environment, Illumination, LightMap, Material, Motion, Object, Scene, Shape,
};
use crate::simplification::Simplification;
use crate::stereo::{Convergence, EyeNoise, Stereo};
use crate::viewing::Viewing;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use shutterlab_data_schema::definition::DefinitionError;

/// Longest side of an image.
pub const MAX_SIDE_PX: u32 = 16384;

/// Most frames of a sequence.
pub const MAX_FRAMES: u32 = 9999;

/// Most camera paths per pixel.
pub const MAX_SAMPLES: u32 = 1 << 20;

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
    /// Surface of the objects that have none of their own.
    pub material: Material,
    /// Screen velocity of what moves at the stimulus's speed across the view, at the distance of the point
    /// that the camera looks at, in degrees of visual angle per second.
    pub speed_deg_per_s: f64,
    /// The same in pixels per second.
    pub speed_px_per_s: f64,
    /// The same in metres per second.
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
    /// What happens when what moves at the stimulus's speed leaves the view.
    pub trajectory: Trajectory,
    /// Two eyes, or one.
    pub stereo: Option<Stereo>,
    /// What is in view.
    pub scene: Scene,
    /// How the scene's only mesh is simplified, if it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simplification: Option<Simplification>,
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
    /// The camera in its place at the frame's time.
    pub camera: Camera,
    /// How far its pinhole and the point it looks at go while the shutter is open, in metres.
    pub travel_m: [[f64; 3]; 2],
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Path tracing with samples spread over the shutter interval (Cook, Porter and Carpenter 1984).
    DistributionRayTracing,
    /// Whole images at instants of the shutter interval, averaged (Haeberli and Akeley 1990).
    AccumulationBuffer,
    /// Moving triangles drawn into samples that each have their own instant (Munkberg et al. 2011).
    StochasticRasterization,
}

impl Method {
    /// All there are, with their names in files.
    pub const ALL: [(&str, Self); 3] = [
        ("distribution-ray-tracing", Self::DistributionRayTracing),
        ("accumulation-buffer", Self::AccumulationBuffer),
        ("stochastic-rasterization", Self::StochasticRasterization),
    ];

    /// Whether it draws what the camera sees and knows of no light but the lamps'.
    pub fn is_local(self) -> bool {
        self != Self::DistributionRayTracing
    }
}

impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = Self::ALL.iter().find(|(_, method)| method == self).map(|(name, _)| *name);
        f.write_str(name.unwrap_or_default())
    }
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

/// What happens when what moves at the stimulus's speed leaves the view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Trajectory {
    /// Nothing: it passes once.
    Once,
    /// When object and streak are wholly outside, it comes back in on the other side.
    Wrap,
    /// It turns back where it would begin to leave the view.
    Bounce,
}

/// Where an object is during one frame. Distances are along its path, from where it is when half of the
/// sequence has passed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObjectPath {
    /// Distance at the frame's time, in metres, before any bounce.
    pub distance_m: f64,
    /// Change of the distance from the opening of the shutter to its closing, in metres.
    pub travel_m: f64,
    /// Distance on either side at which it turns back, if it does.
    pub bounce_m: Option<f64>,
    /// Angle turned about its axis at the frame's time, in radians; the whole turns are left out.
    pub angle_rad: f64,
    /// Part of the way from the first pose to the second at the frame's time; past the second it
    /// goes back, and so on. Whole rounds, of 2, are left out.
    pub pose: f64,
}

impl Stimulus {
    /// Name of its sequence folder: the id, and the number of the exemplar where it is not the first.
    pub fn folder_name(&self) -> String {
        match self.exemplar {
            0 => self.id.clone(),
            exemplar => format!("{}-E{exemplar}", self.id),
        }
    }

    /// What its model is called: its level of that axis or, if it is simplified, the object.
    pub fn model(&self) -> Option<&str> {
        let is_mesh = |object: &&Object| matches!(object.shape, Shape::Mesh { .. });
        let object = || self.scene.objects.iter().find(is_mesh).map(|object| object.name.as_str());
        let level = self.levels.get("model").map(String::as_str);
        level.or_else(|| self.simplification.and_then(|_| object()))
    }

    /// Whether it shows a simplified model where `other`, alike in all else, shows the original.
    pub fn is_simplified_from(&self, other: &Self) -> bool {
        let is_other =
            |(axis, _): &(&String, _)| !["r", "level_of_detail"].contains(&axis.as_str());
        self.simplification.is_some()
            && other.simplification.is_none()
            && self.exemplar == other.exemplar
            && self.levels.iter().filter(is_other).eq(other.levels.iter().filter(is_other))
    }

    /// The surface of `object`.
    pub fn material_of<'a>(&'a self, object: &'a Object) -> &'a Material {
        object.material.as_ref().unwrap_or(&self.material)
    }

    /// Where `object` is during frame `frame`.
    ///
    /// In frame f it has covered v·(f − half the number of frames, rounded down)/fps. With `wrap` the period is 2·(half the
    /// view's width + how far aside its path's middle is + the object's radius + v/fps), and whole periods
    /// are taken off per frame, so that no shutter interval contains the jump; angle and pose follow the
    /// unwrapped distance. The shadow may reach into the view from an object that is outside: it comes in
    /// with the jump.
    pub fn path(&self, object: &Object, frame: u32) -> ObjectPath {
        let Some(motion) = &object.motion else { return ObjectPath::default() };
        let ImageFormat { fps, .. } = self.image;
        let speed = motion.speed_m_per_s.unwrap_or(self.speed_m_per_s);
        let covered = speed * self.seconds_past_half(frame);
        let folded = |period: f64| covered - period * (covered / period).round();
        let (distance_m, bounce_m) = match self.trajectory_of(object) {
            Trajectory::Once => (covered, None),
            Trajectory::Wrap => (folded(2.0 * (self.reach_m(object)[1] + speed / fps)), None),
            Trajectory::Bounce => {
                let turn = self.reach_m(object)[0];
                // Four turns are a whole period; within it the renderer mirrors at ±turn.
                (folded(4.0 * turn), Some(turn))
            }
        };
        // What bounces turns back, too: its angle and pose are those of its mirrored place, which the
        // renderer derives from the distance, so they must agree before mirroring.
        let done = if bounce_m.is_some() { distance_m } else { covered };
        let angle_rad = motion.rotation.map_or(0.0, |rotation| done / rotation.radius_m);
        let poses = motion.deformation.as_ref().map_or(0.0, |d| 0.5 + done / d.distance_m);
        ObjectPath {
            distance_m,
            travel_m: speed * self.shutter_open_fraction / fps,
            bounce_m,
            angle_rad: angle_rad % std::f64::consts::TAU,
            pose: poses.rem_euclid(2.0),
        }
    }

    /// The trajectory concerns what goes somewhere at the stimulus's speed.
    fn trajectory_of(&self, object: &Object) -> Trajectory {
        match &object.motion {
            Some(Motion { speed_m_per_s: None, translation: Some(_), .. }) => self.trajectory,
            _ => Trajectory::Once,
        }
    }

    /// How far `object` can go on its path across the view before it begins to leave it, and how far at
    /// most until it is out of it, on either side, in metres.
    fn reach_m(&self, object: &Object) -> [f64; 2] {
        let [ahead, aside] = self.scene.camera.ahead_and_aside_m(object.position_m);
        let width = self.image.width_px;
        let half_view = 0.5 * f64::from(width) / self.scene.camera.focal_length_px(width) * ahead;
        let radius = object.radius_m().unwrap_or(0.0);
        [half_view - aside.abs() - radius, half_view + aside.abs() + radius]
    }

    fn seconds_past_half(&self, frame: u32) -> f64 {
        // Of an odd number of frames the middle one shows the middle.
        (f64::from(frame) - f64::from(self.image.frames / 2)) / self.image.fps
    }

    /// Refuses what the scene and the grid do not allow together; `grid` is the grid's name.
    pub(crate) fn check(&self, grid: &str) -> Result<(), DefinitionError> {
        if self.method.is_local() && self.scene.illumination != Illumination::Local {
            let allowed = "with this method the scene's `illumination` is to be \"local\"";
            return Err(DefinitionError::value(grid, "method", self.method, allowed));
        }
        if self.scene.camera.motion.is_some() {
            for frame in 0..self.image.frames {
                let distance = self.camera_at(frame).0.look_at_distance_m();
                if distance < 1e-3 {
                    let allowed =
                        "in no frame may it come nearer than 0.001 m to the point it looks at";
                    let value = format!("{distance} m away in frame {frame}");
                    return Err(DefinitionError::value(
                        grid,
                        "scene: camera.motion",
                        value,
                        allowed,
                    ));
                }
            }
        }
        for object in &self.scene.objects {
            let is_mesh = matches!(object.shape, Shape::Mesh { .. });
            if matches!(self.material_of(object), Material::Model { .. }) && !is_mesh {
                let level = self.levels.get("material").map_or("", String::as_str);
                let field = format!("axes.material.{level}");
                let allowed = format!("only a mesh has a model's file, {} is none", object.name);
                return Err(DefinitionError::value(grid, field, "model", allowed));
            }
            let trajectory = self.trajectory_of(object);
            if trajectory == Trajectory::Once {
                continue;
            }
            let name = &object.name;
            let refuse = |allowed: String| {
                let value = if trajectory == Trajectory::Wrap { "wrap" } else { "bounce" };
                Err(DefinitionError::value(grid, "trajectory", value, allowed))
            };
            let camera = &self.scene.camera;
            if camera.motion.is_some() {
                return refuse("with a camera that moves once is allowed".into());
            }
            if dot(object.direction().unwrap_or_default(), camera.right()).abs() < 1.0 - 1e-6 {
                return refuse(format!(
                    "{name} does not move straight across the view: once is allowed"
                ));
            }
            let Some(radius) = object.radius_m() else {
                return refuse(format!("{name} has no shape.radius_m: once is allowed"));
            };
            if camera.ahead_and_aside_m(object.position_m)[0] <= radius {
                return refuse(format!("{name} is not in front of the camera: once is allowed"));
            }
            if object.motion.as_ref().is_some_and(|motion| motion.deformation.is_some()) {
                return refuse(format!(
                    "{name} changes its shape, so its radius is not known: once is allowed"
                ));
            }
            // Within one frame it turns back once at most.
            let travel = self.path(object, 0).travel_m;
            if trajectory == Trajectory::Bounce && 2.0 * self.reach_m(object)[0] <= travel {
                return refuse(format!(
                    "{name}, of radius {radius} m, has no room to move in the view: once or wrap is allowed"
                ));
            }
        }
        Ok(())
    }

    /// Refuses what no grid resolves to; `file` is the manifest that it stands in.
    pub(crate) fn check_resolved(&self, file: &str) -> Result<(), DefinitionError> {
        let refuse = |field: &str, value: String, allowed: &str| {
            Err(DefinitionError::value(file, field, value, allowed))
        };
        let ImageFormat { width_px, height_px, frames, .. } = self.image;
        for (field, value, most) in [
            ("image.width_px", width_px, MAX_SIDE_PX),
            ("image.height_px", height_px, MAX_SIDE_PX),
            ("image.frames", frames, MAX_FRAMES),
            ("samples", self.samples, MAX_SAMPLES),
        ] {
            if !(1..=most).contains(&value) {
                return refuse(field, value.to_string(), &format!("1 to {most} are allowed"));
            }
        }
        for (file, sha256, _) in self.files() {
            if sha256.len() != 64 || !sha256.bytes().all(|b| b.is_ascii_hexdigit()) {
                return refuse(file, sha256.into(), "a SHA-256 has 64 hexadecimal digits");
            }
        }
        if let Some(simplification) = &self.simplification {
            simplification.check(file)?;
        }
        self.scene.check(file)?;
        self.material.check("material", file)?;
        self.check(file)
    }

    /// Name, hash and use of each file that it is made with.
    pub fn files(&self) -> Vec<(&str, &str, Kind)> {
        let mut files: Vec<(&str, &str, Kind)> = vec![];
        if let Environment::Map(LightMap { file, sha256 }) = &self.scene.environment {
            files.push((file, sha256, Kind::LightMap));
        }
        for object in &self.scene.objects {
            if let Material::Image { file, sha256, .. } = self.material_of(object) {
                files.push((file, sha256, Kind::Picture));
            }
            if let Shape::Mesh { file, sha256, .. } = &object.shape
                && made(file).is_none()
            {
                files.push((file, sha256, Kind::Model));
            }
            let motion = object.motion.as_ref();
            if let Some(second) = motion.and_then(|motion| motion.deformation.as_ref()) {
                files.push((&second.file, &second.sha256, Kind::Model));
            }
        }
        files.sort_by_key(|(_, sha256, _)| *sha256);
        files.dedup();
        files
    }

    /// What the eyes see of frame `frame`: one view, or left and right.
    pub fn views(&self, frame: u32) -> Vec<View> {
        let (camera, travel_m) = self.camera_at(frame);
        let Some(stereo) = &self.stereo else {
            return vec![View { camera, travel_m, shift_px: 0.0, noise: 0 }];
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
            let camera = Camera { position_m, look_at_m, ..camera.clone() };
            View { camera, travel_m, shift_px, noise }
        };
        vec![view(-1.0, 0), view(1.0, 1)]
    }

    /// The camera at the time of frame `frame`, and how far its pinhole and the point it looks at go while
    /// the shutter is open.
    fn camera_at(&self, frame: u32) -> (Camera, [[f64; 3]; 2]) {
        let camera = &self.scene.camera;
        let Some(motion) = camera.motion else { return (camera.clone(), [[0.0; 3]; 2]) };
        let speed = motion.speed_m_per_s.unwrap_or(self.speed_m_per_s);
        let open = self.shutter_open_fraction / self.image.fps;
        let after = |seconds: f64, by: [f64; 3]| by.map(|component| component * speed * seconds);
        let moved = |point: [f64; 3], by: [f64; 3]| {
            let by = after(self.seconds_past_half(frame), by);
            std::array::from_fn(|i| point[i] + by[i])
        };
        let position_m = moved(camera.position_m, motion.position);
        let look_at_m = moved(camera.look_at_m, motion.look_at);
        let travel_m = [after(open, motion.position), after(open, motion.look_at)];
        (Camera { position_m, look_at_m, ..camera.clone() }, travel_m)
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Grid, Selection};

    const RADIUS_M: f64 = 0.1;

    fn stimulus(speed: &str, trajectory: Trajectory) -> Stimulus {
        let mut grid = Grid::load("rolling-sphere-mono").unwrap();
        grid.trajectory = trajectory;
        let select = format!("material=checker,speed={speed},shutter=T5,samples=A1");
        grid.stimuli(&Selection::parse(&[select], &grid).unwrap()).unwrap().remove(0)
    }

    impl Stimulus {
        fn sphere_path(&self, frame: u32) -> ObjectPath {
            self.path(&self.scene.objects[0], frame)
        }

        fn half_view_width_m(&self) -> f64 {
            0.5 * f64::from(self.image.width_px)
                / self.scene.camera.pixels_per_metre(self.image.width_px)
        }
    }

    /// A manifest may come from anywhere: what it lacks is told, not stumbled over.
    #[test]
    fn a_stimulus_without_its_levels_is_refused_all_the_same() {
        let mut meddled = stimulus("S1", Trajectory::Once);
        meddled.material = Material::Model { coat: None };
        meddled.levels.clear();
        let error = meddled.check_resolved("sequence.json").unwrap_err().to_string();
        assert!(error.contains("only a mesh has a model's file, sphere is none"), "{error}");
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
                assert_eq!((path.distance_m, path.angle_rad), (0.0, 0.0));
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
            let outside = stimulus.half_view_width_m() + RADIUS_M;
            let mut jumps = 0;
            for frame in 1..stimulus.image.frames {
                let (before, after) =
                    (stimulus.sphere_path(frame - 1), stimulus.sphere_path(frame));
                if (after.distance_m - before.distance_m - step).abs() > 1e-9 {
                    jumps += 1;
                    let gone_on = before.distance_m + step - before.travel_m / 2.0;
                    let come_earlier = after.distance_m - step + after.travel_m / 2.0;
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
        let step = stimulus.speed_m_per_s / stimulus.image.fps / RADIUS_M;
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
        let turn = stimulus.half_view_width_m() - RADIUS_M;
        for frame in 0..stimulus.image.frames {
            let path = stimulus.sphere_path(frame);
            assert!(path.bounce_m.is_some_and(|bounce| (bounce - turn).abs() < 1e-9));
            // Mirrored once at ±turn, as the renderer does, it is within ±turn.
            assert!(path.distance_m.abs() <= 2.0 * turn + 1e-9, "{frame}: {path:?}");
        }
    }
}

//! A frame of a stimulus as all pipelines read it, and what frames have in common.

use crate::sampling::random::{StreamKey, unit};
use crate::sampling::{sampler, warp};
use crate::scene::camera::Camera;
use crate::scene::environment::Environment;
use crate::scene::import::ImportError;
use crate::scene::object::Object;
use crate::scene::shutter::Shutter;
use crate::scene::world::{Instant, Met, SceneMesh, World};
use crate::shading::bsdf::Bsdf;
use crate::shading::direct::from_lights;
use crate::shading::material::Material;
use crate::shading::surface::Surface;
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};
use shutterlab_stimuli::scene::Illumination;
use shutterlab_stimuli::stimulus::{Sampler, View};
use shutterlab_stimuli::{Stimulus, scene};
use std::path::Path;

/// What frames of stimuli have in common: made anew only where they have not.
#[derive(Debug)]
pub struct Kept<E, W> {
    environment: Option<(scene::Environment, E)>,
    world: Option<(Stimulus, W)>,
}

impl<E, W> Default for Kept<E, W> {
    fn default() -> Self {
        Self { environment: None, world: None }
    }
}

impl<E, W> Kept<E, W> {
    /// The environment and the world of `stimulus`, with what a device makes of them; files are taken from
    /// `assets`.
    pub fn of<F: From<ImportError>>(
        &mut self,
        stimulus: &Stimulus,
        assets: &Path,
        environment: impl FnOnce(Environment) -> Result<E, F>,
        world: impl FnOnce(World) -> Result<W, F>,
    ) -> Result<(&E, &W), F> {
        let wanted = &stimulus.scene.environment;
        let kept = match self.environment.take() {
            Some(kept) if kept.0 == *wanted => kept,
            _ => (wanted.clone(), environment(Environment::load(wanted, assets)?)?),
        };
        let kept_world = match self.world.take() {
            Some(kept) if has_world_of(&kept.0, stimulus) => kept,
            _ => (stimulus.clone(), world(World::load(stimulus, assets)?)?),
        };
        Ok((&self.environment.insert(kept).1, &self.world.insert(kept_world).1))
    }
}

/// Whether two stimuli have the same world. What is simplified is so for its motion.
fn has_world_of(one: &Stimulus, other: &Stimulus) -> bool {
    let motion = |of: &Stimulus| {
        let Stimulus { speed_m_per_s, shutter_open_fraction, trajectory, .. } = of;
        (*speed_m_per_s, *shutter_open_fraction, *trajectory, of.image.clone(), of.stereo.clone())
    };
    one.scene == other.scene
        && one.material == other.material
        && one.simplification == other.simplification
        && (one.simplification.is_none() || motion(one) == motion(other))
}

/// One frame as both devices read it. `frame.wgsl` declares the same struct; a test compares them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FrameParams {
    /// The camera.
    pub camera: Camera,
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Number of the first sample to draw.
    pub first_sample: u32,
    /// How many samples to draw.
    pub sample_count: u32,
    /// See [`StreamKey`].
    pub key: [u32; 2],
    /// How many samples a pixel has in all, for the sampler that needs to know.
    pub strata: u32,
    /// The [`Sampler`].
    pub sampler: u32,
    /// See [`Shutter::kind`].
    pub shutter_kind: u32,
    /// See [`Shutter::width`].
    pub shutter_width: f32,
    /// See [`Shutter::reach`].
    pub shutter_reach: f32,
    /// 1 if light comes from the lights alone: [`Illumination::Local`].
    pub is_local: u32,
    /// The pixel in which the part of the image begins that is drawn.
    pub first_pixel: [u32; 2],
    /// Fills up to a multiple of 16 bytes.
    pub padding: [u32; 2],
}

/// A frame: its parameters, and the objects of its world with their surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// What is alike in all scenes.
    pub params: FrameParams,
    /// The objects, in the order of their world.
    pub objects: Vec<Object>,
    /// The pattern of each.
    pub materials: Vec<Material>,
    /// How each scatters light.
    pub bsdfs: Vec<Bsdf>,
}

impl Frame {
    /// Frame number `frame` of `stimulus`, whose world is `world`, as `view` sees it, with all its samples.
    pub fn new(stimulus: &Stimulus, world: &World, view: &View, frame: u32) -> Self {
        let shutter = Shutter::new(stimulus.shutter_profile);
        let StreamKey(key) = StreamKey::new(
            stimulus.seed,
            &stimulus.noise_stream,
            stimulus.exemplar,
            view.noise,
            frame,
        );
        let params = FrameParams {
            camera: Camera::new(view, stimulus.image.width_px),
            width: stimulus.image.width_px,
            height: stimulus.image.height_px,
            first_sample: 0,
            sample_count: stimulus.samples,
            key,
            strata: stimulus.samples,
            sampler: stimulus.sampler as u32,
            shutter_kind: shutter.kind,
            shutter_width: shutter.width,
            shutter_reach: shutter.reach,
            is_local: u32::from(stimulus.scene.illumination == Illumination::Local),
            first_pixel: [0; 2],
            padding: [0; 2],
        };
        let descriptions: Vec<_> = world.descriptions(stimulus).collect();
        let materials = || descriptions.iter().map(|object| stimulus.material_of(object));
        Self {
            params,
            objects: world.objects(stimulus, frame),
            materials: materials()
                .zip(&world.object_pictures)
                .map(|(material, &picture)| Material::new(material, picture))
                .collect(),
            bsdfs: materials().map(|material| Bsdf::new(material.coat())).collect(),
        }
    }
}

impl Frame {
    /// Radiance of what a ray of the camera meets at an instant of `world`, in the light of the lights alone; of the
    /// environment where it meets nothing, looked up as far aside as `tent` says.
    pub fn local_radiance(
        &self,
        instant: &Instant,
        environment: &Environment,
        met: Option<Met>,
        (origin, direction): (Vec3, Vec3),
        tent: [f32; 2],
    ) -> Vec3 {
        let Some(met) = met else { return environment.evaluate(direction, tent).0 };
        let surface = Surface::new(instant, &self.materials, &met, origin, direction);
        let is_lit = |to_light: Vec3, _| surface.face_normal.dot(to_light) > 0.0;
        let bsdf = &self.bsdfs[met.object];
        from_lights(&instant.world.lights, bsdf, &surface, -direction, is_lit)
    }
}

impl FrameParams {
    /// The ray through the point (`in_x`, `in_y`) of pixel (x, y), both from 0 to 1, at an instant, from a point of the
    /// lens, a unit disk.
    pub fn ray(
        &self,
        [x, y]: [u32; 2],
        [in_x, in_y]: [f32; 2],
        shutter: f32,
        lens: Vec2,
    ) -> (Vec3, Vec3) {
        self.camera.ray(
            x as f32 + in_x - 0.5 * self.width as f32,
            y as f32 + in_y - 0.5 * self.height as f32,
            shutter,
            lens,
        )
    }

    /// The point of the lens that a sample of a pixel sees from; a pinhole has but one.
    pub fn lens(&self, pixel: u32, sample: u32) -> Vec2 {
        if self.camera.lens_radius == 0.0 {
            return Vec2::ZERO;
        }
        let key = StreamKey(self.key);
        let words = sampler::lens_words(self.sampler(), key, self.strata, pixel, sample);
        warp::concentric_disk(words.map(unit))
    }

    /// The sampler.
    pub fn sampler(&self) -> Sampler {
        let all = [Sampler::Random, Sampler::Stratified, Sampler::Sobol];
        // The number was one of these, and a wrong one is an ordinary sampler all the same.
        all.into_iter().find(|&s| s as u32 == self.sampler).unwrap_or(Sampler::Random)
    }

    /// The shutter.
    pub fn shutter(&self) -> Shutter {
        Shutter { kind: self.shutter_kind, width: self.shutter_width, reach: self.shutter_reach }
    }
}

/// Where a ray meets `object`, whose triangle `triangle` it is seen to meet: spheres and planes where they truly are, a mesh
/// where the triangle's plane is.
pub fn met_where(
    instant: &Instant,
    object: usize,
    triangle: u32,
    (origin, direction): (Vec3, Vec3),
) -> Option<Met> {
    let Some(SceneMesh { mesh, .. }) = instant.mesh(object) else {
        return instant.meet(object, origin, direction, f32::INFINITY, false);
    };
    let (of, pose) = (&instant.objects[object], &instant.pose(object));
    let begin = of.to_object(pose, origin - pose.centre);
    let along = of.to_object(pose, direction);
    let corners = mesh.corners(mesh.triangles[triangle as usize], pose.time);
    let [a, b, c] = corners.map(|corner| corner - begin);
    let weights = [b.cross(c), c.cross(a), a.cross(b)].map(|normal| normal.dot(along));
    let sum = weights[0] + weights[1] + weights[2];
    let is_edge_on = sum == 0.0;
    let barycentrics = if is_edge_on { [1.0, 0.0, 0.0] } else { weights.map(|w| w / sum) };
    // Nothing asks a mesh for the distance.
    Some(Met { object, distance: 0.0, triangle, barycentrics })
}

/// How far aside of a direction the camera looks the environment up, by a random word: as far as a texel, so that
/// its texels blur into one another.
pub fn tent(word: u32) -> [f32; 2] {
    [word >> 16, word & 0xffff].map(|half| half as f32 / 65536.0 - 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use shutterlab_stimuli::stimulus::Trajectory;
    use shutterlab_stimuli::{Grid, Selection};

    /// A world is kept as long as all that it is made from is the same: what is simplified, for its motion too.
    #[test]
    fn worlds_are_made_anew_where_they_differ() {
        let grid = Grid::load("zhang-lod").unwrap();
        let of = |select: &str| {
            let selection = Selection::parse(&[select], &grid).unwrap();
            grid.stimuli(&selection).unwrap().remove(0)
        };
        let original = of("model=comb,speed=S1,level_of_detail=L100");
        let simplified = of("model=comb,speed=S1,level_of_detail=L8");
        let changed = |of: &Stimulus, change: &dyn Fn(&mut Stimulus)| {
            let mut changed = of.clone();
            change(&mut changed);
            has_world_of(of, &changed)
        };
        for of in [&original, &simplified] {
            assert!(changed(of, &|s| s.samples += 1) && changed(of, &|s| s.seed += 1));
            assert!(!changed(of, &|s| s.scene.camera.position_m[0] += 0.1));
        }
        let motions: [&dyn Fn(&mut Stimulus); 4] = [
            &|s| s.speed_m_per_s *= 2.0,
            &|s| s.shutter_open_fraction *= 0.5,
            &|s| s.trajectory = Trajectory::Wrap,
            &|s| s.image.frames = 2,
        ];
        for motion in motions {
            assert!(changed(&original, motion) && !changed(&simplified, motion));
        }
        assert!(!has_world_of(&original, &simplified));
        assert!(!has_world_of(&simplified, &of("model=comb,speed=S1,level_of_detail=L4")));
        assert!(!has_world_of(&simplified, &of("model=dunes,speed=S1,level_of_detail=L8")));
    }
}

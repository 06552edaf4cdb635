//! The scene of the measurements: a grey model that crosses a black view, lit by two lamps at rest.

use crate::mesh::Mesh;
use crate::scene::export;
use crate::scene::import::Model;
use anyhow::anyhow;
use shutterlab_stimuli::assets::{Asset, Kind};
use shutterlab_stimuli::scene::{self, Camera, Environment, Illumination, Light, Motion, Shape};
use shutterlab_stimuli::stimulus::{Method, Sampler, Trajectory};
use shutterlab_stimuli::{Grid, Selection, Stimulus};
use std::path::Path;

/// The frame in which half of the sequence has passed: the model is in the middle.
pub const FRAME: u32 = 60;

/// A stimulus without its model.
pub struct Stage<'a> {
    folder: &'a Path,
    stimulus: Stimulus,
}

/// A model that is kept for stimuli.
pub struct Kept {
    name: &'static str,
    sha256: String,
}

impl<'a> Stage<'a> {
    /// Seen by `camera` in images of `size_px`; models are kept in `folder`.
    pub fn new(folder: &'a Path, camera: &Camera, size_px: [u32; 2]) -> anyhow::Result<Self> {
        let mut grid = Grid::load("rolling-sphere-mono")?;
        [grid.image.width_px, grid.image.height_px] = size_px;
        let selection = Selection::parse(&["material=M1,speed=S1,shutter=T5,samples=A1"], &grid)?;
        let mut stimulus = grid.stimuli(&selection)?.remove(0);
        stimulus.trajectory = Trajectory::Once;
        stimulus.sampler = Sampler::Sobol;
        stimulus.material = scene::Material::Constant { albedo: [0.6; 3], coat: None };
        stimulus.scene.illumination = Illumination::Local;
        stimulus.scene.environment = Environment::Uniform([0.0; 3]);
        stimulus.scene.camera = camera.clone();
        stimulus.scene.lights = vec![
            Light::Directional { direction: [0.4, -0.6, -0.7], irradiance: [2.5; 3] },
            Light::Directional { direction: [-0.8, 0.1, -0.6], irradiance: [0.6; 3] },
        ];
        Ok(Self { folder, stimulus })
    }

    /// Keeps a model.
    pub fn keep(&self, name: &'static str, mesh: &Mesh) -> anyhow::Result<Kept> {
        let file = self.folder.join(name);
        export::model(&Model::plain(mesh.clone()), &file)?;
        let kept = Asset::open(&file, Kind::Model)
            .and_then(|asset| asset.keep(self.folder).map(|()| asset.sha256));
        let sha256 = kept.map_err(|error| anyhow!("{}: {error}", file.display()))?;
        Ok(Kept { name, sha256 })
    }

    /// The model going to the right so fast.
    pub fn stimulus(
        &self,
        model: &Kept,
        method: Method,
        px_per_shutter: u32,
        samples: u32,
    ) -> Stimulus {
        let mut stimulus = Stimulus { method, samples, ..self.stimulus.clone() };
        let camera = &stimulus.scene.camera;
        let px_per_second = f64::from(px_per_shutter) * stimulus.image.fps;
        let speed = px_per_second / camera.pixels_per_metre(stimulus.image.width_px);
        let (file, sha256) = (model.name.into(), model.sha256.clone());
        stimulus.scene.objects = vec![scene::Object {
            name: "model".into(),
            shape: Shape::Mesh { file, sha256, radius_m: None },
            position_m: [0.0; 3],
            orientation: None,
            material: None,
            motion: Some(Motion {
                speed_m_per_s: Some(speed),
                translation: Some([1.0, 0.0, 0.0]),
                rotation: None,
                deformation: None,
            }),
        }];
        stimulus
    }
}

//! Scene descriptions: camera, objects, lights and environment, as data.

pub mod camera;
pub mod material;
pub mod object;

pub use camera::{Camera, CameraMotion};
pub use material::{Coat, Material};
pub use object::{Deformation, Motion, Object, Orientation, Rotation, Shape};

use crate::assets::{Asset, Assets, Kind};
use serde::{Deserialize, Serialize};
use shutterlab_data_schema::definition::{self, DefinitionError};
use std::path::Path;

/// Most objects of a scene, each of which every ray looks at.
pub const MAX_OBJECTS: usize = 32;

/// Most lights of a scene, each of which every hit looks at.
pub const MAX_LIGHTS: usize = 16;

/// Objects under an environment and lights, seen by a pinhole camera. Metres, right-handed, y up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Version of this format: 1.
    pub schema: u32,
    /// Name of the scene.
    pub name: String,
    /// How light gets about.
    #[serde(default, skip_serializing_if = "Illumination::is_global")]
    pub illumination: Illumination,
    /// The camera.
    pub camera: Camera,
    /// The light from all around.
    pub environment: Environment,
    /// Lights without extent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lights: Vec<Light>,
    /// What there is to see.
    pub objects: Vec<Object>,
}

/// How light gets about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Illumination {
    /// From the environment, the lights and other surfaces, but for what is in the way.
    #[default]
    Global,
    /// From the lights alone, as if nothing were in the way; the environment is seen behind the objects and
    /// lights none.
    Local,
}

impl Illumination {
    fn is_global(&self) -> bool {
        *self == Self::Global
    }
}

/// The light around the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Environment {
    /// An environment that the renderer makes itself.
    BuiltIn(BuiltIn),
    /// The same radiance (linear Rec. 709) from everywhere: a white furnace.
    Uniform([f64; 3]),
    /// A latitude–longitude map of radiance, .hdr or .exr: its middle lies in direction +x, the next
    /// quarter to its right in +z, the upper border at the zenith.
    Map(LightMap),
}

/// A light map in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightMap {
    /// Its path, from the folder of the scene's file; in a manifest its name.
    pub file: String,
    /// SHA-256 of the file, which a manifest tells and a scene need not.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub sha256: String,
}

/// A light without extent. Its colour is linear Rec. 709.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum Light {
    /// Shines from a point in all directions.
    Point {
        /// The point.
        position_m: [f64; 3],
        /// Radiant intensity: the irradiance at a distance of one metre.
        intensity: [f64; 3],
    },
    /// Shines from infinitely far away.
    Directional {
        /// The direction in which the light goes.
        direction: [f64; 3],
        /// Irradiance of a surface that faces the light.
        irradiance: [f64; 3],
    },
}

/// Environments that the renderer makes itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BuiltIn {
    /// A clear sky with a soft sun.
    ClearSky,
    /// The sun of the clear sky without its aureole and without the sky.
    SunOnly,
}

/// Scenes that come with Shutterlab, by name.
const SHIPPED: &[(&str, &str)] = &[
    ("rolling-sphere", include_str!("../scenes/rolling-sphere.toml")),
    ("crossing-model", include_str!("../scenes/crossing-model.toml")),
];

impl Scene {
    /// Parses and checks the shipped scene called `name`, or the scene in the file of that name, which
    /// is taken from `folder`; returns the files that it needs, too.
    ///
    /// # Errors
    /// There is neither, a value cannot be used, or a file that it names cannot be read.
    pub fn load(name: &str, folder: &Path) -> Result<(Self, Vec<Asset>), DefinitionError> {
        let file = folder.join(name);
        let is_shipped = SHIPPED.iter().any(|(shipped, _)| *shipped == name);
        let place = if is_shipped { name.into() } else { file.display().to_string() };
        let text = definition::find(&place, SHIPPED, ["grid", "scene"], "scenes")?;
        let mut scene: Self = definition::parse(&text, &place)?;
        scene.check(&place)?;
        let folder = file.parent().unwrap_or(folder).into();
        let mut assets = Assets { place: &place, folder, found: vec![] };
        if let Environment::Map(map) = &mut scene.environment {
            assets.find("environment.map", Kind::LightMap, &mut map.file, &mut map.sha256)?;
        }
        for (k, object) in scene.objects.iter_mut().enumerate() {
            object.find_files(&object_field(k), &mut assets)?;
        }
        let found = assets.found;
        Ok((scene, found))
    }

    /// Whether any object is a mesh.
    pub fn has_mesh(&self) -> bool {
        self.objects.iter().any(|object| matches!(object.shape, Shape::Mesh { .. }))
    }

    /// Refuses values that make no picture; `file` is what an error calls the scene.
    pub(crate) fn check(&self, file: &str) -> Result<(), DefinitionError> {
        definition::check_schema(self.schema, file)?;
        let refuse = |field: &str, value: String, allowed: &str| {
            Err(DefinitionError::value(file, field, value, allowed))
        };
        self.camera.check(file)?;
        if !(1..=MAX_OBJECTS).contains(&self.objects.len()) {
            let allowed = format!("1 to {MAX_OBJECTS} are allowed");
            return refuse("objects", self.objects.len().to_string(), &allowed);
        }
        for (k, object) in self.objects.iter().enumerate() {
            object.check(&object_field(k), file)?;
            self.check_camera_outside(object, file)?;
        }
        if self.lights.len() > MAX_LIGHTS {
            let allowed = format!("up to {MAX_LIGHTS} are allowed");
            return refuse("lights", self.lights.len().to_string(), &allowed);
        }
        for (k, light) in self.lights.iter().enumerate() {
            let (field, place, color) = match light {
                Light::Point { position_m, intensity } => ("position_m", position_m, intensity),
                Light::Directional { direction, irradiance } => {
                    ("direction", direction, irradiance)
                }
            };
            let field = format!("lights[{k}].{field}");
            match light {
                Light::Point { .. } => check_point(&field, *place, file)?,
                Light::Directional { .. } => check_vector(&field, *place, file)?,
            }
            if !color.iter().all(|channel| (0.0..=1e9).contains(channel)) {
                let allowed = "intensities and irradiances from 0 to 1e9 are allowed";
                return refuse(&format!("lights[{k}]"), format!("{color:?}"), allowed);
            }
        }
        if let Environment::Uniform(radiance) = self.environment
            && !radiance.iter().all(|channel| (0.0..=1e6).contains(channel))
        {
            let allowed = "radiances from 0 to 1000000 are allowed";
            return refuse("environment.uniform", format!("{radiance:?}"), allowed);
        }
        Ok(())
    }

    /// Refuses a camera at rest in a sphere, or where one passes through. Meshes and planes are looked at
    /// from either side.
    fn check_camera_outside(&self, object: &Object, file: &str) -> Result<(), DefinitionError> {
        let Shape::Sphere { radius_m } = object.shape else { return Ok(()) };
        let offset: [f64; 3] =
            std::array::from_fn(|i| self.camera.position_m[i] - object.position_m[i]);
        let along = object.direction().map_or(0.0, |direction| object::dot(offset, direction));
        let distance = (object::dot(offset, offset) - along * along).max(0.0).sqrt();
        if self.camera.motion.is_none() && distance <= radius_m {
            let value = format!("{:?}", self.camera.position_m);
            let allowed = format!("the sphere {} is or passes here", object.name);
            return Err(DefinitionError::value(file, "camera.position_m", value, allowed));
        }
        Ok(())
    }
}

/// What errors call the object of number `k`.
fn object_field(k: usize) -> String {
    format!("objects[{k}]")
}

/// Refuses a vector without a direction.
fn check_vector(field: &str, vector: [f64; 3], file: &str) -> Result<(), DefinitionError> {
    let largest = vector.iter().fold(0.0, |largest: f64, c| largest.max(c.abs()));
    if (1e-6..=1e6).contains(&largest) && vector.iter().all(|c| c.is_finite()) {
        return Ok(());
    }
    let allowed = "a vector whose largest component is 0.000001 to 1000000 is needed";
    Err(DefinitionError::value(file, field, format!("{vector:?}"), allowed))
}

/// Refuses a speed that no motion can have.
fn check_speed(field: &str, speed: Option<f64>, file: &str) -> Result<(), DefinitionError> {
    let Some(speed) = speed.filter(|speed| !(0.0..=1e6).contains(speed)) else { return Ok(()) };
    let allowed = "0 to 1000000 metres per second are allowed";
    Err(DefinitionError::value(file, field, speed, allowed))
}

/// Refuses a place or vector that single precision would not hold well.
fn check_point(field: &str, point: [f64; 3], file: &str) -> Result<(), DefinitionError> {
    if point.iter().all(|coordinate| coordinate.abs() <= 1e6) {
        return Ok(());
    }
    let allowed = "coordinates up to 1000000 are allowed";
    Err(DefinitionError::value(file, field, format!("{point:?}"), allowed))
}

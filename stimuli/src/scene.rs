//! Scene descriptions: camera, sphere, floor, environment and materials, as data.

use crate::assets::Asset;
use serde::{Deserialize, Serialize};
use shutterlab_data_schema::definition::{self, DefinitionError};
use std::path::Path;

/// A sphere that rolls over a floor under an environment, seen by a pinhole camera.
/// Metres, right-handed, y up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Version of this format: 1.
    pub schema: u32,
    /// Name of the scene.
    pub name: String,
    /// The camera.
    pub camera: Camera,
    /// The sphere, which moves along x over the floor at z = 0.
    pub sphere: Sphere,
    /// The floor at y = 0.
    pub floor: Floor,
    /// The light.
    pub environment: Environment,
}

/// A pinhole camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Where the pinhole is.
    pub position_m: [f64; 3],
    /// The point in the centre of the image.
    pub look_at_m: [f64; 3],
    /// Focal length of the lens.
    pub focal_length_mm: f64,
    /// Width of the sensor, which the image's width fills.
    pub sensor_width_mm: f64,
}

/// The moving object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    /// Its radius.
    pub radius_m: f64,
}

/// A square Lambertian floor at y = 0, centred on the origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Floor {
    /// Diffuse reflectance.
    pub albedo: f64,
    /// Length of a side.
    pub side_m: f64,
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

/// Environments that the renderer makes itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BuiltIn {
    /// A clear sky with a soft sun.
    ClearSky,
    /// The sun of the clear sky without its aureole and without the sky.
    SunOnly,
}

/// A Lambertian surface pattern of the sphere, over its object-space unit vector n, with
/// u = frac(atan2(−n_z, n_x)/2π) and v = acos(n_y)/π.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum Material {
    /// One albedo everywhere.
    Constant {
        /// Diffuse reflectance (linear Rec. 709).
        albedo: [f64; 3],
    },
    /// `light` where ⌊Cu⌋ + ⌊(C/2)v⌋ is even, else `dark`.
    Checker {
        /// C, the number of cells around the equator: even, so that the pattern closes.
        cells: u32,
        /// Reflectance of the light cells.
        light: f64,
        /// Reflectance of the dark cells.
        dark: f64,
    },
    /// `dark` + (`light` − `dark`)·m, with m octaves of value noise on n, normalised, stretched by
    /// `contrast` about ½ and clamped to [0, 1].
    Noise {
        /// Reflectance where m = 1.
        light: f64,
        /// Reflectance where m = 0.
        dark: f64,
        /// Lattice cells per unit of the first octave; each further octave doubles it and halves
        /// its amplitude.
        frequency: f64,
        /// Number of octaves, 1 to 8.
        octaves: u32,
        /// Stretch about ½.
        contrast: f64,
    },
}

/// What a surface reflects apart from its pattern of albedo: microfacets after Trowbridge and Reitz (GGX,
/// Walter et al. 2007). α is the square of `roughness`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum Coat {
    /// A metal, whose reflectance at normal incidence is the albedo; nothing is scattered below.
    Metal {
        /// 0.02 (nearly a mirror) to 1.
        roughness: f64,
    },
    /// A clear varnish over the diffuse surface.
    Dielectric {
        /// 0.02 (nearly a mirror) to 1.
        roughness: f64,
        /// Index of refraction, 1.01 to 3.
        ior: f64,
    },
}

/// Scenes that come with Shutterlab, by name.
const SHIPPED: &[(&str, &str)] =
    &[("rolling-sphere", include_str!("../scenes/rolling-sphere.toml"))];

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
        let mut assets = vec![];
        if let Environment::Map(map) = &mut scene.environment {
            let source = file.parent().unwrap_or(folder).join(&map.file);
            let asset = Asset::open(&source).map_err(|error| {
                DefinitionError::value(&place, "environment.map.file", &map.file, error.to_string())
            })?;
            map.file = source.file_name().unwrap_or_default().to_string_lossy().into_owned();
            map.sha256.clone_from(&asset.sha256);
            assets.push(asset);
        }
        Ok((scene, assets))
    }

    /// Refuses values that make no picture; `file` is what an error calls the scene.
    fn check(&self, file: &str) -> Result<(), DefinitionError> {
        definition::check_schema(self.schema, file)?;
        let refuse = |field: &str, value: String, allowed: &str| {
            Err(DefinitionError::value(file, field, value, allowed))
        };
        let Camera { position_m: [_, y, z], look_at_m, .. } = self.camera;
        let numbers = [
            ("camera.focal_length_mm", self.camera.focal_length_mm, 1e-3, 1e6),
            ("camera.sensor_width_mm", self.camera.sensor_width_mm, 1e-3, 1e6),
            ("sphere.radius_m", self.sphere.radius_m, 1e-6, 1e6),
            ("floor.albedo", self.floor.albedo, 0.0, 1.0),
            ("floor.side_m", self.floor.side_m, 0.0, 1e9),
        ];
        for (field, value, low, high) in numbers {
            if !(low..=high).contains(&value) {
                return refuse(field, value.to_string(), &format!("{low} to {high} is allowed"));
            }
        }
        let points =
            [("camera.position_m", self.camera.position_m), ("camera.look_at_m", look_at_m)];
        for (field, point) in points {
            if !point.iter().all(|coordinate| coordinate.abs() <= 1e6) {
                return refuse(
                    field,
                    format!("{point:?}"),
                    "coordinates up to 1000000 are allowed",
                );
            }
        }
        let position = format!("{:?}", self.camera.position_m);
        if self.camera.position_m == look_at_m {
            let allowed = "another point than camera.look_at_m is needed";
            return refuse("camera.position_m", position, allowed);
        }
        if y <= 0.0 {
            return refuse("camera.position_m", position, "a place above the floor is needed");
        }
        if (y - self.sphere.radius_m).hypot(z) <= self.sphere.radius_m {
            return refuse("camera.position_m", position, "the sphere passes through this place");
        }
        if let Environment::Uniform(radiance) = self.environment
            && !radiance.iter().all(|channel| (0.0..=1e6).contains(channel))
        {
            let allowed = "radiances from 0 to 1000000 are allowed";
            return refuse("environment.uniform", format!("{radiance:?}"), allowed);
        }
        Ok(())
    }
}

impl Camera {
    /// Unit vector towards the right of the image, which holds y up; of a camera that looks straight
    /// up or down it is x.
    pub fn right(&self) -> [f64; 3] {
        let [x, _, z] = std::array::from_fn(|i| self.look_at_m[i] - self.position_m[i]);
        let length = x.hypot(z);
        if length > 0.0 { [-z / length, 0.0, x / length] } else { [1.0, 0.0, 0.0] }
    }

    /// Distance from the pinhole to the point it looks at, in metres.
    pub fn focus_distance_m(&self) -> f64 {
        let squares = (0..3).map(|i| (self.position_m[i] - self.look_at_m[i]).powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// Focal length in pixels of an image `width_px` wide.
    pub fn focal_length_px(&self, width_px: u32) -> f64 {
        self.focal_length_mm / self.sensor_width_mm * f64::from(width_px)
    }

    /// Pixels per metre, across the view, at the distance of the point it looks at.
    pub fn pixels_per_metre(&self, width_px: u32) -> f64 {
        self.focal_length_px(width_px) / self.focus_distance_m()
    }
}

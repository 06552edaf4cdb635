//! Descriptions of surfaces: a pattern of albedo, and a coat if there is one.

use crate::assets::{Assets, Kind};
use serde::{Deserialize, Serialize};
use shutterlab_data_schema::definition::DefinitionError;

/// A pattern of albedo, and a coat. Patterns are drawn in the object's own space:
///
/// - on a sphere over its unit vector n, with u = frac(atan2(−n_z, n_x)/2π) and v = acos(n_y)/π;
/// - on a plane over n, the point in units of half the side, with u and v from 0 to 1 along x and z;
/// - on a mesh as on a sphere, n pointing from the object's position towards the surface, but u and v are
///   the mesh's texture coordinates if it has any, v from the upper edge of the picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum Material {
    /// One albedo everywhere.
    Constant {
        /// Diffuse reflectance (linear Rec. 709).
        albedo: [f64; 3],
        /// What lies over it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        coat: Option<Coat>,
    },
    /// `light` where ⌊Cu⌋ + ⌊(C/2)v⌋ is even, on a plane and by texture coordinates where ⌊Cu⌋ + ⌊Cv⌋
    /// is; else `dark`.
    Checker {
        /// C, the number of cells around the equator: even, so that the pattern closes.
        cells: u32,
        /// Reflectance of the light cells.
        light: f64,
        /// Reflectance of the dark cells.
        dark: f64,
        /// What lies over it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        coat: Option<Coat>,
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
        /// What lies over it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        coat: Option<Coat>,
    },
    /// A picture over u and v, repeated beyond its edges: .png, .jpg, .hdr or .exr.
    Image {
        /// Its path, from the folder of the definition's file; in a manifest its name.
        file: String,
        /// SHA-256 of the file, which a manifest tells and a definition need not.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        sha256: String,
        /// What lies over it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        coat: Option<Coat>,
    },
    /// The colours and pictures that the file of a mesh gives to its faces.
    Model {
        /// What lies over them.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        coat: Option<Coat>,
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

impl Material {
    /// What lies over the pattern.
    pub fn coat(&self) -> Option<&Coat> {
        match self {
            Self::Constant { coat, .. }
            | Self::Checker { coat, .. }
            | Self::Noise { coat, .. }
            | Self::Image { coat, .. }
            | Self::Model { coat } => coat.as_ref(),
        }
    }

    /// Finds and hashes the file that it needs, if it does; `field` is what an error calls the material.
    pub(crate) fn find_files(
        &mut self,
        field: &str,
        assets: &mut Assets<'_>,
    ) -> Result<(), DefinitionError> {
        match self {
            Self::Image { file, sha256, .. } => assets.find(field, Kind::Picture, file, sha256),
            _ => Ok(()),
        }
    }

    /// Refuses values that no surface can have; `field` is what an error calls the material in `file`.
    pub(crate) fn check(&self, field: &str, file: &str) -> Result<(), DefinitionError> {
        let refuse = |key: &str, value: String, allowed: &str| {
            Err(DefinitionError::value(file, format!("{field}.{key}"), value, allowed))
        };
        let reflectances = match self {
            Self::Constant { albedo, .. } => albedo.map(|value| ("albedo", value)).to_vec(),
            Self::Checker { light, dark, .. } | Self::Noise { light, dark, .. } => {
                vec![("light", *light), ("dark", *dark)]
            }
            Self::Image { .. } | Self::Model { .. } => vec![],
        };
        let bad = |(_, value): &&(&str, f64)| !(0.0..=1.0).contains(value);
        if let Some((key, value)) = reflectances.iter().find(bad) {
            return refuse(key, value.to_string(), "a reflectance is 0 to 1");
        }
        if let Some(&Coat::Metal { roughness } | &Coat::Dielectric { roughness, .. }) = self.coat()
            && !(0.02..=1.0).contains(&roughness)
        {
            return refuse("coat.roughness", roughness.to_string(), "0.02 to 1 is allowed");
        }
        if let Some(&Coat::Dielectric { ior, .. }) = self.coat()
            && !(1.01..=3.0).contains(&ior)
        {
            return refuse("coat.ior", ior.to_string(), "1.01 to 3 is allowed");
        }
        match *self {
            Self::Checker { cells, .. } if cells == 0 || cells % 2 == 1 || cells > 4096 => refuse(
                "cells",
                cells.to_string(),
                "an even number from 2 to 4096 closes the pattern",
            ),
            Self::Noise { octaves, .. } if !(1..=8).contains(&octaves) => {
                refuse("octaves", octaves.to_string(), "1 to 8 are allowed")
            }
            Self::Noise { frequency, .. } if !(0.01..=1e4).contains(&frequency) => {
                refuse("frequency", frequency.to_string(), "0.01 to 10000 is allowed")
            }
            Self::Noise { contrast, .. } if !(0.0..=1e3).contains(&contrast) => {
                refuse("contrast", contrast.to_string(), "0 to 1000 is allowed")
            }
            _ => Ok(()),
        }
    }
}

//! The axes of a grid, their levels and cells.

use super::Samples;
use crate::assets::check_made;
use crate::scene::Material;
use crate::simplification::MOST_R;
use crate::stimulus::{MAX_SAMPLES, Method};
use indexmap::{IndexMap, IndexSet};
use serde::{Deserialize, Serialize};
use shutterlab_data_schema::definition::DefinitionError;

/// The levels of each axis, in the order of the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axes {
    /// Axis `method`; if there are no levels, it is the grid's.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub method: IndexMap<String, Method>,
    /// Axis `model`: file of the scene's only mesh, from the folder of the grid's file, or `made:` and the name of one
    /// of [`MADE`](crate::assets::MADE); if there are no levels, it is the scene's.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub model: IndexMap<String, String>,
    /// Axis `material`: names in the grid's table of materials.
    pub material: IndexMap<String, String>,
    /// Axis `speed`: degrees of visual angle per second.
    pub speed_deg_per_s: IndexMap<String, f64>,
    /// Axis `shutter`: open part of the frame time, 0 to 1.
    pub shutter_open_fraction: IndexMap<String, f64>,
    /// Axis `samples`: camera paths per pixel.
    pub samples: IndexMap<String, Samples>,
    /// Axis `r`: exponent of the weight by which the scene's only mesh is simplified.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub r: IndexMap<String, f64>,
    /// Axis `level_of_detail`: part of the mesh's faces that is left. The original, at 1, has no r.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub level_of_detail: IndexMap<String, f64>,
}

/// Names of the axes, in the order in which they make up a stimulus's id.
pub(super) const AXES: [&str; 8] =
    ["method", "model", "material", "speed", "shutter", "samples", "r", "level_of_detail"];

/// Axis by axis, the name of each level and what it stands for.
pub(super) type Levels<'a> = [(&'static str, Vec<(&'a str, String)>); AXES.len()];

/// The level names of a stimulus, axis by axis; empty for an axis that it does not have.
pub(super) type Cell<'a> = [&'a str; AXES.len()];

/// The axes' keys in a grid file.
const AXIS_KEYS: [&str; AXES.len()] = [
    "method",
    "model",
    "material",
    "speed_deg_per_s",
    "shutter_open_fraction",
    "samples",
    "r",
    "level_of_detail",
];

/// Those of the axes that every grid has.
const NEEDED: std::ops::Range<usize> = 2..6;

/// Longest name of a level, which becomes part of a folder's.
pub(super) const MAX_LEVEL_NAME: usize = 32;

impl Axes {
    /// Refuses levels that no stimulus can have; `file` is what an error calls the grid, `materials` are its own.
    pub(super) fn check(
        &self,
        materials: &IndexMap<String, Material>,
        file: &str,
    ) -> Result<(), DefinitionError> {
        let refuse = |field: String, value: String, allowed: &str| {
            Err(DefinitionError::value(file, field, value, allowed))
        };
        for (k, (axis, (_, levels))) in AXIS_KEYS.into_iter().zip(self.levels()).enumerate() {
            if levels.is_empty() && NEEDED.contains(&k) {
                return refuse(
                    format!("axes.{axis}"),
                    "no levels".into(),
                    "at least one level is needed",
                );
            }
            for (level, _) in levels {
                if !is_level_name(level) {
                    let allowed = format!(
                        "1 to {MAX_LEVEL_NAME} letters and digits are allowed in a level's name"
                    );
                    return refuse(format!("axes.{axis}"), format!("{level:?}"), &allowed);
                }
            }
        }
        for (level, name) in &self.material {
            if !materials.contains_key(name) {
                let known: Vec<&str> = materials.keys().map(String::as_str).collect();
                return refuse(
                    format!("axes.material.{level}"),
                    name.clone(),
                    &format!("the grid's materials are {}", known.join(", ")),
                );
            }
        }
        for (level, speed) in &self.speed_deg_per_s {
            if !(0.0..=1000.0).contains(speed) {
                return refuse(
                    format!("axes.speed_deg_per_s.{level}"),
                    speed.to_string(),
                    "0 to 1000 degrees per second are allowed",
                );
            }
        }
        for (level, open) in &self.shutter_open_fraction {
            if !(0.0..=1.0).contains(open) {
                return refuse(
                    format!("axes.shutter_open_fraction.{level}"),
                    open.to_string(),
                    "0 to 1 of the frame time is allowed",
                );
            }
        }
        for (level, samples) in &self.samples {
            if let Samples::Count(count) = samples
                && !(1..=MAX_SAMPLES).contains(count)
            {
                return refuse(
                    format!("axes.samples.{level}"),
                    count.to_string(),
                    "1 to 1048576 samples are allowed",
                );
            }
        }
        for (level, file_name) in &self.model {
            check_made(file_name, &format!("axes.model.{level}"), file)?;
        }
        for (level, r) in &self.r {
            if !(0.0..=MOST_R).contains(r) {
                let allowed = format!("0 to {MOST_R} is allowed");
                return refuse(format!("axes.r.{level}"), r.to_string(), &allowed);
            }
        }
        for (level, part) in &self.level_of_detail {
            if !(*part > 0.0 && *part <= 1.0) {
                return refuse(
                    format!("axes.level_of_detail.{level}"),
                    part.to_string(),
                    "a part of the faces above 0 and up to 1 is allowed",
                );
            }
        }
        for (one, other, is_alone) in [
            ("r", "level_of_detail", !self.r.is_empty() && self.level_of_detail.is_empty()),
            ("level_of_detail", "r", !self.level_of_detail.is_empty() && self.r.is_empty()),
        ] {
            if is_alone {
                let allowed = format!("with axes.{one} at least one level is needed");
                return refuse(format!("axes.{other}"), "no levels".into(), &allowed);
            }
        }
        Ok(())
    }

    /// Axis by axis, the name of each level and what it stands for.
    pub(super) fn levels(&self) -> Levels<'_> {
        fn texts<T: ToString>(levels: &IndexMap<String, T>) -> Vec<(&str, String)> {
            levels.iter().map(|(name, value)| (name.as_str(), value.to_string())).collect()
        }
        let Self { method, model, material, speed_deg_per_s, shutter_open_fraction, .. } = self;
        [
            (AXES[0], texts(method)),
            (AXES[1], texts(model)),
            (AXES[2], texts(material)),
            (AXES[3], texts(speed_deg_per_s)),
            (AXES[4], texts(shutter_open_fraction)),
            (AXES[5], texts(&self.samples)),
            (AXES[6], texts(&self.r)),
            (AXES[7], texts(&self.level_of_detail)),
        ]
    }

    /// The cells, the last axis fastest. The original of a model is the same for all r, so it comes once.
    pub(super) fn cells(&self) -> Vec<Cell<'_>> {
        let mut cells = vec![Cell::default()];
        for (axis, (_, levels)) in self.levels().into_iter().enumerate() {
            if !levels.is_empty() {
                let with = |cell: &[_; _], level| {
                    let mut cell = *cell;
                    cell[axis] = level;
                    cell
                };
                let names = || levels.iter().map(|(name, _)| *name);
                cells = cells
                    .iter()
                    .flat_map(|cell| names().map(move |level| with(cell, level)))
                    .collect();
            }
        }
        for [.., r, level_of_detail] in &mut cells {
            if self.level_of_detail.get(*level_of_detail) == Some(&1.0) {
                *r = "";
            }
        }
        let different: IndexSet<_> = cells.into_iter().collect();
        different.into_iter().collect()
    }
}

/// Whether a level can be called so.
pub(super) fn is_level_name(name: &str) -> bool {
    (1..=MAX_LEVEL_NAME).contains(&name.len()) && name.bytes().all(|b| b.is_ascii_alphanumeric())
}

//! A grid of stimuli: axes × levels, one TOML file, and the resolution of its cells.

mod axes;
mod models;
mod samples;
mod selection;

pub use axes::Axes;
pub use samples::Samples;
pub use selection::Selection;

use crate::assets::{Asset, Assets};
use crate::scene::{Material, Scene};
use crate::simplification::Simplification;
use crate::stereo::{Layout, Stereo};
use crate::stimulus::{
    ImageFormat, MAX_FRAMES, MAX_SIDE_PX, Method, Sampler, ShutterProfile, Stimulus, Trajectory,
};
use crate::viewing::{Display, Viewing};
use axes::AXES;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use shutterlab_data_schema::definition::{self, DefinitionError};
use std::path::{Path, PathBuf};

/// A grid of stimuli.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Version of this format: 1.
    pub schema: u32,
    /// Name of the grid.
    pub name: String,
    /// One line that says what the grid is for.
    pub title: String,
    /// Name of a shipped scene, or the path of a scene's file, from the folder of the grid's.
    pub scene: String,
    /// How the stimuli are rendered.
    pub method: Method,
    /// What happens when the sphere leaves the view.
    pub trajectory: Trajectory,
    /// Seed of all noise.
    pub seed: u64,
    /// Where the samples fall.
    pub sampler: Sampler,
    /// Whether the levels of `samples` share their noise.
    pub sampling: Sampling,
    /// Realisations of the noise of each stimulus.
    #[serde(default = "one")]
    pub exemplars: u32,
    /// What the shutter lets through while it is open; all, if nothing is said.
    #[serde(default = "ShutterProfile::full")]
    pub shutter_profile: ShutterProfile,
    /// Two eyes; one, if nothing is said.
    pub stereo: Option<Stereo>,
    /// Size, length and encoding of the sequences.
    pub image: ImageFormat,
    /// How large they appear.
    pub viewing: Viewing,
    /// Materials that the levels of the axis `material` name.
    pub materials: IndexMap<String, Material>,
    /// The axes.
    pub axes: Axes,
    /// Where the grid's file lies.
    #[serde(skip)]
    folder: PathBuf,
}

/// Whether the levels of the axis `samples` share their noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sampling {
    /// The samples of a level are the first of the next: one pass yields them all.
    Nested,
    /// Each level has samples of its own.
    Independent,
}

fn one() -> u32 {
    1
}

/// Longest name of a grid, which becomes that of a job.
const MAX_NAME: usize = 64;

/// Grids that come with Shutterlab, by name.
const SHIPPED: &[(&str, &str)] = &[
    ("rolling-sphere-mono", include_str!("../grids/rolling-sphere-mono.toml")),
    ("rolling-sphere-stereo", include_str!("../grids/rolling-sphere-stereo.toml")),
    ("zhang-r", include_str!("../grids/zhang-r.toml")),
    ("zhang-lod", include_str!("../grids/zhang-lod.toml")),
    ("zhang-validation", include_str!("../grids/zhang-validation.toml")),
    ("demo", include_str!("../grids/demo.toml")),
];

impl Grid {
    /// Loads the shipped grid called `grid`, or the grid in the file of that name.
    ///
    /// # Errors
    /// There is neither; or as [`Grid::parse`].
    pub fn load(grid: &str) -> Result<Self, DefinitionError> {
        let text = definition::find(grid, SHIPPED, ["render", "GRID"], "grids")?;
        let folder = Path::new(grid).parent().unwrap_or(Path::new("")).into();
        Ok(Self { folder, ..Self::parse(&text, grid)? })
    }

    /// Whether [`Grid::load`] takes `grid` for a shipped one, even where a file has that name.
    pub fn is_shipped(grid: &str) -> bool {
        SHIPPED.iter().any(|(name, _)| *name == grid)
    }

    /// Parses and checks a grid; `file` is what an error calls it.
    ///
    /// # Errors
    /// As [`definition::parse`], or the first value that no stimulus can have, by field.
    pub fn parse(text: &str, file: &str) -> Result<Self, DefinitionError> {
        let grid: Self = definition::parse(text, file)?;
        grid.check(file)?;
        Ok(grid)
    }

    /// Refuses values that no stimulus can have; `file` is what an error calls the grid.
    ///
    /// # Errors
    /// The first field that does not fit, by name.
    pub fn check(&self, file: &str) -> Result<(), DefinitionError> {
        definition::check_schema(self.schema, file)?;
        let refuse = |field: &str, value: &dyn ToString, allowed: &str| {
            Err(DefinitionError::value(file, field, value.to_string(), allowed))
        };
        let is_whole = self.name.trim() == self.name && !self.name.contains(char::is_control);
        if !is_whole || !(1..=MAX_NAME).contains(&self.name.chars().count()) {
            let allowed =
                format!("1 to {MAX_NAME} printable characters are allowed, no space at either end");
            return refuse("name", &format!("{:?}", self.name), &allowed);
        }
        let ImageFormat { width_px, height_px, fps, frames, exposure_stops, .. } = self.image;
        for (field, size) in [("image.width_px", width_px), ("image.height_px", height_px)] {
            if !(1..=MAX_SIDE_PX).contains(&size) {
                return refuse(field, &size, "1 to 16384 pixels are allowed");
            }
        }
        if !(1.0..=1000.0).contains(&fps) {
            return refuse("image.fps", &fps, "1 to 1000 frames per second are allowed");
        }
        if !(1..=MAX_FRAMES).contains(&frames) {
            return refuse("image.frames", &frames, "1 to 9999 frames are allowed");
        }
        if !(-30.0..=30.0).contains(&exposure_stops) {
            return refuse("image.exposure_stops", &exposure_stops, "-30 to 30 stops are allowed");
        }
        if let crate::frames::Transfer::Gamma(gamma) = self.image.transfer
            && !(0.1..=10.0).contains(&gamma)
        {
            return refuse("image.transfer.gamma", &gamma, "0.1 to 10 is allowed");
        }
        self.viewing.check(file)?;
        if let Some(Display { resolution_px: [columns, rows], .. }) = self.viewing.display {
            let sides = [("width_px", width_px, columns), ("height_px", height_px, rows)];
            if let Some((side, pixels, most)) = sides.into_iter().find(|(_, px, most)| px > most) {
                let allowed = format!("at most the {most} pixels of viewing.display.resolution_px");
                return refuse(&format!("image.{side}"), &pixels, &allowed);
            }
        }
        self.check_sampling(file)?;
        for (name, material) in &self.materials {
            material.check(&format!("materials.{name}"), file)?;
        }
        self.axes.check(&self.materials, file)
    }

    fn check_sampling(&self, file: &str) -> Result<(), DefinitionError> {
        let refuse = |field: &str, value: &dyn ToString, allowed: &str| {
            Err(DefinitionError::value(file, field, value.to_string(), allowed))
        };
        if (self.sampler, self.sampling) == (Sampler::Stratified, Sampling::Nested) {
            return refuse(
                "sampling",
                &"nested",
                "the sampler stratified needs to know the number of samples: independent is allowed, \
                 or the samplers random and sobol",
            );
        }
        if !(1..=1000).contains(&self.exemplars) {
            return refuse("exemplars", &self.exemplars, "1 to 1000 are allowed");
        }
        match self.shutter_profile {
            ShutterProfile::Trapezoid { ramp_fraction }
                if !(ramp_fraction > 0.0 && ramp_fraction <= 0.5) =>
            {
                return refuse(
                    "shutter_profile.ramp_fraction",
                    &ramp_fraction,
                    "above 0 to 0.5 of the interval is allowed",
                );
            }
            ShutterProfile::Gaussian { sigma_fraction }
                if !(0.01..=10.0).contains(&sigma_fraction) =>
            {
                return refuse(
                    "shutter_profile.sigma_fraction",
                    &sigma_fraction,
                    "0.01 to 10 of the interval is allowed",
                );
            }
            _ => {}
        }
        let Some(stereo) = &self.stereo else { return Ok(()) };
        if !(0.0..=1000.0).contains(&stereo.interocular_mm) {
            return refuse(
                "stereo.interocular_mm",
                &stereo.interocular_mm,
                "0 to 1000 mm are allowed",
            );
        }
        if stereo.layout == Layout::HalfWidth && self.image.width_px % 2 == 1 {
            return refuse("image.width_px", &self.image.width_px, "half-width needs an even one");
        }
        Ok(())
    }

    /// The stimuli of all cells that `selection` takes, in the order of the axes, and the files that they
    /// are made with.
    ///
    /// # Errors
    /// As [`Scene::load`], or the scene does not suit the grid.
    pub fn resolve(
        &self,
        selection: &Selection,
    ) -> Result<(Vec<Stimulus>, Vec<Asset>), DefinitionError> {
        let (scene, found) = Scene::load(&self.scene, &self.folder)?;
        let mut materials = self.materials.clone();
        let mut assets = Assets { place: &self.name, folder: self.folder.clone(), found };
        for (name, material) in &mut materials {
            material.find_files(&format!("materials.{name}"), &mut assets)?;
        }
        let cells: Vec<_> =
            self.axes.cells().into_iter().filter(|&cell| selection.takes(cell)).collect();
        let scenes = self.scenes(&scene, &cells, &mut assets)?;
        let exemplars = |cell| (0..self.exemplars).map(move |exemplar| (cell, exemplar));
        let stimuli: Vec<Stimulus> = cells
            .into_iter()
            .flat_map(exemplars)
            .map(|(cell, exemplar)| {
                let scene = scenes.get(models::of(cell)).unwrap_or(&scene);
                self.stimulus(cell, exemplar, scene, &materials)
            })
            .collect();
        stimuli.iter().try_for_each(|stimulus| stimulus.check(&self.name))?;
        Ok((stimuli, assets.found))
    }

    /// The stimuli of [`Grid::resolve`].
    ///
    /// # Errors
    /// As [`Grid::resolve`].
    pub fn stimuli(&self, selection: &Selection) -> Result<Vec<Stimulus>, DefinitionError> {
        Ok(self.resolve(selection)?.0)
    }

    /// The stimulus of the cell with these levels.
    fn stimulus(
        &self,
        cell: [&str; AXES.len()],
        exemplar: u32,
        scene: &Scene,
        materials: &IndexMap<String, Material>,
    ) -> Stimulus {
        let Axes { method, material, speed_deg_per_s, shutter_open_fraction, samples, .. } =
            &self.axes;
        let [of_method, _, of_material, of_speed, of_shutter, of_samples, of_r, of_level] = cell;
        let speed_deg_per_s = speed_deg_per_s[of_speed];
        let shutter_open_fraction = shutter_open_fraction[of_shutter];
        let width_px = self.image.width_px;
        let pixels_per_degree = self.viewing.pixels_per_degree(width_px);
        let speed_px_per_s = speed_deg_per_s * pixels_per_degree;
        let px_per_shutter = speed_px_per_s * shutter_open_fraction / self.image.fps;
        let levels = || AXES.into_iter().zip(cell).filter(|(_, level)| !level.is_empty());
        let names = |levels: &mut dyn Iterator<Item = (_, &str)>| {
            levels.map(|(_, level)| level).collect::<Vec<_>>().join("-")
        };
        // What is compared with one truth has its noise in common with it.
        let named = |axis: &str| match axis {
            "method" | "r" | "level_of_detail" => false,
            "samples" => self.sampling == Sampling::Independent,
            _ => true,
        };
        let simplification = self.axes.r.get(of_r).map(|&r| Simplification {
            level_of_detail: self.axes.level_of_detail[of_level],
            r,
            epsilon: Simplification::EPSILON,
        });
        Stimulus {
            id: names(&mut levels()),
            levels: levels().map(|(axis, level)| (axis.to_string(), level.to_string())).collect(),
            method: method.get(of_method).copied().unwrap_or(self.method),
            material: materials[&material[of_material]].clone(),
            speed_deg_per_s,
            speed_px_per_s,
            speed_m_per_s: speed_px_per_s / scene.camera.pixels_per_metre(width_px),
            shutter_open_fraction,
            shutter_profile: self.shutter_profile,
            samples: samples[of_samples].at(px_per_shutter),
            sampler: self.sampler,
            seed: self.seed,
            noise_stream: names(&mut levels().filter(|(axis, _)| named(axis))),
            exemplar,
            image: self.image.clone(),
            viewing: self.viewing.clone(),
            pixels_per_degree,
            trajectory: self.trajectory,
            stereo: self.stereo.clone(),
            scene: scene.clone(),
            simplification,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ids(select: &[&str]) -> Vec<String> {
        let grid = Grid::load("rolling-sphere-mono").unwrap();
        let selection = Selection::parse(select, &grid).unwrap();
        grid.stimuli(&selection).unwrap().into_iter().map(|stimulus| stimulus.id).collect()
    }

    #[test]
    fn a_selection_joins_axes_and_adds_alternatives() {
        assert_eq!(ids(&["material=checker,speed=S2,shutter=T5,samples=A3"]), ["M2-S2-T5-A3"]);
        assert_eq!(ids(&["material=M2,speed=10,shutter=1,samples=256"]), ["M2-S2-T5-A3"]);
        assert_eq!(ids(&["material=M1,speed=S1,shutter=T1"]).len(), 5);
        assert_eq!(ids(&["material=M1,speed=S1,shutter=T1,samples=A1,samples=A5"]).len(), 2);
        assert_eq!(ids(&["material=M1", "material=M1,speed=S1", "speed=S3"]).len(), 75 + 50);
        assert_eq!(ids(&[]).len(), 225);
    }

    #[test]
    fn stimuli_are_selected_as_their_cells_were() {
        let grid = Grid::load("rolling-sphere-mono").unwrap();
        let stimuli = grid.stimuli(&Selection::default()).unwrap();
        let all: Vec<&Stimulus> = stimuli.iter().collect();
        for select in [&["material=M2,speed=10,shutter=1", "samples=A3,speed=S1"][..], &[]] {
            let selection = Selection::parse_for_screen(select, &all).unwrap();
            let taken = all.iter().filter(|stimulus| selection.takes_stimulus(stimulus));
            assert_eq!(taken.map(|s| s.id.as_str()).collect::<Vec<_>>(), ids(select));
        }
        let error = Selection::parse_for_screen(&["shutter=T6"], &all).unwrap_err().to_string();
        assert!(
            error.starts_with("screen: --select: shutter=T6: the levels of shutter"),
            "{error}"
        );
    }

    /// Fewer samples are a prefix of more, so the noise does not know the number of samples; and it
    /// differs between all other levels.
    #[test]
    fn noise_streams_differ_in_all_but_the_samples() {
        let grid = Grid::load("rolling-sphere-mono").unwrap();
        let stimuli = grid.stimuli(&Selection::default()).unwrap();
        let streams: std::collections::BTreeSet<&str> =
            stimuli.iter().map(|s| s.noise_stream.as_str()).collect();
        assert_eq!(streams.len(), 45);
    }

    /// A grid may have a method per level, and samples that follow the speed.
    #[test]
    fn methods_are_an_axis_and_samples_follow_the_speed() {
        let text = include_str!("../grids/rolling-sphere-mono.toml");
        let text = text.replace("A1 = 4", "A1 = \"adaptive\"");
        let axis = "[axes.method]\nD = \"distribution-ray-tracing\"\nA = \"accumulation-buffer\"\n";
        let grid = Grid::parse(&format!("{text}\n{axis}"), "grid").unwrap();
        let error = grid.stimuli(&Selection::default()).unwrap_err().to_string();
        assert!(error.contains("illumination"), "{error}");
        let of = |select| {
            let selection = Selection::parse(&[select], &grid).unwrap();
            grid.stimuli(&selection).unwrap()
        };
        let stimuli = of("method=D,samples=A1,shutter=T5,material=M1");
        let ids: Vec<_> = stimuli.iter().map(|stimulus| stimulus.id.as_str()).collect();
        assert_eq!(ids, ["D-M1-S1-T5-A1", "D-M1-S2-T5-A1", "D-M1-S3-T5-A1"]);
        // 7.4, 14.8 and 22.2 pixels per shutter.
        assert_eq!([0, 1, 2].map(|k| stimuli[k].samples), [16, 24, 36]);
        let error = Selection::parse(&["method=D"], &Grid::load("demo").unwrap()).unwrap_err();
        assert!(error.to_string().contains("the axes are material, speed"), "{error}");
        for wrong in ["-1", "1.5", "\"many\""] {
            let text = text.replace("\"adaptive\"", wrong);
            let error = Grid::parse(&text, "grid").unwrap_err().to_string();
            assert!(error.contains("u32 or \"adaptive\""), "{error}");
        }
    }

    fn stimuli(grid: &str, select: &[&str]) -> Vec<Stimulus> {
        let grid = Grid::load(grid).unwrap();
        grid.stimuli(&Selection::parse(select, &grid).unwrap()).unwrap()
    }

    /// Simplified models have an r and a level of detail; the original comes once and has noise in common with them.
    #[test]
    fn models_are_an_axis_and_originals_have_no_r() {
        assert_eq!(stimuli("zhang-r", &[]).len(), 16 * 4 * (8 * 4 + 1));
        assert_eq!(stimuli("zhang-lod", &[]).len(), 16 * 4 * (7 + 1));
        assert_eq!(stimuli("zhang-validation", &[]).len(), 5 * 4 * (2 * 4 + 1));
        let some = stimuli(
            "zhang-r",
            &["model=comb,speed=S4,r=4,r=R0125,level_of_detail=0.1,level_of_detail=L100"],
        );
        let ids: Vec<&str> = some.iter().map(|stimulus| stimulus.id.as_str()).collect();
        let comb = |end: &str| format!("comb-G-S4-T-A-{end}");
        assert_eq!(ids, [comb("L100"), comb("R0125-L10"), comb("R4-L10")]);
        let simplified = some[2].simplification.unwrap();
        assert_eq!((simplified.r, simplified.level_of_detail), (4.0, 0.1));
        assert!(some[0].simplification.is_none() && !some[0].levels.contains_key("r"));
        assert!(some.iter().all(|stimulus| stimulus.noise_stream == "comb-G-S4-T"));
        assert!(some.iter().all(|s| s.samples == 432 && s.files().is_empty()));
        assert!(some[1].is_simplified_from(&some[0]) && !some[0].is_simplified_from(&some[1]));
        assert_eq!(crate::generate::passes(&some).len(), 3);
        // The frame shows the middle of the motion.
        assert_eq!(some[0].path(&some[0].scene.objects[0], 0).distance_m, 0.0);
    }

    #[test]
    fn axes_of_models_that_make_no_stimulus_are_refused() {
        let text = include_str!("../grids/zhang-validation.toml");
        let refused = |from: &str, to: &str| {
            let grid = Grid::parse(&text.replace(from, to), "grid");
            let stimuli = grid.and_then(|grid| grid.stimuli(&Selection::default()));
            stimuli.unwrap_err().to_string()
        };
        for (from, to, expected) in [
            ("made:ridge", "made:rigde", "did you mean ridge?"),
            ("made:ridge", "none.ply", "axes.model.ridge.file: none.ply"),
            ("L4 = 0.04", "L4 = 0.0", "axes.level_of_detail.L4: 0: a part of the faces"),
            ("R4 = 4.0", "R4 = -1.0", "axes.r.R4: -1: 0 to 1000"),
            ("R0 = 0.0\nR4 = 4.0", "", "axes.r: no levels: with axes.level_of_detail at least one"),
            ("crossing-model", "rolling-sphere", "axes.model: 0 meshes in scene rolling-sphere"),
        ] {
            let error = refused(from, to);
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn every_shipped_grid_is_sound() {
        for (name, _) in SHIPPED {
            assert_eq!(Grid::load(name).unwrap().name, *name);
        }
    }
}

//! The models of a grid: the levels of its axis `model`, and the scenes that have them.

use super::Grid;
use super::axes::{Cell, MAX_LEVEL_NAME, is_level_name};
use crate::assets::{Assets, Kind};
use crate::scene::{Scene, Shape};
use indexmap::IndexMap;
use shutterlab_data_schema::definition::DefinitionError;
use std::path::Path;

/// The endings of models' files.
const ENDINGS: [&str; 5] = ["ply", "obj", "gltf", "glb", "stl"];

/// The model of a cell.
pub(super) fn of([_, model, ..]: Cell<'_>) -> &str {
    model
}

impl Grid {
    /// Puts the models in `folder` in the place of those of the axis `model`. A level is called like its file, without
    /// the ending and what is no letter or digit.
    ///
    /// # Errors
    /// The grid has no such axis, the folder cannot be read or has no model, or two of them would be called the same.
    pub fn set_models(&mut self, folder: &Path) -> Result<(), DefinitionError> {
        let place = folder.display().to_string();
        let refuse = |value: &str, allowed: String| {
            Err(DefinitionError::value("render", "--models", value, allowed))
        };
        if self.axes.model.is_empty() {
            return refuse(&place, format!("{}: the grid has no axis model", self.name));
        }
        let entries = std::fs::read_dir(folder)
            .and_then(|entries| entries.collect::<std::io::Result<Vec<_>>>());
        let entries = match entries {
            Ok(entries) => entries,
            Err(error) => return refuse(&place, format!("a folder is needed: {error}")),
        };
        let is_model = |path: &Path| {
            let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
            ENDINGS.contains(&ending.as_str()) && path.is_file()
        };
        let mut files: Vec<_> =
            entries.iter().map(|entry| entry.path()).filter(|path| is_model(path)).collect();
        files.sort();
        let mut models: IndexMap<String, String> = IndexMap::new();
        for file in files {
            let shown = file.display().to_string();
            let stem = file.file_stem().unwrap_or_default().to_string_lossy();
            let name: String = stem.chars().filter(char::is_ascii_alphanumeric).collect();
            if !is_level_name(&name) {
                let allowed =
                    format!("1 to {MAX_LEVEL_NAME} letters and digits are needed in a name");
                return refuse(&shown, allowed);
            }
            // Grids take paths from their own folder.
            let file = match std::path::absolute(&file) {
                Ok(file) => file.display().to_string(),
                Err(error) => return refuse(&shown, error.to_string()),
            };
            if let Some(other) = models.insert(name.clone(), file) {
                return refuse(&shown, format!("{other} is called {name}, too"));
            }
        }
        if models.is_empty() {
            let allowed = format!("it holds no model: .{} files are needed", ENDINGS.join(", ."));
            return refuse(&place, allowed);
        }
        self.axes.model = models;
        Ok(())
    }

    /// The scene of each model of `cells`, which is `scene` with the model's file.
    pub(super) fn scenes(
        &self,
        scene: &Scene,
        cells: &[Cell<'_>],
        assets: &mut Assets<'_>,
    ) -> Result<IndexMap<&str, Scene>, DefinitionError> {
        let is_mesh = |shape: &Shape| matches!(shape, Shape::Mesh { .. });
        let meshes = scene.objects.iter().filter(|object| is_mesh(&object.shape)).count();
        for (axis, is_there) in
            [("model", !self.axes.model.is_empty()), ("r", !self.axes.r.is_empty())]
        {
            if is_there && meshes != 1 {
                let allowed = "with this axis the scene is to have one mesh";
                let value = format!("{meshes} meshes in scene {}", scene.name);
                return Err(DefinitionError::value(
                    &self.name,
                    format!("axes.{axis}"),
                    value,
                    allowed,
                ));
            }
        }
        let mut scenes = IndexMap::new();
        for (level, name) in &self.axes.model {
            if !cells.iter().any(|&cell| of(cell) == level) {
                continue;
            }
            let mut scene = scene.clone();
            for object in &mut scene.objects {
                if let Shape::Mesh { file, sha256, .. } = &mut object.shape {
                    file.clone_from(name);
                    sha256.clear();
                    assets.find(&format!("axes.model.{level}"), Kind::Model, file, sha256)?;
                }
            }
            scenes.insert(level.as_str(), scene);
        }
        Ok(scenes)
    }
}

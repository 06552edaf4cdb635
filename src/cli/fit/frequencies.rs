//! The spatial frequencies of the simplified models that were rated, measured where they lie.

use crate::mesh::Mesh;
use crate::mesh::simplify::detail::perimeter_px;
use crate::mesh::simplify::direction::ScreenMotion;
use crate::scene::screen_motion::ScreenPaths;
use crate::scene::world::World;
use anyhow::bail;
use glam::DAffine3;
use shutterlab_analysis::ratings::points::Frequencies;
use shutterlab_data_schema::fitted::FrequencyUnit;
use shutterlab_stimuli::scene::Shape;
use shutterlab_stimuli::{Sequence, Stimulus};
use std::path::Path;

/// The frequency of each model at each level of detail among the stimuli in `folder`, of those with this `r` if one is
/// given: one over the mean perimeter of its triangles as they are seen. How fast it goes makes no difference.
///
/// # Errors
/// A sequence or a model cannot be read, or none is of a simplified model.
pub(super) fn measured(
    folder: &Path,
    r: Option<f64>,
    unit: FrequencyUnit,
) -> anyhow::Result<Frequencies> {
    let mut frequencies = Frequencies::default();
    let mut done: Vec<(String, f64)> = vec![];
    for sequence in Sequence::open_all(folder)? {
        let stimulus = &sequence.manifest.stimulus;
        let (Some(model), Some(how)) = (stimulus.levels.get("model"), stimulus.simplification)
        else {
            continue;
        };
        let image = (model.clone(), how.level_of_detail);
        if r.is_some_and(|r| r != how.r) || done.contains(&image) {
            continue;
        }
        let perimeter_px = mean_perimeter_px(stimulus, folder)?;
        let perimeter = match unit {
            FrequencyUnit::PerPerimeterPixel => perimeter_px,
            FrequencyUnit::PerPerimeterDegree => perimeter_px / stimulus.pixels_per_degree,
        };
        // It is new.
        let _ = frequencies.insert(model, how.level_of_detail, 1.0 / perimeter);
        done.push(image);
    }
    if done.is_empty() {
        let of = r.map_or(String::new(), |r| format!(" with r = {r}"));
        bail!("{}: none of its stimuli is of a simplified model{of}", folder.display());
    }
    Ok(frequencies)
}

fn mean_perimeter_px(stimulus: &Stimulus, folder: &Path) -> anyhow::Result<f64> {
    let world = World::load(stimulus, folder)?;
    let objects = &stimulus.scene.objects;
    let object = objects.iter().find(|object| matches!(object.shape, Shape::Mesh { .. }));
    let (Some(object), [of]) = (object, &world.meshes[..]) else {
        bail!("{}: {}: a scene with one mesh is needed", folder.display(), stimulus.id);
    };
    let frames = 0..stimulus.image.frames;
    let motion = ScreenPaths::of_stimulus(stimulus, object, DAffine3::IDENTITY, frames);
    let Mesh { positions, end_positions, triangles, .. } = &of.mesh;
    let end = end_positions.as_ref().unwrap_or(positions);
    let perimeter = |triangle: &[u32; 3]| {
        let seen = triangle.map(|v| motion.seen([positions[v as usize], end[v as usize]]));
        f64::from(perimeter_px(&seen))
    };
    Ok(triangles.iter().map(perimeter).sum::<f64>() / triangles.len() as f64)
}

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
use std::collections::BTreeSet;
use std::path::Path;

/// The frequency of each model at each level of detail among the stimuli in `folder` that were simplified with one of
/// `rs`: one over the mean perimeter of its triangles as they are seen. Of what goes straight across the view the speed makes
/// no difference; else that of the first of the stimuli counts. If it is known which were `shown`, by their hashes,
/// others do not count. With them comes the ε of their weights.
///
/// # Errors
/// A sequence or a model cannot be read, or none is of a simplified model that was shown.
pub(super) fn measured(
    folder: &Path,
    rs: &[f64],
    shown: Option<&BTreeSet<String>>,
    unit: FrequencyUnit,
) -> anyhow::Result<(Frequencies, f64)> {
    let mut frequencies = Frequencies::default();
    let mut epsilons: Vec<f64> = vec![];
    let mut done: Vec<(String, f64)> = vec![];
    for sequence in Sequence::open_all(folder)? {
        let stimulus = &sequence.manifest.stimulus;
        let (Some(model), Some(how)) = (stimulus.model(), stimulus.simplification) else {
            continue;
        };
        let image = (model.to_string(), how.level_of_detail);
        let was_shown = shown.is_none_or(|shown| shown.contains(&sequence.manifest.sha256));
        if !was_shown || !rs.contains(&how.r) {
            continue;
        }
        epsilons.push(how.epsilon);
        if done.contains(&image) {
            continue;
        }
        let perimeter_px = mean_perimeter_px(stimulus, folder)?;
        let perimeter = match unit {
            FrequencyUnit::PerPerimeterPixel => perimeter_px,
            FrequencyUnit::PerPerimeterDegree => perimeter_px / stimulus.pixels_per_degree,
        };
        if frequencies.insert(model, how.level_of_detail, 1.0 / perimeter).is_ok() {
            done.push(image);
        }
    }
    let [epsilon, others @ ..] = &epsilons[..] else {
        let of = rs.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
        bail!(
            "{}: none of its stimuli is a simplified model, with r = {of}, that the answers are about",
            folder.display()
        );
    };
    if let Some(other) = others.iter().find(|other| *other != epsilon) {
        bail!("{}: epsilon: {epsilon} and {other}: of all stimuli one is needed", folder.display());
    }
    Ok((frequencies, *epsilon))
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

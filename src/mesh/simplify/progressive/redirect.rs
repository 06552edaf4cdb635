//! A changed direction of the motion: simplifies from the record of the nearest direction.

use super::ProgressiveMesh;
use crate::mesh::simplify::{Options, Simplified, SimplifyError, simplify};
use glam::Vec3;

/// A record, and the direction of the motion in the object's space that it was made for.
#[derive(Clone, Debug)]
pub struct Directed {
    /// The direction; of any length above 0.
    pub direction: Vec3,
    /// What was recorded.
    pub mesh: ProgressiveMesh,
}

/// How many times the faces that are asked for are taken from a record of another direction.
pub(super) const SPARE: usize = 4;

/// Simplifies for a motion in another `direction`, from the record whose direction is nearest: its mesh with
/// four times the faces that `options` ask for takes the place of the input, so that time goes with the
/// result, not with the input. `groups` are those of the input's faces, as are the faces of the result.
///
/// # Errors
/// As [`simplify`], and a direction without length or no record.
pub fn redirect(
    records: &mut [Directed],
    direction: Vec3,
    groups: Option<&[u32]>,
    options: &Options,
) -> Result<Simplified, SimplifyError> {
    let Some(direction) = direction.try_normalize() else {
        return Err(SimplifyError::value("direction", direction, "a length above 0"));
    };
    // Back is as far as forth: the angle is to the line.
    let cosine = |record: &Directed| record.direction.normalize_or_zero().dot(direction).abs();
    let nearest = records.iter_mut().max_by(|a, b| cosine(a).total_cmp(&cosine(b)));
    let Some(nearest) = nearest else {
        return Err(SimplifyError::value("records", 0, "1 or more are needed"));
    };
    let record = &mut nearest.mesh;
    if let Some(groups) = groups
        && groups.len() != record.input[1] as usize
    {
        let allowed = format!("one for each of the {} faces of the input", record.input[1]);
        return Err(SimplifyError::value("groups", groups.len(), allowed));
    }
    // Whichever of them stops the simplification.
    let mut splits = record.splits_for_faces(options.faces.saturating_mul(SPARE));
    if let Some(error) = options.error {
        splits = splits.max(record.splits_for_error(error / SPARE as f32));
    }
    if options.limit.is_some() {
        splits = splits.max(record.splits_for_speed(1.0 / SPARE as f32));
    }
    record.go_to(splits);
    let (mesh, faces) = record.mesh();
    let groups: Option<Vec<u32>> =
        groups.map(|groups| faces.iter().map(|&face| groups[face as usize]).collect());
    let mut simplified = simplify(&mesh, groups.as_deref(), options)?;
    simplified.faces.iter_mut().for_each(|face| *face = faces[*face as usize]);
    simplified.error = simplified.error.max(record.error());
    Ok(simplified)
}

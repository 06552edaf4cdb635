//! Quadric edge contraction that knows where the model is going.

mod attributes;
mod cluster;
pub mod detail;
pub mod direction;
mod morton;
pub mod progressive;
mod quadric;
mod rounds;
#[cfg(test)]
mod shapes;
mod surface;
#[cfg(test)]
mod tests;
mod wedges;

use super::{Mesh, MeshError};
use detail::PerimeterLimit;
use direction::{ScreenMotion, Seen, Weight};
use glam::Vec3;
use surface::Surface;

/// What is carried along with the vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Attributes {
    /// A new vertex has the mean of the normals and texture coordinates that it replaces (Zhang et al. 2014).
    Averaged,
    /// Normals and texture coordinates have their own quadrics, are placed best and add to the cost
    /// [Hoppe1999].
    #[default]
    Quadrics,
}

/// How far to simplify, and what to spare.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Stop at so many faces or fewer; 1 or more.
    pub faces: usize,
    /// No contraction whose error (root of the mean squared distance to the planes it replaces, in the mesh's
    /// unit) is larger.
    pub error: Option<f32>,
    /// How the direction of an edge weighs.
    pub weight: Weight,
    /// How the object is seen to move; needed by a weight and by a limit.
    pub motion: Option<&'a dyn ScreenMotion>,
    /// No triangle is seen with a larger perimeter, unless it was so before.
    pub limit: Option<PerimeterLimit>,
    /// What happens to normals and texture coordinates.
    pub attributes: Attributes,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self {
            faces: 1,
            error: None,
            weight: Weight::default(),
            motion: None,
            limit: None,
            attributes: Attributes::default(),
        }
    }
}

/// A simplified mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Simplified {
    /// The mesh, without the vertices that no triangle needs.
    pub mesh: Mesh,
    /// Which face of the input each face was.
    pub faces: Vec<u32>,
    /// Largest error of a contraction, in the mesh's unit: the root of the mean squared distance to the planes
    /// that it replaces.
    pub error: f32,
}

/// A mesh cannot be simplified as asked. Each message names the field, the value and what was allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimplifyError {
    /// The mesh itself.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A parameter.
    #[error("{field}: {value}: {allowed}")]
    Value {
        /// The parameter.
        field: &'static str,
        /// Its value.
        value: String,
        /// What was allowed.
        allowed: String,
    },
}

impl SimplifyError {
    pub(crate) fn value(
        field: &'static str,
        value: impl ToString,
        allowed: impl Into<String>,
    ) -> Self {
        Self::Value { field, value: value.to_string(), allowed: allowed.into() }
    }
}

/// Simplifies `mesh`. `groups` holds a number per face, such as its material, whose borders are kept as the
/// seams of the texture are.
///
/// # Errors
/// The mesh or a parameter cannot be used.
pub fn simplify(
    mesh: &Mesh,
    groups: Option<&[u32]>,
    options: &Options,
) -> Result<Simplified, SimplifyError> {
    options.check(mesh, groups)?;
    match mesh.end_positions {
        None => simplified::<1>(mesh, groups, options),
        Some(_) => simplified::<2>(mesh, groups, options),
    }
}

fn simplified<const F: usize>(
    mesh: &Mesh,
    groups: Option<&[u32]>,
    options: &Options,
) -> Result<Simplified, SimplifyError> {
    let mut surface = Surface::<F>::new(mesh, groups, options.attributes)?;
    let error =
        surface.contract(&options.settings(surface.unit, options.limit), options.faces, None);
    let (mesh, faces) = surface.mesh();
    Ok(Simplified { mesh, faces, error })
}

impl<'a> Options<'a> {
    fn check(&self, mesh: &Mesh, groups: Option<&[u32]>) -> Result<(), SimplifyError> {
        mesh.check("mesh")?;
        self.weight.check()?;
        if self.faces == 0 {
            return Err(SimplifyError::value("faces", 0, "1 or more are allowed"));
        }
        if let Some(groups) = groups
            && groups.len() != mesh.triangles.len()
        {
            let allowed = format!("one for each of the {} faces", mesh.triangles.len());
            return Err(SimplifyError::value("groups", groups.len(), allowed));
        }
        let limits = self.limit.map(|limit| [limit.slope, limit.intercept_px]);
        let [slope, intercept] = limits.unwrap_or_default();
        for (field, value) in [
            ("error", self.error.unwrap_or_default()),
            ("slope of the limit", slope),
            ("intercept of the limit", intercept),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(SimplifyError::value(
                    field,
                    value,
                    "finite numbers from 0 are allowed",
                ));
            }
        }
        if self.motion.is_none() && (self.limit.is_some() || !self.weight.is_isotropic()) {
            let allowed = "a weight by direction and a limit by speed need a motion";
            return Err(SimplifyError::value("motion", "none", allowed));
        }
        Ok(())
    }

    /// What holds for contractions of a surface in units of `unit`.
    fn settings(&self, unit: f32, limit: Option<PerimeterLimit>) -> Settings<'a> {
        let has_use = limit.is_some() || !self.weight.is_isotropic();
        Settings {
            weight: self.weight,
            motion: self.motion.filter(|_| has_use),
            limit,
            squared_error: self.error.map_or(f32::INFINITY, |error| (error / unit).powi(2)),
        }
    }
}

/// What holds for every contraction.
struct Settings<'a> {
    weight: Weight,
    /// None if nothing depends on it.
    motion: Option<&'a dyn ScreenMotion>,
    limit: Option<PerimeterLimit>,
    /// In the surface's unit.
    squared_error: f32,
}

impl Settings<'_> {
    /// How a point is seen that is at `position` in units of `unit`.
    fn look<const F: usize>(&self, position: &[Vec3; F], unit: f32) -> Seen {
        let keyframes = [position[0] * unit, position[F - 1] * unit];
        self.motion.map_or_else(Seen::default, |motion| motion.seen(keyframes))
    }
}

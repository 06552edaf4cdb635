//! Descriptions of things in a scene: their shape, place and motion.

use super::Material;
use crate::assets::{Assets, Kind, made};
use serde::{Deserialize, Serialize};
use shutterlab_data_schema::definition::DefinitionError;

/// A rigid or deforming thing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Object {
    /// What errors call it.
    pub name: String,
    /// Its shape, about its own origin.
    pub shape: Shape,
    /// Where its origin is; if it moves, when half of the sequence has passed.
    #[serde(default)]
    pub position_m: [f64; 3],
    /// How it is turned before it moves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<Orientation>,
    /// Its surface; if nothing is said, the stimulus's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<Material>,
    /// How it moves, if it does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Motion>,
}

/// Shapes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum Shape {
    /// A sphere about the origin.
    Sphere {
        /// Its radius.
        radius_m: f64,
    },
    /// A square in the plane y = 0 about the origin, with sides along x and z, to be seen from above and
    /// from below.
    Plane {
        /// Length of a side.
        side_m: f64,
    },
    /// A model in a file: .ply, .obj, .gltf, .glb or .stl.
    Mesh {
        /// Its path, from the folder of the scene's file; in a manifest its name.
        file: String,
        /// SHA-256 of the file, which a manifest tells and a scene need not; where the file names others,
        /// of the list of their names and hashes.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        sha256: String,
        /// Distance of its farthest vertex from the origin: it is scaled to that, and the middle of its
        /// bounding box comes to the origin. If nothing is said it is taken as it is, in metres.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        radius_m: Option<f64>,
    },
}

/// A rotation about an axis through the origin, by the right-hand rule.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Orientation {
    /// The axis, of any length.
    pub axis: [f64; 3],
    /// The angle.
    pub angle_deg: f64,
}

/// A motion at one speed: along a straight line, about an axis, from one pose to another, or any of these
/// together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// The speed; if nothing is said, the stimulus's, and then the grid's `trajectory` applies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_m_per_s: Option<f64>,
    /// Direction in which it goes at this speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub translation: Option<[f64; 3]>,
    /// Axis about which it turns so fast that points at a distance have this speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Rotation>,
    /// The pose to which its vertices go in straight lines, and back.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deformation: Option<Deformation>,
}

/// A turning about an axis through the object's origin, by the right-hand rule.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rotation {
    /// The axis, of any length.
    pub axis: [f64; 3],
    /// Distance from the axis at which points have the motion's speed: a wheel that goes as fast rolls
    /// on its rim of this radius.
    pub radius_m: f64,
}

/// A second pose of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Deformation {
    /// A model with the same faces, vertex for vertex, as [`Shape::Mesh`] has it.
    pub file: String,
    /// As [`Shape::Mesh`] has it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub sha256: String,
    /// What the motion's speed covers from one pose to the other. It is half way when half of the
    /// sequence has passed.
    pub distance_m: f64,
}

impl Object {
    /// Radius about its origin, where it is known before the file of a mesh is read.
    pub fn radius_m(&self) -> Option<f64> {
        match self.shape {
            Shape::Sphere { radius_m } => Some(radius_m),
            Shape::Plane { side_m } => Some(side_m * std::f64::consts::FRAC_1_SQRT_2),
            Shape::Mesh { radius_m, .. } => radius_m,
        }
    }

    /// Unit vector in which it goes.
    pub fn direction(&self) -> Option<[f64; 3]> {
        self.motion.as_ref()?.translation.map(unit)
    }

    /// Finds and hashes the files that it needs; `field` is what an error calls it.
    pub(super) fn find_files(
        &mut self,
        field: &str,
        assets: &mut Assets<'_>,
    ) -> Result<(), DefinitionError> {
        if let Shape::Mesh { file, sha256, .. } = &mut self.shape {
            assets.find(&format!("{field}.shape"), Kind::Model, file, sha256)?;
        }
        if let Some(Motion { deformation: Some(Deformation { file, sha256, .. }), .. }) =
            &mut self.motion
        {
            let field = format!("{field}.motion.deformation");
            assets.find(&field, Kind::Model, file, sha256)?;
        }
        match &mut self.material {
            Some(material) => material.find_files(&format!("{field}.material"), assets),
            None => Ok(()),
        }
    }

    /// Refuses values that make no picture; `field` is what an error calls the object in `file`.
    pub(super) fn check(&self, field: &str, file: &str) -> Result<(), DefinitionError> {
        let refuse = |key: &str, value: String, allowed: &str| {
            Err(DefinitionError::value(file, format!("{field}.{key}"), value, allowed))
        };
        let length = |key: &str, value: f64, low: f64, high: f64| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            refuse(key, value.to_string(), &format!("{low} to {high} m are allowed"))
        };
        let axis = |key: &str, value| super::check_vector(&format!("{field}.{key}"), value, file);
        if self.name.is_empty() {
            return refuse("name", "\"\"".into(), "a name is needed");
        }
        super::check_point(&format!("{field}.position_m"), self.position_m, file)?;
        match self.shape {
            Shape::Sphere { radius_m } | Shape::Mesh { radius_m: Some(radius_m), .. } => {
                length("shape.radius_m", radius_m, 1e-6, 1e6)?;
            }
            Shape::Plane { side_m } => length("shape.side_m", side_m, 1e-6, 1e9)?,
            Shape::Mesh { radius_m: None, .. } => {}
        }
        if let Some(Orientation { axis: about, angle_deg }) = self.orientation {
            axis("orientation.axis", about)?;
            if angle_deg.is_nan() || angle_deg.abs() > 360.0 {
                let allowed = "-360 to 360 degrees are allowed";
                return refuse("orientation.angle_deg", angle_deg.to_string(), allowed);
            }
        }
        let is_mesh = matches!(self.shape, Shape::Mesh { .. });
        if let Some(material) = &self.material {
            material.check(&format!("{field}.material"), file)?;
            if matches!(material, Material::Model { .. }) && !is_mesh {
                return refuse("material.kind", "model".into(), "only a mesh has a model's file");
            }
        }
        let Some(motion) = &self.motion else { return Ok(()) };
        super::check_speed(&format!("{field}.motion.speed_m_per_s"), motion.speed_m_per_s, file)?;
        if let Some(direction) = motion.translation {
            axis("motion.translation", direction)?;
        }
        if let Some(Rotation { axis: about, radius_m }) = motion.rotation {
            axis("motion.rotation.axis", about)?;
            length("motion.rotation.radius_m", radius_m, 1e-6, 1e6)?;
        }
        if let Some(Deformation { file: pose, distance_m, .. }) = &motion.deformation {
            length("motion.deformation.distance_m", *distance_m, 1e-6, 1e6)?;
            if !is_mesh {
                return refuse("motion.deformation.file", pose.clone(), "only a mesh has poses");
            }
            if made(pose).is_some() {
                let allowed = "a file is needed: models that are made have one pose";
                return refuse("motion.deformation.file", pose.clone(), allowed);
            }
        }
        Ok(())
    }
}

/// `vector` with the length 1; as it is if it has none.
pub(crate) fn unit(vector: [f64; 3]) -> [f64; 3] {
    let length = dot(vector, vector).sqrt();
    if length > 0.0 { vector.map(|component| component / length) } else { vector }
}

/// The scalar product.
pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

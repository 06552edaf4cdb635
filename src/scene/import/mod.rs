//! What other programs wrote: triangle meshes (PLY, OBJ, glTF, STL) and pictures (light maps, textures).
//!
//! A file may be damaged or hostile: every reader works on the file's bytes, believes no number in it
//! before the bytes are there, and answers with one error. The mesh readers are our own: of the crates
//! looked at, `tobj` 4.0.5 panics on `Kd 1` in a material, `gltf` 1.4.1 on an accessor index that is out
//! of range or of the wrong type, and `ply-rs-bw` 4.0.1 walks as many elements without properties as a
//! header claims, for hours if it says so.

pub mod gltf;
pub mod image;
pub mod obj;
pub mod ply;
pub mod stl;

use super::made;
use crate::mesh::simplify::SimplifyError;
use crate::mesh::{Mesh, MeshError};
use glam::Vec3;
use shutterlab_stimuli::assets::{Asset, Kind, MADE, made};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Larger files are refused.
pub const MAX_FILE_BYTES: u64 = 1 << 32;

/// A mesh and what its faces are made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// All triangles of the file.
    pub mesh: Mesh,
    /// The material of each triangle, by its place in `materials`.
    pub face_materials: Vec<u32>,
    /// At least one. Where a file says nothing, a face is white.
    pub materials: Vec<Material>,
}

impl Model {
    /// `mesh`, with nothing said about its faces.
    pub fn plain(mesh: Mesh) -> Self {
        let face_materials = vec![0; mesh.triangles.len()];
        Self { mesh, face_materials, materials: vec![Material::default()] }
    }
}

/// How a surface reflects.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// As the file calls it; may be empty.
    pub name: String,
    /// Diffuse reflectance (linear Rec. 709).
    pub base_color: Vec3,
    /// What the base colour is multiplied by.
    pub texture: Option<Texture>,
}

impl Default for Material {
    fn default() -> Self {
        Self { name: String::new(), base_color: Vec3::ONE, texture: None }
    }
}

/// A picture that has not been decoded yet; [`image::texture`] does.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// A file of its own.
    File(PathBuf),
    /// Inside the model's file.
    Embedded {
        /// The model's file and the picture's place in it.
        name: String,
        /// The picture's file.
        bytes: Arc<[u8]>,
    },
}

impl Texture {
    /// What errors call it.
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Embedded { name, .. } => name.clone(),
        }
    }
}

/// A file could not be imported. Each message names the file, the field, the value and what was allowed.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The file could not be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Something in the file cannot be used.
    #[error("{file}: {field}: {value}: {allowed}")]
    Value {
        /// The file.
        file: String,
        /// Which part of the file.
        field: String,
        /// What was found, shortened.
        value: String,
        /// What was allowed.
        allowed: String,
    },
    /// What was read makes no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A model cannot be simplified.
    #[error("{}: simplification: {source}", path.display())]
    Simplify {
        /// The model's file.
        path: PathBuf,
        /// What the simplifier said.
        source: SimplifyError,
    },
}

impl ImportError {
    fn value(
        file: &str,
        field: impl Into<String>,
        value: impl ToString,
        allowed: impl Into<String>,
    ) -> Self {
        let mut value = value.to_string();
        if let Some((end, _)) = value.char_indices().nth(60) {
            value.truncate(end);
            value.push('…');
        }
        Self::Value { file: file.into(), field: field.into(), value, allowed: allowed.into() }
    }
}

/// Reads the model in `path`; the ending of its name says how.
///
/// # Errors
/// The ending is unknown, the file cannot be read, or it holds no mesh that can be used.
pub fn model(path: &Path) -> Result<Model, ImportError> {
    let file = path.display().to_string();
    if let Some(name) = made(&file) {
        let unknown =
            || ImportError::value(&file, "model", name, format!("one of {}", MADE.join(", ")));
        return Ok(Model::plain(made::model(name).ok_or_else(unknown)?));
    }
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let folder = path.parent().unwrap_or(Path::new(""));
    let model = match ending.as_str() {
        "ply" => ply::parse(&file, &read(path)?)?,
        "obj" => obj::parse(&file, &read(path)?, folder)?,
        "gltf" | "glb" => gltf::parse(&file, &read(path)?, folder)?,
        "stl" => stl::parse(&file, &read(path)?)?,
        _ => {
            let allowed = "models are .ply, .obj, .gltf, .glb and .stl files";
            return Err(ImportError::value(&file, "ending", ending, allowed));
        }
    };
    Ok(model)
}

/// The vertices of the model in `path`, a second pose of `first`.
///
/// # Errors
/// As [`model`], or it has other faces.
pub fn second_pose(path: &Path, first: &Mesh) -> Result<Vec<Vec3>, ImportError> {
    let Mesh { positions, triangles, .. } = model(path)?.mesh;
    let counted = |triangles: usize, vertices| format!("{triangles}, of {vertices} vertices");
    if triangles != first.triangles || positions.len() != first.positions.len() {
        let needed = counted(first.triangles.len(), first.positions.len());
        return Err(ImportError::value(
            &path.display().to_string(),
            "triangles",
            counted(triangles.len(), positions.len()),
            format!("those of the first pose, vertex for vertex, are needed: {needed}"),
        ));
    }
    Ok(positions)
}

/// Refuses a file that a scene cannot use as what it is to be, with all that it names.
///
/// # Errors
/// As [`model`], [`image::light_map`] and [`image::texture`].
pub fn check(asset: &Asset) -> Result<(), ImportError> {
    match asset.kind {
        Kind::LightMap => image::light_map(&asset.source).map(drop),
        Kind::Picture => image::texture(&Texture::File(asset.source.clone())).map(drop),
        Kind::Model => model(&asset.source)?
            .materials
            .iter()
            .filter_map(|material| material.texture.as_ref())
            .try_for_each(|texture| image::texture(texture).map(drop)),
    }
}

/// The bytes of a regular file of allowed size.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, ImportError> {
    let unreadable = |source| ImportError::Unreadable { path: path.into(), source };
    // Neither a device, which may never end, nor a pipe, which may never begin.
    let metadata = std::fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(unreadable(std::io::Error::other("not a regular file")));
    }
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let mut bytes = vec![];
    file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        let (file, allowed) = (path.display().to_string(), format!("at most {MAX_FILE_BYTES}"));
        return Err(ImportError::value(&file, "bytes", metadata.len(), allowed));
    }
    Ok(bytes)
}

/// Triangles of a polygon, as a fan around its first corner.
fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]])
}

#[cfg(test)]
mod hostile;

//! Models written for other programs: PLY, OBJ, glTF and STL, as the ending of the file's name says.
//!
//! What a file is said to hold, [`super::import`] reads back from it. Faces of one material lie together in it, in
//! the order of the materials; OBJ and STL number the vertices by their first use and have no others.

mod gltf;
mod obj;
mod pictures;
mod ply;
mod stl;

use super::import::{Material, Model};
use crate::mesh::MeshError;
use shutterlab_data_schema::files::write_atomically_with;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// How a model is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Binary, little endian; no materials.
    Ply,
    /// Text, with its materials in a file beside it that ends in .mtl.
    Obj,
    /// JSON, with its buffer in a file beside it that ends in .bin.
    Gltf,
    /// As glTF, all in one file.
    Glb,
    /// Binary; nothing but triangles.
    Stl,
}

/// A model could not be written. Each message names the file, the field, the value and what was allowed.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// A file could not be written.
    #[error("cannot be written: {0}")]
    Unwritable(#[from] std::io::Error),
    /// Something that the file cannot be or hold.
    #[error("{}: {field}: {value}: {allowed}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// What cannot be.
        field: &'static str,
        /// Its value.
        value: String,
        /// What was allowed.
        allowed: String,
    },
    /// The model has no sound mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl ExportError {
    fn value(
        path: &Path,
        field: &'static str,
        value: impl ToString,
        allowed: impl Into<String>,
    ) -> Self {
        Self::Value { path: path.into(), field, value: value.to_string(), allowed: allowed.into() }
    }
}

impl Format {
    /// The format of a file called `path`.
    ///
    /// # Errors
    /// The ending is unknown, or no name is before it that other files can name.
    pub fn of(path: &Path) -> Result<Self, ExportError> {
        if path.file_name().and_then(|name| name.to_str()).is_none() {
            let allowed = "the name of a file, in UTF-8, is needed";
            return Err(ExportError::value(path, "name", path.display(), allowed));
        }
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        Ok(match ending.as_str() {
            "ply" => Self::Ply,
            "obj" => Self::Obj,
            "gltf" => Self::Gltf,
            "glb" => Self::Glb,
            "stl" => Self::Stl,
            _ => {
                let allowed = "models are written as .ply, .obj, .gltf, .glb and .stl files";
                let found = if ending.is_empty() { "none".into() } else { ending };
                return Err(ExportError::value(path, "ending", found, allowed));
            }
        })
    }

    /// The file beside `path` that its materials or its buffer are written to.
    pub fn companion(self, path: &Path) -> Option<PathBuf> {
        match self {
            Self::Obj => Some(path.with_extension("mtl")),
            Self::Gltf => Some(path.with_extension("bin")),
            Self::Ply | Self::Glb | Self::Stl => None,
        }
    }

    /// What `model` has and such a file has not.
    fn left_out(self, model: &Model) -> Vec<String> {
        let mesh = &model.mesh;
        let plain = |material: &Material| {
            *material == Material { name: material.name.clone(), ..Material::default() }
        };
        let has_materials = || {
            model.face_materials.iter().any(|&material| !plain(&model.materials[material as usize]))
        };
        let is_stl = self == Self::Stl;
        [
            ("positions at the shutter's closing", mesh.end_positions.is_some()),
            ("normals", is_stl && mesh.normals.is_some()),
            ("texture coordinates", is_stl && mesh.texture_coordinates.is_some()),
            ("materials", (is_stl || self == Self::Ply) && has_materials()),
        ]
        .into_iter()
        .filter(|(_, is_left_out)| *is_left_out)
        .map(|(what, _)| what.into())
        .collect()
    }
}

/// Writes `model` to `path`, whose ending says how, and what its format has in files of their own beside it; each
/// is there whole or not at all. Pictures beside or below `path` are referred to by name. Others are written into
/// glTF's buffer, and beside an OBJ file as `NAME-1.png` and so on.
///
/// Returns what the model has and the file has not, in words.
///
/// # Errors
/// The ending is unknown, the folder is not there, the model is not sound, or something cannot be written.
pub fn model(model: &Model, path: &Path) -> Result<Vec<String>, ExportError> {
    let format = Format::of(path)?;
    check_folder(path)?;
    model.mesh.check(&path.display().to_string())?;
    let (faces, materials) = (model.mesh.triangles.len(), model.materials.len());
    let unknown = model.face_materials.iter().find(|&&material| material as usize >= materials);
    if model.face_materials.len() != faces || unknown.is_some() {
        let found = unknown.map_or(model.face_materials.len(), |&material| material as usize);
        let allowed = format!("one for each of {faces} faces, below {materials}, is needed");
        return Err(ExportError::value(path, "materials of faces", found, allowed));
    }

    let mut left_out = format.left_out(model);
    match format {
        Format::Ply => write(path, |out| ply::write(&model.mesh, out))?,
        Format::Stl => write(path, |out| stl::write(&model.mesh, out))?,
        Format::Obj => left_out.extend(obj::write(model, path)?),
        Format::Gltf | Format::Glb => left_out.extend(gltf::write(model, path, format)?),
    }
    Ok(left_out)
}

/// Refuses a `path` whose folder is not there.
///
/// # Errors
/// It is not.
pub fn check_folder(path: &Path) -> Result<(), ExportError> {
    let folder = folder_of(path);
    if folder.is_dir() {
        return Ok(());
    }
    let allowed = "an existing folder is needed";
    Err(ExportError::value(path, "folder", folder.display(), allowed))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The file at `path` with what `content` writes, or as it was.
fn write(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), ExportError> {
    write_atomically_with(path, |file| {
        let mut buffered = BufWriter::new(file);
        content(&mut buffered)?;
        buffered.flush()
    })?;
    Ok(())
}

fn put(out: &mut dyn Write, numbers: &[f32]) -> std::io::Result<()> {
    numbers.iter().try_for_each(|number| out.write_all(&number.to_le_bytes()))
}

/// Each material that `model` uses, with its triangles.
fn by_material(model: &Model) -> Vec<(usize, Vec<[u32; 3]>)> {
    let mut groups = vec![vec![]; model.materials.len()];
    for (&triangle, &material) in model.mesh.triangles.iter().zip(&model.face_materials) {
        groups[material as usize].push(triangle);
    }
    groups.into_iter().enumerate().filter(|(_, triangles)| !triangles.is_empty()).collect()
}

/// The materials that are written, with their place in `model`. A first one that says nothing is not: in OBJ and
/// glTF, faces without a material are of it.
fn told_materials(model: &Model) -> impl Iterator<Item = (usize, &Material)> {
    let says_nothing = model.materials.first() == Some(&Material::default());
    model.materials.iter().enumerate().skip(usize::from(says_nothing))
}

#[cfg(test)]
mod tests;

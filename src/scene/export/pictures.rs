//! The pictures of a model that is written: which its file can refer to, and the bytes of the others.

use crate::scene::import::{Model, Texture, read};
use image::ImageFormat;
use std::path::{Component, Path};
use std::sync::Arc;

/// A picture as a file can have it.
pub(super) enum Picture {
    /// Beside or below the model's file: the name from there, with slashes.
    Named(String),
    /// Somewhere else.
    Bytes(Arc<[u8]>, ImageFormat),
}

/// The different pictures of a model.
#[derive(Default)]
pub(super) struct Pictures {
    pub all: Vec<Picture>,
    /// The picture of each material.
    pub of_material: Vec<Option<usize>>,
    /// Those that are not in `all`, in words.
    pub left_out: Vec<String>,
}

impl Pictures {
    /// The pictures of `model`. Those in `folder` and below are referred to by name; without a folder, none.
    pub fn of(model: &Model, folder: Option<&Path>, formats: &[ImageFormat]) -> Self {
        let mut pictures = Self::default();
        let mut met: Vec<(&Texture, Option<usize>)> = vec![];
        for material in &model.materials {
            let place = material.texture.as_ref().and_then(|texture| {
                if let Some((_, place)) = met.iter().find(|(known, _)| *known == texture) {
                    return *place;
                }
                let place = match picture(texture, folder, formats) {
                    Ok(picture) => {
                        pictures.all.push(picture);
                        Some(pictures.all.len() - 1)
                    }
                    Err(reason) => {
                        pictures.left_out.push(format!("a picture ({reason})"));
                        None
                    }
                };
                met.push((texture, place));
                place
            });
            pictures.of_material.push(place);
        }
        pictures
    }
}

fn picture(
    texture: &Texture,
    folder: Option<&Path>,
    formats: &[ImageFormat],
) -> Result<Picture, String> {
    let (bytes, name): (Arc<[u8]>, _) = match texture {
        Texture::Embedded { bytes, .. } => (bytes.clone(), None),
        Texture::File(path) => {
            let bytes = read(path).map_err(|error| error.to_string())?;
            (bytes.into(), folder.and_then(|folder| name_from(folder, path)))
        }
    };
    match image::guess_format(&bytes) {
        Ok(format) if formats.contains(&format) => {
            Ok(name.map_or(Picture::Bytes(bytes, format), Picture::Named))
        }
        _ => {
            let names: Vec<&str> = formats.iter().map(|format| ending(*format)).collect();
            Err(format!("{}: one of the formats {} is needed", texture.name(), names.join(", ")))
        }
    }
}

/// How the file at `path`, if there is one, is called from `folder`, if it is there or below and every format can
/// say its name.
fn name_from(folder: &Path, path: &Path) -> Option<String> {
    let path = path.canonicalize().ok()?;
    let below = path.strip_prefix(folder.canonicalize().ok()?).ok()?;
    let parts: Option<Vec<&str>> = below
        .components()
        .map(|part| match part {
            Component::Normal(name) => name.to_str(),
            _ => None,
        })
        .collect();
    let name = parts?.join("/");
    let is_plain = !name.starts_with('-')
        && name.trim() == name
        && !name.contains(|c: char| c == '\\' || c.is_control());
    is_plain.then_some(name)
}

/// What files in `format` end in.
pub(super) fn ending(format: ImageFormat) -> &'static str {
    format.extensions_str().first().copied().unwrap_or_default()
}

//! What is read of a glTF document, and the bytes that it points to.

use crate::scene::import::{ImportError, MAX_FILE_BYTES, read};
use base64::Engine;
use glam::{DMat4, DQuat, DVec3};
use serde::Deserialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Document {
    pub asset: Asset,
    #[serde(default)]
    pub extensions_required: Vec<String>,
    pub scene: Option<usize>,
    #[serde(default)]
    pub scenes: Vec<Scene>,
    #[serde(default)]
    pub nodes: Vec<Node>,
    #[serde(default)]
    pub meshes: Vec<Mesh>,
    #[serde(default)]
    pub materials: Vec<Material>,
    #[serde(default)]
    pub textures: Vec<Texture>,
    #[serde(default)]
    pub images: Vec<Image>,
    #[serde(default)]
    accessors: Vec<Accessor>,
    #[serde(default)]
    buffer_views: Vec<BufferView>,
    #[serde(default)]
    buffers: Vec<Buffer>,
}

#[derive(Deserialize)]
pub struct Asset {
    pub version: String,
}

#[derive(Deserialize)]
pub struct Scene {
    #[serde(default)]
    pub nodes: Vec<usize>,
}

#[derive(Deserialize)]
pub struct Node {
    pub mesh: Option<usize>,
    #[serde(default)]
    pub children: Vec<usize>,
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

#[derive(Deserialize)]
pub struct Mesh {
    pub primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
pub struct Primitive {
    pub attributes: BTreeMap<String, usize>,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    #[serde(default = "triangles")]
    pub mode: u32,
}

fn triangles() -> u32 {
    4
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Material {
    #[serde(default)]
    pub name: String,
    #[serde(default)]
    pub pbr_metallic_roughness: Surface,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Surface {
    pub base_color_factor: [f32; 4],
    pub base_color_texture: Option<TextureUse>,
}

impl Default for Surface {
    fn default() -> Self {
        Self { base_color_factor: [1.0; 4], base_color_texture: None }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TextureUse {
    pub index: usize,
    #[serde(default)]
    pub tex_coord: u32,
}

#[derive(Deserialize)]
pub struct Texture {
    pub source: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Image {
    pub uri: Option<String>,
    pub buffer_view: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    #[serde(default)]
    normalized: bool,
    count: usize,
    r#type: String,
    sparse: Option<serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct BufferView {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Buffer {
    uri: Option<String>,
    byte_length: usize,
}

impl Node {
    /// Parent from node.
    pub fn transform(&self) -> DMat4 {
        if let Some(columns) = &self.matrix {
            return DMat4::from_cols_array(columns);
        }
        let rotation = self.rotation.map_or(DQuat::IDENTITY, DQuat::from_array);
        DMat4::from_scale_rotation_translation(
            self.scale.map_or(DVec3::ONE, DVec3::from),
            // A quaternion of another length than 1 would scale.
            rotation.normalize(),
            self.translation.map_or(DVec3::ZERO, DVec3::from),
        )
    }
}

/// The JSON text and the binary chunk of a file in either form.
pub fn chunks<'a>(
    file: &str,
    bytes: &'a [u8],
) -> Result<(&'a [u8], Option<&'a [u8]>), ImportError> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes, None));
    }
    let wrong =
        |field, value: String, allowed: &str| ImportError::value(file, field, value, allowed);
    let word = |at: usize| {
        let word = bytes.get(at..at + 4).and_then(|word| word.try_into().ok());
        word.map(u32::from_le_bytes).ok_or_else(|| {
            wrong("header", format!("{} bytes", bytes.len()), "the file ends too soon")
        })
    };
    if word(4)? != 2 {
        return Err(wrong("version", word(4)?.to_string(), "binary glTF 2 is known"));
    }
    let mut found = [None, None];
    let mut at = 12;
    for (slot, kind) in found.iter_mut().zip([*b"JSON", *b"BIN\0"]) {
        if slot.is_none() && at < bytes.len() && word(at + 4)?.to_le_bytes() == kind {
            let length = word(at)? as usize;
            let end = (at + 8).checked_add(length).filter(|&end| end <= bytes.len());
            let Some(end) = end else {
                let allowed = format!("the file has {} bytes", bytes.len());
                return Err(wrong("length of a chunk", length.to_string(), &allowed));
            };
            *slot = Some(&bytes[at + 8..end]);
            at = end;
        }
    }
    match found {
        [Some(json), binary] => Ok((json, binary)),
        _ => Err(wrong("first chunk", "another kind".into(), "JSON comes first")),
    }
}

/// A document with its buffers.
pub struct File<'a> {
    pub name: &'a str,
    folder: &'a Path,
    pub document: &'a Document,
    buffers: Vec<Cow<'a, [u8]>>,
}

impl<'a> File<'a> {
    /// Reads the buffers of `document`.
    pub fn open(
        name: &'a str,
        folder: &'a Path,
        document: &'a Document,
        binary: Option<&'a [u8]>,
    ) -> Result<Self, ImportError> {
        let mut file = Self { name, folder, document, buffers: vec![] };
        for (index, buffer) in document.buffers.iter().enumerate() {
            let bytes = match (&buffer.uri, binary) {
                (Some(uri), _) if uri.starts_with("data:") => Cow::Owned(decode_data(name, uri)?),
                (Some(uri), _) => Cow::Owned(read(&file.path_of(uri)?)?),
                (None, Some(binary)) if index == 0 => Cow::Borrowed(binary),
                (None, _) => {
                    let field = format!("buffers[{index}].uri");
                    let allowed = "only the first buffer of a .glb file can do without";
                    return Err(ImportError::value(name, field, "none", allowed));
                }
            };
            if bytes.len() < buffer.byte_length {
                let field = format!("buffers[{index}].byteLength");
                let allowed = format!("there are {} bytes", bytes.len());
                return Err(ImportError::value(name, field, buffer.byte_length, allowed));
            }
            file.buffers.push(bytes);
            // One file named many times would be in memory as often.
            let total: u64 = file.buffers.iter().map(|bytes| bytes.len() as u64).sum();
            if total > MAX_FILE_BYTES {
                let allowed = format!("at most {MAX_FILE_BYTES} bytes together");
                return Err(ImportError::value(name, "buffers", total, allowed));
            }
        }
        Ok(file)
    }

    /// Item `index` of the list called `list`.
    pub fn item<'b, T>(
        &self,
        field: &str,
        list: &str,
        items: &'b [T],
        index: usize,
    ) -> Result<&'b T, ImportError> {
        items.get(index).ok_or_else(|| {
            let found = if index == usize::MAX { "none".into() } else { index.to_string() };
            ImportError::value(self.name, field, found, format!("there are {} {list}", items.len()))
        })
    }

    /// The file that a relative `uri` names, its %20 and the like decoded.
    pub fn path_of(&self, uri: &str) -> Result<PathBuf, ImportError> {
        if uri.contains("://") {
            return Err(ImportError::value(self.name, "uri", uri, "names of files are known"));
        }
        let name = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
        Ok(self.folder.join(name.as_ref()))
    }

    /// The bytes of buffer view `index`, and its stride.
    pub fn view(&self, index: usize) -> Result<(&[u8], Option<usize>), ImportError> {
        let view = self.item("bufferView", "bufferViews", &self.document.buffer_views, index)?;
        let buffer = self.item("buffer", "buffers", &self.buffers, view.buffer)?;
        let end = view.byte_offset.checked_add(view.byte_length);
        let bytes = end.and_then(|end| buffer.get(view.byte_offset..end)).ok_or_else(|| {
            let field = format!("bufferViews[{index}]");
            let found = format!("{} bytes from {}", view.byte_length, view.byte_offset);
            ImportError::value(self.name, field, found, format!("there are {}", buffer.len()))
        })?;
        Ok((bytes, view.byte_stride))
    }

    /// The elements of accessor `index`, which `field` names, in floating point.
    pub fn vectors<const N: usize>(
        &self,
        field: &str,
        index: usize,
    ) -> Result<Vec<[f32; N]>, ImportError> {
        let (kind, is_normalized, elements) = self.elements::<N>(field, index)?;
        let decode = |bytes: &[u8]| decode(kind, is_normalized, bytes);
        Ok(elements
            .map(|element| {
                let size = element.len() / N;
                std::array::from_fn(|k| decode(&element[k * size..][..size]) as f32)
            })
            .collect())
    }

    /// The elements of accessor `index` as indices.
    pub fn indices(&self, index: usize) -> Result<Vec<u32>, ImportError> {
        let (kind, _, elements) = self.elements::<1>("indices", index)?;
        if ![5121, 5123, 5125].contains(&kind) {
            let field = format!("accessors[{index}].componentType");
            let allowed = "indices are of type 5121, 5123 or 5125";
            return Err(ImportError::value(self.name, field, kind, allowed));
        }
        Ok(elements.map(|element| decode(kind, false, element) as u32).collect())
    }

    /// Type, normalisation and elements of accessor `index`, which has `N` components.
    fn elements<const N: usize>(
        &self,
        field: &str,
        index: usize,
    ) -> Result<(u32, bool, impl Iterator<Item = &[u8]>), ImportError> {
        let accessor = self.item(field, "accessors", &self.document.accessors, index)?;
        let wrong = |part: &str, value: String, allowed: &str| {
            let field = format!("accessors[{index}].{part}");
            ImportError::value(self.name, field, value, allowed)
        };
        let shape = ["SCALAR", "VEC2", "VEC3"][N - 1];
        if accessor.r#type != shape {
            return Err(wrong("type", accessor.r#type.clone(), &format!("{field} needs {shape}")));
        }
        let size = match accessor.component_type {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            5125 | 5126 => 4,
            other => {
                return Err(wrong("componentType", other.to_string(), "5120 to 5126 but 5124"));
            }
        };
        let (Some(view), None) = (accessor.buffer_view, &accessor.sparse) else {
            return Err(wrong("bufferView", "none, or sparse".into(), "plain accessors are known"));
        };
        let (bytes, stride) = self.view(view)?;
        let element = N * size;
        let stride = stride.unwrap_or(element);
        if stride < element {
            return Err(wrong(
                "bufferView",
                format!("byteStride {stride}"),
                "elements may not overlap",
            ));
        }
        let needed = match accessor.count {
            0 => Some(accessor.byte_offset),
            count => (count - 1)
                .checked_mul(stride)
                .and_then(|length| length.checked_add(element)?.checked_add(accessor.byte_offset)),
        };
        if needed.is_none_or(|needed| needed > bytes.len()) {
            let allowed = format!("the buffer view has {} bytes", bytes.len());
            return Err(wrong("count", accessor.count.to_string(), &allowed));
        }
        let at = move |k: usize| &bytes[accessor.byte_offset + k * stride..][..element];
        Ok((accessor.component_type, accessor.normalized, (0..accessor.count).map(at)))
    }
}

/// A component of type `kind`, lowest byte first.
fn decode(kind: u32, is_normalized: bool, bytes: &[u8]) -> f64 {
    let mut word = [0; 4];
    word[..bytes.len()].copy_from_slice(bytes);
    let [a, b, ..] = word;
    let (value, largest) = match kind {
        5120 => (f64::from(i8::from_le_bytes([a])), 127.0),
        5121 => (f64::from(a), 255.0),
        5122 => (f64::from(i16::from_le_bytes([a, b])), 32767.0),
        5123 => (f64::from(u16::from_le_bytes([a, b])), 65535.0),
        5125 => (f64::from(u32::from_le_bytes(word)), f64::from(u32::MAX)),
        _ => return f64::from(f32::from_le_bytes(word)),
    };
    if is_normalized { (value / largest).max(-1.0) } else { value }
}

/// The bytes of a `data:` URI.
pub fn decode_data(file: &str, uri: &str) -> Result<Vec<u8>, ImportError> {
    let wrong = |allowed: &str| ImportError::value(file, "uri", uri, allowed);
    let (_, text) = uri.split_once(";base64,").ok_or_else(|| wrong("data URIs are base64"))?;
    base64::engine::general_purpose::STANDARD
        .decode(text)
        .map_err(|error| wrong(&error.to_string()))
}

//! Models as glTF 2.0 files: a JSON document and a buffer, in two files or in one.

use super::pictures::{Picture, Pictures};
use super::{ExportError, Format, by_material, folder_of, told_materials, write as write_file};
use crate::scene::import::Model;
use glam::Vec3;
use image::ImageFormat;
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use serde_json::{Value, json};
use std::path::Path;

/// What names of files need not be encoded for.
const KEPT: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'_').remove(b'.').remove(b'/');

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

/// Returns what could not be written, in words.
pub(super) fn write(
    model: &Model,
    path: &Path,
    format: Format,
) -> Result<Vec<String>, ExportError> {
    let folder = (format == Format::Gltf).then(|| folder_of(path));
    let pictures = Pictures::of(model, folder, &[ImageFormat::Png, ImageFormat::Jpeg]);
    let mut buffer = Buffer::default();
    let mut document = document(model, &pictures, &mut buffer);
    let mut left_out = pictures.left_out;
    if model.materials.iter().any(|material| material.base_color.max_element() > 1.0) {
        left_out.push("reflectances above 1".into());
    }
    if let Some(companion) = format.companion(path) {
        let name = companion.file_name().unwrap_or_default().to_string_lossy();
        document["buffers"] = json!([{ "byteLength": buffer.bytes.len(), "uri": encoded(&name) }]);
        write_file(&companion, |out| out.write_all(&buffer.bytes))?;
        write_file(path, |out| Ok(serde_json::to_writer(out, &document)?))?;
        return Ok(left_out);
    }

    document["buffers"] = json!([{ "byteLength": buffer.bytes.len() }]);
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + json.len() + 8 + buffer.bytes.len();
    let Ok(length) = u32::try_from(length) else {
        let allowed = format!("a .glb file has at most {}; .gltf may have more", u32::MAX);
        return Err(ExportError::value(path, "bytes", length, allowed));
    };
    write_file(path, |out| {
        out.write_all(b"glTF")?;
        out.write_all(&[2, length].map(u32::to_le_bytes).concat())?;
        for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &buffer.bytes)] {
            out.write_all(&(chunk.len() as u32).to_le_bytes())?;
            out.write_all(kind)?;
            out.write_all(chunk)?;
        }
        Ok(())
    })?;
    Ok(left_out)
}

/// The document without its buffer, which is gathered.
fn document(model: &Model, pictures: &Pictures, buffer: &mut Buffer) -> Value {
    let mesh = &model.mesh;
    let positions = mesh.positions.iter().map(|position| position.to_array());
    let position = buffer.floats("VEC3", mesh.positions.iter().flat_map(Vec3::to_array));
    let bound = |better: fn(f32, f32) -> f32| {
        positions.clone().reduce(|a, b| std::array::from_fn(|k| better(a[k], b[k])))
    };
    buffer.accessors[position]["min"] = json!(bound(f32::min));
    buffer.accessors[position]["max"] = json!(bound(f32::max));
    let mut attributes = json!({ "POSITION": position });
    if let Some(normals) = &mesh.normals {
        let unit = normals.iter().map(|normal| normal.as_dvec3().normalize_or_zero().as_vec3());
        attributes["NORMAL"] = buffer.floats("VEC3", unit.flat_map(|n| n.to_array())).into();
    }
    if let Some(coordinates) = &mesh.texture_coordinates {
        // glTF counts v from the upper edge.
        let numbers = coordinates.iter().flat_map(|at| [at.x, 1.0 - at.y]);
        attributes["TEXCOORD_0"] = buffer.floats("VEC2", numbers).into();
    }

    let told: Vec<_> = told_materials(model).collect();
    let mut primitives = vec![];
    for (material, triangles) in by_material(model) {
        let indices = buffer.indices(&triangles);
        let mut primitive = json!({ "attributes": attributes, "indices": indices });
        if let Some(place) = told.iter().position(|(place, _)| *place == material) {
            primitive["material"] = place.into();
        }
        primitives.push(primitive);
    }
    let materials = told.iter().map(|(place, material)| {
        let [r, g, b] = material.base_color.min(Vec3::ONE).to_array();
        // Diffuse: glTF's default is a metal.
        let mut surface = json!({ "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0 });
        if let Some(picture) = pictures.of_material[*place] {
            surface["baseColorTexture"] = json!({ "index": picture });
        }
        let mut told = json!({ "pbrMetallicRoughness": surface });
        if !material.name.is_empty() {
            told["name"] = material.name.as_str().into();
        }
        told
    });
    let materials: Vec<Value> = materials.collect();
    let images: Vec<Value> = pictures.all.iter().map(|picture| buffer.image(picture)).collect();
    let textures: Vec<Value> =
        (0..images.len()).map(|source| json!({ "source": source })).collect();
    let mut document = json!({
        "asset": {
            "version": "2.0",
            "generator": concat!("Shutterlab ", env!("CARGO_PKG_VERSION")),
        },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": primitives }],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
    });
    // Lists without elements are not allowed.
    for (name, list) in [("materials", materials), ("textures", textures), ("images", images)] {
        if !list.is_empty() {
            document[name] = list.into();
        }
    }
    document
}

fn encoded(name: &str) -> String {
    utf8_percent_encode(name, KEPT).to_string()
}

/// The buffer, and the parts of the document that say what it holds.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Closes the view of what was added from byte `start` on.
    fn view(&mut self, start: usize) -> usize {
        let length = self.bytes.len() - start;
        self.views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": length }));
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn accessor(&mut self, start: usize, component: u32, shape: &str, elements: usize) -> usize {
        let view = self.view(start);
        self.accessors.push(json!({
            "bufferView": view, "componentType": component, "type": shape, "count": elements,
        }));
        self.accessors.len() - 1
    }

    fn floats(&mut self, shape: &str, numbers: impl Iterator<Item = f32>) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(numbers.flat_map(f32::to_le_bytes));
        let element = if shape == "VEC3" { 12 } else { 8 };
        self.accessor(start, FLOAT, shape, (self.bytes.len() - start) / element)
    }

    fn indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(triangles.iter().flatten().flat_map(|index| index.to_le_bytes()));
        self.accessor(start, UNSIGNED_INT, "SCALAR", 3 * triangles.len())
    }

    fn image(&mut self, picture: &Picture) -> Value {
        match picture {
            Picture::Named(name) => json!({ "uri": encoded(name) }),
            Picture::Bytes(bytes, format) => {
                let start = self.bytes.len();
                self.bytes.extend(&bytes[..]);
                json!({ "bufferView": self.view(start), "mimeType": format.to_mime_type() })
            }
        }
    }
}

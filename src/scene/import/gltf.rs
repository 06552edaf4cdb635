//! Meshes from glTF 2.0 files, as JSON or binary: all triangles of the default scene, with the nodes'
//! transforms applied, and the materials' base colours.
//!
//! Skins, morph targets and animations are passed over: the meshes are as their nodes place them.
//! Extensions that a file requires are refused by name, but for quantized meshes, which cost nothing.

mod document;

use super::{ImportError, MAX_FILE_BYTES, Material, Model, Texture};
use crate::mesh::{MAX_ELEMENTS, Mesh};
use document::{Document, File, Primitive};
use glam::{DMat3, DMat4, DVec3, Vec2, Vec3};
use std::collections::BTreeMap;
use std::path::Path;

const KNOWN_EXTENSIONS: [&str; 1] = ["KHR_mesh_quantization"];

/// The model in `bytes`, the content of `file`, which lies in `folder`.
///
/// # Errors
/// The bytes are no glTF file, a buffer cannot be read, an extension is required that is not known, or
/// there is no mesh that can be used.
pub fn parse(file: &str, bytes: &[u8], folder: &Path) -> Result<Model, ImportError> {
    let (json, binary) = document::chunks(file, bytes)?;
    let document: Document = serde_json::from_slice(json)
        .map_err(|error| ImportError::value(file, "JSON", error, "a glTF document is needed"))?;
    let value = |field: &str, value: &str, allowed: &str| {
        Err(ImportError::value(file, field, value, allowed))
    };
    if !document.asset.version.starts_with("2.") {
        return value("asset.version", &document.asset.version, "2.0 is known");
    }
    let unknown = |name: &&String| !KNOWN_EXTENSIONS.contains(&name.as_str());
    if let Some(name) = document.extensions_required.iter().find(unknown) {
        return value(
            "extensionsRequired",
            name,
            &format!("known are {}", KNOWN_EXTENSIONS.join(", ")),
        );
    }
    let file = File::open(file, folder, &document, binary)?;
    let mut gathered = Gathered { materials: vec![Material::default()], ..Gathered::default() };
    let mut pictures = Pictures::default();
    for index in 0..document.materials.len() {
        gathered.materials.push(material(&file, index, &mut pictures)?);
    }
    place_nodes(&file, &mut gathered)?;
    gathered.finish(file.name)
}

/// Walks the default scene and gathers its meshes.
fn place_nodes(file: &File, gathered: &mut Gathered) -> Result<(), ImportError> {
    let document = file.document;
    let scene = document.scene.unwrap_or(0);
    let scene = file.item("scene", "scenes", &document.scenes, scene)?;
    let mut visited = vec![false; document.nodes.len()];
    let mut waiting: Vec<(usize, DMat4)> =
        scene.nodes.iter().rev().map(|&node| (node, DMat4::IDENTITY)).collect();
    while let Some((index, world_from_parent)) = waiting.pop() {
        let node = file.item("node", "nodes", &document.nodes, index)?;
        if std::mem::replace(&mut visited[index], true) {
            let allowed = "a node has one parent at most, and no node is below itself";
            return Err(ImportError::value(file.name, "nodes", index, allowed));
        }
        let world_from_node = world_from_parent * node.transform();
        if let Some(index) = node.mesh {
            let mesh = file.item("mesh", "meshes", &document.meshes, index)?;
            gathered.of_node.clear();
            for primitive in &mesh.primitives {
                gathered.add(file, primitive, world_from_node)?;
            }
        }
        waiting.extend(node.children.iter().rev().map(|&child| (child, world_from_node)));
    }
    Ok(())
}

fn material(file: &File, index: usize, pictures: &mut Pictures) -> Result<Material, ImportError> {
    let document = file.document;
    let material = &document.materials[index];
    let surface = &material.pbr_metallic_roughness;
    let [r, g, b, _] = surface.base_color_factor;
    let base_color = Vec3::new(r, g, b);
    if !base_color.to_array().iter().all(|channel| (0.0..=1.0).contains(channel)) {
        let field = format!("materials[{index}].pbrMetallicRoughness.baseColorFactor");
        return Err(ImportError::value(file.name, field, base_color, "0 to 1"));
    }
    let mut texture = None;
    if let Some(used) = &surface.base_color_texture {
        let used = file.item("baseColorTexture", "textures", &document.textures, used.index)?;
        // A texture without a source has one that only an extension knows.
        let source = used.source.unwrap_or(usize::MAX);
        texture = Some(pictures.get(file, source)?);
    }
    Ok(Material { name: material.name.clone(), base_color, texture })
}

/// The images met so far. Those inside the file are held once each, and together are not larger than a
/// file may be.
#[derive(Default)]
struct Pictures {
    textures: BTreeMap<usize, Texture>,
    bytes: u64,
}

impl Pictures {
    fn get(&mut self, file: &File, index: usize) -> Result<Texture, ImportError> {
        if let Some(texture) = self.textures.get(&index) {
            return Ok(texture.clone());
        }
        let texture = picture(file, index)?;
        if let Texture::Embedded { bytes, .. } = &texture {
            self.bytes += bytes.len() as u64;
        }
        if self.bytes > MAX_FILE_BYTES {
            let allowed = format!("at most {MAX_FILE_BYTES} bytes together");
            return Err(ImportError::value(file.name, "images", self.bytes, allowed));
        }
        self.textures.insert(index, texture.clone());
        Ok(texture)
    }
}

fn picture(file: &File, index: usize) -> Result<Texture, ImportError> {
    let image = file.item("source of a texture", "images", &file.document.images, index)?;
    let bytes = match (&image.uri, image.buffer_view) {
        (Some(uri), _) if !uri.starts_with("data:") => {
            return Ok(Texture::File(file.path_of(uri)?));
        }
        (Some(uri), _) => document::decode_data(file.name, uri)?.into(),
        (None, Some(view)) => file.view(view)?.0.into(),
        (None, None) => {
            let (field, allowed) =
                (format!("images[{index}]"), "an image has a uri or a bufferView");
            return Err(ImportError::value(file.name, field, "neither", allowed));
        }
    };
    Ok(Texture::Embedded { name: format!("{}: images[{index}]", file.name), bytes })
}

/// The meshes of the nodes visited so far, as one.
#[derive(Default)]
struct Gathered {
    mesh: Mesh,
    normals: Vec<Vec3>,
    coordinates: Vec<Vec2>,
    face_materials: Vec<u32>,
    /// The first is for faces that name none.
    materials: Vec<Material>,
    /// The first of these vertices of the node at hand, and how many there are. Primitives that share them are
    /// one surface.
    of_node: BTreeMap<Vertices, (usize, usize)>,
}

/// The accessors of vertices.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Vertices {
    position: usize,
    normal: Option<usize>,
    coordinates: Option<usize>,
}

impl Gathered {
    fn add(
        &mut self,
        file: &File,
        primitive: &Primitive,
        world_from_node: DMat4,
    ) -> Result<(), ImportError> {
        let attribute = |name: &str| primitive.attributes.get(name).copied();
        let Some(position) = attribute("POSITION") else {
            let allowed = "a primitive needs positions";
            return Err(ImportError::value(file.name, "attributes", "no POSITION", allowed));
        };
        let material = match primitive.material {
            None => None,
            Some(index) => {
                Some((index, file.item("material", "materials", &file.document.materials, index)?))
            }
        };
        let set = material
            .and_then(|(_, material)| material.pbr_metallic_roughness.base_color_texture.as_ref())
            .map_or(0, |texture| texture.tex_coord);
        let coordinates = attribute(&format!("TEXCOORD_{set}"));
        let vertices = Vertices { position, normal: attribute("NORMAL"), coordinates };
        let (first, count) = match self.of_node.get(&vertices) {
            Some(&known) => known,
            None => {
                let first = self.mesh.positions.len();
                self.add_vertices(file, vertices, world_from_node)?;
                let count = self.mesh.positions.len() - first;
                self.of_node.insert(vertices, (first, count));
                (first, count)
            }
        };
        let indices: Vec<u32> = match primitive.indices {
            Some(accessor) => file.indices(accessor)?,
            None => (0..count as u32).collect(),
        };
        let triangles = triangles_of(primitive.mode, &indices).ok_or_else(|| {
            let allowed = "4, 5 and 6 are triangles, strips and fans";
            ImportError::value(file.name, "mode of a primitive", primitive.mode, allowed)
        })?;
        within_limit(file, "triangles", self.mesh.triangles.len() + triangles.len())?;

        // A mirror turns the triangles inside out.
        let is_mirrored = world_from_node.determinant() < 0.0;
        for triangle in triangles {
            if let Some(index) = triangle.iter().find(|&&index| index as usize >= count) {
                let allowed = format!("the primitive has {count} vertices");
                return Err(ImportError::value(file.name, "index of a primitive", index, allowed));
            }
            let [a, b, c] = triangle.map(|index| first as u32 + index);
            self.mesh.triangles.push(if is_mirrored { [a, c, b] } else { [a, b, c] });
        }
        let material = material.map_or(0, |(index, _)| index as u32 + 1);
        self.face_materials.resize(self.mesh.triangles.len(), material);
        Ok(())
    }

    fn add_vertices(
        &mut self,
        file: &File,
        vertices: Vertices,
        world_from_node: DMat4,
    ) -> Result<(), ImportError> {
        let first = self.mesh.positions.len();
        let positions = file.vectors::<3>("POSITION", vertices.position)?;
        let count = positions.len();
        within_limit(file, "vertices", first + count)?;
        self.mesh.positions.extend(positions.iter().map(|&position| {
            world_from_node.transform_point3(Vec3::from(position).as_dvec3()).as_vec3()
        }));

        let same_count = |field: &str, found: usize| {
            if found == count {
                return Ok(());
            }
            Err(ImportError::value(file.name, field, found, format!("there are {count} positions")))
        };
        if let Some(accessor) = vertices.normal {
            let normals = file.vectors::<3>("NORMAL", accessor)?;
            same_count("NORMAL", normals.len())?;
            // Normals stay at right angles to their surface under the inverse transpose.
            let turn = DMat3::from_mat4(world_from_node).inverse().transpose();
            self.normals.resize(first, Vec3::ZERO);
            self.normals.extend(normals.into_iter().map(|normal| {
                (turn * DVec3::from(normal.map(f64::from))).normalize_or_zero().as_vec3()
            }));
        }
        if let Some(accessor) = vertices.coordinates {
            let coordinates = file.vectors::<2>("TEXCOORD", accessor)?;
            same_count("TEXCOORD", coordinates.len())?;
            self.coordinates.resize(first, Vec2::ZERO);
            // glTF counts v from the upper edge.
            self.coordinates.extend(coordinates.into_iter().map(|[u, v]| Vec2::new(u, 1.0 - v)));
        }
        Ok(())
    }

    fn finish(mut self, file: &str) -> Result<Model, ImportError> {
        let vertices = self.mesh.positions.len();
        if !self.normals.is_empty() {
            self.normals.resize(vertices, Vec3::ZERO);
            self.mesh.normals = Some(self.normals);
        }
        if !self.coordinates.is_empty() {
            self.coordinates.resize(vertices, Vec2::ZERO);
            self.mesh.texture_coordinates = Some(self.coordinates);
        }
        self.mesh.check(file)?;
        let Self { mesh, face_materials, materials, .. } = self;
        Ok(Model { mesh, face_materials, materials })
    }
}

fn within_limit(file: &File, field: &str, total: usize) -> Result<(), ImportError> {
    if total <= MAX_ELEMENTS {
        return Ok(());
    }
    Err(ImportError::value(file.name, field, total, format!("at most {MAX_ELEMENTS}")))
}

/// The triangles that `indices` list, make a strip of, or make a fan of.
fn triangles_of(mode: u32, indices: &[u32]) -> Option<Vec<[u32; 3]>> {
    Some(match mode {
        4 => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
        5 => indices
            .windows(3)
            .enumerate()
            .map(|(i, t)| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] })
            .collect(),
        6 => super::fan(indices).collect(),
        _ => return None,
    })
}

#[cfg(test)]
pub(super) mod tests;

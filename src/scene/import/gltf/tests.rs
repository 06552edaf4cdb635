//! Tests of the glTF reader, with documents that the tests make themselves.

use super::*;
use base64::Engine;

/// A triangle in the plane z = 0, its normals, texture coordinates in bytes and indices.
fn buffer() -> Vec<u8> {
    let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let normals = [[0.0_f32, 0.0, 1.0]; 3];
    let mut bytes: Vec<u8> =
        positions.iter().chain(&normals).flatten().flat_map(|value| value.to_le_bytes()).collect();
    bytes.extend([0_u8, 0, 99, 99, 255, 0, 99, 99, 0, 51, 99, 99]);
    bytes.extend([0_u16, 1, 2, 2].iter().flat_map(|index| index.to_le_bytes()));
    bytes
}

const NODES: &str = r#"[
    { "children": [2, 1], "translation": [10, 0, 0], "scale": [2, 1, 1] },
    { "mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,-1,0, 0,0,5,1] },
    { "mesh": 0, "rotation": [0, 0.7071067811865476, 0, 0.7071067811865476] }]"#;

fn document(uri: &str) -> String {
    format!(
        r#"{{ "asset": {{ "version": "2.0" }}, "scene": 1, "scenes": [{{}}, {{ "nodes": [0] }}],
        "nodes": {NODES},
        "meshes": [{{ "primitives": [{{ "attributes": {{ "POSITION": 0, "NORMAL": 1, "TEXCOORD_1": 2 }},
            "indices": 3, "material": 0 }}] }}],
        "materials": [{{ "name": "red", "pbrMetallicRoughness": {{ "baseColorFactor": [1, 0.5, 0.25, 1],
            "baseColorTexture": {{ "index": 0, "texCoord": 1 }} }} }}],
        "textures": [{{ "source": 0 }}], "images": [{{ "uri": "the%20cow.png" }}],
        "accessors": [
            {{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }},
            {{ "bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3, "type": "VEC3" }},
            {{ "bufferView": 1, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC2" }},
            {{ "bufferView": 2, "componentType": 5123, "count": 3, "type": "SCALAR" }}],
        "bufferViews": [{{ "buffer": 0, "byteLength": 72 }},
            {{ "buffer": 0, "byteOffset": 72, "byteLength": 12, "byteStride": 4 }},
            {{ "buffer": 0, "byteOffset": 84, "byteLength": 8 }}],
        "buffers": [{{ {uri} "byteLength": 92 }}] }}"#
    )
}

/// The document with its buffer inside.
pub fn embedded() -> String {
    let data = base64::engine::general_purpose::STANDARD.encode(buffer());
    document(&format!(r#""uri": "data:application/octet-stream;base64,{data}","#))
}

/// The document as a binary file.
pub fn binary() -> Vec<u8> {
    let mut json = document("").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    let length = 12 + 8 + json.len() + 8 + buffer().len();
    bytes.extend([2, length as u32].iter().flat_map(|word| word.to_le_bytes()));
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", buffer())] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

fn parse_in(folder: &str, bytes: &[u8]) -> Result<Model, ImportError> {
    parse("a.gltf", bytes, Path::new(folder))
}

#[test]
fn nodes_place_their_meshes() {
    for bytes in [embedded().into_bytes(), binary()] {
        let model = parse_in("models", &bytes).unwrap();
        // Node 2, a quarter turn about y: x to −z; then twice as long along x, and moved by 10.
        // Node 1, mirrored in z and moved by 5, then as node 2.
        let expected = [
            [10.0, 0.0, 0.0],
            [10.0, 0.0, -1.0],
            [10.0, 1.0, 0.0],
            [10.0, 0.0, 5.0],
            [12.0, 0.0, 5.0],
            [10.0, 1.0, 5.0],
        ];
        for (found, expected) in model.mesh.positions.iter().zip(expected) {
            assert!(found.abs_diff_eq(expected.into(), 1e-6), "{found} {expected:?}");
        }
        assert_eq!(model.mesh.triangles, [[0, 1, 2], [3, 5, 4]]);
        let normals = model.mesh.normals.unwrap();
        assert!(normals[0].abs_diff_eq(Vec3::X, 1e-6) && normals[3].abs_diff_eq(-Vec3::Z, 1e-6));
        let coordinates = [Vec2::Y, Vec2::ONE, Vec2::new(0.0, 0.8)];
        assert_eq!(model.mesh.texture_coordinates.unwrap(), [coordinates, coordinates].concat());

        assert_eq!(model.face_materials, [1, 1]);
        let red = Material {
            name: "red".into(),
            base_color: Vec3::new(1.0, 0.5, 0.25),
            texture: Some(Texture::File("models/the cow.png".into())),
        };
        assert_eq!(model.materials, [Material::default(), red]);
    }
}

#[test]
fn a_buffer_and_a_picture_may_lie_beside_or_inside() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a b.bin"), buffer()).unwrap();
    let text = document(r#""uri": "a%20b.bin","#)
        .replace(r#""uri": "the%20cow.png""#, r#""bufferView": 2, "mimeType": "image/png""#);
    let model = parse("a.gltf", text.as_bytes(), folder.path()).unwrap();
    let bytes = buffer()[84..].into();
    let name = "a.gltf: images[0]".into();
    assert_eq!(model.materials[1].texture, Some(Texture::Embedded { name, bytes }));
    let message = parse_in("nowhere", text.as_bytes()).unwrap_err().to_string();
    assert!(message.starts_with("nowhere/a b.bin: cannot be read: "), "{message}");
}

#[test]
fn primitives_that_share_vertices_are_one_surface() {
    let primitive = r#"{ "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_1": 2 }"#;
    let second = format!(r#"{primitive}, "indices": 3, "material": 0 }}, {primitive} }}] }}]"#);
    let text = embedded().replacen(r#""indices": 3, "material": 0 }] }]"#, "", 1);
    let text = text.replacen(&format!("{primitive},"), &second, 1);
    let model = parse_in("", text.as_bytes()).unwrap();
    // With the picture's second set of texture coordinates or without, they differ.
    assert_eq!(model.mesh.positions.len(), 12);
    let same = text.replace(r#""texCoord": 1"#, r#""texCoord": 0"#);
    let model = parse_in("", same.as_bytes()).unwrap();
    assert_eq!(model.mesh.triangles, [[0, 1, 2], [0, 1, 2], [3, 5, 4], [3, 5, 4]]);
    assert_eq!(model.face_materials, [1, 0, 1, 0]);
}

#[test]
fn strips_and_fans_are_triangles() {
    assert_eq!(triangles_of(4, &[0, 1, 2, 3]).unwrap(), [[0, 1, 2]]);
    assert_eq!(triangles_of(5, &[0, 1, 2, 3, 4]).unwrap(), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    assert_eq!(triangles_of(6, &[5, 1, 2, 3]).unwrap(), [[5, 1, 2], [5, 2, 3]]);
    assert_eq!(triangles_of(1, &[0, 1]), None);
}

#[test]
fn errors_name_the_place() {
    let message = |from: &str, to: &str| {
        let text = embedded();
        assert!(text.contains(from), "{from}");
        parse_in("", text.replacen(from, to, 1).as_bytes()).unwrap_err().to_string()
    };
    for (found, expected) in [
        (
            message(r#""scene": 1"#, r#""extensionsRequired": ["KHR_draco_mesh_compression"]"#),
            "extensionsRequired: KHR_draco_mesh_compression: known are KHR_mesh_quantization",
        ),
        (message(r#""version": "2.0""#, r#""version": "1.0""#), "asset.version: 1.0: 2.0 is known"),
        (message(r#""scene": 1"#, r#""scene": 2"#), "scene: 2: there are 2 scenes"),
        (
            message(r#""children": [2, 1]"#, r#""children": [2, 0]"#),
            "nodes: 0: a node has one parent at most, and no node is below itself",
        ),
        (message(r#""mesh": 0"#, r#""mesh": 7"#), "mesh: 7: there are 1 meshes"),
        (message(r#""POSITION": 0"#, r#""POSITION": 4"#), "POSITION: 4: there are 4 accessors"),
        (
            message(r#""POSITION": 0"#, r#""POSITION": 2"#),
            "accessors[2].type: VEC2: POSITION needs VEC3",
        ),
        (
            message(r#""count": 3"#, r#""count": 1000000000"#),
            "accessors[0].count: 1000000000: the buffer view has 72 bytes",
        ),
        (
            message(r#""bufferView": 0, "#, ""),
            "accessors[0].bufferView: none, or sparse: plain accessors are known",
        ),
        (
            message(r#""NORMAL": 1, "#, r#""NORMAL": 1, "POSITION": 2, "#),
            "accessors[2].type: VEC2: POSITION needs VEC3",
        ),
        (
            message(r#""byteLength": 72"#, r#""byteLength": 720"#),
            "bufferViews[0]: 720 bytes from 0: there are 92",
        ),
        (
            message(r#""byteLength": 92"#, r#""byteLength": 93"#),
            "buffers[0].byteLength: 93: there are 92 bytes",
        ),
        (
            message(r#""indices": 3"#, r#""indices": 3, "mode": 1"#),
            "mode of a primitive: 1: 4, 5 and 6 are triangles, strips and fans",
        ),
        (
            message(r#""byteOffset": 84"#, r#""byteOffset": 80"#),
            "index of a primitive: 13056: the primitive has 3 vertices",
        ),
        (
            message("[1, 0.5, 0.25, 1]", "[1, 1.5, 0.25, 1]"),
            "materials[0].pbrMetallicRoughness.baseColorFactor: [1, 1.5, 0.25]: 0 to 1",
        ),
        (
            message("the%20cow.png", "http://a/b.png"),
            "uri: http://a/b.png: names of files are known",
        ),
        (message(r#""source": 0"#, ""), "source of a texture: none: there are 1 images"),
        (
            message("[10, 0, 0]", "[1e300, 0, 0]"),
            "position of vertex 0: [inf, 0, 0]: numbers from -1e9 to 1e9 are allowed",
        ),
    ] {
        assert_eq!(found, format!("a.gltf: {expected}"));
    }
}

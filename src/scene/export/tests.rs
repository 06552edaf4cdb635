//! What is written is read back.

use super::*;
use crate::mesh::Mesh;
use crate::scene::import::{self, Texture};
use glam::{Vec2, Vec3};

/// A cube whose sides have their own vertices, normals and texture coordinates, in two colours.
fn cube() -> Model {
    let mut mesh = Mesh::default();
    let (mut normals, mut coordinates) = (vec![], vec![]);
    let mut face_materials = vec![];
    for side in 0..6 {
        let (axis, sign) = (side % 3, if side < 3 { 1.0 } else { -1.0 });
        let first = mesh.positions.len() as u32;
        for [u, v] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            let mut at = [0.1_f32; 3];
            at[axis] = sign / 3.0;
            at[(axis + 1) % 3] += sign * (u - 0.5);
            at[(axis + 2) % 3] += v - 0.5;
            mesh.positions.push(at.into());
            let mut normal = [0.0; 3];
            normal[axis] = sign;
            normals.push(normal.into());
            coordinates.push(Vec2::new(u * 0.75, v));
        }
        mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k: u32| first + k)));
        face_materials.extend([side as u32 / 2; 2]);
    }
    mesh.normals = Some(normals);
    mesh.texture_coordinates = Some(coordinates);
    let red = Material {
        name: "dark red".into(),
        base_color: Vec3::new(0.7, 0.1, 1.0 / 3.0),
        texture: None,
    };
    let materials = vec![Material::default(), red.clone(), Material { name: "b".into(), ..red }];
    Model { mesh, face_materials, materials }
}

/// Every vertex is used, and they are numbered by their first use.
fn tetrahedron() -> Model {
    let mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::Y, Vec3::X, Vec3::new(0.1, 1.0 / 3.0, -1e-20)],
        triangles: vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]],
        ..Mesh::default()
    };
    Model { mesh, face_materials: vec![0; 4], materials: vec![Material::default()] }
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

/// What is read of `written` after it was written as a file called `name`, and what that left out.
fn back(folder: &Path, name: &str, written: &Model) -> (Model, Vec<String>) {
    let path = folder.join(name);
    let left_out = model(written, &path).unwrap();
    (import::model(&path).unwrap(), left_out)
}

#[test]
fn triangles_come_back_from_every_format() {
    let folder = folder();
    for name in ["a.ply", "a.obj", "a.gltf", "a.glb", "a.STL"] {
        let (found, left_out) = back(folder.path(), name, &tetrahedron());
        assert_eq!((found, left_out), (tetrahedron(), vec![]), "{name}");
    }
    let mut names: Vec<_> =
        std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["a.STL", "a.bin", "a.glb", "a.gltf", "a.obj", "a.ply"]);
}

#[test]
fn attributes_and_materials_come_back_where_they_can() {
    let folder = folder();
    let cube = cube();
    for name in ["a.obj", "b c.gltf", "a.glb"] {
        assert_eq!(back(folder.path(), name, &cube), (cube.clone(), vec![]), "{name}");
    }
    let (found, left_out) = back(folder.path(), "a.ply", &cube);
    assert_eq!((found.mesh, left_out), (cube.mesh.clone(), vec!["materials".to_string()]));
    let (found, left_out) = back(folder.path(), "a.stl", &cube);
    assert_eq!(left_out, ["normals", "texture coordinates", "materials"]);
    assert_eq!(found.mesh.triangles.len(), 12);
    let corners = |mesh: &Mesh| -> Vec<_> {
        mesh.triangles.iter().map(|&triangle| mesh.corners(triangle, 0.0)).collect()
    };
    assert_eq!(corners(&found.mesh), corners(&cube.mesh));
}

#[test]
fn seams_of_an_obj_share_their_positions() {
    let folder = folder();
    let path = folder.path().join("a.obj");
    // A square of two triangles whose texture is cut along the diagonal.
    let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y];
    let mesh = Mesh {
        positions: vec![a, b, c, a, c, d],
        texture_coordinates: Some([0.0, 0.1, 0.2, 0.3, 0.4, 0.5].map(Vec2::splat).to_vec()),
        triangles: vec![[0, 1, 2], [3, 4, 5]],
        ..Mesh::default()
    };
    let square = Model { mesh, face_materials: vec![0; 2], materials: vec![Material::default()] };
    model(&square, &path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let count = |key: &str| text.lines().filter(|line| line.starts_with(key)).count();
    assert_eq!((count("v "), count("vt "), count("f ")), (4, 6, 2));
    assert_eq!(import::model(&path).unwrap(), square);
}

#[test]
fn faces_of_one_material_come_together() {
    let folder = folder();
    let mut mixed = cube();
    mixed.face_materials = (0..12).map(|face| face % 3).collect();
    for name in ["a.obj", "a.gltf"] {
        let (found, _) = back(folder.path(), name, &mixed);
        assert_eq!(found.materials, mixed.materials);
        let corner = |model: &Model| -> Vec<_> {
            let corners = |face: usize| model.mesh.corners(model.mesh.triangles[face], 0.0);
            let mut faces: Vec<_> =
                (0..12).map(|face| (model.face_materials[face], corners(face))).collect();
            faces.sort_by_key(|(material, _)| *material);
            faces
        };
        assert_eq!(corner(&found), corner(&mixed), "{name}");
    }
}

/// A picture of one colour as a file.
fn png(value: u8) -> Vec<u8> {
    let picture = ::image::RgbImage::from_pixel(2, 2, [value; 3].into());
    let mut bytes = std::io::Cursor::new(vec![]);
    picture.write_to(&mut bytes, ::image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

#[test]
fn pictures_are_referred_to_or_come_along() {
    let folder = folder();
    let (inside, outside) = (folder.path().join("out"), folder.path().join("in"));
    std::fs::create_dir_all(inside.join("maps")).unwrap();
    std::fs::create_dir(&outside).unwrap();
    std::fs::write(inside.join("maps/the cow.png"), png(1)).unwrap();
    std::fs::write(outside.join("b.png"), png(2)).unwrap();
    let mut textured = cube();
    let textures = [
        Texture::File(inside.join("maps/the cow.png")),
        Texture::File(outside.join("b.png")),
        Texture::Embedded { name: "c".into(), bytes: png(3).into() },
        Texture::File(outside.join("b.png")),
        Texture::File(outside.join("missing.png")),
    ];
    textured.materials = vec![Material::default()];
    for (texture, name) in textures.into_iter().zip(["a", "b", "c", "d", "e"]) {
        let texture = Some(texture);
        textured.materials.push(Material { name: name.into(), texture, ..Material::default() });
    }
    for (name, first_is_file) in [("a.obj", true), ("a.gltf", true), ("a.glb", false)] {
        let (found, left_out) = back(&inside, name, &textured);
        let [reason] = &left_out[..] else { panic!("{left_out:?}") };
        assert!(reason.starts_with("a picture (") && reason.contains("missing.png: "), "{reason}");
        let texels = |place: usize| {
            let texture = found.materials[place].texture.as_ref().unwrap();
            import::image::texture(texture).unwrap().texels[0].x
        };
        assert!(texels(1) < texels(2) && texels(2) < texels(3) && texels(2) == texels(4), "{name}");
        assert_eq!(found.materials[5].texture, None);
        let picture = Texture::File(inside.join("maps/the cow.png"));
        assert_eq!(found.materials[1].texture == Some(picture), first_is_file);
    }
    // Elsewhere they need nothing that is not there.
    let moved = folder.path().join("moved");
    std::fs::rename(&inside, &moved).unwrap();
    std::fs::remove_dir_all(&outside).unwrap();
    for name in ["a.obj", "a.gltf", "a.glb"] {
        for material in import::model(&moved.join(name)).unwrap().materials {
            material.texture.map(|texture| import::image::texture(&texture).unwrap());
        }
    }
}

#[test]
fn names_that_a_line_cannot_end_with_are_changed() {
    let mut model = cube();
    let names = ["a\nKd 0 0 0", "", "", "a", "a "];
    model.materials =
        names.map(|name| Material { name: name.into(), ..Material::default() }).into();
    let (found, _) = back(folder().path(), "a.obj", &model);
    let names: Vec<&str> = found.materials[1..].iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["a Kd 0 0 0", "material", "material-2", "a", "a-2"]);
}

#[test]
fn errors_name_the_file_and_leave_nothing() {
    let folder = folder();
    let write = |name: &str, change: &dyn Fn(&mut Model)| {
        let mut cube = cube();
        change(&mut cube);
        model(&cube, &folder.path().join(name)).unwrap_err().to_string()
    };
    let none: &dyn Fn(&mut Model) = &|_| {};
    for (found, expected) in [
        (write("a.off", none), "a.off: ending: off: models are written as .ply, .obj, .gltf, .glb"),
        (write("a", none), "a: ending: none: models are written"),
        (write("no/a.ply", none), "no: an existing folder is needed"),
        (write("a.ply", &|m| m.mesh.triangles.clear()), "a.ply: triangles: 0: 1 to"),
        (
            write("a.ply", &|m| m.face_materials.clear()),
            "a.ply: materials of faces: 0: one for each of 12",
        ),
        (
            write("a.obj", &|m| m.face_materials[3] = 3),
            "a.obj: materials of faces: 3: one for each of 12",
        ),
    ] {
        assert!(found.contains(expected), "{found}");
    }
    std::fs::create_dir(folder.path().join("a.ply")).unwrap();
    assert!(write("a.ply", none).starts_with("cannot be written: "), "{}", write("a.ply", none));
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
}

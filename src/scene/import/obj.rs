//! Meshes from Wavefront OBJ files, with the diffuse colours and textures of their MTL files.
//!
//! Read are v, vt, vn, f, usemtl and mtllib; newmtl, Kd and map_Kd. Corners that agree in all three of
//! their indices become one vertex. A material library that is not there leaves its materials white,
//! because OBJ files are often passed on without.

use super::{ImportError, Material, Model, Texture, fan, read};
use crate::mesh::Mesh;
use glam::{Vec2, Vec3};
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

/// The model in `bytes`, the content of `file`, which lies in `folder`.
///
/// # Errors
/// A line cannot be understood, a material library cannot be read, or there is no mesh that can be used.
pub fn parse(file: &str, bytes: &[u8], folder: &Path) -> Result<Model, ImportError> {
    let materials = vec![Material::default()];
    let mut reader = Reader { file, materials, ..Reader::default() };
    for line in lines(file, bytes) {
        match line.key() {
            "v" => reader.positions.push(Vec3::from(line.numbers(&[3, 4, 6, 7])?)),
            "vn" => reader.normals.push(Vec3::from(line.numbers(&[3])?)),
            "vt" => {
                let [u, v, _] = line.numbers(&[1, 2, 3])?;
                reader.coordinates.push(Vec2::new(u, v));
            }
            "f" => reader.face(&line)?,
            "usemtl" => reader.material = reader.material_named(line.rest()),
            "mtllib" => reader.library(folder, line.rest())?,
            _ => {}
        }
    }
    reader.finish()
}

#[derive(Default)]
struct Reader<'a> {
    file: &'a str,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    coordinates: Vec<Vec2>,
    /// Indices of position, texture coordinates and normal.
    corners: Vec<[Option<u32>; 3]>,
    vertices: HashMap<[Option<u32>; 3], u32>,
    triangles: Vec<[u32; 3]>,
    face_materials: Vec<u32>,
    materials: Vec<Material>,
    /// The material of the next face. The first is for faces before any `usemtl`.
    material: u32,
    names: HashMap<String, u32>,
}

impl Reader<'_> {
    fn face(&mut self, line: &Line) -> Result<(), ImportError> {
        let lengths = [self.positions.len(), self.coordinates.len(), self.normals.len()];
        let mut polygon = vec![];
        for word in line.rest().split_ascii_whitespace() {
            let mut corner = [None; 3];
            for (slot, (part, length)) in word.split('/').zip(lengths).enumerate() {
                if part.is_empty() && slot > 0 {
                    continue;
                }
                let index = part.parse::<i64>().ok().and_then(|index| match index {
                    1.. => usize::try_from(index - 1).ok(),
                    // From the end.
                    _ => length.checked_sub(usize::try_from(index.checked_neg()?).ok()?),
                });
                let Some(index) = index.filter(|&index| index < length) else {
                    let kind = ["v", "vt", "vn"][slot];
                    return Err(
                        line.wrong(word, &format!("{length} {kind} are above, counted from 1"))
                    );
                };
                corner[slot] = Some(index as u32);
            }
            if word.split('/').count() > 3 {
                return Err(line.wrong(word, "a corner is v, v/vt, v//vn or v/vt/vn"));
            }
            let corners = &mut self.corners;
            polygon.push(*self.vertices.entry(corner).or_insert_with(|| {
                corners.push(corner);
                corners.len() as u32 - 1
            }));
        }
        if polygon.len() < 3 {
            return Err(line.wrong(line.rest(), "a face has 3 corners or more"));
        }
        self.triangles.extend(fan(&polygon));
        self.face_materials.resize(self.triangles.len(), self.material);
        Ok(())
    }

    fn material_named(&mut self, name: &str) -> u32 {
        let next = self.materials.len() as u32;
        let index = *self.names.entry(name.into()).or_insert(next);
        if index == next {
            self.materials.push(Material { name: name.into(), ..Material::default() });
        }
        index
    }

    /// Reads the materials in file `name` of `folder`.
    fn library(&mut self, folder: &Path, name: &str) -> Result<(), ImportError> {
        let path = folder.join(name.replace('\\', "/"));
        let bytes = match read(&path) {
            Err(ImportError::Unreadable { source, .. })
                if source.kind() == std::io::ErrorKind::NotFound =>
            {
                return Ok(());
            }
            bytes => bytes?,
        };
        self.materials_of(&path.display().to_string(), &bytes, path.parent().unwrap_or(folder))
    }

    fn materials_of(&mut self, file: &str, bytes: &[u8], folder: &Path) -> Result<(), ImportError> {
        let mut material = None;
        for line in lines(file, bytes) {
            let key = line.key();
            if key == "newmtl" {
                material = Some(self.material_named(line.rest()));
            } else if ["Kd", "map_Kd"].contains(&key) {
                let Some(material) = material else {
                    return Err(line.wrong(&line.text, "newmtl comes first"));
                };
                let material = &mut self.materials[material as usize];
                if key == "Kd" {
                    let [r, g, b] = line.numbers(&[1, 3])?;
                    let is_grey = line.rest().split_ascii_whitespace().count() == 1;
                    material.base_color = if is_grey { Vec3::splat(r) } else { Vec3::new(r, g, b) };
                    if !(material.base_color.is_finite()
                        && material.base_color.min_element() >= 0.0)
                    {
                        return Err(line.wrong(line.rest(), "reflectances are not negative"));
                    }
                } else {
                    let name = without_options(line.rest()).replace('\\', "/");
                    material.texture = Some(Texture::File(folder.join(name)));
                }
            }
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Model, ImportError> {
        let of = |slot: usize| self.corners.iter().map(move |corner| corner[slot]);
        let has = |slot: usize| of(slot).any(|index| index.is_some());
        let mesh = Mesh {
            positions: of(0).flatten().map(|index| self.positions[index as usize]).collect(),
            end_positions: None,
            normals: has(2).then(|| gather(of(2), &self.normals)),
            texture_coordinates: has(1).then(|| gather(of(1), &self.coordinates)),
            triangles: std::mem::take(&mut self.triangles),
        };
        mesh.check(self.file)?;
        Ok(Model { mesh, face_materials: self.face_materials, materials: self.materials })
    }
}

/// The values at `indices`, zero where there is none.
fn gather<T: Copy + Default>(indices: impl Iterator<Item = Option<u32>>, values: &[T]) -> Vec<T> {
    indices.map(|index| index.map_or(T::default(), |index| values[index as usize])).collect()
}

/// The file's name behind options such as `-s 2 2 1` and `-clamp on`. It may contain spaces.
fn without_options(text: &str) -> &str {
    let mut rest = text;
    while rest.starts_with('-') {
        let Some((_, behind)) = rest.split_once(char::is_whitespace) else { break };
        rest = behind.trim_start();
        while let Some((word, behind)) = rest.split_once(char::is_whitespace) {
            if word.parse::<f32>().is_err() && !["on", "off"].contains(&word) {
                break;
            }
            rest = behind.trim_start();
        }
    }
    rest
}

struct Line<'a> {
    file: &'a str,
    number: usize,
    text: Cow<'a, str>,
}

fn lines<'a>(file: &'a str, bytes: &'a [u8]) -> impl Iterator<Item = Line<'a>> {
    bytes.split(|&byte| byte == b'\n').zip(1..).map(move |(line, number)| Line {
        file,
        number,
        text: String::from_utf8_lossy(line.trim_ascii()),
    })
}

impl Line<'_> {
    fn key(&self) -> &str {
        self.text.split_ascii_whitespace().next().unwrap_or_default()
    }

    /// What follows the key.
    fn rest(&self) -> &str {
        self.text[self.key().len()..].trim_start()
    }

    /// The first three numbers of the line, 0 for those that are not there; `counts` are allowed.
    fn numbers(&self, counts: &[usize]) -> Result<[f32; 3], ImportError> {
        let mut numbers = [0.0; 3];
        let mut count = 0;
        for word in self.rest().split_ascii_whitespace() {
            let Ok(number) = word.parse() else {
                return Err(self.wrong(word, "numbers are needed"));
            };
            if let Some(slot) = numbers.get_mut(count) {
                *slot = number;
            }
            count += 1;
        }
        if !counts.contains(&count) {
            let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
            let allowed = format!("{} numbers are needed", counts.join(" or "));
            return Err(self.wrong(&self.text, &allowed));
        }
        Ok(numbers)
    }

    fn wrong(&self, value: &str, allowed: &str) -> ImportError {
        ImportError::value(
            self.file,
            format!("line {}: {}", self.number, self.key()),
            value,
            allowed,
        )
    }
}

/// Reads `bytes` as a material library.
#[cfg(test)]
pub(super) fn parse_materials(file: &str, bytes: &[u8]) -> Result<(), ImportError> {
    let mut reader = Reader { materials: vec![Material::default()], ..Reader::default() };
    reader.materials_of(file, bytes, Path::new("/nowhere"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_text(text: &str) -> Result<Model, ImportError> {
        parse("a.obj", text.as_bytes(), Path::new("nowhere"))
    }

    #[test]
    fn corners_with_the_same_indices_are_one_vertex() {
        let model = parse_text(
            "# caf\u{e9}\no thing\nv 0 0 0\nv 1 0 0 1\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0\n\
             vt 0 0\nvt 1 0.5 0\nvt 0.25\nvn 0 0 2\n\
             f 1/1/1 2/2/1 3/3/1 4/1/1\nf -4/-3 -3/2/1 3//-1\n",
        )
        .unwrap();
        let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        let (n, o) = (Vec3::Z * 2.0, Vec3::ZERO);
        let [s, t, u] = [Vec2::ZERO, Vec2::new(1.0, 0.5), Vec2::new(0.25, 0.0)];
        let expected = Mesh {
            positions: vec![a, b, c, d, a, c],
            end_positions: None,
            normals: Some(vec![n, n, n, n, o, n]),
            texture_coordinates: Some(vec![s, t, u, s, s, Vec2::ZERO]),
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 1, 5]],
        };
        assert_eq!(model.mesh, expected);
        assert_eq!(
            (model.face_materials, model.materials),
            (vec![0; 3], vec![Material::default()])
        );
    }

    #[test]
    fn materials_come_from_the_library_beside_the_file() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("mtl")).unwrap();
        let library = "newmtl skin\nNs 10\nKd 0.5 0.25 1\nmap_Kd -s 2 2 -clamp on maps\\the cow.png\r\n\
                       newmtl grey\nKd 0.5\n";
        std::fs::write(folder.path().join("mtl/a.mtl"), library).unwrap();
        let text = "mtllib mtl/a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl grey\nf 1 3 2\n\
                    usemtl skin\nf 2 1 3\nusemtl none\nf 1 2 3\nusemtl grey\nf 1 2 3\n";
        let model = parse("a.obj", text.as_bytes(), folder.path()).unwrap();
        let of_face = |face: usize| &model.materials[model.face_materials[face] as usize];
        let picture = folder.path().join("mtl/maps/the cow.png");
        let skin = Material {
            name: "skin".into(),
            base_color: Vec3::new(0.5, 0.25, 1.0),
            texture: Some(Texture::File(picture)),
        };
        let grey =
            Material { name: "grey".into(), base_color: Vec3::splat(0.5), ..Material::default() };
        assert_eq!(*of_face(0), Material::default());
        assert_eq!((of_face(1), of_face(2), of_face(4)), (&grey, &skin, &grey));
        assert_eq!(*of_face(3), Material { name: "none".into(), ..Material::default() });

        std::fs::write(folder.path().join("mtl/a.mtl"), "newmtl a\nKd -1 0 0\n").unwrap();
        let message = parse("a.obj", text.as_bytes(), folder.path()).unwrap_err().to_string();
        assert!(
            message.ends_with("a.mtl: line 2: Kd: -1 0 0: reflectances are not negative"),
            "{message}"
        );
    }

    #[test]
    fn errors_name_the_line() {
        for (text, expected) in [
            ("v 0 0", "line 1: v: v 0 0: 3 or 4 or 6 or 7 numbers are needed"),
            ("\nv 0 0 z", "line 2: v: z: numbers are needed"),
            ("v 0 0 0\nf 1 1", "line 2: f: 1 1: a face has 3 corners or more"),
            ("v 0 0 0\nf 1 1 0", "line 2: f: 0: 1 v are above, counted from 1"),
            ("v 0 0 0\nf 1 1 -2", "line 2: f: -2: 1 v are above, counted from 1"),
            ("v 0 0 0\nf 1 1 1/1", "line 2: f: 1/1: 0 vt are above, counted from 1"),
            ("v 0 0 0\nf 1 1 1/////", "line 2: f: 1/////: a corner is v, v/vt, v//vn or v/vt/vn"),
            ("v 0 0 0\n", "vertices: 0: 1 to 67108864 are allowed"),
            (
                "v 0 0 nan\nf 1 1 1",
                "position of vertex 0: [0, 0, NaN]: numbers from -1e9 to 1e9 are allowed",
            ),
        ] {
            assert_eq!(parse_text(text).unwrap_err().to_string(), format!("a.obj: {expected}"));
        }
    }
}

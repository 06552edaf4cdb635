//! Meshes from PLY files, as text or binary in either byte order.
//!
//! Read are the element `vertex` (x, y, z; nx, ny, nz; u, v or s, t or texture_u, texture_v) and the
//! lists `vertex_indices` or `vertex_index` of the element `face`; everything else is passed over.

use super::{ImportError, Model, fan};
use crate::mesh::{MAX_ELEMENTS, Mesh};
use glam::{Vec2, Vec3};

/// The model in `bytes`, the content of `file`.
///
/// # Errors
/// The bytes are no PLY file, end too soon, or describe no mesh that can be used.
pub fn parse(file: &str, bytes: &[u8]) -> Result<Model, ImportError> {
    let mut body = Body { file, encoding: Encoding::Text, rest: bytes };
    let elements = header(&mut body)?;
    let mut mesh = Mesh::default();
    for element in &elements {
        match element.name.as_str() {
            "vertex" => vertices(&mut body, element, &mut mesh)?,
            "face" => faces(&mut body, element, &mut mesh.triangles)?,
            _ if element.properties.is_empty() => {}
            _ => {
                for index in 0..element.count {
                    for property in &element.properties {
                        body.values(property, element, index, |_| {})?;
                    }
                }
            }
        }
    }
    mesh.check(file)?;
    Ok(Model::plain(mesh))
}

fn vertices(body: &mut Body, element: &Element, mesh: &mut Mesh) -> Result<(), ImportError> {
    let find = |names: &[&str]| {
        element
            .properties
            .iter()
            .position(|p| p.count.is_none() && names.contains(&p.name.as_str()))
    };
    let all = |names: &[&[&str]]| names.iter().map(|names| find(names)).collect::<Option<Vec<_>>>();
    let Some(position) = all(&[&["x"], &["y"], &["z"]]) else {
        let known: Vec<&str> = element.properties.iter().map(|p| p.name.as_str()).collect();
        let allowed = "a vertex needs the numbers x, y and z";
        return Err(ImportError::value(body.file, "element vertex", known.join(", "), allowed));
    };
    let normal = all(&[&["nx"], &["ny"], &["nz"]]);
    let texture = all(&[&["u", "s", "texture_u"], &["v", "t", "texture_v"]]);
    let (mut normals, mut coordinates) = (vec![], vec![]);
    let mut row = vec![0.0; element.properties.len()];
    for index in 0..element.count {
        for (slot, property) in row.iter_mut().zip(&element.properties) {
            body.values(property, element, index, |value| *slot = value as f32)?;
        }
        mesh.positions.push(Vec3::new(row[position[0]], row[position[1]], row[position[2]]));
        if let Some(at) = &normal {
            normals.push(Vec3::new(row[at[0]], row[at[1]], row[at[2]]));
        }
        if let Some(at) = &texture {
            coordinates.push(Vec2::new(row[at[0]], row[at[1]]));
        }
    }
    mesh.normals = normal.map(|_| normals);
    mesh.texture_coordinates = texture.map(|_| coordinates);
    Ok(())
}

fn faces(
    body: &mut Body,
    element: &Element,
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), ImportError> {
    let is_indices = |property: &Property| {
        property.count.is_some() && ["vertex_indices", "vertex_index"].contains(&&*property.name)
    };
    if !element.properties.iter().any(is_indices) {
        let known: Vec<&str> = element.properties.iter().map(|p| p.name.as_str()).collect();
        let allowed = "a face needs the list vertex_indices or vertex_index";
        return Err(ImportError::value(body.file, "element face", known.join(", "), allowed));
    }
    let mut corners = vec![];
    for index in 0..element.count {
        for property in &element.properties {
            if !is_indices(property) {
                body.values(property, element, index, |_| {})?;
                continue;
            }
            corners.clear();
            let mut odd = None;
            body.values(property, element, index, |value| {
                if value.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&value) {
                    odd = Some(value);
                }
                corners.push(value as u32);
            })?;
            let field = || format!("face {index}: {}", property.name);
            if let Some(value) = odd {
                let allowed = "indices of vertices count from 0";
                return Err(ImportError::value(body.file, field(), value, allowed));
            }
            if corners.len() < 3 {
                let found = format!("{} corners", corners.len());
                return Err(ImportError::value(body.file, field(), found, "3 or more are needed"));
            }
            triangles.extend(fan(&corners));
        }
    }
    Ok(())
}

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

struct Property {
    name: String,
    /// The type of a list's length.
    count: Option<Number>,
    value: Number,
}

#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Copy)]
enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number in the first bytes of `word`, lowest first.
    fn decode(self, word: [u8; 8]) -> f64 {
        let [a, b, c, d, ..] = word;
        match self {
            Self::I8 => i8::from_le_bytes([a]).into(),
            Self::U8 => a.into(),
            Self::I16 => i16::from_le_bytes([a, b]).into(),
            Self::U16 => u16::from_le_bytes([a, b]).into(),
            Self::I32 => i32::from_le_bytes([a, b, c, d]).into(),
            Self::U32 => u32::from_le_bytes([a, b, c, d]).into(),
            Self::F32 => f32::from_le_bytes([a, b, c, d]).into(),
            Self::F64 => f64::from_le_bytes(word),
        }
    }
}

/// Reads the header; `body` begins behind it afterwards.
fn header(body: &mut Body) -> Result<Vec<Element>, ImportError> {
    let file = body.file;
    let mut elements: Vec<Element> = vec![];
    let mut encoding = None;
    for number in 1.. {
        let Some(end) = body.rest.iter().position(|&byte| byte == b'\n') else {
            let allowed = "a header begins with ply and ends with end_header";
            return Err(ImportError::value(file, "header", "the end of the file", allowed));
        };
        let line = String::from_utf8_lossy(&body.rest[..end]);
        body.rest = &body.rest[end + 1..];
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let wrong = |allowed: &str| {
            Err(ImportError::value(file, format!("line {number}"), line.trim(), allowed))
        };
        if number == 1 && words[..] != ["ply"] {
            return wrong("a PLY file begins with the line ply");
        }
        match words[..] {
            ["ply"] if number == 1 => {}
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, "1.0"] => {
                encoding = Some(match name {
                    "ascii" => Encoding::Text,
                    "binary_little_endian" => Encoding::LittleEndian,
                    "binary_big_endian" => Encoding::BigEndian,
                    _ => {
                        return wrong("formats are ascii, binary_little_endian, binary_big_endian");
                    }
                });
            }
            ["element", name, count] => {
                let Some(count) = count.parse().ok().filter(|&n: &u64| n <= MAX_ELEMENTS as u64)
                else {
                    return wrong(&format!(
                        "an element has a name and a count up to {MAX_ELEMENTS}"
                    ));
                };
                if elements.iter().any(|element| element.name == name) {
                    return wrong("an element is declared once");
                }
                elements.push(Element { name: name.into(), count, properties: vec![] });
            }
            ["property", ref types @ .., name] => {
                let (count, value) = match types {
                    [value] => (None, Number::named(value)),
                    ["list", count, value] => (Number::named(count), Number::named(value)),
                    _ => (None, None),
                };
                let (Some(value), Some(element), true) =
                    (value, elements.last_mut(), types.len() == 1 || count.is_some())
                else {
                    return wrong("a property follows its element and has a type and a name");
                };
                element.properties.push(Property { name: name.into(), count, value });
            }
            ["end_header"] => break,
            _ => return wrong("known are format, element, property, comment, end_header"),
        }
    }
    let Some(encoding) = encoding else {
        return Err(ImportError::value(file, "format", "none", "a header names the format"));
    };
    body.encoding = encoding;
    Ok(elements)
}

/// What has not been read yet.
struct Body<'a> {
    file: &'a str,
    encoding: Encoding,
    rest: &'a [u8],
}

impl Body<'_> {
    /// Passes the value or the values of `property` to `take`.
    fn values(
        &mut self,
        property: &Property,
        element: &Element,
        index: u64,
        mut take: impl FnMut(f64),
    ) -> Result<(), ImportError> {
        let (file, encoding, rest) = (self.file, self.encoding, &mut self.rest);
        let wrong = |value: String| {
            let field = format!("{} {index}: {}", element.name, property.name);
            ImportError::value(file, field, value, "numbers, and a count before a list, are needed")
        };
        let mut next = |number| number_at(encoding, number, rest).map_err(wrong);
        let count = property.count.map_or(Ok(1.0), &mut next)?;
        if count < 0.0 || count.fract() != 0.0 {
            return Err(wrong(count.to_string()));
        }
        for _ in 0..count as u64 {
            take(next(property.value)?);
        }
        Ok(())
    }
}

/// The number at the beginning of `rest`, which it is taken from; else what is there.
fn number_at(encoding: Encoding, number: Number, rest: &mut &[u8]) -> Result<f64, String> {
    let end_of_file = || "the end of the file".to_string();
    if encoding == Encoding::Text {
        let start = rest.trim_ascii_start();
        let end = start.iter().position(u8::is_ascii_whitespace).unwrap_or(start.len());
        *rest = &start[end..];
        let word = String::from_utf8_lossy(&start[..end]);
        return match word.parse() {
            Ok(value) => Ok(value),
            Err(_) if word.is_empty() => Err(end_of_file()),
            Err(_) => Err(word.into_owned()),
        };
    }
    let mut word = [0; 8];
    let (bytes, behind) = rest.split_at_checked(number.size()).ok_or_else(end_of_file)?;
    word[..bytes.len()].copy_from_slice(bytes);
    if encoding == Encoding::BigEndian {
        word[..bytes.len()].reverse();
    }
    *rest = behind;
    Ok(number.decode(word))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A square with normals and texture coordinates, amid things to pass over.
    pub const TEXT: &str = "ply\r
format ascii 1.0
comment made by hand
element camera 1
property float view_x
element vertex 4
property float x
property double y
property float z
property list uchar int tags
property float nx
property float ny
property float nz
property float s
property float t
element face 1
property uchar flag
property list uchar int vertex_indices
end_header
9
0 0 -1.5e0  2 7 8  0 0 1  0 0
1 0 -1.5    0      0 0 1  1 0
1 1 -1.5    0      0 0 1  1 1
0 1 -1.5    1 3    0 0 1  0 1
200 4 0 1 2 3
";

    /// The same as [`TEXT`] in binary, without the camera.
    pub fn binary(is_big: bool) -> Vec<u8> {
        let start = TEXT.find("element vertex").unwrap();
        let end = TEXT.find("9\n0 0 -1.5e0").unwrap();
        let name = if is_big { "big" } else { "little" };
        let mut bytes = format!("ply\nformat binary_{name}_endian 1.0\n").into_bytes();
        bytes.extend(TEXT[start..end].bytes());
        let mut number = |value: f64, size: usize| {
            let mut word = match size {
                8 => value.to_le_bytes().to_vec(),
                4 => (value as f32).to_le_bytes().to_vec(),
                0 => (value as i32).to_le_bytes().to_vec(),
                _ => vec![value as u8],
            };
            if is_big {
                word.reverse();
            }
            bytes.extend(word);
        };
        for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            for (value, size) in [(x, 4), (y, 8), (-1.5, 4), (1.0, 1), (-7.0, 0)] {
                number(value, size);
            }
            for value in [0.0, 0.0, 1.0, x, y] {
                number(value, 4);
            }
        }
        for (value, size) in [(200.0, 1), (4.0, 1), (0.0, 0), (1.0, 0), (2.0, 0), (3.0, 0)] {
            number(value, size);
        }
        bytes
    }

    #[test]
    fn the_three_encodings_hold_the_same_square() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let expected = Mesh {
            positions: square.map(|[x, y]| Vec3::new(x, y, -1.5)).to_vec(),
            end_positions: None,
            normals: Some(vec![Vec3::Z; 4]),
            texture_coordinates: Some(square.map(Vec2::from).to_vec()),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        for bytes in [TEXT.as_bytes().to_vec(), binary(false), binary(true)] {
            let model = parse("square.ply", &bytes).unwrap();
            assert_eq!(model.mesh, expected);
            assert_eq!((model.face_materials, model.materials.len()), (vec![0, 0], 1));
        }
    }

    #[test]
    fn errors_name_the_place() {
        let message = |from: &str, to: &str| {
            assert!(TEXT.contains(from));
            parse("a.ply", TEXT.replacen(from, to, 1).as_bytes()).unwrap_err().to_string()
        };
        for (found, expected) in [
            (message("ply", "plyx"), "line 1: plyx: a PLY file begins with the line ply"),
            (
                message("vertex 4", "vertex 1000000000"),
                "line 6: element vertex 1000000000: an element has a name and a count up to 67108864",
            ),
            (
                message("property double y", "property double h"),
                "element vertex: x, h, z, tags, nx, ny, nz, s, t: a vertex needs the numbers x, y and z",
            ),
            (
                message("200 4 0 1 2 3", "200 4 0 1 2"),
                "face 0: vertex_indices: the end of the file: numbers, and a count before a list, are \
                 needed",
            ),
            (
                message("200 4 0 1 2 3", "200 3 0 1 -2"),
                "face 0: vertex_indices: -2: indices of vertices count from 0",
            ),
            (
                message("200 4 0 1 2 3", "200 2 0 1"),
                "face 0: vertex_indices: 2 corners: 3 or more are needed",
            ),
            (
                message("200 4 0 1 2 3", "200 3 0 1 4"),
                "triangle 0: vertex 4: vertices 0 to 3 are allowed",
            ),
            (
                message("1 0 -1.5 ", "1 O -1.5 "),
                "vertex 1: y: O: numbers, and a count before a list, are needed",
            ),
        ] {
            assert_eq!(found, format!("a.ply: {expected}"));
        }
    }

    #[test]
    fn a_billion_elements_of_nothing_take_no_time() {
        let junk = "element camera 60000000\nelement junk 60000000\n";
        let text = TEXT.replacen("element camera 1\nproperty float view_x\n", junk, 1);
        assert_eq!(
            parse("a.ply", text.replacen("\n9\n", "\n", 1).as_bytes())
                .unwrap()
                .mesh
                .positions
                .len(),
            4
        );
    }
}

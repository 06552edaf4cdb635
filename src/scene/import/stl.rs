//! Meshes from STL files, as text or binary.
//!
//! STL lists the corners of every triangle, so corners at one point become one vertex. Normals, which are those
//! of the faces, colours and names are passed over; several solids are one mesh.

use super::{ImportError, Model};
use crate::mesh::{Mesh, weld::weld};
use glam::Vec3;

/// Comments, and the number of triangles.
const HEADER_BYTES: usize = 84;
/// Normal, corners, and two bytes that some programs put a colour into.
const TRIANGLE_BYTES: usize = 50;

/// The model in `bytes`, the content of `file`.
///
/// # Errors
/// The bytes are no STL file, end too soon, or describe no mesh that can be used.
pub fn parse(file: &str, bytes: &[u8]) -> Result<Model, ImportError> {
    // Binary files, too, may begin with `solid`; but letters where they have their number of triangles would be a
    // number too large for any file.
    let start = bytes.trim_ascii_start();
    let is_text = start.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
        && binary_end(bytes).is_none_or(|end| end > bytes.len() as u64);
    let corners = if is_text { text(file, bytes) } else { binary(file, bytes) }?;
    let (positions, vertices) = weld(&corners);
    let triangles = vertices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    let mesh = Mesh { positions, triangles, ..Mesh::default() };
    mesh.check(file)?;
    Ok(Model::plain(mesh))
}

/// Where a binary file ends, by its number of triangles.
fn binary_end(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER_BYTES - 4..HEADER_BYTES)?.try_into().ok()?;
    Some(HEADER_BYTES as u64 + u64::from(u32::from_le_bytes(count)) * TRIANGLE_BYTES as u64)
}

/// What follows the last triangle is passed over.
fn binary(file: &str, bytes: &[u8]) -> Result<Vec<Vec3>, ImportError> {
    let length = bytes.len() as u64;
    let Some(end) = binary_end(bytes).filter(|&end| end <= length) else {
        let allowed = match binary_end(bytes) {
            Some(end) => format!("its number of triangles needs {end}"),
            None => format!("a text begins with solid, other files with {HEADER_BYTES} bytes"),
        };
        return Err(ImportError::value(file, "bytes", length, allowed));
    };
    let triangles = bytes[HEADER_BYTES..end as usize].chunks_exact(TRIANGLE_BYTES);
    let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let corner = |b: &[u8]| Vec3::new(number(b), number(&b[4..]), number(&b[8..]));
    Ok(triangles.flat_map(|t| t[12..48].chunks_exact(12)).map(corner).collect())
}

fn text(file: &str, bytes: &[u8]) -> Result<Vec<Vec3>, ImportError> {
    let mut corners: Vec<Vec3> = vec![];
    // How many corners are read when the present facet ends.
    let mut facet_end = None;
    let mut is_open = false;
    for (line, number) in bytes.split(|&byte| byte == b'\n').zip(1..) {
        let line = String::from_utf8_lossy(line.trim_ascii());
        let wrong =
            |allowed: &str| Err(ImportError::value(file, format!("line {number}"), &line, allowed));
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let key = words.first().unwrap_or(&"").to_ascii_lowercase();
        match (key.as_str(), facet_end) {
            ("", _) => {}
            ("solid", None) if !is_open => is_open = true,
            ("endsolid", None) if is_open => is_open = false,
            ("facet", None) if is_open => facet_end = Some(corners.len() + 3),
            ("outer" | "endloop", Some(_)) => {}
            ("endfacet", Some(end)) if corners.len() == end => facet_end = None,
            ("endfacet", Some(_)) => return wrong("a facet has three corners"),
            ("vertex", Some(end)) if corners.len() < end => {
                let numbers: Option<Vec<f32>> =
                    words[1..].iter().map(|word| word.parse().ok()).collect();
                let Some([x, y, z]) = numbers.as_deref() else {
                    return wrong("a corner has three numbers");
                };
                corners.push(Vec3::new(*x, *y, *z));
            }
            _ => {
                return wrong(
                    "in this order: solid, facet, outer loop, vertex three times, endloop, endfacet, \
                     endsolid",
                );
            }
        }
    }
    if is_open {
        let allowed = "a solid ends with endsolid";
        return Err(ImportError::value(file, "solid", "the end of the file", allowed));
    }
    Ok(corners)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Two triangles of a square.
    pub const TEXT: &str = "solid a square\r
  facet normal 0 0 1
    outer loop
      vertex 0 0 -1.5e0
      vertex 1 0 -1.5
      vertex 1 1 -1.5
    endloop
  endfacet
  FACET NORMAL 0 0 1
    OUTER LOOP
      VERTEX 0 0 -1.5
      VERTEX 1 1 -1.5
      VERTEX -0 1 -1.5
    ENDLOOP
  ENDFACET
endsolid a square
";

    /// The same as [`TEXT`] in binary. Its comment begins as a text does.
    pub fn binary() -> Vec<u8> {
        let mut bytes = b"solid".to_vec();
        bytes.resize(80, b' ');
        bytes.extend(2_u32.to_le_bytes());
        for corners in [[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [[0.0, 0.0], [1.0, 1.0], [-0.0, 1.0]]]
        {
            bytes.extend([0_u8; 12]);
            for [x, y] in corners {
                bytes.extend([x, y, -1.5_f32].iter().flat_map(|number| number.to_le_bytes()));
            }
            bytes.extend([0x1f, 0x80]);
        }
        bytes
    }

    #[test]
    fn corners_at_one_point_are_one_vertex() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let expected = Mesh {
            positions: square.map(|[x, y]| Vec3::new(x, y, -1.5)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        let named = [b"liquid", &binary()[6..], b"left over"].concat();
        for bytes in [TEXT.as_bytes().to_vec(), binary(), named] {
            let model = parse("square.stl", &bytes).unwrap();
            assert_eq!(model.mesh, expected);
            assert_eq!((model.face_materials, model.materials.len()), (vec![0, 0], 1));
        }
        let twice = parse("square.stl", TEXT.repeat(2).as_bytes()).unwrap();
        assert_eq!((twice.mesh.positions.len(), twice.mesh.triangles.len()), (4, 4));
    }

    #[test]
    fn errors_name_the_place() {
        let message = |from: &str, to: &str| {
            assert!(TEXT.contains(from));
            parse("a.stl", TEXT.replacen(from, to, 1).as_bytes()).unwrap_err().to_string()
        };
        let order = "in this order: solid, facet, outer loop, vertex three times, endloop, endfacet, \
                     endsolid";
        for (found, expected) in [
            (
                message("1 0 -1.5", "1 O -1.5"),
                "line 5: vertex 1 O -1.5: a corner has three numbers".into(),
            ),
            (message("1 0 -1.5", "1 0"), "line 5: vertex 1 0: a corner has three numbers".into()),
            (
                message("      vertex 1 0 -1.5\n", ""),
                "line 7: endfacet: a facet has three corners".into(),
            ),
            (message("endloop", "vertex 0 0 0"), format!("line 7: vertex 0 0 0: {order}")),
            (message("  facet normal 0 0 1\n", ""), format!("line 2: outer loop: {order}")),
            (message("  endfacet\n", ""), format!("line 8: FACET NORMAL 0 0 1: {order}")),
            (
                message("endsolid a square\n", ""),
                "solid: the end of the file: a solid ends with endsolid".into(),
            ),
        ] {
            assert_eq!(found, format!("a.stl: {expected}"));
        }
        let message = |bytes: &[u8]| parse("a.stl", bytes).unwrap_err().to_string();
        let short = [b"x", &binary()[1..183]].concat();
        assert_eq!(message(&short), "a.stl: bytes: 183: its number of triangles needs 184");
        assert_eq!(
            message(b""),
            "a.stl: bytes: 0: a text begins with solid, other files with 84 bytes"
        );
        assert_eq!(message(b"solid\nendsolid"), "a.stl: vertices: 0: 1 to 67108864 are allowed");
        let mut infinite = binary();
        infinite[96..100].copy_from_slice(&f32::INFINITY.to_le_bytes());
        let expected = "position of vertex 0: [inf, 0, -1.5]: numbers from -1e9 to 1e9 are allowed";
        assert_eq!(message(&infinite), format!("a.stl: {expected}"));
    }
}

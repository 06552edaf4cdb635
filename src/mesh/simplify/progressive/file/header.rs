//! The header of a file, and reading numbers.

use super::FileError;
use super::columns::{Wrong, checksum};
use crate::mesh::MAX_ELEMENTS;
use crate::mesh::simplify::progressive::{Layout, ProgressiveMesh};
use std::io::{ErrorKind, Read};

const MAGIC: [u8; 8] = *b"\x89SLPM\r\n\x1a";
const VERSION: u32 = 1;

/// Most multiples of the speed.
const MAX_SPEEDS: u32 = 1 << 16;

impl ProgressiveMesh {
    /// The header of a file.
    pub(super) fn header(&self) -> Vec<u8> {
        let Layout { has_end, has_normal, has_texture, is_flat } = self.layout;
        let layout = [has_end, has_normal, has_texture, is_flat];
        let layout = layout.into_iter().rev().fold(0, |bits, has| 2 * bits + u32::from(has));
        let counts = [self.splits.len(), self.speeds.len()].map(|count| count as u32);
        let [vertices, faces] = self.input;
        let base = [self.base_vertices() as u32, self.base_faces, self.base_error.to_bits()];
        let mut bytes = MAGIC.to_vec();
        let numbers = [VERSION, layout, vertices, faces].into_iter().chain(base).chain(counts);
        let speeds = self.speeds.iter().flat_map(|&(speed, splits)| [speed.to_bits(), splits]);
        bytes.extend(numbers.chain(speeds).flat_map(u32::to_le_bytes));
        bytes.extend(checksum(&bytes).to_le_bytes());
        bytes
    }
}

/// An empty mesh, the vertices of the coarsest mesh, and the number of splits.
pub fn read(file: &str, from: &mut impl Read) -> Result<(ProgressiveMesh, u32, usize), FileError> {
    let refuse = |field: &str, value: &dyn ToString, allowed: String| {
        Err(error(file, field, Wrong::new("", value.to_string(), allowed)))
    };
    let mut bytes = next_bytes::<12>(file, "header", from)?.to_vec();
    if bytes[..8] != MAGIC {
        let allowed = "such a file begins with \\x89SLPM\\r\\n\\x1a";
        return refuse("header", &bytes[..8].escape_ascii(), allowed.into());
    }
    let [version] = numbers(&bytes[8..]);
    if version != VERSION {
        return refuse("version", &version, format!("{VERSION} is known"));
    }
    bytes.extend(next_bytes::<32>(file, "header", from)?);
    let [layout, vertices, faces, base_vertices, base_faces, error_bits, splits, speeds] =
        numbers(&bytes[12..]);
    let base_error = f32::from_bits(error_bits);
    let most = MAX_ELEMENTS as u32;
    for (field, value, range) in [
        ("layout", layout, 0..=15),
        ("vertices", vertices, 1..=most),
        ("faces", faces, 1..=most),
        ("vertices of the coarsest mesh", base_vertices, 1..=vertices),
        ("faces of the coarsest mesh", base_faces, 1..=faces),
        ("speeds", speeds, 0..=MAX_SPEEDS),
    ] {
        if !range.contains(&value) {
            let allowed = format!("{} to {} are allowed", range.start(), range.end());
            return refuse(field, &value, allowed);
        }
    }
    if !(base_error.is_finite() && base_error.is_sign_positive()) {
        return refuse("error", &base_error, "finite numbers from 0 are allowed".into());
    }
    let mut list = vec![];
    for _ in 0..speeds {
        let pair = next_bytes::<8>(file, "speeds", from)?;
        bytes.extend(pair);
        let [speed, splits] = numbers(&pair);
        let speed = f32::from_bits(speed);
        let last = list.last().map_or(0.0, |&(last, _)| last);
        if !(speed.is_finite() && speed > last) {
            let allowed = "growing numbers above 0 are allowed";
            return refuse("speeds", &speed, allowed.into());
        }
        list.push((speed, splits));
    }
    let [sum] = numbers(&next_bytes::<4>(file, "header", from)?);
    check_sum(&bytes, sum).map_err(|wrong| error(file, "header: CRC-32", wrong))?;
    let [has_end, has_normal, has_texture, is_flat] = [1, 2, 4, 8].map(|bit| layout & bit != 0);
    let mesh = ProgressiveMesh {
        layout: Layout { has_end, has_normal, has_texture, is_flat },
        input: [vertices, faces],
        base_faces,
        base_error,
        values: vec![],
        triangles: vec![],
        vertex_ids: vec![],
        face_ids: vec![],
        splits: vec![],
        vertex_splits: vec![],
        split_values: vec![],
        corners: vec![],
        done: 0,
        speeds: list,
    };
    Ok((mesh, base_vertices, splits as usize))
}

/// An error in `field`.
pub fn error(file: &str, field: impl Into<String>, wrong: Wrong) -> FileError {
    let Wrong { value, allowed, .. } = wrong;
    FileError::Value { file: file.into(), field: field.into(), value, allowed }
}

/// An error of the system; the end of the file is one of the file.
pub fn unreadable(file: &str, field: &str, source: std::io::Error) -> FileError {
    match source.kind() {
        ErrorKind::UnexpectedEof => {
            error(file, field, Wrong::new("", "the end of the file", "more bytes are needed"))
        }
        _ => FileError::Unreadable { file: file.into(), source },
    }
}

/// The next bytes.
pub fn next_bytes<const N: usize>(
    file: &str,
    field: &str,
    from: &mut impl Read,
) -> Result<[u8; N], FileError> {
    let mut bytes = [0; N];
    let read = from.read_exact(&mut bytes);
    read.map(|()| bytes).map_err(|source| unreadable(file, field, source))
}

/// The numbers in four bytes each.
pub fn numbers<const N: usize>(bytes: &[u8]) -> [u32; N] {
    let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |all, &byte| all << 8 | u32::from(byte));
    std::array::from_fn(|at| number(&bytes[4 * at..4 * at + 4]))
}

/// Refuses bytes with another checksum than is said.
pub fn check_sum(bytes: &[u8], said: u32) -> Result<(), Wrong> {
    match checksum(bytes) {
        found if found == said => Ok(()),
        found => {
            Err(Wrong::new("CRC-32", format!("{found:08x}"), format!("the file says {said:08x}")))
        }
    }
}

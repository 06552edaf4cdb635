//! Blocks of a file: columns of numbers, each compressed by itself, under one checksum.

use flate2::bufread::DeflateDecoder;
use flate2::write::DeflateEncoder;
use flate2::{Compression, Crc};
use std::io::{self, Read, Write};
use std::ops::Range;

pub const VERTEX_SPLITS: usize = 0;
pub const FACES: usize = 1;
pub const ERRORS: usize = 2;
pub const OLD: usize = 3;
pub const VERTEX_IDS: usize = 4;
pub const CORNERS: usize = 5;
pub const TRIANGLES: usize = 6;
pub const FACE_IDS: usize = 7;
/// One column for each byte of a number.
pub const OLD_VALUES: Range<usize> = 8..12;
pub const NEW_VALUES: Range<usize> = 12..16;
pub const COUNT: usize = 16;

const NAMES: [&str; COUNT] = [
    "vertices of a split",
    "faces of a split",
    "error",
    "vertex that is split",
    "vertex of the input",
    "corners",
    "vertex of a face",
    "face of the input",
    "number of the vertex that is split",
    "number of the vertex that is split",
    "number of the vertex that is split",
    "number of the vertex that is split",
    "number of a vertex",
    "number of a vertex",
    "number of a vertex",
    "number of a vertex",
];

/// A block is compressed to no less than one part in so many, so that few bytes never stand for many.
const MOST_RATIO: usize = 8;

/// What is wrong in a block: field, value and what was allowed.
#[derive(Debug)]
pub struct Wrong {
    pub field: &'static str,
    pub value: String,
    pub allowed: String,
}

impl Wrong {
    pub fn new(field: &'static str, value: impl ToString, allowed: impl Into<String>) -> Self {
        Self { field, value: value.to_string(), allowed: allowed.into() }
    }
}

/// A column of numbers.
#[derive(Debug)]
pub struct Column {
    name: &'static str,
    pub(super) bytes: Vec<u8>,
    /// Where the next number is read.
    at: usize,
}

impl Column {
    /// All columns of a block, empty.
    pub fn all() -> [Self; COUNT] {
        NAMES.map(|name| Self { name, bytes: vec![], at: 0 })
    }

    /// How many bytes there are.
    pub fn len(&self) -> usize {
        self.bytes.len()
    }

    /// Whether all has been read.
    pub fn is_read(&self) -> bool {
        self.at == self.bytes.len()
    }

    pub fn put(&mut self, number: u32) {
        self.put_long(number.into());
    }

    fn put_long(&mut self, mut number: u64) {
        while number > 127 {
            self.bytes.push(number as u8 | 128);
            number >>= 7;
        }
        self.bytes.push(number as u8);
    }

    /// An id beside that of a neighbour.
    pub fn put_difference(&mut self, id: u32, neighbour: u32) {
        let difference = i64::from(id) - i64::from(neighbour);
        self.put_long((difference << 1 ^ difference >> 63) as u64);
    }

    pub fn put_bits(&mut self, bits: &[bool]) {
        let byte =
            |bits: &[bool]| bits.iter().rev().fold(0, |byte, &bit| byte << 1 | u8::from(bit));
        self.bytes.extend(bits.chunks(8).map(byte));
    }

    fn byte(&mut self) -> Result<u8, Wrong> {
        let byte = self.bytes.get(self.at).copied();
        self.at += 1;
        byte.ok_or_else(|| Wrong::new(self.name, "the end of the block", "a number is needed"))
    }

    fn long(&mut self) -> Result<u64, Wrong> {
        let mut number = 0;
        for shift in (0..).step_by(7) {
            let byte = self.byte()?;
            if shift > 28 {
                return Err(Wrong::new(self.name, "a number of six bytes", "five are allowed"));
            }
            number |= u64::from(byte & 127) << shift;
            if byte < 128 {
                break;
            }
        }
        Ok(number)
    }

    /// A number from 0 up to `most`.
    pub fn get(&mut self, most: u32) -> Result<u32, Wrong> {
        let number = self.long()?;
        match u32::try_from(number) {
            Ok(number) if number <= most => Ok(number),
            _ => Err(Wrong::new(self.name, number, format!("0 to {most} are allowed"))),
        }
    }

    /// An id below `count`, beside that of a neighbour.
    pub fn get_difference(&mut self, neighbour: u32, count: u32) -> Result<u32, Wrong> {
        let number = self.long()?;
        let difference = (number >> 1) as i64 ^ -((number & 1) as i64);
        let id = i64::from(neighbour) + difference;
        match u32::try_from(id) {
            Ok(id) if id < count => Ok(id),
            _ => Err(Wrong::new(self.name, id, format!("less than {count} and not less than 0"))),
        }
    }

    pub fn get_bits(&mut self, count: usize) -> Result<Vec<bool>, Wrong> {
        let mut bits = vec![];
        let mut byte = 0;
        for bit in 0..count {
            if bit % 8 == 0 {
                byte = self.byte()?;
            }
            bits.push(byte >> (bit % 8) & 1 == 1);
        }
        Ok(bits)
    }
}

/// An integer for each number, in the same order.
fn ordered(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// Puts the difference of `value` to the one that is expected.
pub fn put_value(columns: &mut [Column], expected: f32, value: f32) {
    let difference = ordered(value).wrapping_sub(ordered(expected)) as i32;
    let bytes = ((difference << 1 ^ difference >> 31) as u32).to_le_bytes();
    columns.iter_mut().zip(bytes).for_each(|(column, byte)| column.bytes.push(byte));
}

/// The value whose difference to the one that is expected comes next; not beyond ±`most`.
pub fn get_value(columns: &mut [Column], expected: f32, most: f32) -> Result<f32, Wrong> {
    let mut bytes = [0; 4];
    for (column, byte) in columns.iter_mut().zip(&mut bytes) {
        *byte = column.byte()?;
    }
    let number = u32::from_le_bytes(bytes);
    let difference = number >> 1 ^ (number & 1).wrapping_neg();
    let bits = ordered(expected).wrapping_add(difference);
    let value = f32::from_bits(if bits >> 31 == 1 { bits & !(1 << 31) } else { !bits });
    if value.abs() <= most {
        return Ok(value);
    }
    Err(Wrong::new(columns[0].name, value, format!("-{most:e} to {most:e} are allowed")))
}

/// The CRC-32 of bytes.
pub fn checksum(bytes: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(bytes);
    crc.sum()
}

/// A block of columns.
pub fn block(columns: &[Column; COUNT]) -> io::Result<Vec<u8>> {
    let whole: usize = columns.iter().map(Column::len).sum();
    let mut bytes = vec![];
    for level in [Compression::best(), Compression::none()] {
        bytes = vec![0; 8 * COUNT];
        for (number, column) in columns.iter().enumerate() {
            let start = bytes.len();
            let mut encoder = DeflateEncoder::new(&mut bytes, level);
            encoder.write_all(&column.bytes)?;
            encoder.finish()?;
            let lengths = [length(column.len())?, length(bytes.len() - start)?];
            bytes[8 * number..8 * number + 8]
                .copy_from_slice(bytemuck::bytes_of(&lengths.map(u32::to_le)));
        }
        if whole <= MOST_RATIO * bytes.len() {
            break;
        }
    }
    let head = [length(bytes.len())?, checksum(&bytes)].map(u32::to_le_bytes);
    Ok([head.as_flattened(), &bytes].concat())
}

/// A length as files have it.
fn length(bytes: usize) -> io::Result<u32> {
    u32::try_from(bytes)
        .map_err(|_| io::Error::other(format!("a split of {bytes} bytes is too large for a file")))
}

/// The columns in what follows the head of a block.
pub fn columns(bytes: &[u8]) -> Result<[Column; COUNT], Wrong> {
    let mut columns = Column::all();
    let Some((lengths, mut rest)) = bytes.split_at_checked(8 * COUNT) else {
        return Err(Wrong::new("bytes", bytes.len(), format!("{} or more are needed", 8 * COUNT)));
    };
    let lengths: Vec<usize> = lengths
        .chunks_exact(4)
        .map(|bytes| bytes.iter().rev().fold(0, |number, &byte| number << 8 | usize::from(byte)))
        .collect();
    let length: usize = lengths.iter().step_by(2).sum();
    let most = MOST_RATIO * bytes.len();
    if length > most {
        return Err(Wrong::new("uncompressed bytes", length, format!("up to {most} are allowed")));
    }
    for (column, lengths) in columns.iter_mut().zip(lengths.chunks_exact(2)) {
        let Some((own, behind)) = rest.split_at_checked(lengths[1]) else {
            let allowed = format!("only {} are left in the block", rest.len());
            return Err(Wrong::new("compressed bytes", lengths[1], allowed));
        };
        rest = behind;
        let read = DeflateDecoder::new(own).take(lengths[0] as u64).read_to_end(&mut column.bytes);
        if read.ok() != Some(lengths[0]) {
            let found = format!("{} bytes", column.len());
            return Err(Wrong::new(column.name, found, format!("{} are needed", lengths[0])));
        }
    }
    Ok(columns)
}

/// Refuses columns that have more than was asked for.
pub fn check_read(columns: &[Column; COUNT]) -> Result<(), Wrong> {
    match columns.iter().find(|column| !column.is_read()) {
        None => Ok(()),
        Some(Column { name, bytes, at }) => {
            let allowed = format!("{at} are needed");
            Err(Wrong::new(name, format!("{} bytes", bytes.len()), allowed))
        }
    }
}

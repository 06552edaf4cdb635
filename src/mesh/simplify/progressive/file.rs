//! Files of progressive meshes, which are read from coarse to fine: a reader that needs no more than some level
//! of detail reads no more than what leads there.
//!
//! ```text
//! header   89 "SLPM" 0d 0a 1a; version 1; layout (1: end, 2: normal, 4: texture); vertices and faces of the
//!          input; vertices and faces of the coarsest mesh, and its error; splits; speeds, and for each its
//!          multiple and its splits; CRC-32 of all this
//! block    bytes that follow the next number; their CRC-32; for each column the number of its bytes and of
//!          those they are compressed to (deflate); the columns
//! ```
//! All numbers are little endian, of 32 bits. The first block holds the coarsest mesh, the others some thousand
//! splits each. The numbers in a column have seven bits in a byte, and the eighth says that there are more:
//! ids are differences to ids of neighbours, corners one bit for each at the vertex that is split, and the
//! vertices of faces places in a list of those nearby. Floating-point numbers are differences, as integers in
//! the same order, to those of the vertex that is split, one column for each of their four bytes.

mod columns;
mod front;
mod header;
mod reader;
#[cfg(test)]
mod tests;

pub use reader::Reader;

use super::{ProgressiveMesh, VertexSplit};
use columns::{Column, block, put_value};
use front::Front;
use std::io::Write;

/// Splits of a block.
const SPLITS: usize = 4096;

/// A block of splits ends early when it has so many bytes.
const BLOCK_BYTES: usize = 1 << 20;

/// A file could not be read. Each message names the file, the field, the value and what was allowed.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The system could not read it.
    #[error("{file}: cannot be read: {source}")]
    Unreadable {
        /// The file.
        file: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// Something in it cannot be.
    #[error("{file}: {field}: {value}: {allowed}")]
    Value {
        /// The file.
        file: String,
        /// Which part of it.
        field: String,
        /// What was found.
        value: String,
        /// What was allowed.
        allowed: String,
    },
}

impl ProgressiveMesh {
    /// Writes all levels of detail, whichever the mesh is at.
    ///
    /// # Errors
    /// `to` cannot be written to.
    pub fn write(&self, mut to: impl Write) -> std::io::Result<()> {
        let mut mesh = self.clone();
        mesh.go_to(0);
        to.write_all(&mesh.header())?;
        let mut front = Front::default();
        to.write_all(&block(&mesh.base_block(&mut front))?)?;
        while mesh.done < mesh.splits.len() {
            let mut columns = Column::all();
            for _ in 0..SPLITS.min(mesh.splits.len() - mesh.done) {
                mesh.write_split(&mut front, &mut columns);
                if columns.iter().map(Column::len).sum::<usize>() > BLOCK_BYTES {
                    break;
                }
            }
            to.write_all(&block(&columns)?)?;
        }
        to.flush()
    }

    fn base_block(&self, front: &mut Front) -> [Column; columns::COUNT] {
        let stride = self.layout.stride();
        let mut columns = Column::all();
        let mut last = 0;
        for (row, &id) in self.values.chunks(stride).zip(&self.vertex_ids[..self.base_vertices()]) {
            columns[columns::VERTEX_IDS].put_difference(id, last);
            last = id;
            let before = front.vertices().checked_sub(1);
            for (number, &value) in row.iter().enumerate() {
                let expected = before.map_or(0.0, |before| self.values[before * stride + number]);
                put_value(&mut columns[columns::NEW_VALUES], expected, value);
            }
            front.add_vertex();
        }
        let (mut last, mut last_vertex) = (0, 0);
        for face in 0..self.base_faces {
            let id = self.face_ids[face as usize];
            columns[columns::FACE_IDS].put_difference(id, last);
            last = id;
            let triangle = self.triangles[face as usize];
            for vertex in triangle {
                columns[columns::TRIANGLES].put_difference(vertex, last_vertex);
                last_vertex = vertex;
            }
            front.add_face(triangle);
        }
        columns
    }

    /// Does the next split, and writes it.
    fn write_split(&mut self, front: &mut Front, columns: &mut [Column; columns::COUNT]) {
        let stride = self.layout.stride();
        let error = self.error();
        let splits = self.vertex_splits_after(self.done)..self.vertex_splits_after(self.done + 1);
        let faces = self.faces_after(self.done)..self.faces_after(self.done + 1);
        columns[columns::VERTEX_SPLITS].put(splits.len() as u32);
        columns[columns::FACES].put(faces.len() as u32);
        let mut last_pairs = vec![];
        for index in splits {
            let VertexSplit { old, corners } = self.vertex_splits[index];
            let first = index.checked_sub(1).map_or(0, |at| self.vertex_splits[at].corners);
            let corners = &self.corners[first as usize..corners as usize];
            let new = front.vertices();
            columns[columns::OLD].put(old);
            columns[columns::VERTEX_IDS]
                .put_difference(self.vertex_ids[new], self.vertex_ids[old as usize]);
            let goes: Vec<bool> =
                front.fan(old).iter().map(|corner| corners.binary_search(corner).is_ok()).collect();
            columns[columns::CORNERS].put_bits(&goes);
            for number in 0..stride {
                let before = self.values[old as usize * stride + number];
                let after = self.split_values[index * stride + number];
                put_value(&mut columns[columns::OLD_VALUES], before, after);
                let expected = front::mirrored(before, after);
                let value = self.values[new * stride + number];
                put_value(&mut columns[columns::NEW_VALUES], expected, value);
            }
            front.split(old, &goes);
            self.exchange(index, new as u32);
            last_pairs.push((new as u32, old));
        }
        let nearby = front.nearby(&last_pairs, &self.triangles);
        for face in faces {
            let triangle = self.triangles[face];
            let mut expected = face - 1;
            let mut farthest = 0;
            for vertex in triangle {
                match nearby.iter().position(|&(near, _)| near == vertex) {
                    Some(place) => {
                        columns[columns::TRIANGLES].put(place as u32);
                        if place >= farthest {
                            (farthest, expected) = (place, nearby[place].1 as usize);
                        }
                    }
                    None => {
                        columns[columns::TRIANGLES].put(nearby.len() as u32);
                        columns[columns::TRIANGLES].put(vertex);
                    }
                }
            }
            columns[columns::FACE_IDS].put_difference(self.face_ids[face], self.face_ids[expected]);
            front.add_face(triangle);
        }
        self.done += 1;
        let after = self.error();
        columns[columns::ERRORS].put(error.to_bits() - after.to_bits());
    }
}

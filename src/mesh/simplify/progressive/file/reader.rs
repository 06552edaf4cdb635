//! Reads files of progressive meshes, as far as asked.

use super::FileError;
use super::columns::{self, Column, Wrong, columns, get_value};
use super::front::{Front, mirrored};
use super::header::{self, check_sum, error, next_bytes, numbers, unreadable};
use crate::mesh::MAX_COORDINATE;
use crate::mesh::simplify::progressive::{ProgressiveMesh, Split, VertexSplit};
use rayon::prelude::*;
use std::io::{ErrorKind, Read};

/// Corners that splits move, at most, for each vertex and face of the input. Records have some six, and the logarithm
/// of the number at a vertex where there are many.
const CORNERS_PER_ELEMENT: usize = 64;

/// A progressive mesh of which more is read when a finer level is asked for.
///
/// ```
/// # use shutterlab::mesh::{Mesh, simplify::{Options, progressive::{record, file::Reader}}};
/// # let positions = (0..81).map(|i| glam::vec3((i % 9) as f32, (i / 9) as f32, 0.0)).collect();
/// # let squares = (0..64).map(|i| i % 8 + 9 * (i / 8));
/// # let triangles = squares.flat_map(|i| [[i, i + 1, i + 10], [i, i + 10, i + 9]]).collect();
/// # let input = Mesh { positions, triangles, ..Mesh::default() };
/// # let progressive = record(&input, None, &Options::default(), &[])?;
/// let mut file = vec![];
/// progressive.write(&mut file)?;
///
/// let mut reader = Reader::open("grid", &file[..])?;
/// reader.set_faces(20)?;
/// assert!(reader.mesh().face_count() <= 20);
/// assert_eq!(reader.read_all()?, progressive);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Reader<R> {
    file: String,
    from: R,
    mesh: ProgressiveMesh,
    front: Front,
    /// How many splits the file has.
    splits: usize,
    /// How many blocks have been read.
    blocks: usize,
    /// Whether a block could not be read, nor anything behind it.
    is_broken: bool,
}

impl<R: Read> Reader<R> {
    /// Reads the coarsest mesh; `file` is what errors call the file.
    ///
    /// # Errors
    /// It is not such a file, or damaged.
    pub fn open(file: &str, mut from: R) -> Result<Self, FileError> {
        let (mesh, base_vertices, splits) = header::read(file, &mut from)?;
        let (file, front) = (file.into(), Front::default());
        let mut reader = Self { file, from, mesh, front, splits, blocks: 0, is_broken: false };
        let columns = reader.block()?;
        reader.base(columns, base_vertices).map_err(|wrong| reader.wrong(wrong))?;
        reader.check_whole()?;
        reader.blocks += 1;
        Ok(reader)
    }

    /// The mesh as far as it has been read.
    pub fn mesh(&self) -> &ProgressiveMesh {
        &self.mesh
    }

    /// As [`ProgressiveMesh::set_faces`]; reads on if it has to.
    ///
    /// # Errors
    /// The file is damaged. The mesh is as fine as what could be read of it.
    pub fn set_faces(&mut self, faces: usize) -> Result<(), FileError> {
        self.read_while(|mesh| mesh.triangles.len() <= faces)?;
        self.mesh.set_faces(faces);
        Ok(())
    }

    /// As [`ProgressiveMesh::set_error`]; reads on if it has to.
    ///
    /// # Errors
    /// The file is damaged. The mesh is as fine as what could be read of it.
    pub fn set_error(&mut self, error: f32) -> Result<(), FileError> {
        self.read_while(|mesh| mesh.error_after(mesh.splits.len()) > error)?;
        self.mesh.set_error(error);
        Ok(())
    }

    /// As [`ProgressiveMesh::set_speed`]; reads on if it has to.
    ///
    /// # Errors
    /// The file is damaged. The mesh is as fine as what could be read of it.
    pub fn set_speed(&mut self, speed: f32) -> Result<(), FileError> {
        self.read_while(|mesh| mesh.splits.len() < mesh.splits_for_speed(speed))?;
        self.mesh.set_speed(speed);
        Ok(())
    }

    /// Reads all that is left. The mesh is at its coarsest.
    ///
    /// # Errors
    /// The file is damaged.
    pub fn read_all(mut self) -> Result<ProgressiveMesh, FileError> {
        self.read_while(|_| true)?;
        self.mesh.go_to(0);
        Ok(self.mesh)
    }

    fn read_while(&mut self, wanted: impl Fn(&ProgressiveMesh) -> bool) -> Result<(), FileError> {
        let is_left = |reader: &Self| reader.is_broken || reader.mesh.splits.len() < reader.splits;
        while is_left(self) && wanted(&self.mesh) {
            if self.is_broken {
                let allowed = "a damaged file is not read further";
                return Err(self.wrong(Wrong::new("the block before", "damaged", allowed)));
            }
            self.is_broken = true;
            let columns = self.block()?;
            self.mesh.go_to(usize::MAX);
            if let Err(wrong) = self.splits(columns) {
                self.mesh.drop_unfinished();
                return Err(self.wrong(wrong));
            }
            self.check_whole()?;
            self.blocks += 1;
            self.is_broken = false;
        }
        Ok(())
    }

    /// The next block.
    fn block(&mut self) -> Result<[Column; columns::COUNT], FileError> {
        let field = format!("block {}", self.blocks);
        let head = next_bytes::<8>(&self.file, &field, &mut self.from)?;
        let [length, checksum] = numbers(&head);
        let mut bytes = vec![];
        let rest = self.from.by_ref().take(length.into()).read_to_end(&mut bytes);
        rest.map_err(|source| unreadable(&self.file, &field, source))?;
        if bytes.len() < length as usize {
            return Err(unreadable(&self.file, &field, ErrorKind::UnexpectedEof.into()));
        }
        let columns = check_sum(&bytes, checksum).and_then(|()| columns(&bytes));
        columns.map_err(|wrong| self.wrong(wrong))
    }

    /// An error in the block that is being read.
    fn wrong(&self, wrong: Wrong) -> FileError {
        error(&self.file, format!("block {}: {}", self.blocks, wrong.field), wrong)
    }

    /// The coarsest mesh.
    fn base(
        &mut self,
        mut columns: [Column; columns::COUNT],
        base_vertices: u32,
    ) -> Result<(), Wrong> {
        let (mesh, front) = (&mut self.mesh, &mut self.front);
        let [vertices, faces] = mesh.input;
        let mut row = vec![0.0; mesh.layout.stride()];
        for _ in 0..base_vertices {
            let last = mesh.vertex_ids.last().copied().unwrap_or_default();
            mesh.vertex_ids.push(columns[columns::VERTEX_IDS].get_difference(last, vertices)?);
            for value in &mut row {
                *value = get_value(&mut columns[columns::NEW_VALUES], *value, MAX_COORDINATE)?;
            }
            mesh.values.extend(&row);
            front.add_vertex();
        }
        let mut vertex = 0;
        for _ in 0..mesh.base_faces {
            let last = mesh.face_ids.last().copied().unwrap_or_default();
            mesh.face_ids.push(columns[columns::FACE_IDS].get_difference(last, faces)?);
            let mut triangle = [0; 3];
            for corner in &mut triangle {
                vertex = columns[columns::TRIANGLES].get_difference(vertex, base_vertices)?;
                *corner = vertex;
            }
            mesh.triangles.push(triangle);
            front.add_face(triangle);
        }
        columns::check_read(&columns)
    }

    /// The splits of a block; the mesh is at its finest.
    fn splits(&mut self, mut columns: [Column; columns::COUNT]) -> Result<(), Wrong> {
        let before = self.mesh.splits.len();
        while self.mesh.splits.len() < self.splits && !columns[columns::VERTEX_SPLITS].is_read() {
            self.split(&mut columns)?;
        }
        if self.mesh.splits.len() == before {
            return Err(Wrong::new("splits", 0, "1 or more are needed"));
        }
        columns::check_read(&columns)
    }

    fn split(&mut self, columns: &mut [Column; columns::COUNT]) -> Result<(), Wrong> {
        let (mesh, front) = (&mut self.mesh, &mut self.front);
        let stride = mesh.layout.stride();
        let [vertices, faces] = mesh.input;
        let vertices_left = vertices - mesh.vertex_ids.len() as u32;
        let faces_left = faces - mesh.face_ids.len() as u32;
        let vertex_splits = columns[columns::VERTEX_SPLITS].get(vertices_left)?;
        let new_faces = columns[columns::FACES].get(faces_left)?;
        let mut pairs = vec![];
        for _ in 0..vertex_splits {
            let new = front.vertices() as u32;
            let old = columns[columns::OLD].get(new - 1)?;
            let id = mesh.vertex_ids[old as usize];
            let id = columns[columns::VERTEX_IDS].get_difference(id, vertices)?;
            let goes = columns[columns::CORNERS].get_bits(front.fan(old).len())?;
            let (mut old_row, mut new_row) = (vec![], vec![]);
            for &before in &mesh.values[old as usize * stride..][..stride] {
                let most = MAX_COORDINATE;
                let after = get_value(&mut columns[columns::OLD_VALUES], before, most)?;
                let expected = mirrored(before, after);
                old_row.push(after);
                new_row.push(get_value(&mut columns[columns::NEW_VALUES], expected, most)?);
            }
            let start = mesh.corners.len();
            let most = CORNERS_PER_ELEMENT * (vertices as usize + faces as usize);
            if start + goes.len() > most.min(u32::MAX as usize) {
                let allowed = format!("up to {most} are allowed for so many vertices and faces");
                return Err(Wrong::new("corners", start + goes.len(), allowed));
            }
            let fan = front.fan(old).iter().zip(&goes);
            mesh.corners.extend(fan.filter(|(_, goes)| **goes).map(|(corner, _)| corner));
            mesh.corners[start..].sort_unstable();
            mesh.vertex_ids.push(id);
            mesh.values.extend(new_row);
            mesh.split_values.extend(old_row);
            mesh.vertex_splits.push(VertexSplit { old, corners: mesh.corners.len() as u32 });
            mesh.exchange(mesh.vertex_splits.len() - 1, new);
            front.split(old, &goes);
            pairs.push((new, old));
        }
        let nearby = front.nearby(&pairs, &mesh.triangles);
        for _ in 0..new_faces {
            let mut expected = mesh.face_ids.len() - 1;
            let mut farthest = 0;
            let mut triangle = [0; 3];
            for vertex in &mut triangle {
                let place = columns[columns::TRIANGLES].get(nearby.len() as u32)?;
                *vertex = match nearby.get(place as usize) {
                    Some(&(near, face)) => {
                        if place >= farthest {
                            (farthest, expected) = (place, face as usize);
                        }
                        near
                    }
                    None => columns[columns::TRIANGLES].get(front.vertices() as u32 - 1)?,
                };
            }
            let id = mesh.face_ids[expected];
            mesh.face_ids.push(columns[columns::FACE_IDS].get_difference(id, faces)?);
            mesh.triangles.push(triangle);
            front.add_face(triangle);
        }
        let error = mesh.error().to_bits();
        let error = f32::from_bits(error - columns[columns::ERRORS].get(error)?);
        let (vertices, faces) = (mesh.vertex_splits.len() as u32, mesh.triangles.len() as u32);
        mesh.splits.push(Split { vertices, faces, error });
        mesh.done += 1;
        Ok(())
    }

    /// Refuses ids that are there twice, once all splits have been read.
    fn check_whole(&mut self) -> Result<(), FileError> {
        if self.mesh.splits.len() < self.splits {
            return Ok(());
        }
        let ids = [&self.mesh.vertex_ids, &self.mesh.face_ids];
        for (field, ids) in ["vertex of the input", "face of the input"].into_iter().zip(ids) {
            let mut ids = ids.clone();
            ids.par_sort_unstable();
            if let Some(pair) = ids.windows(2).find(|pair| pair[0] == pair[1]) {
                return Err(error(&self.file, field, Wrong::new("", pair[0], "once is allowed")));
            }
        }
        Ok(())
    }
}

impl ProgressiveMesh {
    /// Leaves out what came of a split that could not be read to its end; all splits are done.
    fn drop_unfinished(&mut self) {
        let (vertex_splits, faces) =
            (self.vertex_splits_after(self.done), self.faces_after(self.done));
        for index in (vertex_splits..self.vertex_splits.len()).rev() {
            self.exchange(index, self.vertex_splits[index].old);
        }
        let vertices = self.base_vertices() + vertex_splits;
        self.triangles.truncate(faces);
        self.face_ids.truncate(faces);
        self.vertex_splits.truncate(vertex_splits);
        self.vertex_ids.truncate(vertices);
        self.values.truncate(vertices * self.layout.stride());
        self.split_values.truncate(vertex_splits * self.layout.stride());
        let corners = self.vertex_splits.last().map_or(0, |last| last.corners);
        self.corners.truncate(corners as usize);
    }
}

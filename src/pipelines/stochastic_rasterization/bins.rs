//! Moving triangles in tiles: how many there are in each is counted first, so that those that fit into memory together, in
//! bands of rows, are known before they are written.

use super::motion::Way;
use super::{LAYERS, TILE, moving_wgsl};
use crate::gpu::device::{Gpu, GpuError};
use crate::gpu::{buffers, shader};
use crate::mesh::BVH_WGSL;
use crate::pipelines::on_gpu::Shown;
use crate::pipelines::triangles::Triangles;
use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Vec4};
use rayon::prelude::*;
use shutterlab_stimuli::stimulus::View;
use std::ops::Range;
use wgpu::BufferUsages;

/// Triangles that a workgroup puts into tiles.
const GROUP: u32 = 64;

/// Bytes of an entry.
const ENTRY: u64 = 16;

/// The source of the shader that puts triangles into tiles.
pub fn wgsl() -> String {
    const CONSTANTS: &str = "const MESHES_MOVE = true;\nconst FAR = 3.4e38;\n";
    shader::join(&[CONSTANTS, BVH_WGSL, &moving_wgsl(), include_str!("bin.wgsl")])
}

/// The triangles of a frame in tiles.
#[derive(Debug)]
pub struct Bins<'a> {
    gpu: &'a Gpu,
    /// Rows of tiles that are drawn together.
    pub bands: Vec<Range<u32>>,
    /// Columns of tiles that are drawn.
    pub columns: Range<u32>,
    /// What they are put together with.
    pub band: wgpu::Buffer,
    /// The segments of all objects.
    pub segments: wgpu::Buffer,
    /// Where the entries of each layer of each tile of a band begin.
    pub places: wgpu::Buffer,
    /// The entries of a band.
    pub entries: wgpu::Buffer,
    /// Of each layer of each tile, how many entries it has.
    counts: Vec<u32>,
    params: Band,
    binning: Binning,
}

/// The shader with all that it reads and writes.
#[derive(Debug)]
struct Binning {
    pipeline: wgpu::ComputePipeline,
    bind_group: wgpu::BindGroup,
    groups: [u32; 2],
}

/// A segment of an object's way, as `moving.wgsl` declares it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Segment {
    /// Columns of what takes the object's own space to (x·z, y·z, z) as the segment begins.
    pub to_image: [Vec4; 4],
    /// The same as it ends.
    pub to_image_at_end: [Vec4; 4],
    /// Where between its two poses a mesh is then.
    pub poses: [f32; 2],
    /// How many of the object's segments come before.
    pub before: f32,
    /// How many segments the object has.
    pub count: f32,
    /// The object.
    pub object: u32,
    /// How many triangles it has.
    pub triangles: u32,
    /// See [`MeshRange`](crate::mesh::upload::MeshRange).
    pub faces: u32,
    /// The same.
    pub vertices: u32,
    /// The same.
    pub end_vertices: u32,
    /// The first of the workgroups that put its triangles into tiles.
    pub first_group: u32,
    /// Fills up to a multiple of 16 bytes.
    pub padding: [u32; 2],
}

/// What tiles are put together with, as `moving.wgsl` declares it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Band {
    /// Tiles per row.
    pub columns: u32,
    /// The first of them that is drawn.
    pub first_column: u32,
    /// The first of the rows that are drawn together.
    pub first_row: u32,
    /// The row behind the last of them.
    pub end_row: u32,
    /// 1 if entries are written, 0 if they are only counted.
    pub fills: u32,
    /// What is nearest, in metres along the view.
    pub nearest: f32,
    /// Layers of depth per metre behind it.
    pub layers_per_m: f32,
    /// How far a point is moved at most by where on the lens it is seen from: this times 1 − its depth times…
    pub blur_px: f32,
    /// … one over the distance of the focus, in metres.
    pub inverse_focus: f32,
    /// Fills up to a multiple of 16 bytes.
    pub padding: [u32; 3],
}

impl<'a> Bins<'a> {
    /// Counts the entries of the triangles of what is `shown`, as `view` sees them. If there are more than `most`, they come
    /// in bands.
    ///
    /// # Errors
    /// The device fails, or cannot bind the entries of a row of tiles.
    pub fn new(
        shown: &Shown<'a>,
        view: &View,
        triangles: &Triangles<'_>,
        most: u64,
        pipeline: &mut Option<wgpu::ComputePipeline>,
    ) -> Result<Self, GpuError> {
        let &Shown { gpu, frame, .. } = shown;
        let all = frame.objects.par_iter().zip(&triangles.shapes);
        let ways: Vec<Way> =
            all.map(|(object, shape)| Way::new(frame, view, object, shape)).collect();
        let (segments, groups) = segments(&ways, triangles);
        let [columns, rows] = [frame.params.width, frame.params.height].map(|n| n.div_ceil(TILE));
        let [nearest, farthest] = ways
            .iter()
            .map(Way::depths)
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[least, most], [near, far]| {
                [least.min(near), most.max(far)]
            });
        let nearest = nearest.max(0.0);
        let layers_per_m = LAYERS as f32 / (farthest - nearest).max(1e-6);
        let camera = &frame.params.camera;
        let params = Band {
            columns,
            end_row: rows,
            nearest,
            layers_per_m,
            blur_px: camera.lens_radius * camera.focal_length_px,
            inverse_focus: camera.focus_distance.recip(),
            ..Band::zeroed()
        };
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let band = buffers::holding(gpu, "band", BufferUsages::UNIFORM, &[params])?;
        let segments = buffers::holding(gpu, "segments", BufferUsages::STORAGE, &segments)?;
        let size = 4 * (u64::from(columns * rows * LAYERS) + 1);
        let places = buffers::empty(gpu, "places", storage, size)?;
        let pipeline =
            pipeline.get_or_insert_with(|| shader::compute_pipeline(gpu, wgsl(), "bin")).clone();
        // Whole rows of workgroups, as many as there may be.
        let across = groups.clamp(1, gpu.device.limits().max_compute_workgroups_per_dimension);
        let groups = [across, groups.div_ceil(across)];
        let binning = |entries: &wgpu::Buffer| {
            let all = [&band, &triangles.geometry, &segments, &places, entries];
            let all = (0..).zip(all.map(wgpu::Buffer::as_entire_binding));
            let bind_group = shader::bind_group(gpu, &pipeline, all);
            Binning { pipeline: pipeline.clone(), bind_group, groups }
        };

        let none = buffers::empty(gpu, "no entries", storage, ENTRY)?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        binning(&none).dispatch(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        let counts = buffers::read::<u32>(gpu, &places)?.split_off(1);
        let [drawn_columns, drawn_rows] = if shown.environment.is_black {
            drawn(&counts, columns)
        } else {
            [0..columns, 0..rows]
        };
        let of_row = |row: u32| {
            let row = row as usize * (columns * LAYERS) as usize;
            counts[row..][..(columns * LAYERS) as usize].iter().map(|&count| u64::from(count)).sum()
        };
        let limit = gpu.device.limits().max_storage_buffer_binding_size;
        let bands = bands(drawn_rows.map(|row| (row, of_row(row))), most.min(limit / ENTRY));
        let longest = bands.iter().map(|band| band.clone().map(of_row).sum::<u64>()).max();
        let size = ENTRY * longest.unwrap_or(0).max(1);
        let entries = buffers::empty(gpu, "entries of moving triangles", storage, size)?;
        let binning = binning(&entries);
        Ok(Self {
            gpu,
            bands,
            columns: drawn_columns,
            band,
            segments,
            places,
            entries,
            counts,
            params,
            binning,
        })
    }

    /// The most entries that a tile has.
    pub fn most_in_tile(&self) -> u32 {
        self.counts.chunks(LAYERS as usize).map(|tile| tile.iter().sum()).max().unwrap_or(0)
    }

    /// Writes the entries of a band. What is recorded before it is submitted is of one band.
    pub fn fill(&self, encoder: &mut wgpu::CommandEncoder, band: &Range<u32>) {
        let (first_row, end_row, first_column) = (band.start, band.end, self.columns.start);
        let params = Band { first_column, first_row, end_row, fills: 1, ..self.params };
        self.gpu.queue.write_buffer(&self.band, 0, bytemuck::bytes_of(&params));
        let row = (self.params.columns * LAYERS) as usize;
        let mut begin = 0;
        let mut places = vec![0];
        for count in &self.counts[row * first_row as usize..row * end_row as usize] {
            // Where the next entry goes: once all are there, where the next layer begins.
            places.push(begin);
            begin += count;
        }
        self.gpu.queue.write_buffer(&self.places, 0, bytemuck::cast_slice(&places));
        self.binning.dispatch(encoder);
    }
}

impl Binning {
    fn dispatch(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.dispatch_workgroups(self.groups[0], self.groups[1], 1);
    }
}

/// The segments of objects on these ways, and how many workgroups put their triangles into tiles.
fn segments(ways: &[Way], triangles: &Triangles<'_>) -> (Vec<Segment>, u32) {
    let mut segments = vec![];
    let mut groups = 0;
    let objects = ways.iter().zip(&triangles.shapes).zip(&triangles.ranges);
    for (object, ((way, shape), range)) in (0..).zip(objects) {
        for (before, ends) in way.ends.windows(2).enumerate() {
            let columns = |(to_image, _): (Affine3A, f32)| {
                let matrix = to_image.matrix3;
                [matrix.x_axis, matrix.y_axis, matrix.z_axis, to_image.translation]
                    .map(|column| column.extend(0.0))
            };
            segments.push(Segment {
                to_image: columns(ends[0]),
                to_image_at_end: columns(ends[1]),
                poses: [ends[0].1, ends[1].1],
                before: before as f32,
                count: (way.ends.len() - 1) as f32,
                object,
                triangles: shape.triangles.len() as u32,
                faces: range.faces,
                vertices: range.vertices,
                end_vertices: range.end_vertices,
                first_group: groups,
                padding: [0; 2],
            });
            groups += (shape.triangles.len() as u32).div_ceil(GROUP);
        }
    }
    (segments, groups)
}

/// The columns and rows of tiles that have entries, and what is between them.
fn drawn(counts: &[u32], columns: u32) -> [Range<u32>; 2] {
    let tiles = (0..).zip(counts.chunks(LAYERS as usize));
    let seen = tiles.filter(|(_, layers)| layers.iter().any(|&count| count > 0));
    let hull = |range: Range<u32>, at: u32| match range.is_empty() {
        true => at..at + 1,
        false => range.start.min(at)..range.end.max(at + 1),
    };
    seen.fold([0..0, 0..0], |[xs, ys], (tile, _)| {
        [hull(xs, tile % columns), hull(ys, tile / columns)]
    })
}

/// Rows that have so many entries in bands, as many together as have no more than `most`, or a single one.
fn bands(rows: impl Iterator<Item = (u32, u64)>, most: u64) -> Vec<Range<u32>> {
    let mut bands: Vec<Range<u32>> = vec![];
    let mut entries = 0;
    for (row, count) in rows {
        match bands.last_mut().filter(|_| entries + count <= most) {
            Some(band) => band.end = row + 1,
            None => {
                bands.push(row..row + 1);
                entries = 0;
            }
        }
        entries += count;
    }
    bands
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_as_large_as_they_may_be() {
        let of = |counts: &[u64], most| bands((4..).zip(counts.iter().copied()), most);
        assert_eq!(of(&[3, 4, 5, 20, 1, 1], 9), [4..6, 6..7, 7..8, 8..10]);
        assert_eq!(of(&[3, 4, 5], 12).first(), Some(&(4..7)));
        assert_eq!(of(&[], 12), []);
    }

    #[test]
    fn what_is_drawn_has_all_that_is_seen() {
        let mut counts = vec![0; 5 * 4 * LAYERS as usize];
        assert_eq!(drawn(&counts, 5), [0..0, 0..0]);
        // Tiles (1, 2) and (3, 1).
        counts[11 * LAYERS as usize] = 1;
        counts[8 * LAYERS as usize + 1] = 7;
        assert_eq!(drawn(&counts, 5), [1..4, 1..3]);
    }
}

//! The frames of a trial on the graphics device: decoded in the background before the trial begins,
//! then drawn where they are wanted, as the display profile says.

use super::shell::Shell;
use crate::display::{Arrangement, Codes, is_side_by_side};
use crate::stimuli_set::StimulusSet;
use shutterlab_data_schema::DisplayProfile;
use shutterlab_data_schema::display::{Corner, StereoMode};
use shutterlab_stimuli::frames::{EncodedImage, Transfer};
use shutterlab_stimuli::stereo::DUBOIS;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Weak};

/// What the decoded frames of one trial may take, in MiB.
const MOST_MIB: u64 = 1024;

/// Frames with consecutive numbers, decoded: red, green, blue and an unused byte per pixel.
struct Frames {
    size_px: [u32; 2],
    stereo: bool,
    transfer: Transfer,
    first: u32,
    pixels: Vec<Vec<u8>>,
}

/// The sequences of a trial, decoded.
pub(crate) struct Decoded {
    key: u32,
    /// For each sequence asked for, its place among the different ones.
    places: Vec<usize>,
    different: Vec<Frames>,
}

impl Decoded {
    /// One picture instead of sequences; `stereo` if its left half is for the left eye and its right
    /// half for the right eye.
    pub(crate) fn picture(
        key: u32,
        image: &EncodedImage,
        transfer: Transfer,
        stereo: bool,
    ) -> Self {
        let size_px = [image.width, image.height];
        let frames = Frames { size_px, stereo, transfer, first: 0, pixels: vec![rgba(image)] };
        Self { key, places: vec![0], different: vec![frames] }
    }
}

/// What was asked to be decoded.
#[derive(Clone)]
struct Request {
    key: u32,
    sequences: Vec<usize>,
    still: Option<u32>,
}

/// Decodes the sequences of trials in the background, one trial at a time.
pub(crate) struct Loader {
    set: Arc<StimulusSet>,
    asked: Option<Request>,
    /// What is being decoded. If it is dropped, so is the work.
    pending: Option<Receiver<Result<Decoded, String>>>,
    alive: Arc<()>,
}

impl Loader {
    pub(crate) fn new(set: Arc<StimulusSet>) -> Self {
        Self { set, asked: None, pending: None, alive: Arc::new(()) }
    }

    /// Begins to decode the sequences with these indices in the set, or only frame `still` of each, for
    /// the trial called `key`. Whatever else was being decoded is given up.
    pub(crate) fn prefetch(&mut self, key: u32, sequences: Vec<usize>, still: Option<u32>) {
        if self.asked.as_ref().is_none_or(|asked| asked.key != key) {
            self.asked = Some(Request { key, sequences, still });
            self.begin();
        }
    }

    /// The frames of the trial called `key`, once they are there; none before that.
    ///
    /// # Errors
    /// They cannot be decoded; asking again tries again. Or nobody asked for them.
    pub(crate) fn take(&mut self, key: u32) -> Result<Option<Decoded>, String> {
        if self.asked.as_ref().is_none_or(|asked| asked.key != key) {
            return Err(format!("the frames of trial {key} were not asked for"));
        }
        let Some(pending) = &self.pending else {
            self.begin();
            return Ok(None);
        };
        let result = match pending.try_recv() {
            Err(TryRecvError::Empty) => return Ok(None),
            Err(TryRecvError::Disconnected) => Err("reading the frames ended too early".into()),
            Ok(result) => result,
        };
        self.pending = None;
        if result.is_ok() {
            self.asked = None;
        }
        result.map(Some)
    }

    fn begin(&mut self) {
        let Some(request) = self.asked.clone() else { return };
        let (sender, receiver) = channel();
        self.pending = Some(receiver);
        self.alive = Arc::new(());
        let (set, wanted) = (self.set.clone(), Arc::downgrade(&self.alive));
        std::thread::spawn(move || {
            if let Some(result) = decode(&set, &request, &wanted).transpose() {
                // The window may be closed by now; then nobody waits for the frames.
                sender.send(result).ok();
            }
        });
    }
}

/// None if nobody wants the frames any more.
fn decode(
    set: &StimulusSet,
    request: &Request,
    wanted: &Weak<()>,
) -> Result<Option<Decoded>, String> {
    let mut indices = request.sequences.clone();
    indices.sort_unstable();
    indices.dedup();
    let wanted_frames = |index: usize| {
        let frames = set.sequences[index].manifest.frames.iter();
        frames.filter(|frame| request.still.is_none_or(|still| frame.index == still))
    };
    let bytes = |index: usize| {
        let [width, height] = set.stimulus(index).frame_size_px();
        wanted_frames(index).count() as u64 * 4 * u64::from(width) * u64::from(height)
    };
    let mib = indices.iter().map(|index| bytes(*index)).sum::<u64>() >> 20;
    if mib > MOST_MIB {
        let names: Vec<&str> =
            indices.iter().map(|index| set.stimulus(*index).id.as_str()).collect();
        return Err(format!(
            "{}: {mib} MiB of frames: {MOST_MIB} MiB are allowed in a trial; render them smaller or shorter",
            names.join(", ")
        ));
    }
    let mut different = Vec::new();
    for index in &indices {
        let stimulus = set.stimulus(*index);
        let mut frames = Frames {
            size_px: stimulus.frame_size_px(),
            stereo: is_side_by_side(stimulus),
            transfer: stimulus.image.transfer,
            first: request.still.unwrap_or(0),
            pixels: vec![],
        };
        for frame in wanted_frames(*index) {
            if wanted.strong_count() == 0 {
                return Ok(None);
            }
            let image = set.sequences[*index].read_frame(frame).map_err(|e| e.to_string())?;
            frames.pixels.push(rgba(&image));
        }
        different.push(frames);
    }
    let place = |index: &usize| indices.iter().position(|other| other == index);
    let places = request.sequences.iter().filter_map(place).collect();
    Ok(Some(Decoded { key: request.key, places, different }))
}

fn rgba(image: &EncodedImage) -> Vec<u8> {
    image.bytes.chunks_exact(3).flat_map(|rgb| [rgb[0], rgb[1], rgb[2], 255]).collect()
}

/// One frame to be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Draw {
    /// Place of its sequence among those asked for.
    pub sequence: usize,
    /// Its number.
    pub frame: u32,
    /// From the window's centre to its own, in physical pixels, right and down.
    pub centre: [i32; 2],
}

/// Draws frames. Holds those of one trial.
pub(crate) struct FrameView {
    profile: DisplayProfile,
    /// Where each physical pixel shows one image pixel, and where it mixes several.
    copied: wgpu::RenderPipeline,
    mixed: wgpu::RenderPipeline,
    patch: wgpu::RenderPipeline,
    key: Option<u32>,
    places: Vec<usize>,
    different: Vec<Uploaded>,
}

struct Uploaded {
    size_px: [u32; 2],
    pipeline: wgpu::RenderPipeline,
    first: u32,
    frames: Vec<wgpu::BindGroup>,
}

impl FrameView {
    pub(crate) fn new(shell: &Shell, profile: &DisplayProfile) -> Self {
        Self::on(shell.device(), shell.format(), profile)
    }

    fn on(device: &wgpu::Device, format: wgpu::TextureFormat, profile: &DisplayProfile) -> Self {
        let module = device.create_shader_module(wgpu::include_wgsl!("stimulus.wgsl"));
        let pipeline = |fragment| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(fragment),
                layout: None,
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("corner"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(fragment),
                    compilation_options: Default::default(),
                    targets: &[Some(format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        Self {
            profile: profile.clone(),
            copied: pipeline("copied"),
            mixed: pipeline("mixed"),
            patch: pipeline("patch_pixel"),
            key: None,
            places: vec![],
            different: vec![],
        }
    }

    /// The trial whose frames are held.
    pub(crate) fn holds(&self) -> Option<u32> {
        self.key
    }

    /// Physical width and height of what is drawn of one frame in a window; nothing before there are any.
    pub(crate) fn size_px(&self) -> [u32; 2] {
        self.different.first().map_or([0, 0], |frames| frames.size_px)
    }

    /// Moves the frames of a trial to the device, in place of those of another one.
    pub(crate) fn upload(&mut self, shell: &Shell, decoded: Decoded) {
        self.upload_to(shell.device(), shell.queue(), decoded);
    }

    fn upload_to(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, decoded: Decoded) {
        self.different.clear();
        self.key = Some(decoded.key);
        self.places = decoded.places;
        for frames in decoded.different {
            let arrangement = Arrangement::new(&self.profile, frames.size_px, frames.stereo);
            let settings = settings(&arrangement, &Codes::new(frames.transfer, &self.profile));
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("settings"),
                size: settings.len() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            queue.write_buffer(&buffer, 0, &settings);
            let pipeline = if arrangement.mixes() { &self.mixed } else { &self.copied };
            let layout = pipeline.get_bind_group_layout(0);
            let bind = |pixels: Vec<u8>| {
                let view = texture(device, queue, frames.size_px, &pixels);
                device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("frame"),
                    layout: &layout,
                    entries: &[
                        wgpu::BindGroupEntry {
                            binding: 0,
                            resource: wgpu::BindingResource::TextureView(&view),
                        },
                        wgpu::BindGroupEntry { binding: 1, resource: buffer.as_entire_binding() },
                    ],
                })
            };
            self.different.push(Uploaded {
                size_px: arrangement.size_px,
                pipeline: pipeline.clone(),
                first: frames.first,
                frames: frames.pixels.into_iter().map(bind).collect(),
            });
            // Lets go of what the copies of one sequence take before the next one's.
            queue.submit([]);
        }
    }

    /// Draws in window number `window`, whose inside has `window_px`. Frames that there are not are left
    /// out.
    pub(crate) fn paint(
        &self,
        pass: &mut wgpu::RenderPass<'static>,
        window: usize,
        window_px: [u32; 2],
        draws: &[Draw],
    ) {
        for draw in draws {
            let place = self.places.get(draw.sequence);
            let Some(frames) = place.and_then(|place| self.different.get(*place)) else { continue };
            let index = draw.frame.wrapping_sub(frames.first) as usize;
            let Some(frame) = frames.frames.get(index) else { continue };
            let corner = |i: usize| {
                (window_px[i] as i32 - frames.size_px[i] as i32).div_euclid(2) + draw.centre[i]
            };
            set_viewport(pass, [corner(0), corner(1)], frames.size_px);
            pass.set_pipeline(&frames.pipeline);
            pass.set_bind_group(0, frame, &[]);
            let window = window as u32;
            pass.draw(0..3, window..window + 1);
        }
    }

    /// Draws the patch for a photodiode, white or black, if the profile asks for one.
    pub(crate) fn paint_patch(
        &self,
        pass: &mut wgpu::RenderPass<'static>,
        window_px: [u32; 2],
        bright: bool,
    ) {
        let Some(patch) = self.profile.photodiode else { return };
        let size = patch.size_px;
        let [right, bottom] = window_px.map(|px| px as i32 - size as i32);
        let corner = match patch.corner {
            Corner::TopLeft => [0, 0],
            Corner::TopRight => [right, 0],
            Corner::BottomLeft => [0, bottom],
            Corner::BottomRight => [right, bottom],
        };
        set_viewport(pass, corner, [size; 2]);
        pass.set_pipeline(&self.patch);
        let bright = u32::from(bright);
        pass.draw(0..3, bright..bright + 1);
    }
}

fn set_viewport(pass: &mut wgpu::RenderPass<'static>, [x, y]: [i32; 2], [w, h]: [u32; 2]) {
    pass.set_viewport(x as f32, y as f32, w as f32, h as f32, 0.0, 1.0);
}

/// The bytes of the shader's `Settings`.
fn settings(arrangement: &Arrangement, codes: &Codes) -> Vec<u8> {
    let sizes =
        [arrangement.stored_px, arrangement.image_px, arrangement.view_px, arrangement.size_px];
    let mode = match arrangement.mode {
        None => 0,
        Some(StereoMode::SideBySide) => 1,
        Some(StereoMode::Crossed) => 2,
        Some(StereoMode::HalfWidth) => 3,
        Some(StereoMode::TopBottom) => 4,
        Some(StereoMode::Anaglyph) => 5,
        Some(StereoMode::RowInterleaved) => 6,
        Some(StereoMode::TwoWindows) => 7,
    };
    let flags = [mode, u32::from(arrangement.linear)];
    let integers = sizes.into_iter().flatten().chain(flags);
    let dubois = DUBOIS.into_iter().flatten().flat_map(|[r, g, b]| [r, g, b, 0.0]);
    let tables = codes.light.iter().zip(&codes.emitted).zip(&codes.sent);
    let tables = tables
        .flat_map(|((light, emitted), sent)| [*light, *emitted, f32::from(*sent) / 255.0, 0.0]);
    // The arrays begin at a multiple of 16 bytes.
    let floats = [arrangement.magnification, 0.0].into_iter().chain(dubois).chain(tables);
    let words = integers.map(u32::to_le_bytes).chain(floats.map(f32::to_le_bytes));
    words.flatten().collect()
}

fn texture(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    [width, height]: [u32; 2],
    bytes: &[u8],
) -> wgpu::TextureView {
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("frame"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(4 * width),
        rows_per_image: None,
    };
    queue.write_texture(texture.as_image_copy(), bytes, layout, size);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

#[cfg(test)]
mod tests;

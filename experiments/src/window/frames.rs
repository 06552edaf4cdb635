//! The frames of a trial on the graphics device: decoded in the background before the trial begins,
//! then drawn pixel for pixel in the middle of the window.

use super::shell::Shell;
use crate::design::Trial;
use crate::stimuli_set::StimulusSet;
use shutterlab_data_schema::response::Answer;
use shutterlab_stimuli::frames::EncodedImage;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Both sequences of a trial, decoded: red, green, blue and an unused byte per pixel.
pub(super) struct Decoded {
    trial: u32,
    size_px: [u32; 2],
    sequences: [Vec<Vec<u8>>; 2],
}

/// Decodes trials in the background, one at a time.
pub(super) struct Loader {
    set: Arc<StimulusSet>,
    pending: Option<(u32, Receiver<Result<Decoded, String>>)>,
}

impl Loader {
    pub(super) fn new(set: Arc<StimulusSet>) -> Self {
        Self { set, pending: None }
    }

    /// Begins to decode the sequences of `trial`.
    pub(super) fn prefetch(&mut self, trial: &Trial) {
        let (sender, receiver) = channel();
        let (set, trial) = (self.set.clone(), trial.clone());
        self.pending = Some((trial.number, receiver));
        std::thread::spawn(move || {
            // The window may be closed by now; then nobody waits for the frames.
            sender.send(decode(&set, &trial)).ok();
        });
    }

    /// The frames of `trial`, once they are there. Begins to decode them if nobody has.
    ///
    /// # Errors
    /// A frame cannot be read; asking again tries again.
    pub(super) fn take(&mut self, trial: &Trial) -> Result<Option<Decoded>, String> {
        let Some((_, receiver)) = self.pending.as_ref().filter(|(n, _)| *n == trial.number) else {
            self.prefetch(trial);
            return Ok(None);
        };
        let result = match receiver.try_recv() {
            Err(TryRecvError::Empty) => return Ok(None),
            Err(TryRecvError::Disconnected) => Err("reading the frames ended too early".into()),
            Ok(result) => result,
        };
        self.pending = None;
        result.map(Some)
    }
}

fn decode(set: &StimulusSet, trial: &Trial) -> Result<Decoded, String> {
    let sequence = |answer| {
        let frames = set.load(trial.stimulus(trial.side(answer))).map_err(|e| e.to_string())?;
        Ok::<_, String>(frames.iter().map(rgba).collect())
    };
    Ok(Decoded {
        trial: trial.number,
        size_px: set.stimulus(trial.a).frame_size_px(),
        sequences: [sequence(Answer::First)?, sequence(Answer::Second)?],
    })
}

fn rgba(image: &EncodedImage) -> Vec<u8> {
    image.bytes.chunks_exact(3).flat_map(|rgb| [rgb[0], rgb[1], rgb[2], 255]).collect()
}

/// Draws frames. Holds those of one trial.
pub(super) struct FrameView {
    pipeline: wgpu::RenderPipeline,
    trial: Option<u32>,
    size_px: [u32; 2],
    sequences: [Vec<wgpu::BindGroup>; 2],
}

impl FrameView {
    pub(super) fn new(shell: &Shell) -> Self {
        let source = wgpu::include_wgsl!("stimulus.wgsl");
        let module = shell.device().create_shader_module(source);
        let pipeline = shell.device().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("stimulus"),
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
                entry_point: Some("texel"),
                compilation_options: Default::default(),
                targets: &[Some(shell.format().into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { pipeline, trial: None, size_px: [0, 0], sequences: [vec![], vec![]] }
    }

    /// Number of the trial whose frames are held.
    pub(super) fn trial(&self) -> Option<u32> {
        self.trial
    }

    /// Moves the frames of a trial to the device, in place of those of another one.
    pub(super) fn upload(&mut self, shell: &Shell, decoded: Decoded) {
        self.size_px = decoded.size_px;
        self.trial = Some(decoded.trial);
        self.sequences = [vec![], vec![]];
        for (sequence, frames) in self.sequences.iter_mut().zip(&decoded.sequences) {
            *sequence = frames
                .iter()
                .map(|bytes| bind(shell, &self.pipeline, decoded.size_px, bytes))
                .collect();
        }
    }

    /// Draws frame `index` of a sequence in the middle of the window, which must be large enough.
    pub(super) fn paint(
        &self,
        pass: &mut wgpu::RenderPass<'static>,
        window_px: [u32; 2],
        interval: Answer,
        index: u32,
    ) {
        let sequence = match interval {
            Answer::First => &self.sequences[0],
            Answer::Second => &self.sequences[1],
        };
        let Some(frame) = sequence.get(index as usize) else { return };
        let [width, height] = self.size_px;
        let left = window_px[0].saturating_sub(width) / 2;
        let top = window_px[1].saturating_sub(height) / 2;
        pass.set_viewport(left as f32, top as f32, width as f32, height as f32, 0.0, 1.0);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, frame, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn bind(
    shell: &Shell,
    pipeline: &wgpu::RenderPipeline,
    [width, height]: [u32; 2],
    bytes: &[u8],
) -> wgpu::BindGroup {
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = shell.device().create_texture(&wgpu::TextureDescriptor {
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
    shell.queue().write_texture(texture.as_image_copy(), bytes, layout, size);
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    shell.device().create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("frame"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: wgpu::BindingResource::TextureView(&view),
        }],
    })
}

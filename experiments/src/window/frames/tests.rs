//! The shader against the plain arithmetic of `display`, and what the loader hands over.

use super::*;
use crate::display::compose;
use crate::test_support::{protocol, rendered};
use shutterlab_data_schema::display::{DisplayTransfer, Photodiode, StereoOutput};

/// A device without a window, if there is an adapter. There must be one if `SHUTTERLAB_REQUIRE_GPU` is
/// set.
fn device() -> Option<(wgpu::Device, wgpu::Queue)> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let Ok(adapter) = pollster::block_on(instance.request_adapter(&Default::default())) else {
        let missing = "there is no graphics adapter";
        assert!(std::env::var_os("SHUTTERLAB_REQUIRE_GPU").is_none(), "{missing}");
        println!("skipped: {missing}");
        return None;
    };
    Some(pollster::block_on(adapter.request_device(&Default::default())).unwrap())
}

/// What `paint` leaves in a window of this size on white.
fn drawn(
    (device, queue): &(wgpu::Device, wgpu::Queue),
    [width, height]: [u32; 2],
    paint: impl FnOnce(&mut wgpu::RenderPass<'static>),
) -> EncodedImage {
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let view = target.create_view(&Default::default());
    let mut encoder = device.create_command_encoder(&Default::default());
    let attachment = wgpu::RenderPassColorAttachment {
        view: &view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load: wgpu::LoadOp::Clear(wgpu::Color::WHITE),
            store: wgpu::StoreOp::Store,
        },
    };
    let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(attachment)],
        ..Default::default()
    });
    let mut pass = pass.forget_lifetime();
    paint(&mut pass);
    drop(pass);
    let row_bytes = (4 * width).next_multiple_of(256);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row_bytes * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(row_bytes),
        rows_per_image: None,
    };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(target.as_image_copy(), to, size);
    queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |result| result.unwrap());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let mapped = buffer.slice(..).get_mapped_range().unwrap();
    let row = |y: u32| &mapped[(y * row_bytes) as usize..][..4 * width as usize];
    let bytes = (0..height).flat_map(|y| row(y).chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]));
    EncodedImage { width, height, bytes: bytes.collect() }
}

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

fn frame(width: u32, height: u32) -> EncodedImage {
    let bytes = (0..3 * width * height).map(|i| (i * 37 + i * i / 11) as u8).collect();
    EncodedImage { width, height, bytes }
}

/// The image on white, its left top at `at`.
fn on_white(image: &EncodedImage, at: [i32; 2], [width, height]: [u32; 2]) -> EncodedImage {
    let mut all =
        EncodedImage { width, height, bytes: vec![255; 3 * width as usize * height as usize] };
    for y in 0..image.height as i32 {
        for x in 0..image.width as i32 {
            let to = 3 * ((y + at[1]) * width as i32 + x + at[0]) as usize;
            let from = 3 * (y * image.width as i32 + x) as usize;
            all.bytes[to..to + 3].copy_from_slice(&image.bytes[from..from + 3]);
        }
    }
    all
}

/// In every mode, at whole and other magnifications, on displays of every transfer.
#[test]
fn the_shader_does_what_the_arithmetic_says() {
    use StereoMode::*;
    let Some(gpu) = device() else { return };
    let (window_px, frame) = ([97, 75], frame(26, 15));
    let identity = DisplayTransfer::Identity {};
    let gamma = DisplayTransfer::Gamma { gamma: 1.8 };
    for mode in [SideBySide, Crossed, HalfWidth, TopBottom, Anaglyph, RowInterleaved, TwoWindows] {
        for stereo in [true, false] {
            for magnification in [1.0, 2.0, 1.5, 1.37] {
                for transfer in [&identity, &gamma] {
                    let profile = DisplayProfile {
                        transfer: transfer.clone(),
                        magnification,
                        stereo: StereoOutput { mode, second_output: None },
                        ..DisplayProfile::identity()
                    };
                    let case = format!("{mode:?} {stereo} {magnification} {transfer:?}");
                    let mut view = FrameView::on(&gpu.0, FORMAT, &profile);
                    let picture = Decoded::picture(3, &frame, Transfer::Srgb, stereo);
                    view.upload_to(&gpu.0, &gpu.1, picture);
                    let arrangement = Arrangement::new(&profile, [26, 15], stereo);
                    assert_eq!((view.holds(), view.size_px()), (Some(3), arrangement.size_px));
                    let codes = Codes::new(Transfer::Srgb, &profile);
                    for window in [0, 1] {
                        let draw = Draw { sequence: 0, frame: 0, centre: [3, -2] };
                        let found = drawn(&gpu, window_px, |pass| {
                            view.paint(pass, window, window_px, &[draw]);
                        });
                        let [w, h] = arrangement.size_px;
                        let left = (97 - w as i32).div_euclid(2) + 3;
                        let top = (75 - h as i32).div_euclid(2) - 2;
                        let expected =
                            compose(&frame, &arrangement, &codes, window as u32, top as u32);
                        let expected = on_white(&expected, [left, top], window_px);
                        // Where light is mixed, the last bit of a sum decides what is nearest.
                        let most = u8::from(arrangement.mixes());
                        for (i, (a, b)) in found.bytes.iter().zip(&expected.bytes).enumerate() {
                            let place = (i / 3 % 97, i / 3 / 97);
                            assert!(a.abs_diff(*b) <= most, "{case}: {place:?}: {a}, not {b}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn what_reaches_over_the_edge_is_cut_off() {
    let Some(gpu) = device() else { return };
    let frame = frame(20, 10);
    let mut view = FrameView::on(&gpu.0, FORMAT, &DisplayProfile::identity());
    view.upload_to(&gpu.0, &gpu.1, Decoded::picture(0, &frame, Transfer::Srgb, false));
    let draw = Draw { sequence: 0, frame: 0, centre: [-4, 0] };
    let found = drawn(&gpu, [10, 10], |pass| view.paint(pass, 0, [10, 10], &[draw]));
    // Its left is 9 pixels left of the window's.
    for y in 0..10 {
        let from = 3 * (y * 20 + 9);
        assert_eq!(found.bytes[30 * y..30 * y + 30], frame.bytes[from..from + 30]);
    }
}

#[test]
fn the_patch_is_in_its_corner() {
    let Some(gpu) = device() else { return };
    for (corner, x, y) in [
        (Corner::TopLeft, 0, 0),
        (Corner::TopRight, 25, 0),
        (Corner::BottomLeft, 0, 15),
        (Corner::BottomRight, 25, 15),
    ] {
        let photodiode = Some(Photodiode { corner, size_px: 5 });
        let profile = DisplayProfile { photodiode, ..DisplayProfile::identity() };
        let view = FrameView::on(&gpu.0, FORMAT, &profile);
        let patch = |bright| drawn(&gpu, [30, 20], |pass| view.paint_patch(pass, [30, 20], bright));
        let black = EncodedImage { width: 5, height: 5, bytes: vec![0; 75] };
        assert!(patch(true).bytes.iter().all(|byte| *byte == 255));
        assert_eq!(patch(false), on_white(&black, [x, y], [30, 20]), "{corner:?}");
    }
}

/// What the loader has for `key`, once it is there.
fn wait(loader: &mut Loader, key: u32) -> Result<Decoded, String> {
    loop {
        match loader.take(key) {
            Ok(None) => std::thread::yield_now(),
            Ok(Some(decoded)) => return Ok(decoded),
            Err(error) => return Err(error),
        }
    }
}

#[test]
fn sequences_are_decoded_once_and_in_the_order_asked_for() {
    let folder = rendered();
    let set = Arc::new(StimulusSet::open(&protocol(), folder.path()).unwrap());
    let mut loader = Loader::new(set.clone());
    let error = loader.take(1).err().unwrap();
    assert!(error.contains("trial 1 were not asked for"), "{error}");
    loader.prefetch(1, vec![4, 2, 4], None);
    // The next trial is wanted instead: nobody waits for the first.
    loader.prefetch(2, vec![4, 2, 4], None);
    assert!(loader.take(1).is_err());
    let decoded = wait(&mut loader, 2).unwrap();
    assert_eq!((decoded.key, decoded.different.len()), (2, 2));
    for (place, index) in decoded.places.iter().zip([4, 2, 4]) {
        let expected: Vec<Vec<u8>> = set.load(index).unwrap().iter().map(rgba).collect();
        assert_eq!(decoded.different[*place].pixels, expected);
    }
    loader.prefetch(3, vec![0], Some(2));
    let still = wait(&mut loader, 3).unwrap();
    assert_eq!((still.different[0].first, still.different[0].pixels.len()), (2, 1));
    assert_eq!(still.different[0].pixels[0], rgba(&set.load(0).unwrap()[2]));
}

#[test]
fn what_cannot_be_read_is_named_and_tried_again() {
    let folder = rendered();
    let set = Arc::new(StimulusSet::open(&protocol(), folder.path()).unwrap());
    let file = set.sequences[0].frame_path(1);
    let bytes = std::fs::read(&file).unwrap();
    std::fs::write(&file, &bytes[..40]).unwrap();
    let mut loader = Loader::new(set);
    loader.prefetch(1, vec![0, 1], None);
    let error = wait(&mut loader, 1).err().unwrap();
    assert!(error.contains("frame-0001.png: not a whole PNG"), "{error}");
    std::fs::write(&file, bytes).unwrap();
    assert!(wait(&mut loader, 1).is_ok());
}

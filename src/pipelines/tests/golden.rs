//! Golden images: what the methods showed when they were right. The truth beside them is the agreement of the methods
//! with one another and with formulas; these say that it was this scene, at this place, at this time, in these colours.
//!
//! They are 16,384 rays per pixel on the processor, in 8 bit sRGB. `SHUTTERLAB_BLESS=1 cargo test --lib golden` makes them
//! anew; look at them before you commit them.

use super::*;
use crate::pipelines::DeviceChoice;
use shutterlab_stimuli::frames::{EncodedImage, Transfer};
use shutterlab_stimuli::stimulus::ShutterProfile;
use std::path::PathBuf;

const GOLDEN_SAMPLES: u32 = 16_384;
const SAMPLES: u32 = 1024;
const MOST_BYTES: usize = 4096;

/// Root of the mean square of the differences that is allowed, in codes of 255. Rounding both images makes 0.4 of it, and the
/// noise of 1,024 samples 0.5, before a lens 1.0. An image half a pixel aside is off by 2.5 to 5.5, the same with another
/// shutter profile by 18.
const RMS_TOLERANCE: f64 = 1.5;

/// The largest difference of any code: at an edge, where half of a pixel has the code 180 and half none, samples drawn by
/// chance have a standard deviation of four codes.
const LARGEST_TOLERANCE: u8 = 16;

/// The scenes that have an image.
fn golden_scenes(assets: &Path) -> Vec<(&'static str, Stimulus)> {
    let mut all = scenes(assets);
    all.retain(|(name, _)| ["translation", "rotation", "lens"].contains(name));
    // A shutter that opens slowly.
    let mut slow = all[0].1.clone();
    slow.shutter_profile = ShutterProfile::Gaussian { sigma_fraction: 0.15 };
    all.push(("shutter", slow));
    all
}

fn file(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/pipelines/tests/golden");
    folder.join(format!("{name}.png"))
}

fn encoded(image: &LinearImage) -> EncodedImage {
    image.encode(0.0, Transfer::Srgb)
}

#[test]
fn all_methods_show_the_golden_images() {
    let assets = tempfile::tempdir().unwrap();
    let scenes = golden_scenes(assets.path());
    if std::env::var_os("SHUTTERLAB_BLESS").is_some() {
        for (name, stimulus) in &scenes {
            let rays = Method::DistributionRayTracing;
            let truth = image(stimulus, rays, GOLDEN_SAMPLES, 1, assets.path());
            std::fs::write(file(name), encoded(&truth).to_png().unwrap()).unwrap();
        }
    }
    // Tests of adapters say where there is none.
    let devices = [DeviceChoice::Cpu, DeviceChoice::Gpu].map(OpenDevice::open);
    for device in devices.iter().flatten() {
        for (_, method) in Method::ALL {
            let mut pipeline = device.pipeline(method, assets.path());
            for (name, stimulus) in &scenes {
                assert!(std::fs::read(file(name)).unwrap().len() <= MOST_BYTES, "{name}");
                let golden = EncodedImage::read_png(&file(name)).unwrap();
                let stimulus = Stimulus { method, samples: SAMPLES, seed: 2, ..stimulus.clone() };
                let found = encoded(&image_by(&mut *pipeline, &stimulus));
                let pairs = golden.bytes.iter().zip(&found.bytes);
                let differences: Vec<u8> = pairs.map(|(a, b)| a.abs_diff(*b)).collect();
                let squares: f64 = differences.iter().map(|&d| f64::from(d).powi(2)).sum();
                let rms = (squares / differences.len() as f64).sqrt();
                let largest = differences.into_iter().max().unwrap();
                assert!(
                    rms <= RMS_TOLERANCE && largest <= LARGEST_TOLERANCE,
                    "{name}, {method}, {:?}: RMS {rms}, largest {largest}",
                    device.describe()
                );
            }
        }
    }
}

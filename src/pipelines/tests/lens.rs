//! Depth of field against the formulas of the thin lens.

use super::*;

/// Focal length of the scenes: 50 mm of a sensor 36 mm wide.
const FOCAL_LENGTH_PX: f64 = 50.0 / 36.0 * WIDTH as f64;

/// A square as wide as two pixels, 3 m away, by a lens of 50 mm that is focused at a distance, or by a pinhole.
fn dot(assets: &Path, method: Method, lens: Option<f64>) -> LinearImage {
    let side = 2.0 * 3.0 / FOCAL_LENGTH_PX as f32;
    let dot = sheet(1, |u, v| side * Vec3::new(u - 0.5, v - 0.5, 0.0));
    let mut stimulus = scene(assets, "dot.obj", &dot, STILL);
    let camera = &mut stimulus.scene.camera;
    (camera.aperture_f_number, camera.focus_distance_m) = (lens.map(|_| F_NUMBER), lens);
    image(&stimulus, method, 1024, 1, assets)
}

const F_NUMBER: f64 = 0.1;

/// The variance of where an image's light is, along x and along y, in square pixels.
fn variances(image: &LinearImage) -> [f64; 2] {
    let lights = image.pixels.iter().map(|[red, ..]| f64::from(*red));
    let sum = |f: &dyn Fn([f64; 2]) -> f64| -> f64 {
        let at = |k: usize| [k as u32 % WIDTH, k as u32 / WIDTH].map(f64::from);
        lights.clone().enumerate().map(|(k, light)| light * f(at(k))).sum()
    };
    let all = sum(&|_| 1.0);
    assert!(all > 0.0);
    [0, 1].map(|axis| sum(&|at| at[axis].powi(2)) / all - (sum(&|at| at[axis]) / all).powi(2))
}

/// A disk of diameter c has variance c²/16 along each axis, and c is focal length in pixels times aperture times
/// |1/focus − 1/distance|. To it come the variances of the square, 2²/12, and of the pixel, 1/12.
#[test]
fn a_dot_out_of_focus_is_as_large_as_a_thin_lens_makes_it() {
    let assets = tempfile::tempdir().unwrap();
    let aperture_m = 0.05 / F_NUMBER;
    for method in [
        Method::DistributionRayTracing,
        Method::AccumulationBuffer,
        Method::StochasticRasterization,
    ] {
        for focus_m in [1.5, 2.0, 6.0] {
            let diameter = FOCAL_LENGTH_PX * aperture_m * (1.0 / focus_m - 1.0 / 3.0_f64).abs();
            let known = diameter.powi(2) / 16.0 + 5.0 / 12.0;
            for found in variances(&dot(assets.path(), method, Some(focus_m))) {
                assert!((found / known - 1.0).abs() < 0.03, "{method} {focus_m}: {found} {known}");
            }
        }
    }
}

#[test]
fn a_dot_in_focus_is_as_sharp_as_by_a_pinhole() {
    let assets = tempfile::tempdir().unwrap();
    for method in [
        Method::DistributionRayTracing,
        Method::AccumulationBuffer,
        Method::StochasticRasterization,
    ] {
        let [lens, pinhole] = [Some(3.0), None].map(|lens| dot(assets.path(), method, lens));
        let error = relative_difference(&lens, &pinhole);
        assert!(error < 1e-3, "{method}: {error}");
    }
}

/// A lens that is closed all but a hair is a pinhole.
#[test]
fn a_narrow_lens_is_a_pinhole() {
    let assets = tempfile::tempdir().unwrap();
    let (_, pinhole) = scenes(assets.path()).remove(0);
    let mut narrow = pinhole.clone();
    narrow.scene.camera.aperture_f_number = Some(1e6);
    for method in [Method::DistributionRayTracing, Method::StochasticRasterization] {
        let of = |stimulus| image(stimulus, method, 16, 1, assets.path());
        let error = relative_difference(&of(&narrow), &of(&pinhole));
        assert!(error < 1e-3, "{method}: {error}");
    }
}

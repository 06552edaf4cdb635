//! Tests of the picture readers, with pictures that the tests make themselves.

use super::*;
use image::{ImageBuffer, Rgb, Rgb32FImage, RgbImage, RgbaImage};

/// A picture's file.
pub fn file_of(picture: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = vec![];
    picture.into().write_to(&mut Cursor::new(&mut bytes), format).unwrap();
    bytes
}

/// Two by two texels of radiance.
pub fn radiance(texels: [[f32; 3]; 4]) -> Rgb32FImage {
    ImageBuffer::from_raw(2, 2, texels.into_iter().flatten().collect()).unwrap()
}

/// A Radiance file of one row.
pub fn radiance_file(header: &str, width: u32, texels: &[[u8; 4]]) -> Vec<u8> {
    let header = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n{header}\n\n-Y 1 +X {width}\n");
    [header.as_bytes(), texels.as_flattened()].concat()
}

fn texture_of(bytes: Vec<u8>) -> Result<Picture, ImportError> {
    texture(&Texture::Embedded { name: "a.glb: images[0]".into(), bytes: bytes.into() })
}

fn message<T: std::fmt::Debug>(result: Result<T, ImportError>) -> String {
    result.unwrap_err().to_string()
}

/// Values of IEC 61966-2-1 for 10 and 128 of 255, and for 32768 of 65535.
#[test]
fn eight_and_sixteen_bits_are_srgb() {
    let [low, middle] = [0.003_035_27, 0.215_860_5];
    let picture = RgbImage::from_raw(2, 1, vec![0, 10, 128, 255, 128, 0]).unwrap();
    let expected = [Vec3::new(0.0, low, middle), Vec3::new(1.0, middle, 0.0)];
    let found = texture_of(file_of(picture, ImageFormat::Png)).unwrap();
    assert_eq!((found.width, found.height), (2, 1));
    for (found, expected) in found.texels.iter().zip(expected) {
        assert!(found.abs_diff_eq(expected, 1e-6), "{found} {expected}");
    }

    let transparent = RgbaImage::from_raw(1, 1, vec![128, 128, 128, 0]).unwrap();
    let found = texture_of(file_of(transparent, ImageFormat::Png)).unwrap();
    assert!(found.texels[0].abs_diff_eq(Vec3::splat(middle), 1e-6), "{found:?}");

    let wide: ImageBuffer<Rgb<u16>, _> =
        ImageBuffer::from_raw(1, 1, vec![0, 32_768, 65_535]).unwrap();
    let found = texture_of(file_of(wide, ImageFormat::Png)).unwrap();
    assert!(found.texels[0].abs_diff_eq(Vec3::new(0.0, 0.214_048, 1.0), 1e-6), "{found:?}");

    let grey = file_of(image::GrayImage::from_pixel(8, 8, [128].into()), ImageFormat::Jpeg);
    let found = texture_of(grey).unwrap();
    assert!(found.texels.iter().all(|texel| texel.abs_diff_eq(Vec3::splat(middle), 0.01)));
}

/// By hand: 128·2^(129−136) = 1.
#[test]
fn a_radiance_file_gives_its_radiance_before_the_exposure() {
    let bytes = radiance_file("EXPOSURE=0.5\nEXPOSURE=4", 2, &[[128, 64, 32, 129], [0, 0, 0, 0]]);
    let picture = light_map_from("a.hdr", &bytes).unwrap();
    assert_eq!((picture.width, picture.height), (2, 1));
    assert_eq!(picture.texels, [Vec3::new(0.5, 0.25, 0.125), Vec3::ZERO]);
    let bytes = radiance_file("EXPOSURE=0", 1, &[[128; 4]]);
    let expected = "a.hdr: EXPOSURE: 0: numbers above 0 are allowed";
    assert_eq!(message(light_map_from("a.hdr", &bytes)), expected);
}

#[test]
fn an_exr_map_loses_what_is_below_zero_and_must_be_finite() {
    let map = |last: f32| {
        let texels = [[1.0, 2.0, 3e5], [0.0, -0.25, 0.5], [0.0; 3], [0.0, 0.0, last]];
        light_map_from("a.exr", &file_of(radiance(texels), ImageFormat::OpenExr))
    };
    let picture = map(0.25).unwrap();
    assert_eq!(picture.texels[0], Vec3::new(1.0, 2.0, 3e5));
    assert_eq!(picture.texels[1], Vec3::new(0.0, 0.0, 0.5));
    for last in [f32::NAN, f32::INFINITY] {
        let expected = "a.exr: texel (1, 1): [0, 0, ";
        assert!(message(map(last)).starts_with(expected), "{}", message(map(last)));
    }
}

#[test]
fn what_is_no_light_map_is_refused_by_name() {
    let black = file_of(radiance([[0.0; 3]; 4]), ImageFormat::OpenExr);
    assert_eq!(
        message(light_map_from("a.exr", &black)),
        "a.exr: radiance: 0 everywhere: a light map needs a texel that is not black"
    );
    let png = file_of(RgbImage::new(1, 1), ImageFormat::Png);
    assert_eq!(
        message(light_map_from("a.png", &png)),
        "a.png: first bytes: �PNG: one of the formats hdr, exr"
    );
}

/// The check sum of a PNG file's chunks (ISO 3309).
fn crc(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
    !bytes.iter().fold(u32::MAX, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), step))
}

#[test]
fn large_pictures_are_refused_before_they_are_decoded() {
    for size in ["-Y 1 +X 16385", "-Y 16385 +X 1", "-Y 16384 +X 16384", "-Y 4294967295 +X 9"] {
        let bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes();
        let message = message(light_map_from("a.hdr", &bytes));
        assert!(message.contains("imit"), "{size}: {message}");
    }

    // 10⁵ × 10⁵, in otherwise sound files.
    const SIDE: u32 = 100_000;
    let mut png = file_of(RgbImage::new(1, 1), ImageFormat::Png);
    png[16..20].copy_from_slice(&SIDE.to_be_bytes());
    png[20..24].copy_from_slice(&SIDE.to_be_bytes());
    let check_sum = crc(&png[12..29]).to_be_bytes();
    png[29..33].copy_from_slice(&check_sum);
    let mut exr = file_of(radiance([[0.5; 3]; 4]), ImageFormat::OpenExr);
    for name in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
        let at = exr.windows(name.len()).position(|window| window == name).unwrap();
        let last_corner = at + name.len() + 4 + 8;
        exr[last_corner..][..4].copy_from_slice(&(SIDE - 1).to_le_bytes());
        exr[last_corner + 4..][..4].copy_from_slice(&(SIDE - 1).to_le_bytes());
    }
    for bytes in [png, exr] {
        // The chunks of the EXR file do not match such a window, which is told first.
        let message = message(texture_of(bytes));
        assert!(["imit", "chunk count"].iter().any(|what| message.contains(what)), "{message}");
    }
}

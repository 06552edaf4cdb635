//! Pictures in linear Rec. 709: light maps (.hdr, .exr) and textures (.png, .jpg too).
//!
//! Eight- and sixteen-bit pictures are taken as sRGB, whatever profile they carry, and their alpha is
//! dropped. A Radiance file's EXPOSURE is undone, so that maps keep their photometric scale.

use super::{ImportError, Texture, read};
use glam::Vec3;
use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// Longest side of a picture, in texels.
pub const MAX_SIDE: u32 = 16_384;

/// Most memory for decoding: a map of 16384 × 8192 in floating point.
const MAX_DECODING_BYTES: u64 = 1 << 31;

/// A picture, row by row from the upper left.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Texels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear Rec. 709; finite and not negative.
    pub texels: Vec<Vec3>,
}

/// Reads a map of radiance. Values below zero, which filters leave behind around lamps, become zero.
///
/// # Errors
/// The file cannot be read, is neither .hdr nor .exr, is damaged or too large, has a texel that is not
/// finite, or is black all over.
pub fn light_map(path: &Path) -> Result<Picture, ImportError> {
    light_map_from(&path.display().to_string(), &read(path)?)
}

/// As [`light_map`], of `bytes`, the content of `file`.
///
/// # Errors
/// As [`light_map`].
pub fn light_map_from(file: &str, bytes: &[u8]) -> Result<Picture, ImportError> {
    let picture = decode(file, bytes, &[ImageFormat::Hdr, ImageFormat::OpenExr])?;
    if picture.texels.iter().all(|&texel| texel == Vec3::ZERO) {
        let allowed = "a light map needs a texel that is not black";
        return Err(ImportError::value(file, "radiance", "0 everywhere", allowed));
    }
    Ok(picture)
}

/// Reads a texture, in any of the formats.
///
/// # Errors
/// The file cannot be read, is in another format, is damaged or too large, or has a texel that is not
/// finite.
pub fn texture(texture: &Texture) -> Result<Picture, ImportError> {
    let any = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Hdr, ImageFormat::OpenExr];
    match texture {
        Texture::File(path) => decode(&texture.name(), &read(path)?, &any),
        Texture::Embedded { name, bytes } => decode(name, bytes, &any),
    }
}

/// The picture in `bytes`, which are in one of the `allowed` formats.
pub(super) fn decode(
    file: &str,
    bytes: &[u8],
    allowed: &[ImageFormat],
) -> Result<Picture, ImportError> {
    // The bytes tell more reliably than the name.
    let format = image::guess_format(bytes).ok().filter(|format| allowed.contains(format));
    let Some(format) = format else {
        let names: Vec<&str> = allowed.iter().flat_map(|f| f.extensions_str()).copied().collect();
        let start = String::from_utf8_lossy(&bytes[..bytes.len().min(4)]).into_owned();
        let allowed = format!("one of the formats {}", names.join(", "));
        return Err(ImportError::value(file, "first bytes", start.escape_debug(), allowed));
    };
    let damaged = |error: String| {
        let allowed = format!("a whole picture of at most {MAX_SIDE} texels a side is needed");
        ImportError::value(file, "picture", error, allowed)
    };
    // The decoder paints grey what is missing of a JPEG file.
    let last = |marker: [u8; 2]| bytes.windows(2).rposition(|pair| pair == marker);
    if format == ImageFormat::Jpeg && last([0xff, 0xd9]) < last([0xff, 0xda]) {
        return Err(damaged("the file ends too soon".into()));
    }
    let exposure = if format == ImageFormat::Hdr { exposure(file, bytes)? } else { 1.0 };
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_DECODING_BYTES);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let picture = reader.decode().map_err(|error| damaged(error.to_string()))?;

    let (width, height) = (picture.width(), picture.height());
    let texels: Vec<Vec3> = match picture {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            let finite = |(k, texel): (usize, &[f32])| {
                let radiance = Vec3::from_slice(texel) / exposure;
                if radiance.is_finite() {
                    return Ok(radiance.max(Vec3::ZERO));
                }
                let field = format!("texel ({}, {})", k % width as usize, k / width as usize);
                Err(ImportError::value(file, field, radiance, "finite numbers are needed"))
            };
            let values = picture.into_rgb32f().into_raw();
            values.chunks_exact(3).enumerate().map(finite).collect::<Result<_, _>>()?
        }
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => linear(&picture.into_rgb16().into_raw(), u16::MAX.into()),
        _ => linear(&picture.into_rgb8().into_raw(), u8::MAX.into()),
    };
    Ok(Picture { width, height, texels })
}

/// What the values of a Radiance file have been multiplied by.
fn exposure(file: &str, bytes: &[u8]) -> Result<f32, ImportError> {
    let decoder = HdrDecoder::new(Cursor::new(bytes)).map_err(|error| {
        ImportError::value(file, "header", error, "a Radiance header is needed")
    })?;
    let exposure = decoder.metadata().exposure.unwrap_or(1.0);
    if exposure.is_normal() && exposure > 0.0 {
        return Ok(exposure);
    }
    Err(ImportError::value(file, "EXPOSURE", exposure, "numbers above 0 are allowed"))
}

/// Linear values of sRGB values from 0 to `largest`.
fn linear<T: Copy + Into<u32>>(values: &[T], largest: u32) -> Vec<Vec3> {
    let table: Vec<f32> = (0..=largest)
        .map(|value| {
            let encoded = f64::from(value) / f64::from(largest);
            let linear = if encoded <= 0.04045 {
                encoded / 12.92
            } else {
                ((encoded + 0.055) / 1.055).powf(2.4)
            };
            linear as f32
        })
        .collect();
    let at = |value: T| table[value.into() as usize];
    values
        .chunks_exact(3)
        .map(|texel| Vec3::new(at(texel[0]), at(texel[1]), at(texel[2])))
        .collect()
}

#[cfg(test)]
pub(super) mod tests;

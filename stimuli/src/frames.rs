//! Frames: linear images, the transfer functions that encode them, and 8-bit PNG files.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::io;
use std::path::Path;

/// Linear Rec. 709 radiance, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearImage {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width · height` pixels.
    pub pixels: Vec<[f32; 3]>,
}

/// An encoded image, 8 bits per channel, row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EncodedImage {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width · height` pixels of red, green and blue.
    pub bytes: Vec<u8>,
}

/// How display-referred linear light becomes a code value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Transfer {
    /// IEC 61966-2-1.
    Srgb,
    /// A pure power: code = light^(1/γ).
    Gamma(f64),
}

impl Transfer {
    /// The code value in [0, 1] of `light`, which is clamped to [0, 1].
    pub fn encode(self, light: f32) -> f32 {
        let light = light.clamp(0.0, 1.0);
        match self {
            Self::Srgb if light <= 0.003_130_8 => 12.92 * light,
            Self::Srgb => 1.055 * light.powf(1.0 / 2.4) - 0.055,
            Self::Gamma(gamma) => light.powf(1.0 / gamma as f32),
        }
    }
}

impl Transfer {
    /// The light that a code value in [0, 1] stands for.
    pub fn decode(self, code: f32) -> f32 {
        match self {
            Self::Srgb if code <= 0.040_45 => code / 12.92,
            Self::Srgb => ((code + 0.055) / 1.055).powf(2.4),
            Self::Gamma(gamma) => code.powf(gamma as f32),
        }
    }
}

impl LinearImage {
    /// The image as an OpenEXR file's bytes: 32-bit floats, linear Rec. 709.
    ///
    /// # Errors
    /// The encoder refuses the image.
    pub fn to_exr(&self) -> io::Result<Vec<u8>> {
        use exr::prelude::*;
        let size = (self.width as usize, self.height as usize);
        let pixel = |place: Vec2<usize>| {
            let [r, g, b] = self.pixels[place.y() * size.0 + place.x()];
            (r, g, b)
        };
        let mut file = io::Cursor::new(vec![]);
        let image = Image::from_channels(size, SpecificChannels::rgb(pixel));
        image.write().to_buffered(&mut file).map_err(io::Error::other)?;
        Ok(file.into_inner())
    }

    /// Exposes (2^`exposure_stops`), encodes and rounds to 8 bits.
    pub fn encode(&self, exposure_stops: f64, transfer: Transfer) -> EncodedImage {
        let gain = (exposure_stops as f32).exp2();
        let code = |light: f32| (255.0 * transfer.encode(gain * light)).round() as u8;
        let bytes = self.pixels.iter().flatten().map(|&light| code(light)).collect();
        EncodedImage { width: self.width, height: self.height, bytes }
    }
}

/// A frame could not be read. The message names the file.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {what}")]
pub struct FrameError {
    file: String,
    what: String,
}

impl EncodedImage {
    /// SHA-256 of the pixel bytes, in hexadecimal: the same for any PNG encoder.
    pub fn sha256(&self) -> String {
        hex(&Sha256::digest(&self.bytes))
    }

    /// The image as a PNG file's bytes.
    ///
    /// # Errors
    /// The encoder refuses the image, for one because its size does not fit its bytes.
    pub fn to_png(&self) -> io::Result<Vec<u8>> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Balanced);
        encoder.write_header()?.write_image_data(&self.bytes)?;
        Ok(file)
    }

    /// Reads an 8-bit RGB PNG.
    ///
    /// # Errors
    /// The file cannot be read, is truncated or damaged, or is not 8-bit RGB.
    pub fn read_png(path: &Path) -> Result<Self, FrameError> {
        let fail = |what: String| FrameError { file: path.display().to_string(), what };
        let file = std::fs::File::open(path).map_err(|e| fail(format!("cannot be read: {e}")))?;
        let mut reader = png::Decoder::new(io::BufReader::new(file))
            .read_info()
            .map_err(|e| fail(format!("not a whole PNG: {e}")))?;
        let (color, depth) = reader.output_color_type();
        if (color, depth) != (png::ColorType::Rgb, png::BitDepth::Eight) {
            return Err(fail(format!("{color:?} of {depth:?} bits: 8-bit RGB is needed")));
        }
        let (width, height) = (reader.info().width, reader.info().height);
        let mut bytes = vec![0; 3 * width as usize * height as usize];
        reader.next_frame(&mut bytes).map_err(|e| fail(format!("not a whole PNG: {e}")))?;
        Ok(Self { width, height, bytes })
    }
}

/// Lower-case hexadecimal.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// IEC 61966-2-1 at the codes that everyone knows.
    #[test]
    fn srgb_meets_its_standard() {
        for (light, code) in [(0.0, 0), (0.215_861, 128), (0.5, 188), (1.0, 255), (7.0, 255)] {
            let image = LinearImage { width: 1, height: 1, pixels: vec![[light; 3]] };
            assert_eq!(image.encode(0.0, Transfer::Srgb).bytes, [code; 3], "{light}");
        }
        let image = LinearImage { width: 1, height: 1, pixels: vec![[0.25; 3]] };
        assert_eq!(image.encode(1.0, Transfer::Srgb).bytes, [188; 3]);
        assert_eq!(image.encode(0.0, Transfer::Gamma(2.0)).bytes, [128; 3]);
    }

    #[test]
    fn decoding_undoes_encoding() {
        for transfer in [Transfer::Srgb, Transfer::Gamma(2.2)] {
            for code in 0..=255 {
                let code = f32::from(code as u8) / 255.0;
                assert!((transfer.encode(transfer.decode(code)) - code).abs() < 1e-5, "{code}");
            }
        }
    }

    #[test]
    fn a_png_comes_back_and_a_truncated_one_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frame-0000.png");
        let bytes: Vec<u8> = (0..3 * 64 * 32).map(|i| (i * i % 251) as u8).collect();
        let image = EncodedImage { width: 64, height: 32, bytes };
        let png = image.to_png().unwrap();
        std::fs::write(&path, &png).unwrap();
        assert_eq!(EncodedImage::read_png(&path).unwrap(), image);
        for length in [0, 10, png.len() / 2, png.len() - 20] {
            std::fs::write(&path, &png[..length]).unwrap();
            let error = EncodedImage::read_png(&path).unwrap_err().to_string();
            assert!(error.contains("frame-0000.png: not a whole PNG"), "{length}: {error}");
        }
    }
}

//! Screens sequences before anybody sees them: how different predictors of vision say they are.
//!
//! - ColorVideoVDP (Mantiuk et al. 2024) compares whole sequences as seen on the grid's display, in units
//!   of just objectionable difference: 10 is no visible difference, and of two that lie one unit apart
//!   three of four observers choose the higher.
//! - FLIP (Andersson et al. 2020) compares stills that alternate: the mean over pixels and over at most
//!   eight frames spread over the sequence, 0 to 1.
//! - PSNR of the code values of all frames, in dB; infinite where they are the same.
//!
//! A pair is compared one way only: the one whose folder comes first by name is the reference.

use crate::frames::{EncodedImage, Transfer};
use crate::manifest::{Sequence, SequenceError};
use crate::stimulus::Stimulus;
use colorvideovdp::{Color, Cvvdp, DisplayModel, Geometry, Image, Options, Photometry};
use serde::{Deserialize, Serialize};

/// White of a display whose grid does not tell it, in cd/m².
const WHITE_LUMINANCE: f64 = 100.0;
/// White over black of the display, in a dark room.
const CONTRAST: f64 = 1000.0;
/// Frames that FLIP looks at.
const STILLS: usize = 8;

/// What is known of a pair of sequences: a row of `screen.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Folder of the first.
    pub reference: String,
    /// Folder of the second.
    pub test: String,
    /// Hash of the first, as its manifest has it.
    pub reference_sha256: String,
    /// Hash of the second.
    pub test_sha256: String,
    /// ColorVideoVDP, in units of just objectionable difference.
    pub cvvdp_jod: f64,
    /// FLIP.
    pub flip_mean: f64,
    /// PSNR.
    pub psnr_db: f64,
}

/// Sequences cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum ScreenError {
    /// A sequence is damaged.
    #[error(transparent)]
    Sequence(#[from] SequenceError),
    /// Sequences of other shape are not compared.
    #[error("screen: {reference}, {test}: {field}: {values}: they have to be the same")]
    Differ {
        /// Folder of the first.
        reference: String,
        /// Folder of the second.
        test: String,
        /// What differs.
        field: &'static str,
        /// Both values.
        values: String,
    },
    /// A predictor failed.
    #[error("screen: {reference}, {test}: {what}")]
    Predictor {
        /// Folder of the first.
        reference: String,
        /// Folder of the second.
        test: String,
        /// What it said.
        what: String,
    },
}

/// Compares two finished sequences.
///
/// # Errors
/// See [`ScreenError`].
pub fn compare(reference: &Sequence, test: &Sequence) -> Result<Comparison, ScreenError> {
    let name =
        |s: &Sequence| s.folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (reference_name, test_name) = (name(reference), name(test));
    if let Some((field, values)) = difference(reference, test) {
        return Err(ScreenError::Differ {
            reference: reference_name,
            test: test_name,
            field,
            values,
        });
    }
    let read = |s: &Sequence| -> Result<Vec<EncodedImage>, SequenceError> {
        s.manifest.frames.iter().map(|frame| s.read_frame(frame)).collect()
    };
    let (a, b) = (read(reference)?, read(test)?);
    let predicted = predict(&reference.manifest.stimulus, &a, &b);
    let (cvvdp_jod, flip_mean) = predicted.map_err(|what| ScreenError::Predictor {
        reference: reference_name.clone(),
        test: test_name.clone(),
        what,
    })?;
    Ok(Comparison {
        reference: reference_name,
        test: test_name,
        reference_sha256: reference.manifest.sha256.clone(),
        test_sha256: test.manifest.sha256.clone(),
        cvvdp_jod,
        flip_mean,
        psnr_db: psnr(&a, &b),
    })
}

/// The first of the things that must not differ, with both values.
fn difference(a: &Sequence, b: &Sequence) -> Option<(&'static str, String)> {
    let frames = |s: &Sequence| s.manifest.frames.iter().map(|f| f.index).collect::<Vec<_>>();
    let (x, y) = (&a.manifest.stimulus, &b.manifest.stimulus);
    let values = |a: &dyn std::fmt::Debug, b: &dyn std::fmt::Debug| format!("{a:?}, {b:?}");
    if x.frame_size_px() != y.frame_size_px() {
        Some(("size in pixels", values(&x.frame_size_px(), &y.frame_size_px())))
    } else if frames(a) != frames(b) {
        Some(("frames", format!("{} frames, {} or other frames", frames(a).len(), frames(b).len())))
    } else if x.image.fps != y.image.fps {
        Some(("frames per second", values(&x.image.fps, &y.image.fps)))
    } else if x.image.transfer != y.image.transfer {
        Some(("transfer", values(&x.image.transfer, &y.image.transfer)))
    } else if x.viewing != y.viewing {
        Some(("viewing", values(&x.viewing, &y.viewing)))
    } else {
        None
    }
}

/// ColorVideoVDP and FLIP.
fn predict(
    stimulus: &Stimulus,
    reference: &[EncodedImage],
    test: &[EncodedImage],
) -> Result<(f64, f64), String> {
    let [width, height] = stimulus.frame_size_px().map(|side| side as usize);
    let display = stimulus.viewing.display.as_ref();
    let white = display.and_then(|d| d.white_luminance_cd_m2).unwrap_or(WHITE_LUMINANCE);
    let failed = |error: colorvideovdp::Error| format!("ColorVideoVDP: {error}");
    let geometry =
        Geometry::from_ppd([width, height], stimulus.pixels_per_degree).map_err(failed)?;
    let photometry = Photometry::new(white, CONTRAST, 0.0, 0.0, 1.0).map_err(failed)?;
    let model = DisplayModel::new("grid", photometry, geometry, "BT.709-linear").map_err(failed)?;
    // Two buffers of the sequences' size would not fit a fixed bound for every grid.
    let options = Options::default().with_memory_limit_bytes(1 << 32);
    let metric = Cvvdp::new(model, options).map_err(failed)?;
    let table = luminances(stimulus.image.transfer, white);
    let linear = |images: &[EncodedImage]| -> Result<Vec<Image>, String> {
        let light = |image: &EncodedImage| {
            let values = image.bytes.iter().map(|&code| table[usize::from(code)]).collect();
            Image::new(width, height, 3, values).map_err(failed)
        };
        images.iter().map(light).collect()
    };
    let (test_light, reference_light) = (linear(test)?, linear(reference)?);
    let fps = stimulus.image.fps as f32;
    let jod = metric.predict_video(&test_light, &reference_light, fps, Color::Linear);

    let failed = |error: flip_rs::FlipError| format!("FLIP: {error}");
    let still = |image: &EncodedImage| {
        flip_rs::RgbImage::new(width, height, image.bytes.clone()).map_err(failed)
    };
    let count = STILLS.min(test.len());
    let mut flip = 0.0;
    for n in 0..count {
        let place = (2 * n + 1) * test.len() / (2 * count);
        let pixels_per_degree = stimulus.pixels_per_degree as f32;
        let map =
            flip_rs::ldr_flip(&still(&reference[place])?, &still(&test[place])?, pixels_per_degree);
        flip += f64::from(map.map_err(failed)?.statistics().mean) / count as f64;
    }
    let jod = jod.map_err(|error| format!("ColorVideoVDP: {error}"))?.jod;
    Ok((f64::from(jod), flip))
}

/// What each code value shines with, in cd/m².
fn luminances(transfer: Transfer, white: f64) -> Vec<f32> {
    let luminance = |code: u8| white as f32 * transfer.decode(f32::from(code) / 255.0);
    (0..=255).map(luminance).collect()
}

fn psnr(a: &[EncodedImage], b: &[EncodedImage]) -> f64 {
    let codes = a.iter().zip(b).flat_map(|(a, b)| a.bytes.iter().zip(&b.bytes));
    let (mut squares, mut count) = (0_u64, 0_u64);
    for (a, b) in codes {
        squares += u64::from(a.abs_diff(*b)).pow(2);
        count += 1;
    }
    10.0 * (255.0 * 255.0 * count as f64 / squares as f64).log10()
}

/// The matrix of what ColorVideoVDP says, as an SVG figure: the darker a cell, the more its pair differs.
pub fn figure(comparisons: &[Comparison]) -> String {
    let mut names: Vec<&str> =
        comparisons.iter().flat_map(|row| [row.reference.as_str(), row.test.as_str()]).collect();
    names.sort_unstable();
    names.dedup();
    const CELL: usize = 44;
    let label = 8 * names.iter().map(|name| name.len()).max().unwrap_or(0) + 8;
    let side = label + CELL * names.len();
    // Not narrower than the title.
    let width = side.max(440);
    let mut marks = String::new();
    for (place, name) in names.iter().enumerate() {
        let name = name.replace('&', "&amp;").replace('<', "&lt;");
        let middle = label + CELL * place + CELL / 2;
        marks += &format!(
            "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{name}</text>\n",
            label - 6,
            middle + 4
        );
        marks += &format!(
            "<text transform=\"translate({},{}) rotate(-90)\">{name}</text>\n",
            middle + 4,
            label - 6
        );
    }
    for row in comparisons {
        let place = |name: &str| names.binary_search(&name).unwrap_or_default();
        let (i, j) = (place(&row.reference), place(&row.test));
        // 10 is white, 5 and less black.
        let shade = ((row.cvvdp_jod - 5.0) / 5.0).clamp(0.0, 1.0);
        let grey = (255.0 * shade) as u8;
        let ink = if shade < 0.5 { "#fff" } else { "#000" };
        for (x, y) in [(i, j), (j, i)] {
            let (x, y) = (label + CELL * x, label + CELL * y);
            marks += &format!(
                "<rect x=\"{x}\" y=\"{y}\" width=\"{CELL}\" height=\"{CELL}\" fill=\"rgb({grey},{grey},{grey})\" stroke=\"#999\"/>\n\
                 <text x=\"{}\" y=\"{}\" text-anchor=\"middle\" fill=\"{ink}\">{:.2}</text>\n",
                x + CELL / 2,
                y + CELL / 2 + 4,
                row.cvvdp_jod
            );
        }
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{0}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <text x=\"6\" y=\"18\" font-size=\"14\">ColorVideoVDP, JOD: 10 is no visible difference; each pair once</text>\n\
         <g transform=\"translate(0,24)\">\n{marks}</g>\n</svg>\n",
        side + 24
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(code: impl Fn(u32, u32) -> u8) -> EncodedImage {
        let places = (0..48).flat_map(|y| (0..64).map(move |x| (x, y)));
        let bytes = places.flat_map(|(x, y)| [code(x, y); 3]).collect();
        EncodedImage { width: 64, height: 48, bytes }
    }

    fn stimulus() -> Stimulus {
        let mut grid = crate::Grid::load("demo").unwrap();
        (grid.image.width_px, grid.image.height_px) = (64, 48);
        grid.stimuli(&Default::default()).unwrap().remove(0)
    }

    /// Nothing differs from itself; and all three say that more noise is more different.
    #[test]
    fn predictors_tell_more_from_less() {
        let noisy = |amount: u32| {
            let frame = |t: u32| {
                image(move |x, y| {
                    let hash = (x * 7919 + y * 104_729 + t * 1_299_709).wrapping_mul(0x9e37_79b9);
                    (100 + (hash >> 16) % (amount + 1)) as u8
                })
            };
            (0..4).map(frame).collect::<Vec<_>>()
        };
        let (none, some, much) = (noisy(0), noisy(8), noisy(60));
        let all = |test: &[EncodedImage]| {
            let (jod, flip) = predict(&stimulus(), &none, test).unwrap();
            (jod, flip, psnr(&none, test))
        };
        assert_eq!(all(&none), (10.0, 0.0, f64::INFINITY));
        let (a, b) = (all(&some), all(&much));
        assert!(a.0 < 10.0 && b.0 < a.0 && a.1 > 0.0 && b.1 > a.1 && b.2 < a.2, "{a:?} {b:?}");
    }

    /// A folder may have any name.
    #[test]
    fn the_figure_spells_names_as_text() {
        let row = Comparison {
            reference: "a&b".into(),
            test: "<i>".into(),
            reference_sha256: String::new(),
            test_sha256: String::new(),
            cvvdp_jod: 9.0,
            flip_mean: 0.1,
            psnr_db: 30.0,
        };
        let svg = figure(&[row]);
        assert!(svg.contains(">a&amp;b</text>") && svg.contains(">&lt;i></text>"), "{svg}");
    }

    /// A difference of ten code values everywhere is 28.13 dB.
    #[test]
    fn psnr_is_that_of_code_values() {
        let found = psnr(&[image(|_, _| 100)], &[image(|_, _| 110)]);
        assert!((found - 28.1308).abs() < 1e-3, "{found}");
    }
}

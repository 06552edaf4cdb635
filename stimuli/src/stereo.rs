//! Stereo: where the two eyes are, and how their images make one frame.

use crate::frames::{EncodedImage, LinearImage};
use serde::{Deserialize, Serialize};

/// A pair of eyes at the two sides of the scene's camera (Navarro 2012, §6.2.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stereo {
    /// Distance between the eyes.
    pub interocular_mm: f64,
    /// How the eyes meet in the point that the camera looks at.
    pub convergence: Convergence,
    /// Whether the eyes see the same noise.
    pub noise: EyeNoise,
    /// How the two images make one frame.
    pub layout: Layout,
}

/// How the eyes meet in the point that the camera looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Convergence {
    /// Each looks at the point.
    ToeIn,
    /// Both look straight ahead, and their images are shifted, so that the plane of the point has no
    /// disparity, not even a vertical one.
    OffAxis,
}

/// Whether the eyes see the same noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EyeNoise {
    /// Each its own.
    Independent,
    /// The same pattern of noise in either image.
    Shared,
}

/// How the images of the two eyes make one frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// Left eye left, right eye right.
    SideBySide,
    /// Side by side, each image squeezed to half its width.
    HalfWidth,
    /// Left eye above right.
    TopBottom,
    /// For red-cyan glasses: the least-squares anaglyph of Dubois, in linear light.
    Anaglyph,
    /// No stimulus, but a look at one: how much the two images differ, in false colour.
    Difference,
}

impl Layout {
    /// All layouts by name, for the command line.
    pub const ALL: [(&str, Self); 5] = [
        ("side-by-side", Self::SideBySide),
        ("half-width", Self::HalfWidth),
        ("top-bottom", Self::TopBottom),
        ("anaglyph", Self::Anaglyph),
        ("difference", Self::Difference),
    ];

    /// Width and height of a frame whose views have `size`.
    pub fn size_px(self, [width, height]: [u32; 2]) -> [u32; 2] {
        match self {
            Self::SideBySide => [2 * width, height],
            Self::HalfWidth => [2 * (width / 2), height],
            Self::TopBottom => [width, 2 * height],
            Self::Anaglyph | Self::Difference => [width, height],
        }
    }

    /// The frame that `[left, right]` make, encoded by `encode`. All arithmetic is on linear light,
    /// but for the difference, which is one of what is displayed.
    pub fn compose(
        self,
        [left, right]: [&LinearImage; 2],
        encode: impl Fn(&LinearImage) -> EncodedImage,
    ) -> EncodedImage {
        match self {
            Self::SideBySide => encode(&beside(left, right)),
            Self::HalfWidth => encode(&beside(&squeezed(left), &squeezed(right))),
            Self::TopBottom => encode(&LinearImage {
                height: left.height + right.height,
                pixels: [left.pixels.as_slice(), &right.pixels].concat(),
                ..*left
            }),
            Self::Anaglyph => encode(&anaglyph(left, right)),
            Self::Difference => difference(&encode(left), &encode(right)),
        }
    }
}

/// `left` and `right` in one image.
pub fn beside(left: &LinearImage, right: &LinearImage) -> LinearImage {
    let left_rows = left.pixels.chunks(left.width as usize);
    let right_rows = right.pixels.chunks(right.width as usize);
    let pixels = left_rows.zip(right_rows).flat_map(|(l, r)| [l, r].concat()).collect();
    LinearImage { width: left.width + right.width, height: left.height, pixels }
}

/// Half as wide: the mean of each two neighbours.
fn squeezed(image: &LinearImage) -> LinearImage {
    let mean = |pair: &[[f32; 3]]| std::array::from_fn(|c| 0.5 * (pair[0][c] + pair[1][c]));
    let rows = image.pixels.chunks(image.width as usize);
    let pixels = rows.flat_map(|row| row.chunks_exact(2).map(mean)).collect();
    LinearImage { width: image.width / 2, height: image.height, pixels }
}

/// Per mille of red, green and blue of the left and of the right eye in each channel of the anaglyph
/// for red-cyan glasses (Dubois 2001, as published for that paper's displays and filters).
pub const DUBOIS: [[[f32; 3]; 2]; 3] = [
    [[437.0, 449.0, 164.0], [-11.0, -32.0, -7.0]],
    [[-62.0, -62.0, -24.0], [377.0, 761.0, 9.0]],
    [[-48.0, -50.0, -17.0], [-26.0, -93.0, 1234.0]],
];

/// The anaglyph of a pixel of linear light for the left and one for the right eye.
pub fn anaglyph_pixel(left: [f32; 3], right: [f32; 3]) -> [f32; 3] {
    let dot = |a: [f32; 3], b: [f32; 3]| 1e-3 * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
    DUBOIS.map(|[of_left, of_right]| dot(of_left, left) + dot(of_right, right))
}

fn anaglyph(left: &LinearImage, right: &LinearImage) -> LinearImage {
    let pixels =
        left.pixels.iter().zip(&right.pixels).map(|(l, r)| anaglyph_pixel(*l, *r)).collect();
    LinearImage { pixels, ..*left }
}

/// The difference, in code values, that has the last of the colours.
const FULL_DIFFERENCE: f32 = 64.0;

/// Colours of no difference to [`FULL_DIFFERENCE`], of even steps of lightness: black, violet, red,
/// orange, light yellow.
const FALSE_COLOURS: [[f32; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [66.0, 10.0, 104.0],
    [147.0, 38.0, 103.0],
    [221.0, 81.0, 58.0],
    [252.0, 165.0, 10.0],
    [252.0, 255.0, 164.0],
];

/// The largest absolute difference among the channels of each pixel, in false colour.
fn difference(left: &EncodedImage, right: &EncodedImage) -> EncodedImage {
    let color = |(l, r): (&[u8], &[u8])| {
        let largest = l.iter().zip(r).map(|(l, r)| l.abs_diff(*r)).max().unwrap_or_default();
        let steps = (FALSE_COLOURS.len() - 1) as f32;
        let at = (f32::from(largest) / FULL_DIFFERENCE).min(1.0) * steps;
        let step = (at as usize).min(FALSE_COLOURS.len() - 2);
        let [from, to] = [FALSE_COLOURS[step], FALSE_COLOURS[step + 1]];
        let part = at - step as f32;
        std::array::from_fn::<u8, 3, _>(|c| (from[c] + part * (to[c] - from[c])).round() as u8)
    };
    let pixels = left.bytes.chunks_exact(3).zip(right.bytes.chunks_exact(3));
    EncodedImage { bytes: pixels.flat_map(color).collect(), ..*left }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Transfer;

    fn image(pixels: &[[f32; 3]]) -> LinearImage {
        LinearImage { width: 2, height: pixels.len() as u32 / 2, pixels: pixels.to_vec() }
    }

    fn compose(layout: Layout, left: &LinearImage, right: &LinearImage) -> EncodedImage {
        layout.compose([left, right], |image| image.encode(0.0, Transfer::Gamma(1.0)))
    }

    const BLACK: [f32; 3] = [0.0; 3];
    const WHITE: [f32; 3] = [1.0; 3];

    #[test]
    fn every_layout_has_the_size_it_says_and_each_eye_in_its_place() {
        let (left, right) = (image(&[BLACK; 4]), image(&[WHITE, BLACK, WHITE, BLACK]));
        let red = |layout| {
            let frame = compose(layout, &left, &right);
            assert_eq!([frame.width, frame.height], layout.size_px([2, 2]), "{layout:?}");
            frame.bytes.chunks_exact(3).map(|pixel| pixel[0]).collect::<Vec<_>>()
        };
        assert_eq!(red(Layout::SideBySide), [0, 0, 255, 0, 0, 0, 255, 0]);
        assert_eq!(red(Layout::HalfWidth), [0, 128, 0, 128]);
        assert_eq!(red(Layout::TopBottom), [0, 0, 0, 0, 255, 0, 255, 0]);
        assert_eq!(red(Layout::Difference), [252, 0, 252, 0]);
    }

    /// Grey stays near grey in the anaglyph, the left eye goes to red, the right to green and blue.
    #[test]
    fn the_anaglyph_separates_the_eyes() {
        let (dark, light) = (image(&[BLACK; 2]), image(&[WHITE; 2]));
        let pixel = |l, r| compose(Layout::Anaglyph, l, r).bytes[..3].to_vec();
        assert_eq!(pixel(&light, &light), [255, 255, 255]);
        assert_eq!(pixel(&light, &dark), [255, 0, 0]);
        assert_eq!(pixel(&dark, &light), [0, 255, 255]);
        assert_eq!(pixel(&dark, &dark), [0, 0, 0]);
    }
}

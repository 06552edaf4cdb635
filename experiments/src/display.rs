//! What a display does to a frame: which code value goes out for which, and which pixel of which eye's
//! image is to be seen where. Plain arithmetic, and the truth that the window's shader is held against.

pub mod cards;
pub mod check;
pub mod fusion;

use shutterlab_data_schema::DisplayProfile;
use shutterlab_data_schema::display::{DisplayTransfer, Level, StereoMode};
use shutterlab_data_schema::response::Resampling;
use shutterlab_stimuli::Stimulus;
use shutterlab_stimuli::frames::{EncodedImage, Transfer};
use shutterlab_stimuli::stereo::{Layout, anaglyph_pixel};

/// What code values mean on their way from the stimulus to the display. Light is linear, from 0 for the
/// display's black to 1 for its white.
#[derive(Clone, Debug, PartialEq)]
pub struct Codes {
    /// Light that each code value of the stimulus stands for.
    pub light: [f32; 256],
    /// Light that the display emits for each code value; it increases.
    pub emitted: [f32; 256],
    /// Code value that goes out for each one of the stimulus.
    pub sent: [u8; 256],
}

impl Codes {
    /// For stimuli encoded with `stimulus` on the display of `profile`.
    pub fn new(stimulus: Transfer, profile: &DisplayProfile) -> Self {
        let light = codes().map(|code| stimulus.decode(code));
        let emitted = match &profile.transfer {
            DisplayTransfer::Identity {} => light,
            DisplayTransfer::Gamma { gamma } => codes().map(|code| code.powf(*gamma as f32)),
            DisplayTransfer::Table { .. } => measured(&profile.levels),
        };
        let mut codes = Self { light, emitted, sent: [0; 256] };
        codes.sent = light.map(|light| codes.encode(light));
        codes
    }

    /// The code value for which the display's light is nearest to `light`.
    pub fn encode(&self, light: f32) -> u8 {
        let above = self.emitted.partition_point(|emitted| *emitted <= light);
        match above {
            0 => 0,
            256 => 255,
            _ => {
                let [below, above_light] = [self.emitted[above - 1], self.emitted[above]];
                let nearer = light - below >= above_light - light;
                (above - 1 + usize::from(nearer)) as u8
            }
        }
    }
}

/// All code values as parts of the largest.
fn codes() -> [f32; 256] {
    std::array::from_fn(|code| code as f32 / 255.0)
}

/// Exponent by which light is made about proportional to code values, so that what lies between two
/// measured codes can be taken from the line through them: with 0 and 255 alone a display of this gamma
/// results.
const USUAL_GAMMA: f64 = 2.2;

/// Light of each code value by a table that begins with code 0 and ends with 255; darkness without one.
fn measured(levels: &[Level]) -> [f32; 256] {
    let [first, .., last] = levels else { return codes() };
    let range = last.luminance_cd_m2 - first.luminance_cd_m2;
    let light = |level: &Level| (level.luminance_cd_m2 - first.luminance_cd_m2) / range;
    std::array::from_fn(|code| {
        let above = levels.partition_point(|level| usize::from(level.code) < code);
        let to = &levels[above.min(levels.len() - 1)];
        if usize::from(to.code) == code {
            return light(to) as f32;
        }
        let from = &levels[above - 1];
        let part = (code as f64 - f64::from(from.code)) / f64::from(to.code - from.code);
        let [a, b] = [from, to].map(|level| light(level).powf(1.0 / USUAL_GAMMA));
        (a + part * (b - a)).powf(USUAL_GAMMA) as f32
    })
}

/// Where the pixels of one kind of frames are to be seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrangement {
    /// How two eyes' images are shown; none if a frame is to be seen as it is stored.
    pub mode: Option<StereoMode>,
    /// Pixels of one image in the stored frame: of one eye, or the whole frame.
    pub stored_px: [u32; 2],
    /// Image pixels of it to be seen: half as wide if it is squeezed.
    pub image_px: [u32; 2],
    /// Physical pixels that it takes.
    pub view_px: [u32; 2],
    /// Physical pixels of all that is drawn in a window.
    pub size_px: [u32; 2],
    /// Physical pixels per image pixel.
    pub magnification: f32,
    /// Whether neighbours are mixed where the magnification is no whole number.
    pub linear: bool,
}

/// Whether the frames of `stimulus` hold two eyes' images that a display can arrange in its own way.
pub fn is_side_by_side(stimulus: &Stimulus) -> bool {
    stimulus.stereo.as_ref().is_some_and(|stereo| stereo.layout == Layout::SideBySide)
}

/// How the frames of `stimulus` are drawn on the display of `profile`.
pub fn arrangement(stimulus: &Stimulus, profile: &DisplayProfile) -> Arrangement {
    Arrangement::new(profile, stimulus.frame_size_px(), is_side_by_side(stimulus))
}

impl Arrangement {
    /// Of frames of `frame_px` on the display of `profile`; `stereo` if the left half of a frame is the
    /// left eye's image and the right half the right eye's.
    pub fn new(profile: &DisplayProfile, frame_px: [u32; 2], stereo: bool) -> Self {
        use StereoMode::{Crossed, HalfWidth, SideBySide, TopBottom};
        let [width, height] = frame_px;
        let mode = stereo.then_some(profile.stereo.mode);
        let stored_px = if stereo { [width / 2, height] } else { frame_px };
        let halves = if mode == Some(HalfWidth) { 2 } else { 1 };
        let image_px = [stored_px[0] / halves, height];
        let magnified = |px: u32| (f64::from(px) * profile.magnification).round() as u32;
        let view_px = image_px.map(magnified);
        let [columns, rows] = match mode {
            Some(SideBySide | Crossed | HalfWidth) => [2, 1],
            Some(TopBottom) => [1, 2],
            _ => [1, 1],
        };
        Self {
            mode,
            stored_px,
            image_px,
            view_px,
            size_px: [columns * view_px[0], rows * view_px[1]],
            magnification: profile.magnification as f32,
            linear: profile.resampling() == Resampling::Linear,
        }
    }

    /// Where the middles of the images are, for each eye, from the middle of all that is drawn: in
    /// physical pixels, right and down.
    pub fn middles(&self) -> Vec<[f32; 2]> {
        use StereoMode::{Crossed, HalfWidth, SideBySide, TopBottom};
        let [x, y] = self.view_px.map(|px| px as f32 / 2.0);
        match self.mode {
            Some(SideBySide | Crossed | HalfWidth) => vec![[-x, 0.0], [x, 0.0]],
            Some(TopBottom) => vec![[0.0, -y], [0.0, y]],
            _ => vec![[0.0, 0.0]],
        }
    }

    /// Whether a physical pixel shows anything but one image pixel.
    pub fn mixes(&self) -> bool {
        self.linear || matches!(self.mode, Some(StereoMode::HalfWidth | StereoMode::Anaglyph))
    }
}

/// What is to be seen of `frame` in `window`, 0 or 1, if the drawing begins in row `first_row` of the
/// screen.
pub fn compose(
    frame: &EncodedImage,
    arrangement: &Arrangement,
    codes: &Codes,
    window: u32,
    first_row: u32,
) -> EncodedImage {
    let [width, height] = arrangement.size_px;
    let view = View { frame, arrangement, codes };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    let bytes = pixels.flat_map(|place| view.pixel(place, window, first_row)).collect();
    EncodedImage { width, height, bytes }
}

struct View<'a> {
    frame: &'a EncodedImage,
    arrangement: &'a Arrangement,
    codes: &'a Codes,
}

impl View<'_> {
    fn pixel(&self, [x, y]: [u32; 2], window: u32, first_row: u32) -> [u8; 3] {
        let [width, height] = self.arrangement.view_px;
        let ([column, row], place) = ([x / width, y / height], [x % width, y % height]);
        let eye = match self.arrangement.mode {
            None => 0,
            Some(StereoMode::SideBySide | StereoMode::HalfWidth) => column,
            Some(StereoMode::Crossed) => 1 - column,
            Some(StereoMode::TopBottom) => row,
            Some(StereoMode::RowInterleaved) => (first_row + y) % 2,
            Some(StereoMode::TwoWindows) => window,
            Some(StereoMode::Anaglyph) => {
                let light = anaglyph_pixel(self.light(0, place), self.light(1, place));
                return light.map(|light| self.codes.encode(light));
            }
        };
        if self.arrangement.mixes() {
            self.light(eye, place).map(|light| self.codes.encode(light))
        } else {
            let by = self.arrangement.magnification as u32;
            self.stored(eye, place.map(|at| at / by)).map(|code| self.codes.sent[usize::from(code)])
        }
    }

    /// Light of an eye's image at a physical pixel of its view.
    fn light(&self, eye: u32, place: [u32; 2]) -> [f32; 3] {
        let by = self.arrangement.magnification;
        if !self.arrangement.linear {
            return self.image(eye, place.map(|place| place / by as u32));
        }
        let axis = |i: usize| {
            let last = self.arrangement.image_px[i] - 1;
            let at = ((place[i] as f32 + 0.5) / by - 0.5).clamp(0.0, last as f32);
            let from = at.floor();
            ([from as u32, (from as u32 + 1).min(last)], at - from)
        };
        let ([left, right], across) = axis(0);
        let ([top, bottom], down) = axis(1);
        let row = |y| mix(self.image(eye, [left, y]), self.image(eye, [right, y]), across);
        mix(row(top), row(bottom), down)
    }

    /// Light of an eye's image at an image pixel.
    fn image(&self, eye: u32, [x, y]: [u32; 2]) -> [f32; 3] {
        let light = |x| self.stored(eye, [x, y]).map(|code| self.codes.light[usize::from(code)]);
        match self.arrangement.mode {
            Some(StereoMode::HalfWidth) => mix(light(2 * x), light(2 * x + 1), 0.5),
            _ => light(x),
        }
    }

    /// Code values of an eye's image at a stored pixel.
    fn stored(&self, eye: u32, [x, y]: [u32; 2]) -> [u8; 3] {
        let column = x + eye * self.arrangement.stored_px[0];
        let at = 3 * (y as usize * self.frame.width as usize + column as usize);
        [self.frame.bytes[at], self.frame.bytes[at + 1], self.frame.bytes[at + 2]]
    }
}

fn mix(a: [f32; 3], b: [f32; 3], part: f32) -> [f32; 3] {
    std::array::from_fn(|c| a[c] + part * (b[c] - a[c]))
}

#[cfg(test)]
mod tests;

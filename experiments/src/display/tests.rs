//! Codes and places of pixels against the stimuli's own arithmetic and published values.

use super::*;
use shutterlab_data_schema::display::StereoOutput;
use shutterlab_stimuli::LinearImage;

pub(crate) fn profile(transfer: DisplayTransfer) -> DisplayProfile {
    DisplayProfile { transfer, ..DisplayProfile::identity() }
}

pub(crate) fn stereo(mode: StereoMode, magnification: f64) -> DisplayProfile {
    let stereo = StereoOutput { mode, second_output: None };
    DisplayProfile { stereo, magnification, ..DisplayProfile::identity() }
}

/// A frame without two equal pixels side by side.
pub(crate) fn frame(width: u32, height: u32) -> EncodedImage {
    let bytes = (0..3 * width * height).map(|i| (i * 37 + i * i / 11) as u8).collect();
    EncodedImage { width, height, bytes }
}

fn shown(frame: &EncodedImage, profile: &DisplayProfile, window: u32) -> EncodedImage {
    let arrangement = Arrangement::new(profile, [frame.width, frame.height], true);
    let codes = Codes::new(Transfer::Srgb, profile);
    let shown = compose(frame, &arrangement, &codes, window, 0);
    assert_eq!([shown.width, shown.height], arrangement.size_px);
    shown
}

fn part(image: &EncodedImage, x: u32, y: u32, width: u32, height: u32) -> Vec<u8> {
    let row = |y: u32| &image.bytes[3 * (y * image.width + x) as usize..][..3 * width as usize];
    (y..y + height).flat_map(row).copied().collect()
}

/// A table of a display of this gamma, whose black is not dark.
fn table(gamma: f64, codes: impl Iterator<Item = u8>) -> DisplayProfile {
    let level =
        |code| Level { code, luminance_cd_m2: 0.4 + 119.6 * (f64::from(code) / 255.0).powf(gamma) };
    let levels = codes.map(level).collect();
    DisplayProfile { levels, ..profile(DisplayTransfer::Table { file: "t.csv".into() }) }
}

#[test]
fn the_identity_changes_no_code_value() {
    for transfer in [Transfer::Srgb, Transfer::Gamma(2.2), Transfer::Gamma(1.0)] {
        let codes = Codes::new(transfer, &DisplayProfile::identity());
        assert!(codes.sent.iter().copied().eq(0..=255), "{transfer:?}");
    }
}

/// IEC 61966-2-1 says which light an sRGB code stands for; a display of gamma 2.2 needs its 2.2nd root.
#[test]
fn srgb_on_a_display_of_gamma_2_2_keeps_its_light() {
    let codes = Codes::new(Transfer::Srgb, &profile(DisplayTransfer::Gamma { gamma: 2.2 }));
    for (code, light) in [(0_u8, 0.0_f64), (128, 0.215_861), (188, 0.502_886), (255, 1.0)] {
        let expected = 255.0 * light.powf(1.0 / 2.2);
        let sent = f64::from(codes.sent[usize::from(code)]);
        assert!((sent - expected).abs() <= 0.51, "{code}: {sent} for {expected}");
    }
}

#[test]
fn tables_are_undone_where_they_are_measured_and_between() {
    let every =
        |step: usize| (0..=255).step_by(step).chain([255].repeat(usize::from(255 % step != 0)));
    for (step, gamma) in [(1, 1.8), (1, 2.4), (15, 1.8), (32, 2.6)] {
        let codes = Codes::new(Transfer::Srgb, &table(gamma, every(step)));
        assert!(codes.sent.is_sorted());
        assert_eq!((codes.sent[0], codes.sent[255]), (0, 255));
        // Below, the display's steps are larger than the light asked for.
        for code in 24..=255_usize {
            let expected = 255.0 * f64::from(codes.light[code]).powf(1.0 / gamma);
            let off = (f64::from(codes.sent[code]) - expected).abs();
            assert!(
                off <= 0.51 + if step == 1 { 0.0 } else { 0.6 },
                "{step}, {gamma}, {code}: {off}"
            );
        }
    }
}

#[test]
fn each_mode_puts_the_eyes_in_their_places() {
    let (w, h) = (10, 6);
    let frame = frame(2 * w, h);
    let (left, right) = (part(&frame, 0, 0, w, h), part(&frame, w, 0, w, h));
    let shown = |mode, window| shown(&frame, &stereo(mode, 1.0), window);
    assert_eq!(shown(StereoMode::SideBySide, 0), frame);
    let crossed = shown(StereoMode::Crossed, 0);
    assert_eq!(
        [part(&crossed, 0, 0, w, h), part(&crossed, w, 0, w, h)],
        [right.clone(), left.clone()]
    );
    assert_eq!(shown(StereoMode::TopBottom, 0).bytes, [left.as_slice(), &right].concat());
    assert_eq!(shown(StereoMode::TwoWindows, 0).bytes, left);
    assert_eq!(shown(StereoMode::TwoWindows, 1).bytes, right);
    // Even rows of the screen are the left eye's, wherever the image begins.
    let row = |eye: &[u8], y: usize| eye[3 * 10 * y..][..30].to_vec();
    let profile = stereo(StereoMode::RowInterleaved, 1.0);
    let arrangement = Arrangement::new(&profile, [2 * w, h], true);
    let codes = Codes::new(Transfer::Srgb, &profile);
    for first_row in [100, 101] {
        let image = compose(&frame, &arrangement, &codes, 0, first_row);
        for y in 0..h as usize {
            let eye = if (first_row as usize + y).is_multiple_of(2) { &left } else { &right };
            assert_eq!(row(&image.bytes, y), row(eye, y), "{first_row} + {y}");
        }
    }
}

/// The stimuli's own layouts of the same two images, made before encoding.
#[test]
fn mixed_modes_agree_with_the_layouts_of_the_stimuli() {
    let linear = |shift: usize| LinearImage {
        width: 8,
        height: 5,
        pixels: (0..40)
            .map(|i| [0, 7, 19].map(|c| ((i * 13 + c + shift) % 41) as f32 / 40.0))
            .collect(),
    };
    let encode = |image: &LinearImage| image.encode(0.0, Transfer::Srgb);
    let (left, right) = (linear(0), linear(5));
    let stored = Layout::SideBySide.compose([&left, &right], encode);
    for (mode, layout) in
        [(StereoMode::HalfWidth, Layout::HalfWidth), (StereoMode::Anaglyph, Layout::Anaglyph)]
    {
        let expected = layout.compose([&left, &right], encode);
        let shown = shown(&stored, &stereo(mode, 1.0), 0);
        assert_eq!([shown.width, shown.height], [expected.width, expected.height]);
        // The stored codes are rounded once more; near black a step of light is many codes.
        for (a, b) in shown.bytes.iter().zip(&expected.bytes) {
            assert!(a.abs_diff(*b) <= 2 || (*a).max(*b) < 32, "{mode:?}: {a} {b}");
        }
    }
}

#[test]
fn whole_magnifications_repeat_pixels_and_others_mix_them_within_an_eye() {
    let doubled = shown(&frame(8, 3), &stereo(StereoMode::Crossed, 2.0), 0);
    let once = shown(&frame(8, 3), &stereo(StereoMode::Crossed, 1.0), 0);
    for (x, y) in [(0, 0), (7, 2), (8, 3), (15, 5)] {
        assert_eq!(part(&doubled, x, y, 1, 1), part(&once, x / 2, y / 2, 1, 1));
    }
    // A white and a black half stay so up to the edge between them: no eye sees the other's light.
    let bytes = (0..3 * 8 * 2).map(|i| if i / 3 % 8 < 4 { 255 } else { 0 }).collect();
    let halves = EncodedImage { width: 8, height: 2, bytes };
    let shown = shown(&halves, &stereo(StereoMode::SideBySide, 1.5), 0);
    assert_eq!([shown.width, shown.height], [12, 3]);
    assert!(
        shown.bytes.iter().enumerate().all(|(i, b)| *b == if i / 3 % 12 < 6 { 255 } else { 0 })
    );
    // Half the light of white between white and black, not half the code.
    let pair = EncodedImage { width: 2, height: 1, bytes: vec![0, 0, 0, 255, 255, 255] };
    let profile = stereo(StereoMode::SideBySide, 1.5);
    let arrangement = Arrangement::new(&profile, [2, 1], false);
    let mixed = compose(&pair, &arrangement, &Codes::new(Transfer::Srgb, &profile), 0, 0);
    assert_eq!(part(&mixed, 1, 0, 1, 1), [188; 3]);
}

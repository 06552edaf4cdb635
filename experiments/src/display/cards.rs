//! Cards to look at: does the display make the light that its profile says, and is it as large? Both are
//! pictures of code values that go out as they are, one picture pixel to one physical pixel.

use super::Codes;
use shutterlab_data_schema::display::Screen;
use shutterlab_stimuli::frames::EncodedImage;

/// Code value around the cards: that of the window.
const GREY: u8 = 128;
/// Code value of lines.
const INK: u8 = 16;

/// Pixels along a side of a field of the gamma card, of the even square in it, and between fields.
const FIELD_PX: u32 = 128;
const SQUARE_PX: u32 = 64;
const GAP_PX: u32 = 16;

/// A pattern of the gamma card: how much of its light is on, and which of its pixels.
type Pattern = (f32, fn(u32, u32) -> bool);
const PATTERNS: [Pattern; 4] = [
    (0.5, |_, y| y.is_multiple_of(2)),
    (0.5, |x, y| (x + y).is_multiple_of(2)),
    (0.25, |_, y| y.is_multiple_of(4)),
    (0.75, |_, y| !y.is_multiple_of(4)),
];
/// Channels of the columns: white, red, green, blue.
const CHANNELS: [[u8; 3]; 4] = [[1, 1, 1], [1, 0, 0], [0, 1, 0], [0, 0, 1]];

/// Patterns of black and full light, each around a square of the code value that should be as bright: in
/// rows half the light in lines, half in a checkerboard, a quarter and three quarters in lines; in columns
/// white, red, green and blue. From afar each square should vanish.
pub fn gamma_card(codes: &Codes) -> EncodedImage {
    let side = |fields: usize| fields as u32 * (FIELD_PX + GAP_PX) + GAP_PX;
    let (width, height) = (side(CHANNELS.len()), side(PATTERNS.len()));
    let pixel = |x: u32, y: u32| {
        let ([column, row], [x, y]) =
            ([x, y].map(|at| at / (FIELD_PX + GAP_PX)), [x, y].map(within));
        let (Some(x), Some(y)) = (x, y) else { return [GREY; 3] };
        let (part, is_on) = PATTERNS[row as usize];
        let margin = (FIELD_PX - SQUARE_PX) / 2;
        let in_square = [x, y].iter().all(|at| (margin..margin + SQUARE_PX).contains(at));
        let code = match (in_square, is_on(x, y)) {
            (true, _) => codes.encode(part),
            (false, true) => 255,
            (false, false) => 0,
        };
        CHANNELS[column as usize].map(|channel| channel * code)
    };
    picture(width, height, pixel)
}

/// Place in the field, if `at` is in one and not between two.
fn within(at: u32) -> Option<u32> {
    (at % (FIELD_PX + GAP_PX)).checked_sub(GAP_PX)
}

/// Width and height of an identification card (ISO/IEC 7810, ID-1), in mm.
const CARD_MM: [f64; 2] = [85.60, 53.98];
/// Length of the ruler, and from the outline to it, in mm.
const RULER_MM: u32 = 100;
const APART_MM: f64 = 8.0;

/// The outline of a credit card and below it a ruler of 100 mm, with marks at every millimetre, as large
/// as they are if `screen` says what is true.
pub fn size_card(screen: &Screen) -> EncodedImage {
    let per_mm = [
        f64::from(screen.width_px) / screen.width_mm,
        f64::from(screen.height_px) / screen.height_mm,
    ];
    let px = |mm: f64, axis: usize| (mm * per_mm[axis]).round() as u32;
    let line = px(0.4, 0).max(1);
    let card = [px(CARD_MM[0], 0), px(CARD_MM[1], 1)];
    let ruler_y = card[1] + px(APART_MM, 1);
    let width = px(f64::from(RULER_MM), 0) + 1;
    let mut ink = vec![];
    let mut fill = |x: u32, y: u32, w: u32, h: u32| ink.push([x, y, x + w, y + h]);
    fill(0, 0, card[0], line);
    fill(0, card[1] - line, card[0], line);
    fill(0, 0, line, card[1]);
    fill(card[0] - line, 0, line, card[1]);
    fill(0, ruler_y, width, 1);
    let mut bottom = ruler_y;
    for mm in 0..=RULER_MM {
        let length = match mm {
            mm if mm.is_multiple_of(10) => 8.0,
            mm if mm.is_multiple_of(5) => 6.0,
            _ => 3.0,
        };
        fill(px(f64::from(mm), 0), ruler_y, 1, px(length, 1));
        bottom = bottom.max(ruler_y + px(length, 1));
    }
    let mut card = picture(width, bottom, |_, _| [GREY; 3]);
    for [left, top, right, bottom] in ink {
        for y in top..bottom {
            let row = 3 * (y * width) as usize;
            card.bytes[row + 3 * left as usize..row + 3 * right as usize].fill(INK);
        }
    }
    card
}

fn picture(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [u8; 3]) -> EncodedImage {
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let bytes = places.flat_map(|(x, y)| pixel(x, y)).collect();
    EncodedImage { width, height, bytes }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shutterlab_data_schema::DisplayProfile;
    use shutterlab_stimuli::frames::Transfer;

    fn at(image: &EncodedImage, x: u32, y: u32) -> [u8; 3] {
        let at = 3 * (y * image.width + x) as usize;
        [image.bytes[at], image.bytes[at + 1], image.bytes[at + 2]]
    }

    /// The light of a pattern is that of its square, by the standard's curve: 188 for a half.
    #[test]
    fn patterns_and_squares_have_the_same_light() {
        let card = gamma_card(&Codes::new(Transfer::Srgb, &DisplayProfile::identity()));
        let field = |i: u32| GAP_PX + i * (FIELD_PX + GAP_PX);
        for (row, square) in [188_u8, 188, 137, 225].into_iter().enumerate() {
            for (column, channels) in CHANNELS.into_iter().enumerate() {
                let (x, y) = (field(column as u32), field(row as u32));
                assert_eq!(at(&card, x + 64, y + 64), channels.map(|channel| channel * square));
                let light = |x, y| {
                    at(&card, x, y).map(|code| Transfer::Srgb.decode(f32::from(code) / 255.0))
                };
                let mean: f32 = (0..16 * 16)
                    .map(|i| light(x + i % 16, y + i / 16)[column.max(1) - 1])
                    .sum::<f32>()
                    / 256.0;
                let expected = Transfer::Srgb.decode(f32::from(square) / 255.0);
                assert!((mean - expected).abs() < 0.005, "{row} {column}: {mean} {expected}");
            }
        }
        assert_eq!(at(&card, GAP_PX - 1, 40), [GREY; 3]);
    }

    /// Four physical pixels to a millimetre: 342 × 216 of them for the card, 400 for the ruler.
    #[test]
    fn the_size_card_is_as_large_as_it_says() {
        let screen = Screen {
            width_mm: 480.0,
            height_mm: 270.0,
            width_px: 1920,
            height_px: 1080,
            distance_cm: 60.0,
        };
        let card = size_card(&screen);
        let is_ink = |x, y| at(&card, x, y) == [INK; 3];
        let middle_row: Vec<u32> = (0..card.width).filter(|x| is_ink(*x, 100)).collect();
        assert_eq!((middle_row[0], middle_row[middle_row.len() - 1]), (0, 341));
        let middle_column: Vec<u32> = (0..220).filter(|y| is_ink(170, *y)).collect();
        assert_eq!((middle_column[0], middle_column[middle_column.len() - 1]), (0, 215));
        // 11 long marks, 10 of middle length more, all of one millimetre.
        let marks = |mm: u32| (0..card.width).filter(|x| is_ink(*x, 216 + 32 + 4 * mm)).count();
        assert_eq!((marks(1), marks(4), marks(7)), (101, 21, 11));
        let long: Vec<u32> = (0..card.width).filter(|x| is_ink(*x, 216 + 32 + 28)).collect();
        assert_eq!((long[0], long[10]), (0, 400));
    }
}

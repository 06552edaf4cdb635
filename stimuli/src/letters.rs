//! Writing in images.

use crate::frames::EncodedImage;
use font8x8::{BASIC_FONTS, UnicodeFonts};

/// Width and height of a letter at scale 1.
pub const LETTER_PX: usize = 8;

/// Writes `text` in black from `[left, top]` on, `scale` times as large as the letters are. What lies outside of
/// the image is left out, and so are letters beyond ASCII.
pub fn write(image: &mut EncodedImage, [left, top]: [usize; 2], text: &str, scale: usize) {
    let [width, height] = [image.width, image.height].map(|side| side as usize);
    for (place, letter) in text.chars().enumerate() {
        let rows = BASIC_FONTS.get(letter).unwrap_or_default();
        let start = left + place * LETTER_PX * scale;
        for y in 0..LETTER_PX * scale {
            for x in (0..LETTER_PX * scale).filter(|x| rows[y / scale] >> (x / scale) & 1 == 1) {
                if start + x < width && top + y < height {
                    image.bytes[3 * ((top + y) * width + start + x)..][..3].fill(0);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The places of black pixels after writing an L on white.
    fn black(scale: usize) -> Vec<[usize; 2]> {
        let mut image = EncodedImage { width: 16, height: 16, bytes: vec![255; 3 * 16 * 16] };
        write(&mut image, [0, 0], "L", scale);
        (0..16 * 16).filter(|k| image.bytes[3 * k] == 0).map(|k| [k % 16, k / 16]).collect()
    }

    #[test]
    fn letters_are_drawn_upright() {
        let black = black(1);
        let in_row = |row: usize| black.iter().filter(|[_, y]| *y == row).count();
        // The bar of the L is below.
        assert!(in_row(6) > in_row(1) && in_row(1) > 0);
        let left = black.iter().filter(|[x, _]| *x < 4).count();
        assert!(left > black.len() - left);
    }

    #[test]
    fn letters_grow_and_end_at_the_border() {
        let large: Vec<_> = black(1).iter().map(|at| at.map(|v| 2 * v)).collect();
        let found = black(2);
        assert!(found.len() == 4 * large.len() && large.iter().all(|at| found.contains(at)));
        let mut image = EncodedImage { width: 3, height: 2, bytes: vec![255; 18] };
        write(&mut image, [1, 1], "LL", 3);
    }
}

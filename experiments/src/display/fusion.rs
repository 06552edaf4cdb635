//! The fusion card: a random-dot stereogram (Julesz 1960) that tells whether the two eyes' images reach
//! the right eyes and are fused. One of four squares stands in front of the page, the other three behind
//! it, so exchanged eyes show three in front and the wrong answer. Neither eye's image alone shows any.

use crate::random::Stream;
use shutterlab_stimuli::frames::EncodedImage;

/// A card.
#[derive(Clone, Debug, PartialEq)]
pub struct FusionCard {
    /// The left eye's image and the right eye's beside it.
    pub frame: EncodedImage,
    /// Where the square is that stands in front.
    pub target: Direction,
}

/// A side of the card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Direction {
    Up,
    Down,
    Left,
    Right,
}

impl Direction {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Up, Self::Down, Self::Left, Self::Right];

    /// Left and top of its square, in dots.
    fn square(self) -> [usize; 2] {
        let (near, middle, far) = (MARGIN, (DOTS - SQUARE) / 2, DOTS - SQUARE - MARGIN);
        match self {
            Self::Up => [middle, near],
            Self::Down => [middle, far],
            Self::Left => [near, middle],
            Self::Right => [far, middle],
        }
    }
}

/// Dots along a side of the card, and of a square.
const DOTS: usize = 80;
const SQUARE: usize = 20;
/// Dots from the edge of the card to a square.
const MARGIN: usize = 6;
/// Dots by which a square is shifted in each eye, in opposite directions.
const SHIFT: usize = 1;
/// Image pixels along a side of a dot: an even number, so that a squeezed image keeps its dots whole.
const DOT_PX: usize = 4;
/// Code values of the dots.
const DARK_LIGHT: [u8; 2] = [32, 224];

impl FusionCard {
    /// The card of `seed`.
    pub fn new(seed: u64) -> Self {
        let mut stream = Stream::new(seed);
        let target = Direction::ALL[stream.below(Direction::ALL.len())];
        let mut dots = || DARK_LIGHT[stream.below(2)];
        let mut left: Vec<u8> = (0..DOTS * DOTS).map(|_| dots()).collect();
        let mut right = left.clone();
        for direction in Direction::ALL {
            // What is in front of the page is seen further right by the left eye.
            let [left_shift, right_shift] =
                if direction == target { [2 * SHIFT, 0] } else { [0, 2 * SHIFT] };
            let [x, y] = direction.square();
            for (row, column) in (0..SQUARE * SQUARE).map(|i| (i / SQUARE, i % SQUARE)) {
                let dot = dots();
                let at = (y + row) * DOTS + x - SHIFT + column;
                left[at + left_shift] = dot;
                right[at + right_shift] = dot;
            }
        }
        let side = DOTS * DOT_PX;
        let dot = |eye: &[u8], x: usize, y: usize| [eye[y / DOT_PX * DOTS + x / DOT_PX]; 3];
        let row = |y: usize| {
            let eyes = [&left, &right].into_iter();
            eyes.flat_map(move |eye| (0..side).flat_map(move |x| dot(eye, x, y)))
                .collect::<Vec<u8>>()
        };
        let bytes = (0..side).flat_map(row).collect();
        let (width, height) = (2 * side as u32, side as u32);
        Self { frame: EncodedImage { width, height, bytes }, target }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The dots of each eye, true for light ones.
    fn eyes(card: &FusionCard) -> [Vec<bool>; 2] {
        let dot = |eye: usize, i: usize| {
            let (x, y) = (DOT_PX * (eye * DOTS + i % DOTS), DOT_PX * (i / DOTS));
            card.frame.bytes[3 * (y * card.frame.width as usize + x)] == DARK_LIGHT[1]
        };
        [0, 1].map(|eye| (0..DOTS * DOTS).map(|i| dot(eye, i)).collect())
    }

    /// Dots that agree between the eyes in the square of `direction`, if the left eye's are taken as
    /// much further right; a half by chance.
    fn agreement([left, right]: &[Vec<bool>; 2], direction: Direction, disparity: isize) -> f64 {
        let [x, y] = direction.square();
        let (inner, margin) = (SQUARE - 8, 4);
        let dots = (0..inner * inner).map(|i| (y + margin + i / inner, x + margin + i % inner));
        let same = dots.filter(|(y, x)| {
            left[y * DOTS + x.strict_add_signed(disparity)] == right[y * DOTS + x]
        });
        same.count() as f64 / (inner * inner) as f64
    }

    #[test]
    fn only_the_target_stands_in_front() {
        let mut targets = vec![];
        for seed in 0..40 {
            let card = FusionCard::new(seed);
            let eyes = eyes(&card);
            for direction in Direction::ALL {
                let expected = if direction == card.target { 2 } else { -2 };
                for disparity in -4..=4 {
                    let found = agreement(&eyes, direction, disparity);
                    assert_eq!(
                        found == 1.0,
                        disparity == expected,
                        "{seed} {direction:?} {disparity}"
                    );
                }
            }
            targets.push(card.target);
        }
        assert!(Direction::ALL.iter().all(|direction| targets.contains(direction)));
    }

    /// Dots are light by a half inside squares and outside, and no row or column of any square differs
    /// from its neighbour outside in more than chance would let it.
    #[test]
    fn one_eye_alone_sees_uniform_dots() {
        let cards = 200;
        // Light dots, and neighbours that agree across each column's left edge, over all cards.
        let mut light = [vec![0_u32; DOTS * DOTS], vec![0; DOTS * DOTS]];
        let mut alike = [vec![0_u32; DOTS], vec![0; DOTS]];
        for seed in 0..cards {
            for (eye, dots) in eyes(&FusionCard::new(seed)).iter().enumerate() {
                for (i, dot) in dots.iter().enumerate() {
                    light[eye][i] += u32::from(*dot);
                    alike[eye][i % DOTS] += u32::from(i % DOTS > 0 && dots[i - 1] == *dot);
                }
            }
        }
        // Six standard deviations of as many throws of a coin.
        let is_fair = |heads: u32, throws: f64| {
            (f64::from(heads) - 0.5 * throws).abs() < 6.0 * 0.5 * throws.sqrt()
        };
        for eye in 0..2 {
            assert!(light[eye].iter().all(|n| is_fair(*n, cards as f64)));
            assert!(alike[eye][1..].iter().all(|n| is_fair(*n, (cards * DOTS as u64) as f64)));
        }
    }
}

//! The fusion card before a session with stereo stimuli.

use super::frames::{Decoded, FrameView};
use super::shell::Shell;
use crate::display::fusion::{Direction, FusionCard};
use crate::run::Sitting;
use jiff::Timestamp;
use shutterlab_data_schema::DisplayProfile;
use shutterlab_stimuli::frames::Transfer;

/// Cards that have to be read rightly in a row, of so many at most: who guesses gets through three
/// times in a hundred.
const IN_A_ROW: u32 = 3;
const MOST_CARDS: u32 = 4;

/// A card in front of the participant, and the session that comes after it.
pub(super) struct Fusion {
    pub sitting: Box<Sitting>,
    pub view: FrameView,
    target: Direction,
    cards: u32,
    in_a_row: u32,
}

impl Fusion {
    pub(super) fn new(sitting: Box<Sitting>, profile: &DisplayProfile, shell: &Shell) -> Self {
        let view = FrameView::new(shell, profile);
        let mut fusion = Self { sitting, view, target: Direction::Up, cards: 0, in_a_row: 0 };
        fusion.next_card(shell);
        fusion
    }

    /// Takes what was read: number `place` of [`Direction::ALL`]. Says whether the participant can read
    /// such cards, once that is clear.
    pub(super) fn read(&mut self, place: usize, shell: &Shell) -> Option<bool> {
        let read = Direction::ALL.get(place);
        let is_right = read == Some(&self.target);
        self.in_a_row = if is_right { self.in_a_row + 1 } else { 0 };
        // The rows say so, too, if the cards are not read.
        let detail = format!("card {}: {read:?}, {:?} is right", self.cards, self.target);
        self.sitting.recorder.note("fusion-card", &detail).ok();
        let (is_read, left) = (self.in_a_row >= IN_A_ROW, MOST_CARDS - self.cards);
        if !is_read && self.in_a_row + left >= IN_A_ROW {
            self.next_card(shell);
            return None;
        }
        Some(is_read)
    }

    fn next_card(&mut self, shell: &Shell) {
        self.cards += 1;
        // Another card each time, and for everybody: the time of day is chance enough.
        let card = FusionCard::new(Timestamp::now().as_nanosecond() as u64);
        self.target = card.target;
        let picture = Decoded::picture(self.cards, &card.frame, Transfer::Srgb, true);
        self.view.upload(shell, picture);
    }
}

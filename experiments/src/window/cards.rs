//! Cards to look at before a display is trusted: light, size, and two eyes.

use super::frames::{Decoded, Draw, FrameView};
use super::pages;
use super::shell::{self, App, Next, Shell, ShellError};
use crate::display::Codes;
use crate::display::cards::{gamma_card, size_card};
use crate::display::fusion::{Direction, FusionCard};
use shutterlab_data_schema::DisplayProfile;
use shutterlab_data_schema::display::DisplayTransfer;
use shutterlab_stimuli::frames::{EncodedImage, Transfer};
use std::time::Instant;
use winit::keyboard::{Key, NamedKey};

/// Shows the cards of the display of `profile` until the last one is left. Must be called from the main
/// thread, once per process.
///
/// # Errors
/// There is no window, or it failed.
pub fn show(profile: &DisplayProfile) -> Result<(), ShellError> {
    let mut app = Cards { profile, cards: cards(profile), at: 0, views: vec![] };
    shell::run("Shutterlab – cards", profile, &mut app)
}

struct Card {
    picture: Option<EncodedImage>,
    /// Whether the picture is one of two eyes and goes through the profile; if not, its code values go
    /// out as they are.
    is_stereo: bool,
    words: String,
}

/// All cards, one after the other.
fn cards(profile: &DisplayProfile) -> Vec<Card> {
    let codes = Codes::new(Transfer::Srgb, profile);
    let assumed = match profile.transfer {
        DisplayTransfer::Identity {} => "The profile has no transfer: sRGB is assumed. ",
        _ => "",
    };
    let gamma = Card {
        picture: Some(gamma_card(&codes)),
        is_stereo: false,
        words: format!(
            "Light. From afar, or with eyes half closed, the even squares should vanish in the patterns \
             around them. {assumed}Half of the light is code {}.",
            codes.encode(0.5)
        ),
    };
    let size = Card {
        picture: profile.screen.as_ref().map(size_card),
        is_stereo: false,
        words: match profile.screen {
            Some(_) => {
                "Size. The outline should be as large as a credit card (85.60 × 53.98 mm), and the \
                        ruler 100 mm long."
            }
            None => "Size. The profile has no [screen]: nobody knows how large anything appears.",
        }
        .into(),
    };
    let fusion = FusionCard::new(1);
    let target = match fusion.target {
        Direction::Up => "upper",
        Direction::Down => "lower",
        Direction::Left => "left",
        Direction::Right => "right",
    };
    let stereo = Card {
        picture: Some(fusion.frame),
        is_stereo: true,
        words: format!(
            "Two eyes ({}). The {target} square should stand in front of the page and the other three \
             behind it; if it is the other way about, the eyes are exchanged.",
            profile.stereo.mode.name()
        ),
    };
    vec![gamma, size, stereo]
}

struct Cards<'a> {
    profile: &'a DisplayProfile,
    cards: Vec<Card>,
    at: usize,
    /// One for each card.
    views: Vec<FrameView>,
}

impl App for Cards<'_> {
    type Error = ShellError;

    fn start(&mut self, shell: &mut Shell) -> Result<(), ShellError> {
        pages::set_style(shell.egui());
        let identity = DisplayProfile::identity();
        for Card { picture, is_stereo, .. } in &self.cards {
            let profile = if *is_stereo { self.profile } else { &identity };
            let mut view = FrameView::new(shell, profile);
            if let Some(picture) = picture {
                let picture = Decoded::picture(0, picture, Transfer::Srgb, *is_stereo);
                view.upload(shell, picture);
            }
            self.views.push(view);
        }
        Ok(())
    }

    fn key(&mut self, key: &Key, _: Instant) -> bool {
        self.at = match key {
            Key::Named(NamedKey::Escape) => self.cards.len(),
            Key::Named(NamedKey::ArrowLeft | NamedKey::ArrowUp) => self.at.saturating_sub(1),
            Key::Named(
                NamedKey::ArrowRight | NamedKey::ArrowDown | NamedKey::Enter | NamedKey::Space,
            ) => self.at + 1,
            _ => return false,
        };
        true
    }

    fn redraw(&mut self, shell: &mut Shell) -> Result<Next, ShellError> {
        let (Some(card), Some(view)) = (self.cards.get(self.at), self.views.get(self.at)) else {
            return Ok(Next::Exit);
        };
        let draw = Draw { sequence: 0, frame: 0, centre: [0, 0] };
        shell.draw(
            |pass, window, window_px| view.paint(pass, window, window_px, &[draw]),
            |ui| pages::caption(ui, &card.words),
        )?;
        Ok(Next::OnEvent)
    }
}

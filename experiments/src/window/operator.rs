//! The operator's pages: which protocol, who, and whether the display fits. They are in English, as the
//! command line is; what participants read is in the protocol.

use super::pages::{
    Action, FIELD, INK, SMALL_POINTS, WARNING, button, column, column_of, large, pair, small,
};
use crate::run::Outcome;
use egui::{Align2, Color32, FontId, RichText, TextEdit, Ui, vec2};
use indexmap::IndexMap;
use shutterlab_data_schema::protocol::ParticipantField;

/// Width of the pages, and height of an option, in points.
const FORM_POINTS: f32 = 900.0;
const OPTION_POINTS: f32 = 28.0;

/// A protocol that can be chosen, or why not.
pub(super) struct Offer {
    /// Its name.
    pub name: String,
    /// What it is about.
    pub title: String,
    /// Why it cannot be run with these stimuli.
    pub obstacle: Option<String>,
}

/// Who is going to answer.
#[derive(Debug, Default)]
pub(super) struct Form {
    /// The participant's code.
    pub code: String,
    /// The option chosen in each of the protocol's fields.
    chosen: Vec<Option<usize>>,
    /// What the keys go to: 0 is the code, n the nth field.
    focus: usize,
    /// What was wrong with the last attempt.
    pub problem: Option<String>,
}

impl Form {
    /// A form with so many fields, for a participant whose code may be known.
    pub(super) fn new(fields: &[ParticipantField], code: String) -> Self {
        let focus = usize::from(!code.is_empty() && !fields.is_empty());
        Self { code, chosen: vec![None; fields.len()], focus, problem: None }
    }

    /// Moves the focus.
    pub(super) fn move_focus(&mut self, by: isize) {
        let places = self.chosen.len() as isize + 1;
        self.focus = (self.focus as isize + by).rem_euclid(places) as usize;
    }

    /// Moves the choice in the focus, if there is one to move.
    pub(super) fn move_choice(&mut self, fields: &[ParticipantField], by: isize) {
        let Some(place) = self.focus.checked_sub(1) else { return };
        if let (Some(field), Some(chosen)) = (fields.get(place), self.chosen.get_mut(place)) {
            let options = field.options.len() as isize;
            let from = chosen.map_or(if by > 0 { -1 } else { options }, |index| index as isize);
            *chosen = Some((from + by).clamp(0, options - 1) as usize);
            self.problem = None;
        }
    }

    /// Whether the keys go to the code.
    pub(super) fn is_in_code(&self) -> bool {
        self.focus == 0
    }

    /// The options chosen, by field.
    ///
    /// # Errors
    /// The label of the first field without a choice.
    pub(super) fn answers(
        &mut self,
        fields: &[ParticipantField],
    ) -> Result<IndexMap<String, String>, String> {
        let mut answers = IndexMap::new();
        for (place, (field, chosen)) in fields.iter().zip(&self.chosen).enumerate() {
            let Some(option) = chosen.and_then(|index| field.options.get(index)) else {
                self.focus = place + 1;
                return Err(format!("Not answered yet: {}", field.label));
            };
            answers.insert(field.key.clone(), option.clone());
        }
        Ok(answers)
    }
}

/// The keys that choose a protocol, in order.
pub(super) const KEYS: &str = "123456789abcdefghijklmnopqrstuvwxyz";

/// The protocols that can be chosen, and their places among all.
pub(super) fn open(offers: &[Offer]) -> impl Iterator<Item = (usize, &Offer)> {
    offers.iter().enumerate().filter(|(_, offer)| offer.obstacle.is_none())
}

/// Asks which protocol.
pub(super) fn choose(ui: &mut Ui, offers: &[Offer]) -> Option<Action> {
    column_of(ui, FORM_POINTS, |ui| {
        large(ui, "Which experiment?");
        ui.add_space(24.0);
        let mut action = None;
        for ((place, Offer { name, title, .. }), key) in open(offers).zip(KEYS.chars()) {
            let label = format!("{name}: {title}");
            action = action.or(button(ui, &label, &key.to_string(), Action::Choose(place)));
            ui.add_space(12.0);
        }
        for Offer { name, obstacle, .. } in offers {
            if let Some(obstacle) = obstacle {
                ui.add_space(6.0);
                small(ui, &format!("{name}: not with these stimuli: {obstacle}"));
            }
        }
        action
    })
}

/// Asks who is going to answer. `summary` says what awaits them, `display` what is known of the display.
pub(super) fn form(
    ui: &mut Ui,
    form: &mut Form,
    fields: &[ParticipantField],
    summary: &str,
    display: &[String],
) -> Option<Action> {
    column_of(ui, FORM_POINTS, |ui| {
        large(ui, "Participant's code");
        small(ui, "Letters and digits, no names.");
        ui.add_space(12.0);
        let field = TextEdit::singleline(&mut form.code)
            .font(FontId::proportional(24.0))
            .char_limit(32)
            .desired_width(300.0)
            .align(Align2::CENTER_CENTER);
        let field = ui.add(field);
        if form.focus == 0 {
            field.request_focus();
        } else {
            field.surrender_focus();
        }
        if field.clicked() {
            form.focus = 0;
        }
        if field.changed() {
            form.problem = None;
        }
        for (place, (field, chosen)) in fields.iter().zip(&mut form.chosen).enumerate() {
            ui.add_space(12.0);
            let label = RichText::new(&field.label).size(SMALL_POINTS);
            let label = if form.focus == place + 1 { label.underline() } else { label };
            ui.horizontal_top(|ui| {
                ui.spacing_mut().interact_size.y = OPTION_POINTS;
                ui.horizontal(|ui| ui.label(label));
                ui.horizontal_wrapped(|ui| {
                    for (index, option) in field.options.iter().enumerate() {
                        if ui.add(self::option(option, *chosen == Some(index))).clicked() {
                            *chosen = Some(index);
                            (form.focus, form.problem) = (place + 1, None);
                        }
                    }
                });
            });
        }
        ui.add_space(20.0);
        if let Some(problem) = &form.problem {
            let words = RichText::new(format!(" {problem} ")).size(SMALL_POINTS);
            ui.label(words.background_color(WARNING));
            ui.add_space(12.0);
        }
        let action = button(ui, "Begin", "Enter", Action::Submit);
        ui.add_space(20.0);
        if !fields.is_empty() {
            small(ui, "Up and down go from field to field, left and right choose, Escape leaves.");
        }
        small(ui, summary);
        if !display.is_empty() {
            ui.add_space(12.0);
            small(ui, "This display does not fit. Every answer's row will say so:");
        }
        for fault in display {
            small(ui, fault);
        }
        action
    })
}

/// An option of a field.
fn option(label: &str, is_chosen: bool) -> egui::Button<'static> {
    let (ink, fill) = if is_chosen { (Color32::from_gray(240), INK) } else { (INK, FIELD) };
    let text = RichText::new(label).size(SMALL_POINTS).color(ink);
    egui::Button::new(text).fill(fill).min_size(vec2(0.0, OPTION_POINTS)).corner_radius(6.0)
}

/// Says why no session can begin.
pub(super) fn refused(ui: &mut Ui, why: &[String]) -> Option<Action> {
    column(ui, |ui| {
        large(ui, "This display does not fit, and the protocol does not allow that.");
        ui.add_space(16.0);
        for fault in why {
            small(ui, fault);
        }
        ui.add_space(32.0);
        button(ui, "Close", "Enter", Action::Leave)
    })
}

/// Asks whether to go on with a session that was begun earlier.
pub(super) fn resume(ui: &mut Ui, outcome: &Outcome) -> Option<Action> {
    let Outcome { subject, answered_before, trials, .. } = outcome;
    column(ui, |ui| {
        large(ui, &format!("{subject} has answered {answered_before} of {trials} trials."));
        small(ui, "Go on with this session only if this is the same person.");
        ui.add_space(32.0);
        pair(ui, ("Go on", "Enter", Action::Submit), ("Another code", "Escape", Action::Stay))
    })
}

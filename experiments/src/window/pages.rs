//! The pages that participants read and the buttons they press: dark text on the neutral grey of the
//! trials, nothing that moves or shines. Their words are the protocol's.

use super::shell::GREY;
use crate::session::{Input, Page, Progress};
use egui::{Align2, Button, Color32, FontId, RichText, Ui, Vec2, vec2};
use shutterlab_data_schema::protocol::{Protocol, Task, Text, Words};
use shutterlab_data_schema::response::Answer;

pub(super) const INK: Color32 = Color32::from_gray(16);
pub(super) const FIELD: Color32 = Color32::from_gray(158);
const UNDER_POINTER: Color32 = Color32::from_gray(178);
pub(super) const WARNING: Color32 = Color32::from_rgb(255, 168, 32);
const TEXT_POINTS: f32 = 24.0;
pub(super) const SMALL_POINTS: f32 = 18.0;
const COLUMN_POINTS: f32 = 760.0;
const BANNER_POINTS: f32 = 40.0;

/// What was asked for with a key or a button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    /// Something about the session.
    Session(Input),
    /// Go on: the form is filled in, the card was seen, the consent is given.
    Submit,
    /// Choose number so-and-so of what is offered.
    Choose(usize),
    /// Move the form's focus by so many places.
    Focus(isize),
    /// Move the choice in the form's focus by so many places.
    Option(isize),
    /// Try again what failed.
    Retry,
    /// Ask whether to leave.
    AskToLeave,
    /// Leave the session.
    Leave,
    /// Do not leave after all.
    Stay,
}

/// Sets egui's style to that of the pages.
pub(super) fn set_style(context: &egui::Context) {
    context.set_theme(egui::Theme::Light);
    context.all_styles_mut(|style| {
        let visuals = &mut style.visuals;
        visuals.override_text_color = Some(INK);
        visuals.panel_fill = Color32::from_gray(GREY);
        visuals.text_edit_bg_color = Some(FIELD);
        visuals.extreme_bg_color = FIELD;
        let widgets = &mut visuals.widgets;
        for widget in [&mut widgets.inactive, &mut widgets.hovered, &mut widgets.active] {
            widget.weak_bg_fill = UNDER_POINTER;
            widget.bg_stroke = egui::Stroke::new(1.0, INK);
            widget.expansion = 0.0;
        }
        widgets.inactive.weak_bg_fill = FIELD;
        // A page that is longer than the window has to look like it.
        style.spacing.scroll = egui::style::ScrollStyle::solid();
    });
}

/// Shows a page of text, left with one button.
pub(super) fn page(
    ui: &mut Ui,
    page: Page,
    protocol: &Protocol,
    now: Option<Progress>,
) -> Option<Action> {
    let Protocol { text: texts, words, .. } = protocol;
    let Text { instructions, after_practice, pause, end, .. } = texts;
    let (text, label) = match page {
        Page::Instructions => (instructions, &words.go_on),
        Page::AfterPractice => (after_practice, &words.go_on),
        Page::Pause => (pause, &words.go_on),
        Page::TooSlow => (&words.too_slow, &words.go_on),
        Page::End => (end, &words.close),
    };
    column(ui, |ui| {
        large(ui, text.trim());
        ui.add_space(40.0);
        if let (Page::Pause, Some(now)) = (page, now) {
            progress(ui, words, now);
            ui.add_space(24.0);
        }
        button(ui, label, "Enter", Action::Session(Input::Continue))
    })
}

/// Asks for consent.
pub(super) fn consent(ui: &mut Ui, consent: &str, words: &Words) -> Option<Action> {
    column(ui, |ui| {
        large(ui, consent.trim());
        ui.add_space(40.0);
        let agree = (words.agree.as_str(), "Y", Action::Submit);
        pair(ui, agree, (words.decline.as_str(), "N", Action::Leave))
    })
}

/// Words at the top of the window, over something to look at.
pub(super) fn caption(ui: &mut Ui, words: &str) {
    ui.vertical_centered(|ui| {
        ui.add_space(BANNER_POINTS + 16.0);
        large(ui, words);
    });
}

/// Asks the question.
pub(super) fn question(
    ui: &mut Ui,
    protocol: &Protocol,
    answers: &[Answer],
    now: Option<Progress>,
) -> Option<Action> {
    let words = &protocol.words;
    let mut action = None;
    column(ui, |ui| {
        large(ui, &protocol.question);
        ui.add_space(32.0);
        let label = |answer: &Answer| -> &str {
            match (answer, protocol.task) {
                (Answer::First, Task::Matching) => &words.left,
                (Answer::Second, Task::Matching) => &words.right,
                (Answer::First, _) => &words.first,
                (Answer::Second, _) => &words.second,
                (Answer::Same, _) => &words.same,
                (Answer::Different, _) => &words.different,
                (Answer::NotSure, _) => protocol.not_sure.as_deref().unwrap_or_default(),
            }
        };
        let keys = ["1", "2", "3"];
        let buttons: Vec<(&str, &str, Action)> = answers
            .iter()
            .zip(keys)
            .map(|(answer, key)| (label(answer), key, Action::Session(Input::Answer(*answer))))
            .collect();
        if let [left, right, rest @ ..] = buttons.as_slice() {
            action = action.or(pair(ui, *left, *right));
            for (label, key, meant) in rest {
                ui.add_space(16.0);
                action = action.or(button(ui, label, key, *meant));
            }
        }
        if protocol.timeline.replays {
            ui.add_space(40.0);
            action = action.or(replays(ui, protocol.task, words));
        }
        if let Some(Progress { practice, trial, of, .. }) = now {
            ui.add_space(48.0);
            let sort = if practice { &words.practice_of } else { &words.trial_of };
            small(ui, &numbered(sort, trial, of));
        }
    });
    action
}

fn replays(ui: &mut Ui, task: Task, words: &Words) -> Option<Action> {
    let labels: &[&str] = match task {
        Task::TwoAfc => &[&words.again_first, &words.again_second],
        Task::Matching => &[&words.again_reference, &words.again_left, &words.again_right],
        Task::SameDifferent => &[&words.again_both],
    };
    let replay = |interval| Action::Session(Input::Replay(interval));
    let mut action = None;
    for (row, two) in labels.chunks(2).enumerate() {
        let keys = &["Q", "W", "E"][2 * row..];
        let first = 2 * row;
        action = action.or(match two {
            [left, right] => {
                pair(ui, (left, keys[0], replay(first)), (right, keys[1], replay(first + 1)))
            }
            _ => button(ui, two[0], keys[0], replay(first)),
        });
        ui.add_space(16.0);
    }
    action
}

/// Asks whether to leave; until that is answered, the session rests.
pub(super) fn leaving(ui: &mut Ui, words: &Words, now: Option<Progress>) -> Option<Action> {
    column(ui, |ui| {
        large(ui, &words.leave_question);
        small(ui, &words.leave_hint);
        ui.add_space(24.0);
        if let Some(now) = now {
            progress(ui, words, now);
        }
        ui.add_space(24.0);
        pair(ui, (&words.stay, "Enter", Action::Stay), (&words.leave, "L", Action::Leave))
    })
}

/// Says what went wrong.
pub(super) fn problem(ui: &mut Ui, words: &Words, problem: &str) -> Option<Action> {
    column(ui, |ui| {
        large(ui, &words.problem);
        ui.add_space(16.0);
        small(ui, problem);
        small(ui, &words.problem_hint);
        ui.add_space(32.0);
        pair(ui, (&words.try_again, "Enter", Action::Retry), (&words.leave, "L", Action::Leave))
    })
}

/// Says that the window is too small for the stimuli.
pub(super) fn too_small(ui: &mut Ui, words: &Words, window: [u32; 2], needed: [u32; 2]) {
    column(ui, |ui| {
        large(ui, &words.too_small);
        small(ui, &format!("{} × {} px / {} × {} px", window[0], window[1], needed[0], needed[1]));
    });
}

/// The fixation mark: a cross that can be seen on any image.
pub(super) fn fixation(ui: &Ui, centres_px: &[[f32; 2]]) {
    let points_per_px = 1.0 / ui.ctx().pixels_per_point();
    let middle = ui.ctx().content_rect().center();
    for [x, y] in centres_px {
        let centre = middle + vec2(*x, *y) * points_per_px;
        for (width, colour) in [(5.0, Color32::from_gray(240)), (2.0, INK)] {
            let stroke = egui::Stroke::new(width, colour);
            for arm in [vec2(10.0, 0.0), vec2(0.0, 10.0)] {
                ui.painter().line_segment([centre - arm, centre + arm], stroke);
            }
        }
    }
}

/// The banner of a pilot, over everything.
pub(super) fn pilot_banner(ui: &Ui) {
    let mut band = ui.ctx().content_rect();
    band.set_height(BANNER_POINTS);
    ui.painter().rect_filled(band, 0.0, WARNING);
    let words = "PILOT: a trial run. These answers never count.";
    let font = FontId::proportional(SMALL_POINTS);
    ui.painter().text(band.center(), Align2::CENTER_CENTER, words, font, Color32::BLACK);
}

/// Says how far the session is and how long the rest will take.
fn progress(ui: &mut Ui, words: &Words, now: Progress) {
    if !now.practice {
        small(ui, &numbered(&words.done_of, now.trial - 1, now.of));
    }
    let minutes = (now.remaining_s / 60.0).ceil().max(1.0);
    small(ui, &words.minutes_left.replace("{minutes}", &format!("{minutes:.0}")));
}

fn numbered(words: &str, trial: u32, of: u32) -> String {
    words.replace("{trial}", &trial.to_string()).replace("{of}", &of.to_string())
}

/// A column in the middle of the window, a little above its centre; what does not fit can be scrolled.
pub(super) fn column<R>(ui: &mut Ui, contents: impl FnOnce(&mut Ui) -> R) -> R {
    column_of(ui, COLUMN_POINTS, contents)
}

/// A column of this width, if there is room.
pub(super) fn column_of<R>(ui: &mut Ui, width: f32, contents: impl FnOnce(&mut Ui) -> R) -> R {
    let whole = ui.ctx().content_rect();
    let width = width.min(whole.width() - 48.0);
    let top = whole.top() + BANNER_POINTS + 0.08 * whole.height();
    let left = whole.center().x - width / 2.0;
    let rect =
        egui::Rect::from_min_max(egui::pos2(left, top), egui::pos2(left + width, whole.bottom()));
    let builder =
        egui::UiBuilder::new().max_rect(rect).layout(egui::Layout::top_down(egui::Align::Center));
    let pages = ui.input(|input| {
        let presses = |key| input.num_presses(key) as f32;
        presses(egui::Key::PageUp) - presses(egui::Key::PageDown)
    });
    ui.scope_builder(builder, |ui| {
        let area = egui::ScrollArea::vertical().auto_shrink(false);
        area.show(ui, |ui| {
            if pages != 0.0 {
                ui.scroll_with_delta(vec2(0.0, 0.8 * pages * rect.height()));
            }
            ui.vertical_centered(contents).inner
        })
        .inner
    })
    .inner
}

pub(super) fn large(ui: &mut Ui, words: &str) {
    ui.label(RichText::new(words).size(TEXT_POINTS));
}

pub(super) fn small(ui: &mut Ui, words: &str) {
    ui.label(RichText::new(words).size(SMALL_POINTS));
}

/// A button and the key that does the same.
pub(super) fn button(ui: &mut Ui, label: &str, key: &str, action: Action) -> Option<Action> {
    ui.add(wide(label, key, vec2(300.0, 56.0))).clicked().then_some(action)
}

/// Two buttons side by side, the first on the left.
pub(super) fn pair(
    ui: &mut Ui,
    (left, left_key, left_action): (&str, &str, Action),
    (right, right_key, right_action): (&str, &str, Action),
) -> Option<Action> {
    const GAP: f32 = 40.0;
    let size = vec2(320.0, 56.0);
    let (row, _) = ui.allocate_exact_size(vec2(2.0 * size.x + GAP, size.y), egui::Sense::hover());
    let at = |x: f32| egui::Rect::from_min_size(row.min + vec2(x, 0.0), size);
    let left_clicked = ui.put(at(0.0), wide(left, left_key, size)).clicked();
    let right_clicked = ui.put(at(size.x + GAP), wide(right, right_key, size)).clicked();
    left_clicked.then_some(left_action).or(right_clicked.then_some(right_action))
}

fn wide(label: &str, key: &str, size: Vec2) -> Button<'static> {
    let text = RichText::new(format!("{label} ({key})")).size(SMALL_POINTS);
    Button::new(text).min_size(size).corner_radius(6.0)
}

//! The pages that participants read and the buttons they press: dark text on the neutral grey of the
//! trials, nothing that moves or shines.

use crate::session::{Input, Page, Progress};
use egui::{Align2, Button, Color32, FontId, RichText, TextEdit, Ui, Vec2, vec2};
use shutterlab_data_schema::protocol::Text;
use shutterlab_data_schema::response::Answer;

/// Code value of the neutral grey between and around the stimuli: the middle of the scale, for
/// red, green and blue. In sRGB that is 22 % of white's luminance, near the mean of the scenes.
pub(super) const GREY: u8 = 128;

const INK: Color32 = Color32::from_gray(16);
const BUTTON: Color32 = Color32::from_gray(158);
const BUTTON_UNDER_POINTER: Color32 = Color32::from_gray(178);
const WARNING: Color32 = Color32::from_rgb(255, 168, 32);
const TEXT_POINTS: f32 = 24.0;
const SMALL_POINTS: f32 = 18.0;
const COLUMN_POINTS: f32 = 760.0;
const BANNER_POINTS: f32 = 40.0;

/// What was asked for with a button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    /// Something about the session.
    Session(Input),
    /// The code is typed.
    Submit,
    /// Try again what failed.
    Retry,
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
        visuals.text_edit_bg_color = Some(BUTTON);
        let widgets = &mut visuals.widgets;
        for widget in [&mut widgets.inactive, &mut widgets.hovered, &mut widgets.active] {
            widget.weak_bg_fill = BUTTON_UNDER_POINTER;
            widget.bg_stroke = egui::Stroke::new(1.0, INK);
            widget.expansion = 0.0;
        }
        widgets.inactive.weak_bg_fill = BUTTON;
    });
}

/// Asks for the participant's code; `problem` says what was wrong with the last one.
pub(super) fn code(ui: &mut Ui, code: &mut String, problem: Option<&str>) -> Option<Action> {
    column(ui, |ui| {
        text(ui, "Participant's code");
        small(ui, "Letters and digits, no names.");
        ui.add_space(24.0);
        let field = TextEdit::singleline(code)
            .font(FontId::proportional(TEXT_POINTS))
            .char_limit(32)
            .desired_width(300.0)
            .align(Align2::CENTER_CENTER);
        ui.add(field).request_focus();
        ui.add_space(24.0);
        let action = button(ui, "Continue (Enter)", Action::Submit);
        if let Some(problem) = problem {
            ui.add_space(24.0);
            small(ui, problem);
        }
        action
    })
}

/// Shows a page of text, left with one button.
pub(super) fn page(ui: &mut Ui, page: Page, texts: &Text, now: Option<Progress>) -> Option<Action> {
    let (words, label) = match page {
        Page::Instructions => (&texts.instructions, "Continue (Enter)"),
        Page::AfterPractice => (&texts.after_practice, "Continue (Enter)"),
        Page::Pause => (&texts.pause, "Continue (Enter)"),
        Page::End => (&texts.end, "Close (Enter)"),
    };
    column(ui, |ui| {
        text(ui, words.trim());
        ui.add_space(40.0);
        if let (Page::Pause, Some(Progress { trial, of, .. })) = (page, now) {
            small(ui, &format!("{} of {of} pairs are done.", trial - 1));
            ui.add_space(24.0);
        }
        button(ui, label, Action::Session(Input::Continue))
    })
}

/// Asks the question.
pub(super) fn question(ui: &mut Ui, question: &str, now: Option<Progress>) -> Option<Action> {
    let answer = |answer| Action::Session(Input::Answer(answer));
    let replay = |answer| Action::Session(Input::Replay(answer));
    let mut action = None;
    column(ui, |ui| {
        text(ui, question);
        ui.add_space(32.0);
        action = action.or(pair(
            ui,
            ("The first (1)", answer(Answer::First)),
            ("The second (2)", answer(Answer::Second)),
            true,
        ));
        ui.add_space(40.0);
        action = action.or(pair(
            ui,
            ("See the first again (Q)", replay(Answer::First)),
            ("See the second again (W)", replay(Answer::Second)),
            false,
        ));
        if let Some(Progress { practice, trial, of }) = now {
            ui.add_space(56.0);
            let sort = if practice { "Practice trial" } else { "Trial" };
            small(ui, &format!("{sort} {trial} of {of}"));
        }
    });
    action
}

/// Asks whether to leave.
pub(super) fn leaving(ui: &mut Ui) -> Option<Action> {
    column(ui, |ui| {
        text(ui, "Leave the session?");
        small(ui, "All answers so far are saved, and the session can be continued later.");
        ui.add_space(32.0);
        pair(ui, ("Stay (Enter)", Action::Stay), ("Leave (L)", Action::Leave), true)
    })
}

/// Says what went wrong.
pub(super) fn problem(ui: &mut Ui, problem: &str) -> Option<Action> {
    column(ui, |ui| {
        text(ui, "Something went wrong. Please call the experimenter.");
        ui.add_space(16.0);
        small(ui, problem);
        small(
            ui,
            "All earlier answers are saved. If you leave now, this pair will be asked again.",
        );
        ui.add_space(32.0);
        pair(ui, ("Try again (Enter)", Action::Retry), ("Leave (L)", Action::Leave), true)
    })
}

/// Says that the window is too small for the stimuli.
pub(super) fn too_small(ui: &mut Ui, window: [u32; 2], image: [u32; 2]) {
    column(ui, |ui| {
        text(ui, "This window is too small for the films.");
        small(
            ui,
            &format!(
                "It has {} × {} pixels; {} × {} are needed. Please make it larger.",
                window[0], window[1], image[0], image[1]
            ),
        );
    });
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

/// A column in the middle of the window, a little above its centre.
fn column<R>(ui: &mut Ui, contents: impl FnOnce(&mut Ui) -> R) -> R {
    let whole = ui.ctx().content_rect();
    let width = COLUMN_POINTS.min(whole.width() - 48.0);
    let top = whole.top() + BANNER_POINTS + 0.16 * whole.height();
    let left = whole.center().x - width / 2.0;
    let rect =
        egui::Rect::from_min_max(egui::pos2(left, top), egui::pos2(left + width, whole.bottom()));
    let builder =
        egui::UiBuilder::new().max_rect(rect).layout(egui::Layout::top_down(egui::Align::Center));
    ui.scope_builder(builder, contents).inner
}

fn text(ui: &mut Ui, words: &str) {
    ui.label(RichText::new(words).size(TEXT_POINTS));
}

fn small(ui: &mut Ui, words: &str) {
    ui.label(RichText::new(words).size(SMALL_POINTS));
}

fn button(ui: &mut Ui, label: &str, action: Action) -> Option<Action> {
    ui.add(wide(label, vec2(260.0, 56.0))).clicked().then_some(action)
}

/// Two buttons side by side, the first on the left.
fn pair(
    ui: &mut Ui,
    (left, left_action): (&str, Action),
    (right, right_action): (&str, Action),
    large: bool,
) -> Option<Action> {
    const GAP: f32 = 40.0;
    let size = if large { vec2(300.0, 72.0) } else { vec2(300.0, 48.0) };
    let (row, _) = ui.allocate_exact_size(vec2(2.0 * size.x + GAP, size.y), egui::Sense::hover());
    let at = |x: f32| egui::Rect::from_min_size(row.min + vec2(x, 0.0), size);
    let left_clicked = ui.put(at(0.0), wide(left, size)).clicked();
    let right_clicked = ui.put(at(size.x + GAP), wide(right, size)).clicked();
    left_clicked.then_some(left_action).or(right_clicked.then_some(right_action))
}

fn wide(label: &str, size: Vec2) -> Button<'_> {
    Button::new(RichText::new(label).size(SMALL_POINTS)).min_size(size).corner_radius(6.0)
}

//! The check against simulated displays of known refresh, and its faults one by one.

use super::*;
use crate::random::Stream;
use shutterlab_data_schema::display::{Screen, WindowSize};

/// A display that takes frames through a queue and shows one per refresh.
struct Simulated {
    /// Seconds between two refreshes: shortest and longest. The same for a fixed refresh.
    refresh_s: [f64; 2],
    /// Images that the queue has, the one on the screen included; none if nobody paces the program.
    images: Option<usize>,
    jitter_s: f64,
    /// Part of the frames that come so late that no queue can hide it.
    dropped: f64,
    flips: Vec<f64>,
    now_s: f64,
    chance: Stream,
}

impl Simulated {
    fn new(refresh_s: [f64; 2], images: Option<usize>) -> Self {
        let (flips, chance) = (vec![], Stream::new(7));
        Self { refresh_s, images, jitter_s: 0.0, dropped: 0.0, flips, now_s: 0.0, chance }
    }

    fn fixed(hz: f64, images: usize) -> Self {
        Self::new([1.0 / hz; 2], Some(images))
    }

    /// Hands over a frame at `due_s` or later, and returns when that was noted.
    fn present(&mut self, due_s: f64) -> f64 {
        self.now_s = self.now_s.max(due_s);
        let Some(images) = self.images else {
            let [least, most] = self.refresh_s;
            self.now_s += least + (most - least) * self.chance.uniform();
            return self.now_s;
        };
        // An image is free once the frame after the one that it held is on the screen.
        if let Some(free) = self.flips.len().checked_sub(images - 1).map(|i| self.flips[i]) {
            self.now_s = self.now_s.max(free);
        }
        let [shortest, longest] = self.refresh_s;
        if self.chance.uniform() < self.dropped {
            self.now_s += 3.5 * shortest;
        }
        let last = self.flips.last().copied().unwrap_or(0.0);
        self.flips.push(if shortest == longest {
            ((self.now_s / shortest).floor() + 1.0).max((last / shortest).round() + 1.0) * shortest
        } else {
            // The screen waits for a frame, and repeats the last one when it has waited too long.
            let waited = ((self.now_s - last) / longest).floor().max(0.0) * longest;
            self.now_s.max(last + waited + shortest)
        });
        self.now_s + self.jitter_s * self.chance.normal()
    }

    fn measure(mut self, frames: usize) -> Measurement {
        let mut measurement = Measurement::new(frames);
        while let Some(due_s) = measurement.due_s() {
            let at_s = self.present(due_s);
            measurement.presented(at_s);
        }
        measurement
    }
}

fn facts(system_hz: Option<f64>) -> Facts {
    Facts {
        monitor: Some("DP-1".into()),
        monitor_px: Some([1920, 1080]),
        system_hz,
        window_px: [1920, 1080],
        scale_factor: 1.5,
        adapter: "a graphics card".into(),
        software: false,
    }
}

fn profile() -> DisplayProfile {
    DisplayProfile {
        screen: Some(Screen {
            width_mm: 480.0,
            height_mm: 270.0,
            width_px: 1920,
            height_px: 1080,
            distance_cm: 57.3,
        }),
        ..DisplayProfile::identity()
    }
}

fn check(display: Simulated, system_hz: Option<f64>) -> DisplayCheck {
    display.measure(1000).judge(facts(system_hz), &profile(), None)
}

#[test]
fn fixed_displays_are_told_and_their_refresh_is_measured() {
    for hz in [59.94, 60.0, 75.0, 120.0, 144.0] {
        for images in [2, 3, 4] {
            for (jitter_s, dropped) in [(0.0, 0.0), (2e-4, 0.0), (0.0, 0.01), (2e-4, 0.01)] {
                let display = Simulated { jitter_s, dropped, ..Simulated::fixed(hz, images) };
                let found = check(display, None);
                let case = format!("{hz} Hz, {images} images, {jitter_s}, {dropped}: {found:?}");
                assert_eq!(found.pacing, Pacing::FixedRefresh, "{case}");
                assert!((found.refresh_hz.unwrap() / hz - 1.0).abs() < 5e-4, "{case}");
                assert_eq!(found.dropped > 0, dropped > 0.0, "{case}");
            }
        }
    }
}

#[test]
fn a_variable_refresh_is_told_by_its_known_highest_rate() {
    for jitter_s in [0.0, 2e-4] {
        let display =
            || Simulated { jitter_s, ..Simulated::new([1.0 / 144.0, 1.0 / 48.0], Some(3)) };
        let found = check(display(), Some(144.0));
        assert_eq!(found.pacing, Pacing::VariableRefresh, "{found:?}");
        assert!((found.refresh_hz.unwrap() - 144.0).abs() < 0.3, "{found:?}");
        assert!(found.faults[0].contains("the profile does not declare"), "{found:?}");
        // Nobody knows what it may reach: then it may as well be a program that nobody paces.
        assert_eq!(check(display(), None).pacing, Pacing::Timer);
        assert_eq!(check(display(), Some(60.0)).pacing, Pacing::Timer);
    }
}

#[test]
fn a_program_that_nobody_paces_is_told() {
    for range_s in [[2e-3, 11e-3], [2.9e-3, 3.1e-3], [0.4e-3, 0.5e-3], [15e-3, 18e-3]] {
        for system_hz in [None, Some(60.0)] {
            let found = check(Simulated::new(range_s, None), system_hz);
            assert_eq!(found.pacing, Pacing::Timer, "{range_s:?}: {found:?}");
            assert_eq!(found.refresh_hz, None);
            assert!(found.faults[0].starts_with("pacing timer"), "{found:?}");
        }
    }
}

#[test]
fn each_thing_that_does_not_fit_is_a_fault() {
    let measured = Simulated::fixed(144.0, 3).measure(SESSION_FRAMES);
    let faults = |facts: Facts, profile: &DisplayProfile, angle| {
        measured.judge(facts, profile, angle).faults
    };
    let angle = |pixels_per_degree| Some(Angle { image_width_px: 640, pixels_per_degree });
    let seen = profile().pixels_per_degree(640).unwrap();
    let fit = facts(Some(144.0));
    assert_eq!(faults(fit.clone(), &profile(), angle(1.04 * seen)), [""; 0]);
    assert_eq!(faults(facts(Some(143.98)), &profile(), None), [""; 0]);

    let one = |facts: Facts, profile: DisplayProfile, angle, expected: &str| {
        let found = faults(facts, &profile, angle);
        assert!(found.len() == 1 && found[0].starts_with(expected), "{expected}: {found:?}");
    };
    let off = "refresh 144.00 Hz measured, 60.00 Hz by the ";
    one(facts(Some(60.0)), profile(), None, &format!("{off}system"));
    let slow = DisplayProfile { refresh_hz: Some(60.0), ..profile() };
    one(fit.clone(), slow, None, &format!("{off}profile"));
    let variable = DisplayProfile { variable_refresh: true, ..profile() };
    one(fit.clone(), variable, None, "fixed refresh measured");
    let software = measured.judge(Facts { software: true, ..fit.clone() }, &profile(), None);
    assert_eq!((software.pacing, software.faults.len()), (Pacing::Timer, 2), "{software:?}");
    assert!(software.faults[0].starts_with("adapter a graphics card: "), "{software:?}");
    let other = Facts { monitor_px: Some([1280, 720]), window_px: [1280, 720], ..fit.clone() };
    one(other, profile(), None, "monitor 1280x720 px, 1920x1080 by the profile");
    let small = Facts { window_px: [1920, 1040], ..fit.clone() };
    one(small, profile(), None, "window 1920x1040 px, 1920x1080 asked for");
    let window = Some(WindowSize { width_px: 800, height_px: 600 });
    one(fit.clone(), DisplayProfile { window, ..profile() }, None, "window 1920x1080 px, 800x600");
    one(fit, profile(), angle(1.06 * seen), "40.26 pixels per degree, the stimuli are for 42.68");
}

#[test]
fn statistics_are_those_of_the_textbook() {
    let found = Stats::new(&[0.016, 0.017, 0.018, 0.033]);
    assert_eq!((found.count, found.worst_ms, found.p999_ms), (4, 33.0, 33.0));
    assert!((found.median_ms - 17.5).abs() < 1e-9);
    // Sample variance of 16, 17, 18, 33: 194 / 3.
    assert!((found.sd_ms - (194.0_f64 / 3.0).sqrt()).abs() < 1e-9);
    assert_eq!(Stats::new(&[]), Stats::default());
    let thousand: Vec<f64> = (1..=10_000).map(|i| f64::from(i) * 1e-6).collect();
    assert!((Stats::new(&thousand).p999_ms - 9.99).abs() < 1e-9);
}

//! The check of a display: when presented frames were taken, and what that says about its refresh.
//!
//! First frames are handed over as fast as they are taken. Then come bursts of a few frames, begun half
//! a refresh out of step each time: a display with a fixed refresh takes their last frames on its own
//! beat, one with a variable refresh on that of the bursts. All times are those of handing over, which
//! is all that the graphics interface tells; whether light followed, only a photodiode knows.

use serde::Serialize;
use shutterlab_data_schema::DisplayProfile;
use shutterlab_data_schema::response::Pacing;

/// Frames of the check before each session.
pub const SESSION_FRAMES: usize = 240;
/// Frames of a thorough check, so that ten of them decide the 99.9th percentile.
pub const THOROUGH_FRAMES: usize = 10_000;

/// Frames that are not counted: the first ones fill queues and compile shaders.
const WARM_UP: usize = 12;
/// Bursts, frames in each, and refreshes from one to the next. A burst is longer than any queue of
/// frames, and the queue is empty again before the next one.
const BURSTS: usize = 25;
const BURST_FRAMES: usize = 6;
const BURST_REFRESHES: f64 = 9.5;

/// Part of a refresh by which an interval may be off its beat.
const OFF_BEAT: f64 = 0.15;
/// Part of the intervals that must be on the beat.
const MOSTLY: f64 = 0.85;
/// Part by which two rates may differ and still be the same.
const SAME_RATE: f64 = 0.01;
/// Part of the frames that may be dropped.
const MOST_DROPPED: f64 = 0.005;
/// Part by which pixels per degree may be off.
const SAME_ANGLE: f64 = 0.05;

/// A check under way: says when the next frame is to be presented, and takes down when it was.
#[derive(Clone, Debug)]
pub struct Measurement {
    frames: usize,
    /// Times of the first part, in seconds.
    fast: Vec<f64>,
    /// Times of the last frame of each burst.
    bursts: Vec<f64>,
    in_burst: usize,
    /// Seconds from one burst to the next, once the first part is done; none if that has shown no beat,
    /// and nothing is left to find out.
    apart_s: Option<f64>,
}

/// What the intervals say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// What decides when the next frame is taken.
    pub pacing: Pacing,
    /// Refreshes per second, if the display paces the program; the highest there are if they vary.
    pub refresh_hz: Option<f64>,
    /// Refreshes without a new frame in the first part.
    pub dropped: u32,
}

const UNPACED: Verdict = Verdict { pacing: Pacing::Timer, refresh_hz: None, dropped: 0 };

/// Intervals between presented frames, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Stats {
    /// How many.
    pub count: usize,
    /// Their median.
    pub median_ms: f64,
    /// Their standard deviation: what studies of timing call precision.
    pub sd_ms: f64,
    /// What 99.9 % of them do not exceed.
    pub p999_ms: f64,
    /// The longest.
    pub worst_ms: f64,
}

/// What the system says about window, monitor and graphics adapter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Facts {
    /// The monitor's name, if it has one.
    pub monitor: Option<String>,
    /// Its physical pixels.
    pub monitor_px: Option<[u32; 2]>,
    /// Refreshes per second by the system.
    pub system_hz: Option<f64>,
    /// The window's inside.
    pub window_px: [u32; 2],
    /// Physical pixels per logical one; stimuli are drawn in physical ones.
    pub scale_factor: f64,
    /// The graphics adapter.
    pub adapter: String,
    /// Whether the adapter is a program on the processor.
    pub software: bool,
}

/// How large the stimuli are to appear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angle {
    /// Pixels of an image's width.
    pub image_width_px: u32,
    /// Pixels per degree that the stimuli were made for.
    pub pixels_per_degree: f64,
}

/// The result of a check.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DisplayCheck {
    /// Name of the profile that it was held against.
    pub profile: String,
    /// What the system says.
    #[serde(flatten)]
    pub facts: Facts,
    /// What decides when the next frame is shown.
    pub pacing: Pacing,
    /// Measured refreshes per second; none if the display does not pace the program.
    pub refresh_hz: Option<f64>,
    /// Intervals of frames presented as fast as they were taken.
    pub intervals: Stats,
    /// Refreshes without a new frame among them.
    pub dropped: u32,
    /// What does not fit; empty if all does.
    pub faults: Vec<String>,
}

impl Measurement {
    /// Of `frames` frames, and some bursts after them.
    pub fn new(frames: usize) -> Self {
        let frames = frames.max(2) + WARM_UP;
        Self { frames, fast: vec![], bursts: vec![], in_burst: 0, apart_s: None }
    }

    /// When the next frame is to be presented, in seconds on the clock of [`Measurement::presented`];
    /// a time that is past means at once. None when all is measured.
    pub fn due_s(&self) -> Option<f64> {
        let last_s = self.fast.last().copied().unwrap_or(f64::NEG_INFINITY);
        if self.fast.len() < self.frames {
            return Some(last_s);
        }
        let burst = self.bursts.len();
        self.apart_s.filter(|_| burst < BURSTS).map(|apart_s| last_s + apart_s * (burst + 1) as f64)
    }

    /// Takes down that a frame was presented.
    pub fn presented(&mut self, at_s: f64) {
        if self.fast.len() < self.frames {
            self.fast.push(at_s);
            if self.fast.len() == self.frames {
                self.apart_s = beat_s(&self.fast_s()).map(|beat_s| BURST_REFRESHES * beat_s);
            }
            return;
        }
        self.in_burst += 1;
        if self.in_burst == BURST_FRAMES {
            self.in_burst = 0;
            self.bursts.push(at_s);
        }
    }

    /// Part that is done, 0 to 1.
    pub fn progress(&self) -> f64 {
        let done = self.fast.len() as f64 / self.frames as f64;
        0.5 * (done + self.bursts.len() as f64 / BURSTS as f64)
    }

    /// Holds what was measured against what is known.
    pub fn judge(
        &self,
        facts: Facts,
        profile: &DisplayProfile,
        angle: Option<Angle>,
    ) -> DisplayCheck {
        let fast_s = self.fast_s();
        let known_hz = profile.refresh_hz.or(facts.system_hz);
        // What the processor draws is copied to the screen, and may be so at a steady pace.
        let verdict = match self.apart_s {
            Some(apart_s) if !facts.software => {
                classify(&fast_s, &intervals(&self.bursts), apart_s, known_hz)
            }
            _ => UNPACED,
        };
        let intervals = Stats::new(&fast_s);
        let faults = faults(&verdict, &intervals, &facts, profile, angle);
        let Verdict { pacing, refresh_hz, dropped } = verdict;
        let profile = profile.name.clone();
        DisplayCheck { profile, facts, pacing, refresh_hz, intervals, dropped, faults }
    }

    fn fast_s(&self) -> Vec<f64> {
        intervals(self.fast.get(WARM_UP..).unwrap_or_default())
    }
}

impl Stats {
    /// Of intervals in seconds.
    pub fn new(intervals_s: &[f64]) -> Self {
        if intervals_s.is_empty() {
            return Self::default();
        }
        let count = intervals_s.len();
        let mut sorted: Vec<f64> = intervals_s.iter().map(|s| 1e3 * s).collect();
        sorted.sort_by(f64::total_cmp);
        let mean = sorted.iter().sum::<f64>() / count as f64;
        let squares: f64 = sorted.iter().map(|ms| (ms - mean).powi(2)).sum();
        Self {
            count,
            median_ms: median(&sorted),
            sd_ms: (squares / (count.max(2) - 1) as f64).sqrt(),
            p999_ms: sorted[((0.999 * count as f64).ceil() as usize).clamp(1, count) - 1],
            worst_ms: sorted[count - 1],
        }
    }
}

/// What kind of display takes frames at intervals of `fast_s` when they are offered as fast as can be,
/// and ends bursts, begun every `requested_s`, at intervals of `slow_s`. All in seconds.
///
/// A program that nobody paces may run steadily, too, and follows every request as a display with a
/// variable refresh does: that it is one is believed only if its highest rate is `known_hz`.
pub fn classify(
    fast_s: &[f64],
    slow_s: &[f64],
    requested_s: f64,
    known_hz: Option<f64>,
) -> Verdict {
    let Some(refresh_s) = beat_s(fast_s) else { return UNPACED };
    // A frame that waited in a queue while the program was held up was not dropped: the next ones come
    // so much sooner.
    let all_s: f64 = fast_s.iter().sum();
    let dropped = ((all_s / refresh_s).round() - fast_s.len() as f64).max(0.0) as u32;
    let paced = |pacing| Verdict { pacing, refresh_hz: Some(1.0 / refresh_s), dropped };

    let part_of_slow = |fits: &dyn Fn(&f64) -> bool| {
        slow_s.iter().filter(|s| fits(s)).count() as f64 / slow_s.len().max(1) as f64
    };
    let follows = part_of_slow(&|s| (s - requested_s).abs() <= OFF_BEAT * refresh_s);
    let keeps_beat = part_of_slow(&|s| refreshes(*s, refresh_s).is_some());
    let is_known = known_hz.is_some_and(|hz| is_same(hz * refresh_s, 1.0, SAME_RATE));
    if keeps_beat >= MOSTLY {
        paced(Pacing::FixedRefresh)
    } else if follows >= MOSTLY && is_known {
        paced(Pacing::VariableRefresh)
    } else {
        UNPACED
    }
}

/// The time of which most intervals are about a whole multiple, if there is one.
fn beat_s(intervals_s: &[f64]) -> Option<f64> {
    let usual_s = median(intervals_s);
    let on_beat: Vec<(f64, f64)> =
        intervals_s.iter().filter_map(|s| Some((*s, refreshes(*s, usual_s)?))).collect();
    let is_most = on_beat.len() as f64 >= MOSTLY * intervals_s.len() as f64;
    // The jitter of single frames cancels in their sum.
    let seconds: f64 = on_beat.iter().map(|(seconds, _)| seconds).sum();
    let count: f64 = on_beat.iter().map(|(_, refreshes)| refreshes).sum();
    (is_most && count > 0.0).then(|| seconds / count)
}

/// How many refreshes an interval is, if it is about a whole number of them.
fn refreshes(interval_s: f64, refresh_s: f64) -> Option<f64> {
    let refreshes = (interval_s / refresh_s).round();
    let is_on_beat = (interval_s / refresh_s - refreshes).abs() <= OFF_BEAT;
    (refreshes >= 1.0 && is_on_beat).then_some(refreshes)
}

fn faults(
    verdict: &Verdict,
    intervals: &Stats,
    facts: &Facts,
    profile: &DisplayProfile,
    angle: Option<Angle>,
) -> Vec<String> {
    let mut faults = Vec::new();
    if facts.software {
        faults.push(format!("adapter {}: drawn by the processor", facts.adapter));
    }
    if verdict.pacing == Pacing::Timer {
        faults
            .push("pacing timer: no refresh of the display can be told from the intervals".into());
    }
    match (verdict.pacing, profile.variable_refresh) {
        (Pacing::VariableRefresh, false) => {
            faults.push("variable refresh measured, which the profile does not declare".into());
        }
        (Pacing::FixedRefresh, true) => {
            faults.push("fixed refresh measured, the profile declares a variable one".into());
        }
        _ => {}
    }
    for (source, hz) in [("system", facts.system_hz), ("profile", profile.refresh_hz)] {
        if let (Some(said), Some(measured)) = (hz, verdict.refresh_hz)
            && !is_same(said, measured, SAME_RATE)
        {
            faults.push(format!("refresh {measured:.2} Hz measured, {said:.2} Hz by the {source}"));
        }
    }
    let most = MOST_DROPPED * intervals.count as f64;
    if f64::from(verdict.dropped) > most {
        faults.push(format!("{} of {} frames dropped", verdict.dropped, intervals.count));
    }
    let [width, height] = facts.window_px;
    let by_profile = profile.screen.map(|screen| [screen.width_px, screen.height_px]);
    if let (Some([w, h]), Some(there)) = (by_profile, facts.monitor_px)
        && there != [w, h]
    {
        let [there_w, there_h] = there;
        faults.push(format!("monitor {there_w}x{there_h} px, {w}x{h} by the profile"));
    }
    let asked = match profile.window {
        Some(window) => Some([window.width_px, window.height_px]),
        None => facts.monitor_px,
    };
    if let Some([w, h]) = asked.filter(|asked| *asked != facts.window_px) {
        faults.push(format!("window {width}x{height} px, {w}x{h} asked for"));
    }
    if let Some(angle) = angle
        && let Some(seen) = profile.pixels_per_degree(angle.image_width_px)
        && !is_same(seen, angle.pixels_per_degree, SAME_ANGLE)
    {
        let made_for = angle.pixels_per_degree;
        faults.push(format!("{seen:.2} pixels per degree, the stimuli are for {made_for:.2}"));
    }
    faults
}

fn is_same(a: f64, b: f64, part: f64) -> bool {
    (a / b - 1.0).abs() <= part
}

fn intervals(times: &[f64]) -> Vec<f64> {
    times.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => 0.0,
        n => 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]),
    }
}

#[cfg(test)]
mod tests;

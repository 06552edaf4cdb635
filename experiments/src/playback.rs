//! Playing one sequence by the clock: which frame is due, and what became of each.
//!
//! Time is counted in refreshes of the display since the onset, the first frame's showing. Frame i is
//! due at refresh ⌈i·R⌉, where R refreshes are meant for each frame. Which refresh a moment belongs to
//! follows from the clock, never from sleeping: a hold-up skips frames instead of stretching the motion,
//! and an early or late reading of less than half a refresh changes nothing. A display that paces the
//! program shows each screen for one refresh at least, whenever it was handed over: of two screens that
//! went into its queue at once, the second belongs to the next refresh.
//!
//! A frame is *late* if it was first shown at a later refresh than it was due, *dropped* if it was
//! never shown, and *repeated* if it was still there when its successor was due.

use shutterlab_data_schema::response::Pacing;

/// How frames fall on refreshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cadence {
    /// From one refresh to the next.
    period_s: f64,
    /// Refreshes meant for each frame, R.
    refreshes_per_frame: f64,
    /// Whether refreshes are those of a display that paces the program, and not steps of the clock.
    paced: bool,
}

/// Where a display's refreshes are unknown or follow the program, time is counted in steps of a quarter
/// frame, or shorter ones, so many a second: a frame of 30 per second is late 4 ms after it was due.
const STEPS_HZ: f64 = 120.0;

/// The least number of such steps in a frame.
const STEPS_PER_FRAME: f64 = 4.0;

/// A refresh rate this near to a multiple of the frame rate is taken for one: a film of 30 frames per
/// second plays at 29.97 on a display of 59.94 Hz.
const TOLERANCE: f64 = 0.005;

/// Rounding errors of quotients of refreshes and frames.
const ROUNDING: f64 = 1e-6;

impl Cadence {
    /// Frames at `fps` on a display of `refresh_hz`; none if it does not pace the program.
    pub fn new(fps: f64, refresh_hz: Option<f64>) -> Self {
        let Some(refresh_hz) = refresh_hz else {
            let refreshes_per_frame = (STEPS_HZ / fps).ceil().max(STEPS_PER_FRAME);
            let period_s = 1.0 / (fps * refreshes_per_frame);
            return Self { period_s, refreshes_per_frame, paced: false };
        };
        let exact = refresh_hz / fps;
        let whole = exact.round().max(1.0);
        let fits = (exact / whole - 1.0).abs() <= TOLERANCE;
        let refreshes_per_frame = if fits { whole } else { exact };
        Self { period_s: 1.0 / refresh_hz, refreshes_per_frame, paced: true }
    }

    /// From one refresh to the next, or from one step to the next.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Refreshes meant for each frame.
    pub fn refreshes_per_frame(&self) -> f64 {
        self.refreshes_per_frame
    }

    /// Whether each frame is meant for the same number of refreshes.
    pub fn is_even(&self) -> bool {
        self.refreshes_per_frame.fract() == 0.0
    }

    /// As [`Cadence::new`] on a display that paces the program only if `pacing` says so.
    pub fn paced(fps: f64, pacing: Pacing, refresh_hz: Option<f64>) -> Self {
        Self::new(fps, refresh_hz.filter(|_| pacing == Pacing::FixedRefresh))
    }

    /// The first refresh of frame `index`.
    fn first_refresh(&self, index: u32) -> u64 {
        (f64::from(index) * self.refreshes_per_frame - ROUNDING).ceil().max(0.0) as u64
    }

    /// The frame due at a refresh.
    fn frame_at(&self, refresh: u64) -> u32 {
        ((refresh as f64 + ROUNDING) / self.refreshes_per_frame).floor() as u32
    }
}

/// What did not go as it should.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Frames shown later than they were due.
    pub late: u32,
    /// Frames never shown.
    pub dropped: u32,
    /// Frames that stayed when the next was due.
    pub repeated: u32,
}

impl Faults {
    /// Whether there is any.
    pub fn any(self) -> bool {
        self != Self::default()
    }
}

impl std::ops::AddAssign for Faults {
    fn add_assign(&mut self, other: Self) {
        self.late += other.late;
        self.dropped += other.dropped;
        self.repeated += other.repeated;
    }
}

/// When a frame was due, and when it was shown first, in seconds of the session's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTime {
    /// Number of the interval, from 0.
    pub interval: usize,
    /// 0 for the interval's first showing, 1 for its first replay.
    pub replay: u32,
    /// Number of the frame.
    pub frame: u32,
    /// When it was due.
    pub due_s: f64,
    /// When it was shown.
    pub shown_s: f64,
}

/// One showing of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct Playback {
    cadence: Cadence,
    frames: u32,
    onset_s: Option<f64>,
    last_shown: Option<u32>,
    /// The last refresh that showed one of its frames.
    last_refresh: Option<u64>,
    faults: Faults,
    shown: Vec<(u32, f64)>,
}

impl Playback {
    /// A showing of `frames` frames, not yet begun.
    pub fn new(cadence: Cadence, frames: u32) -> Self {
        Self {
            cadence,
            frames,
            onset_s: None,
            last_shown: None,
            last_refresh: None,
            faults: Faults::default(),
            shown: vec![],
        }
    }

    /// The frame that is due at `now_s`; none if the sequence is over.
    pub fn due(&self, now_s: f64) -> Option<u32> {
        let Some(onset_s) = self.onset_s else { return Some(0) };
        let index = self.cadence.frame_at(self.refresh(onset_s, now_s));
        (index < self.frames).then_some(index)
    }

    /// Takes down that frame `index` was shown at `at_s`.
    pub fn shown(&mut self, index: u32, at_s: f64) {
        let onset_s = *self.onset_s.get_or_insert(at_s);
        let refresh = self.refresh(onset_s, at_s);
        self.last_refresh = Some(refresh);
        if self.last_shown.is_some_and(|last| index <= last) {
            return;
        }
        self.leave_last(refresh);
        self.faults.dropped += index - self.last_shown.map_or(0, |last| last + 1);
        self.faults.late += u32::from(refresh > self.cadence.first_refresh(index));
        self.last_shown = Some(index);
        self.shown.push((index, at_s));
    }

    /// When its frames were due and shown, as showing number `replay` of `interval`.
    pub fn times(&self, interval: usize, replay: u32) -> impl Iterator<Item = FrameTime> {
        let due_s = |frame| self.frame_s(frame).unwrap_or_default();
        let time = move |&(frame, shown_s): &(u32, f64)| FrameTime {
            interval,
            replay,
            frame,
            due_s: due_s(frame),
            shown_s,
        };
        self.shown.iter().map(time)
    }

    /// When the first frame was shown.
    pub fn onset_s(&self) -> Option<f64> {
        self.onset_s
    }

    /// When the next frame is due, or the end if none is left; none before the onset.
    pub fn next_change_s(&self) -> Option<f64> {
        self.frame_s(self.last_shown.map_or(0, |last| last + 1))
    }

    /// When the last frame's time is up; none before the onset.
    pub fn end_s(&self) -> Option<f64> {
        self.frame_s(self.frames)
    }

    /// Faults so far.
    pub fn faults(&self) -> Faults {
        self.faults
    }

    /// Faults of the whole showing, after which something else was shown at `at_s`.
    pub fn faults_until(mut self, at_s: f64) -> Faults {
        self.leave_last(self.onset_s.map_or(0, |onset_s| self.refresh(onset_s, at_s)));
        self.faults.dropped += self.frames - self.last_shown.map_or(0, |last| last + 1);
        self.faults
    }

    /// The last frame gives way at `refresh`.
    fn leave_last(&mut self, refresh: u64) {
        if let Some(last) = self.last_shown {
            self.faults.repeated += u32::from(refresh > self.cadence.first_refresh(last + 1));
        }
    }

    fn frame_s(&self, index: u32) -> Option<f64> {
        let refreshes = self.cadence.first_refresh(index) as f64;
        self.onset_s.map(|onset_s| onset_s + refreshes * self.cadence.period_s)
    }

    /// The refresh, from 0 at the onset, of what is shown next at `at_s`.
    fn refresh(&self, onset_s: f64, at_s: f64) -> u64 {
        let refresh = ((at_s - onset_s) / self.cadence.period_s).round().max(0.0) as u64;
        let taken = self.last_refresh.filter(|_| self.cadence.paced);
        refresh.max(taken.map_or(0, |last| last + 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shows whatever is due at each of `times`, in refreshes; faults if the end comes on time or at
    /// the last of the times.
    fn faults(refresh_hz: f64, times: &[f64]) -> (u32, u32, u32) {
        let mut playback = Playback::new(Cadence::new(30.0, Some(refresh_hz)), 4);
        let at = |refreshes: f64| 7.0 + refreshes / refresh_hz;
        for &time in times {
            if let Some(index) = playback.due(at(time)) {
                playback.shown(index, at(time));
            }
        }
        let end = times.last().copied().unwrap_or(0.0).max(4.0 * refresh_hz / 30.0);
        let Faults { late, dropped, repeated } = playback.faults_until(at(end));
        (late, dropped, repeated)
    }

    #[test]
    fn each_fault_is_counted_once() {
        for (shown_at, expected) in [
            (&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0][..], (0, 0, 0)),
            (&[0.0, 2.0, 4.0, 6.0], (0, 0, 0)),
            (&[0.0, 1.6, 4.4, 5.6], (0, 0, 0)), // within half a refresh
            (&[0.0, 1.0, 3.0, 4.0, 6.0], (1, 0, 1)), // frame 1 came one refresh late, 0 stayed
            (&[0.0, 1.0, 4.0, 6.0], (0, 1, 1)), // frame 1 dropped, 0 stayed for it
            (&[0.0, 5.0, 6.0], (1, 1, 1)),      // frame 1 dropped, 2 late
            (&[0.0, 2.0], (0, 2, 1)),           // the rest never shown
            (&[0.0, 99.0], (0, 3, 1)),
            (&[0.0, 2.0, 4.0, 6.0, 9.0], (0, 0, 1)), // the last stayed
        ] {
            assert_eq!(faults(60.0, shown_at), expected, "{shown_at:?}");
        }
    }

    #[test]
    fn near_multiples_are_taken_for_multiples_and_others_take_turns() {
        for (refresh_hz, per_frame) in
            [(60.0, 2.0), (59.94, 2.0), (60.06, 2.0), (120.0, 4.0), (29.97, 1.0), (150.0, 5.0)]
        {
            assert_eq!(Cadence::new(30.0, Some(refresh_hz)).refreshes_per_frame(), per_frame);
        }
        let cadence = Cadence::new(30.0, Some(144.0));
        assert!(!cadence.is_even());
        let first: Vec<u64> = (0..6).map(|index| cadence.first_refresh(index)).collect();
        assert_eq!(first, [0, 5, 10, 15, 20, 24]);
        assert_eq!([4, 5, 23, 24].map(|refresh| cadence.frame_at(refresh)), [0, 1, 4, 5]);
    }

    #[test]
    fn the_clock_decides_what_is_due() {
        let mut playback = Playback::new(Cadence::new(30.0, Some(60.0)), 3);
        assert_eq!((playback.due(5.0), playback.next_change_s()), (Some(0), None));
        playback.shown(0, 5.0);
        // What is shown after the first screen is there at the second refresh at the earliest.
        for (now, due) in [(4.0, Some(0)), (5.0, Some(0)), (5.034, Some(1)), (5.099, None)] {
            assert_eq!(playback.due(now), due, "{now}");
        }
        assert_eq!(playback.end_s(), Some(5.1));
    }

    #[test]
    fn without_a_known_refresh_a_frame_is_late_after_4_ms() {
        for fps in [0.25, 10.0, 30.0] {
            for (delay_s, late) in [(0.0, 0), (0.004, 0), (0.0043, 1), (0.03, 1)] {
                let mut playback = Playback::new(Cadence::new(fps, None), 2);
                playback.shown(0, 0.0);
                playback.shown(1, 1.0 / fps + delay_s);
                assert_eq!(playback.faults().late, late, "{fps} {delay_s}");
            }
        }
    }
}

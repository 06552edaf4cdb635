//! Playing one sequence by the clock: which frame is due, and which came late.
//!
//! The first frame's showing is the onset. Frame i is due i/fps seconds after it; what is due at any
//! moment follows from the clock alone, never from counting or sleeping, so a hold-up skips frames
//! instead of stretching the motion. A frame is late if it was shown more than half a frame period
//! after it was due, or not at all.

/// One showing of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct Playback {
    fps: f64,
    frames: u32,
    onset_s: Option<f64>,
    last_shown: Option<u32>,
    late: u32,
}

/// Part of a frame period by which a clock reading may fall short of a frame's time and still count
/// as having reached it: rounding of the readings, far below what any display resolves.
const ROUNDING_FRAMES: f64 = 1e-6;

impl Playback {
    /// A showing of `frames` frames, not yet begun.
    pub fn new(fps: f64, frames: u32) -> Self {
        Self { fps, frames, onset_s: None, last_shown: None, late: 0 }
    }

    /// The frame that is due at `now_s`; none if the sequence is over.
    pub fn due(&self, now_s: f64) -> Option<u32> {
        let Some(onset_s) = self.onset_s else { return Some(0) };
        let index = ((now_s - onset_s) * self.fps + ROUNDING_FRAMES).floor().max(0.0) as u32;
        (index < self.frames).then_some(index)
    }

    /// Takes down that frame `index` was shown at `at_s`.
    pub fn shown(&mut self, index: u32, at_s: f64) {
        let onset_s = *self.onset_s.get_or_insert(at_s);
        if self.last_shown.is_some_and(|last| index <= last) {
            return;
        }
        let skipped = index - self.last_shown.map_or(0, |last| last + 1);
        let delay_frames = (at_s - onset_s) * self.fps - f64::from(index);
        self.late += skipped + u32::from(delay_frames > 0.5 + ROUNDING_FRAMES);
        self.last_shown = Some(index);
    }

    /// When the first frame was shown.
    pub fn onset_s(&self) -> Option<f64> {
        self.onset_s
    }

    /// When the next frame is due, or the end if none is left; none before the onset.
    pub fn next_change_s(&self) -> Option<f64> {
        let next = self.last_shown.map_or(0, |last| last + 1);
        self.onset_s.map(|onset| onset + f64::from(next) / self.fps)
    }

    /// When the last frame's time is up; none before the onset.
    pub fn end_s(&self) -> Option<f64> {
        self.onset_s.map(|onset| onset + f64::from(self.frames) / self.fps)
    }

    /// Late frames so far.
    pub fn late(&self) -> u32 {
        self.late
    }

    /// Late frames of the whole showing: those never shown are among them.
    pub fn late_at_end(&self) -> u32 {
        self.late + self.frames - self.last_shown.map_or(0, |last| last + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shows whatever is due at each of `times`; late frames at the end.
    fn late(times: &[f64]) -> u32 {
        let mut playback = Playback::new(30.0, 4);
        for &time in times {
            if let Some(index) = playback.due(time) {
                playback.shown(index, time);
            }
        }
        playback.late_at_end()
    }

    #[test]
    fn lateness_is_counted_per_frame() {
        let frame = 1.0 / 30.0;
        let times = |frames: &[f64]| frames.iter().map(|f| 7.0 + f * frame).collect::<Vec<_>>();
        for (shown_at, expected) in [
            (&[0.0, 1.0, 2.0, 3.0][..], 0),
            (&[0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5], 0), // 60 Hz
            (&[0.0, 1.4, 2.4, 3.4], 0),                     // late by less than half a frame
            (&[0.0, 1.6, 2.0, 3.0], 1),                     // frame 1 late
            (&[0.0, 2.1, 3.0], 1),                          // frame 1 skipped
            (&[0.0, 2.7, 3.0], 2),                          // frame 1 skipped, frame 2 late
            (&[0.0, 1.0], 2),                               // the rest never shown
            (&[0.0, 9.0], 3),
        ] {
            assert_eq!(late(&times(shown_at)), expected, "{shown_at:?}");
        }
    }

    #[test]
    fn the_clock_decides_what_is_due() {
        let mut playback = Playback::new(30.0, 3);
        assert_eq!((playback.due(5.0), playback.next_change_s()), (Some(0), None));
        playback.shown(0, 5.0);
        for (now, due) in [(5.0, Some(0)), (5.034, Some(1)), (5.099, Some(2)), (5.1, None)] {
            assert_eq!(playback.due(now), due, "{now}");
        }
        assert_eq!(playback.end_s(), Some(5.1));
    }
}

//! How far a render is: a bar on a terminal, a line per sequence elsewhere; and Ctrl-C.

use super::counted;
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use shutterlab_stimuli::generate::{Progress, passes};
use shutterlab_stimuli::{Sequence, Stimulus};
use std::collections::HashMap;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

static STOP: AtomicBool = AtomicBool::new(false);

/// Makes the first Ctrl-C a request to stop after the frame at hand. A second one ends the process.
fn watch_interrupts() {
    static WATCH: OnceLock<()> = OnceLock::new();
    WATCH.get_or_init(|| {
        let stop = || {
            if STOP.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
            eprintln!(
                "stopping after the frame at hand; Ctrl-C again stops at once, finished frames stay"
            );
        };
        if let Err(error) = ctrlc::set_handler(stop) {
            eprintln!("Ctrl-C will end the program at once ({error}); finished frames stay");
        }
    });
}

/// Progress of a render, measured in camera paths: frames of one grid differ a hundredfold in cost.
pub struct RenderProgress {
    bar: ProgressBar,
    /// By sequence folder, the camera paths that a frame of it adds to those of the level below.
    cost: HashMap<String, f64>,
    paths: f64,
    paths_done: f64,
    paths_rendered: f64,
    started: Instant,
    sequences: usize,
    /// The finished sequences, in order.
    pub finished: Vec<Sequence>,
}

impl RenderProgress {
    /// Progress over `frames_each` frames of every stimulus.
    pub fn new(stimuli: &[Stimulus], frames_each: impl Fn(&Stimulus) -> u32) -> Self {
        watch_interrupts();
        let style = ProgressStyle::with_template("{msg} [{bar:30}] {percent}% {prefix}");
        let bar = ProgressBar::new(1000);
        if let Ok(style) = style {
            bar.set_style(style.progress_chars("=> "));
        }
        let cost = costs(stimuli);
        Self {
            bar,
            paths: stimuli.iter().map(|s| cost[&s.folder_name()] * f64::from(frames_each(s))).sum(),
            cost,
            paths_done: 0.0,
            paths_rendered: 0.0,
            started: Instant::now(),
            sequences: stimuli.len(),
            finished: vec![],
        }
    }

    /// Time left at the speed so far; none before the first frame is rendered or after the last.
    fn time_left(&self) -> Option<String> {
        if self.paths_rendered == 0.0 || self.paths_done >= self.paths {
            return None;
        }
        let seconds = self.started.elapsed().as_secs_f64() / self.paths_rendered
            * (self.paths - self.paths_done);
        Some(format!("{} left", HumanDuration(Duration::from_secs_f64(seconds.max(0.0)))))
    }
}

fn costs(stimuli: &[Stimulus]) -> HashMap<String, f64> {
    let mut costs = HashMap::new();
    for pass in passes(stimuli) {
        let mut fewer = 0;
        for stimulus in pass {
            let (image, views) = (&stimulus.image, stimulus.views(0).len() as f64);
            let pixels = f64::from(image.width_px) * f64::from(image.height_px) * views;
            costs.insert(stimulus.folder_name(), pixels * f64::from(stimulus.samples - fewer));
            fewer = stimulus.samples;
        }
    }
    costs
}

impl Progress for RenderProgress {
    fn frame(&mut self, stimulus: &Stimulus, rendered: bool) {
        let cost = self.cost.get(&stimulus.folder_name()).copied().unwrap_or_default();
        self.paths_done += cost;
        if rendered {
            self.paths_rendered += cost;
        }
        let count = format!("{}/{}", self.finished.len() + 1, self.sequences);
        self.bar.set_message(format!("{count} {}", stimulus.folder_name()));
        self.bar.set_prefix(self.time_left().unwrap_or_default());
        self.bar.set_position((1000.0 * self.paths_done / self.paths) as u64);
    }

    fn sequence(&mut self, sequence: &Sequence, rendered: usize) {
        self.finished.push(sequence.clone());
        if self.bar.is_hidden() {
            let count = format!("{}/{}", self.finished.len(), self.sequences);
            let name = sequence.manifest.stimulus.folder_name();
            let what = match rendered {
                0 => "was finished".into(),
                _ => format!("{} rendered", counted(rendered, "frame")),
            };
            let left = self.time_left().map_or(String::new(), |left| format!(", {left}"));
            eprintln!("{count} {name}: {what}{left}");
        }
        if self.finished.len() == self.sequences {
            self.bar.finish_and_clear();
        }
    }

    fn stop(&self) -> bool {
        STOP.load(Ordering::Relaxed)
    }
}

//! A made-up study: observers who choose by a latent quality of each stimulus, with noise.

use shutterlab_data_schema::Response;
use shutterlab_data_schema::protocol::Eye;
use shutterlab_data_schema::protocol::Task;
use shutterlab_data_schema::response::{Answer, Clock, Pacing, Resampling, Side, TrialKind};

/// Nine stimuli of a grid, best first.
pub const STIMULI: [&str; 9] = [
    "M2-S2-T3-A4",
    "M2-S2-T3-A3",
    "M2-S2-T3-A5",
    "M2-S2-T4-A5",
    "M2-S2-T4-A4",
    "M2-S2-T4-A3",
    "M2-S2-T5-A5",
    "M2-S2-T5-A4",
    "M2-S2-T5-A3",
];

/// One session of each of `observers` subjects: two practice trials, then every pair of `stimuli`
/// (best first) once. A better stimulus is chosen more surely the further apart the two are.
pub fn study(observers: u32, stimuli: &[&str], kind: TrialKind) -> Vec<Response> {
    let mut random = Random(2012);
    let mut rows = Vec::new();
    for subject in 1..=observers {
        let practice = [(0, stimuli.len() - 1), (1, stimuli.len() - 1)];
        let pairs = (0..stimuli.len()).flat_map(|i| (i + 1..stimuli.len()).map(move |j| (i, j)));
        for (trial, (i, j)) in (1..).zip(practice.into_iter().chain(pairs)) {
            let kind = if trial <= 2 { TrialKind::Practice } else { kind };
            let first = if random.unit() < 0.5 { Side::A } else { Side::B };
            let better = random.unit() < 1.0 / (1.0 + (-0.45 * (j - i) as f64).exp());
            rows.push(response(
                subject,
                trial,
                kind,
                (stimuli[i], stimuli[j]),
                first,
                better,
                &mut random,
            ));
        }
    }
    rows
}

fn response(
    subject: u32,
    trial: u32,
    kind: TrialKind,
    (a, b): (&str, &str),
    first: Side,
    chooses_a: bool,
    random: &mut Random,
) -> Response {
    let observer = match kind {
        TrialKind::Simulated => "simulated:made-up",
        _ => "participant",
    };
    Response {
        study: "madeUp".into(),
        subject: format!("P{subject:02}").parse().unwrap(),
        session: 1,
        station: "desk".into(),
        block: u32::from(kind != TrialKind::Practice),
        trial,
        repetition: 1,
        attempt: 1,
        kind,
        observer: observer.into(),
        task: Task::TwoAfc,
        question: "Which of the two sequences has the higher quality?".into(),
        reference: None,
        stimulus_a: a.into(),
        exemplar_a: 0,
        hash_a: format!("hash of {a}"),
        stimulus_b: b.into(),
        exemplar_b: 0,
        hash_b: format!("hash of {b}"),
        first,
        answer: if chooses_a == (first == Side::A) { Answer::First } else { Answer::Second },
        selected: Some(if chooses_a { a } else { b }.into()),
        correct: None,
        response_time_s: 0.4 + 3.0 * random.unit() * random.unit(),
        replays_reference: None,
        replays_a: u32::from(random.unit() < 0.05),
        replays_b: 0,
        onset_reference_s: None,
        onset_a_s: 10.0 * f64::from(trial),
        onset_b_s: 10.0 * f64::from(trial) + 4.5,
        duration_reference_s: None,
        duration_a_s: 4.0,
        duration_b_s: 4.0,
        late_frames_reference: None,
        late_frames_a: u32::from(random.unit() < 0.02),
        late_frames_b: 0,
        dropped_frames_reference: None,
        dropped_frames_a: 0,
        dropped_frames_b: 0,
        repeated_frames_reference: None,
        repeated_frames_a: 0,
        repeated_frames_b: 0,
        clock: Clock::Submission,
        pacing: Pacing::FixedRefresh,
        refresh_hz: Some(60.0),
        refreshes_per_frame: Some(2.0),
        display: "Made-up 27, 2560x1440, scale 1".into(),
        display_profile: "identity".into(),
        display_profile_sha256: None,
        display_faults: None,
        stereo_mode: "mono".into(),
        magnification: 1.0,
        resampling: Resampling::None,
        eye: Eye::Follow,
        pixels_per_degree: 44.44,
        viewed_pixels_per_degree: None,
        model: None,
        r: None,
        level_of_detail: None,
        speed_deg_per_s: 10.0,
        pilot: kind == TrialKind::Pilot,
        answered_at: "2026-11-22T09:00:00Z".into(),
        program_version: "0.1.0".into(),
    }
}

/// The rows as the CSV that a session writes.
pub fn csv_text(rows: &[Response]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).unwrap();
    }
    String::from_utf8(writer.into_inner().unwrap()).unwrap()
}

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / u64::MAX as f64
    }
}

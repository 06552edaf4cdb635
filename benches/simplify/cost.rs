//! What a piece of work costs this process: time on the clock and of the processor, and memory (Linux).

use cpu_time::ProcessTime;
use std::io::{Error, Result};
use std::time::Instant;

/// Seconds and megabytes.
#[derive(Clone, Copy)]
pub struct Cost {
    pub wall_s: f64,
    pub cpu_s: f64,
    /// What was resident before.
    pub before_mb: f64,
    /// How much more was resident at most.
    pub peak_mb: f64,
}

/// Does `work` once.
pub fn of<T>(work: impl FnOnce() -> T) -> Result<(T, Cost)> {
    // The peak is now what is resident.
    std::fs::write("/proc/self/clear_refs", "5")?;
    let before_mb = resident_mb("VmRSS:")?;
    let (started, cpu) = (Instant::now(), ProcessTime::now());
    let done = work();
    let (wall_s, cpu_s) = (started.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
    let peak_mb = resident_mb("VmHWM:")? - before_mb;
    Ok((done, Cost { wall_s, cpu_s, before_mb, peak_mb }))
}

/// The line that every program here prints: median times, and the memory of the first run, which found the
/// heap as it was after reading.
pub fn line(costs: &[Cost]) -> Option<String> {
    let Cost { before_mb, peak_mb, .. } = costs.first()?;
    let wall_s = median(costs.iter().map(|cost| cost.wall_s));
    let cpu_s = median(costs.iter().map(|cost| cost.cpu_s));
    Some(format!("{wall_s:.4},{cpu_s:.4},{before_mb:.1},{peak_mb:.1}"))
}

/// The middle one of an odd number of values.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn resident_mb(field: &str) -> Result<f64> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let kib = status.lines().find_map(|line| line.strip_prefix(field)?.split_whitespace().next());
    let kib: f64 = kib.and_then(|kib| kib.parse().ok()).ok_or(Error::other("no memory status"))?;
    Ok(kib * 1024.0 / 1e6)
}

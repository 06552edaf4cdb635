//! `shutterlab display`: is this display fit for a session?

use super::say;
use anyhow::bail;
use shutterlab_data_schema::DisplayProfile;
use shutterlab_data_schema::response::Pacing;
use shutterlab_experiments::display::check::{DisplayCheck, THOROUGH_FRAMES};
use std::path::PathBuf;

/// Look at the display before people do.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, clap::Subcommand)]
enum Verb {
    /// Measure when the display takes frames, and hold it against its profile. Exit status 1 if
    /// anything does not fit
    Check {
        /// The display profile; without one, only what the system says is known
        #[arg(long, value_name = "FILE")]
        profile: Option<PathBuf>,
        /// Frames to present as fast as the display takes them
        #[arg(long, value_name = "N", default_value_t = THOROUGH_FRAMES,
              value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(100..=1_000_000))]
        frames: usize,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Show cards on which light, size and stereo can be seen to be right. Arrow keys turn them over,
    /// Escape ends
    Cards {
        /// The display profile
        #[arg(long, value_name = "FILE")]
        profile: Option<PathBuf>,
    },
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    match &args.verb {
        Verb::Check { profile, frames, json } => {
            let check = check(&read(profile.as_ref())?, *frames)?;
            say(&if *json { serde_json::to_string_pretty(&check)? } else { table(&check) })?;
            match check.faults.len() {
                0 => Ok(()),
                1 => bail!("display check: {}", check.faults[0]),
                n => bail!("display check: {n} things do not fit, first: {}", check.faults[0]),
            }
        }
        Verb::Cards { profile } => cards(&read(profile.as_ref())?),
    }
}

fn read(profile: Option<&PathBuf>) -> anyhow::Result<DisplayProfile> {
    Ok(match profile {
        Some(path) => DisplayProfile::read(path)?,
        None => DisplayProfile::identity(),
    })
}

#[cfg(feature = "window")]
fn check(profile: &DisplayProfile, frames: usize) -> anyhow::Result<DisplayCheck> {
    Ok(shutterlab_experiments::window::check::check(profile, frames)?)
}

#[cfg(feature = "window")]
fn cards(profile: &DisplayProfile) -> anyhow::Result<()> {
    Ok(shutterlab_experiments::window::cards::show(profile)?)
}

#[cfg(not(feature = "window"))]
fn check(_: &DisplayProfile, _: usize) -> anyhow::Result<DisplayCheck> {
    bail!("display check: this build has no window (feature `window`)")
}

#[cfg(not(feature = "window"))]
fn cards(_: &DisplayProfile) -> anyhow::Result<()> {
    bail!("display cards: this build has no window (feature `window`)")
}

/// What people read. The standard deviation is what studies of timing with a photodiode call precision,
/// there of light and here of handing over.
fn table(check: &DisplayCheck) -> String {
    let DisplayCheck { profile, facts, pacing, refresh_hz, intervals, dropped, faults } = check;
    let unknown = || "unknown".to_string();
    let size = |px: Option<[u32; 2]>| px.map_or_else(unknown, |[w, h]| format!("{w} x {h} px"));
    let hz = |hz: Option<f64>| hz.map_or_else(unknown, |hz| format!("{hz:.2} Hz"));
    let ms = |ms: f64| format!("{ms:.3} ms");
    let pacing = match pacing {
        Pacing::FixedRefresh => "fixed refresh",
        Pacing::VariableRefresh => "variable refresh",
        Pacing::Timer => "timer: the display paces nothing",
    };
    let kind = if facts.software { "software" } else { "hardware" };
    let monitor = facts.monitor.clone().unwrap_or_else(unknown);
    let mut rows = vec![
        ("profile", profile.clone()),
        ("monitor", format!("{monitor}, {}", size(facts.monitor_px))),
        ("window", format!("{}, scale factor {}", size(Some(facts.window_px)), facts.scale_factor)),
        ("adapter", format!("{} ({kind})", facts.adapter)),
        ("pacing", pacing.into()),
        ("refresh, measured", hz(*refresh_hz)),
        ("refresh, by the system", hz(facts.system_hz)),
        ("intervals", intervals.count.to_string()),
        ("median", ms(intervals.median_ms)),
        ("precision (SD)", ms(intervals.sd_ms)),
        ("99.9th percentile", ms(intervals.p999_ms)),
        ("worst", ms(intervals.worst_ms)),
        ("dropped", dropped.to_string()),
    ];
    rows.extend(faults.iter().map(|fault| ("does not fit", fault.clone())));
    if faults.is_empty() {
        rows.push(("result", "fit".into()));
    }
    rows.iter().map(|(name, value)| format!("{name:<24}{value}\n")).collect()
}

//! `shutterlab demo`: the whole way, small.

use super::analyze::{read_thumbnails, write_report};
use super::render::render;
use super::run::published_observer;
use super::say;
use crate::pipelines::DeviceChoice;
use anyhow::Context;
use shutterlab_analysis::input::responses;
use shutterlab_analysis::{analyze, report};
use shutterlab_data_schema::files::create_folder;
use shutterlab_data_schema::study::StudyKind;
use shutterlab_experiments::{SessionRequest, protocols, run_simulated};
use shutterlab_stimuli::generate::Request;
use shutterlab_stimuli::{Grid, Selection};
use std::path::PathBuf;

/// Go the whole way, small: render nine sequences, let 21 simulated observers compare them, analyse
/// their answers and write a report.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for everything the demo makes
    #[arg(short, long, value_name = "DIR", default_value = "demo")]
    out: PathBuf,
}

/// The votes that the simulated observers follow, and how many of them there are (Navarro 2012, §5.7).
const PUBLISHED: &str = "mono-shutter-sampling";
const OBSERVERS: u32 = 21;

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    create_folder(&args.out)?;
    let stimuli = args.out.join("stimuli");
    let study = args.out.join("study");

    eprintln!("1/3 rendering into {}", stimuli.display());
    let grid = Grid::load("demo")?;
    let cells = grid.stimuli(&Selection::default())?;
    let request =
        Request { grid: &grid.name, stimuli: &cells, frames: None, exr: false, out: &stimuli };
    render(&request, DeviceChoice::Auto)?;

    eprintln!("2/3 {OBSERVERS} simulated observers answer, as study {}", study.display());
    let protocol = protocols::load("demo")?;
    let observer = published_observer(PUBLISHED)?.context("the published votes")?;
    for number in 1..=OBSERVERS {
        let request = SessionRequest {
            protocol: protocol.clone(),
            stimuli: stimuli.clone(),
            study: study.clone(),
            participant: Some(format!("S{number:02}").parse()?),
            pilot: false,
        };
        run_simulated(&request, &observer)?;
    }

    eprintln!("3/3 analysing");
    // Simulated answers have a folder of their own in the study.
    let study = StudyKind::Simulated.folder(&study);
    let document = analyze(&responses::read(&[&study])?, 0.01)?.document();
    let command = format!("shutterlab demo -o {}", args.out.display());
    let thumbnails = read_thumbnails(&study)?;
    let page =
        write_report(&document, &args.out.join("report"), &protocol.title, &thumbnails, &command)?;
    say(&report::text(&document))?;
    say(&format!("\nreport: {}", std::path::absolute(&page)?.display()))
}

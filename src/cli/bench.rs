//! `shutterlab bench`: the papers' measurements, made anew on this machine.

mod motion_blur;

/// Measure what the papers measured, on this machine.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    MotionBlur(motion_blur::Args),
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    match &args.what {
        What::MotionBlur(args) => motion_blur::run(args),
    }
}

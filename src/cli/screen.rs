//! `shutterlab screen`: what predictors of vision say about sequences before anybody sees them.

use super::{UsageError, counted, say};
use anyhow::{Context, anyhow};
use indicatif::{ProgressBar, ProgressStyle};
use shutterlab_data_schema::files::write_atomically;
use shutterlab_stimuli::screen::{Comparison, compare, figure};
use shutterlab_stimuli::{Selection, Sequence, Stimulus};
use std::path::{Path, PathBuf};

/// Compare rendered sequences pairwise by ColorVideoVDP, FLIP and PSNR, into screen.csv and screen.svg; where models are
/// simplified, each with its original alone, into screen.csv.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of sequence folders
    folder: PathBuf,
    /// Sequences to compare, such as material=M2,samples=A3,samples=A5; given again, adds sequences
    #[arg(long, value_name = "AXIS=LEVEL,…")]
    select: Vec<String>,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let mut sequences = Sequence::open_all(&args.folder)?;
    let there: Vec<String> = sequences.iter().map(|s| s.manifest.sha256.clone()).collect();
    // Where there are no sequences, there are no levels to select.
    if !sequences.is_empty() {
        let stimuli: Vec<&Stimulus> = sequences.iter().map(|s| &s.manifest.stimulus).collect();
        let selection =
            Selection::parse_for_screen(&args.select, &stimuli).map_err(UsageError::from)?;
        sequences.retain(|sequence| selection.takes_stimulus(&sequence.manifest.stimulus));
    }
    if sequences.len() < 2 {
        let found = counted(sequences.len(), "sequence");
        let folder = args.folder.display();
        return Err(anyhow!("screen: {folder}: {found} found: at least two are needed"));
    }
    let file = args.folder.join("screen.csv");
    let mut rows = read(&file)?;
    let is_simplified = |one: &Sequence| one.manifest.stimulus.simplification.is_some();
    let is_simplified_from = |one: &Sequence, original: &Sequence| {
        one.manifest.stimulus.is_simplified_from(&original.manifest.stimulus)
    };
    // What simplified models come from is compared with them alone.
    let is_original = |one: &Sequence| sequences.iter().any(|other| is_simplified_from(other, one));
    let originals: Vec<bool> = sequences.iter().map(is_original).collect();
    let pairs: Vec<(&Sequence, &Sequence)> = (0..sequences.len())
        .flat_map(|i| (i + 1..sequences.len()).map(move |j| (i, j)))
        .filter(|&(i, j)| !(originals[i] && originals[j]))
        .map(|(i, j)| (&sequences[i], &sequences[j]))
        .filter_map(|(a, b)| match [a, b].map(is_simplified) {
            [false, false] => Some((a, b)),
            _ if is_simplified_from(b, a) => Some((a, b)),
            _ if is_simplified_from(a, b) => Some((b, a)),
            _ => None,
        })
        .collect();
    if pairs.is_empty() {
        return Err(anyhow!(
            "screen: {}: no original of a simplified model is among them",
            args.folder.display()
        ));
    }
    let is_of = |row: &Comparison, (a, b): (&Sequence, &Sequence)| {
        row.reference_sha256 == a.manifest.sha256 && row.test_sha256 == b.manifest.sha256
    };
    // Rows about sequences that are no longer what they were say nothing.
    rows.retain(|row| [&row.reference_sha256, &row.test_sha256].iter().all(|h| there.contains(h)));
    let known = pairs.iter().filter(|&&pair| rows.iter().any(|row| is_of(row, pair))).count();
    let bar = ProgressBar::new(pairs.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{pos}/{len} pairs [{bar:30}] {eta} left") {
        bar.set_style(style.progress_chars("=> "));
    }
    eprintln!("pairs: {}, of which {} are compared already", pairs.len(), known);
    for &pair in &pairs {
        if !rows.iter().any(|row| is_of(row, pair)) {
            rows.push(compare(pair.0, pair.1)?);
            write(&file, &rows)?;
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    write(&file, &rows)?;
    let svg = args.folder.join("screen.svg");
    if sequences.iter().any(is_simplified) {
        // A matrix would be almost empty, and one from before is about other pairs.
        return match std::fs::remove_file(&svg) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error.into()),
            _ => say(&file.display().to_string()),
        };
    }
    rows.retain(|row| pairs.iter().any(|&pair| is_of(row, pair)));
    write_atomically(&svg, figure(&rows).as_bytes())?;
    say(&format!("{}\n{}", file.display(), svg.display()))
}

fn read(file: &Path) -> anyhow::Result<Vec<Comparison>> {
    if !file.exists() {
        return Ok(vec![]);
    }
    let unreadable = || format!("{}: cannot be read; remove it to begin again", file.display());
    let mut reader = csv::Reader::from_path(file).with_context(unreadable)?;
    reader.deserialize().collect::<Result<_, _>>().with_context(unreadable)
}

fn write(file: &Path, rows: &[Comparison]) -> anyhow::Result<()> {
    let mut writer = csv::Writer::from_writer(vec![]);
    for row in rows {
        writer.serialize(row)?;
    }
    Ok(write_atomically(file, &writer.into_inner()?)?)
}

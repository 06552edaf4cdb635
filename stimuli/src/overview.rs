//! Looks at a folder of sequences: a contact sheet as one PNG, and a page that plays them.
//!
//! The sheet has a block for each combination of levels of the other axes; in it a row per level of
//! `samples` and a column per level of `shutter`, as Figure 5.1 of Navarro (2012).

use crate::frames::EncodedImage;
use crate::letters::{self, LETTER_PX};
use crate::manifest::{Sequence, SequenceError};
use crate::stimulus::Stimulus;
use indexmap::{IndexMap, IndexSet};
use shutterlab_data_schema::files::write_atomically;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Name of the contact sheet.
pub const SHEET: &str = "contact-sheet.png";
/// Name of the page.
pub const PAGE: &str = "index.html";

/// Axes of the rows and of the columns of a block.
const ROWS: &str = "samples";
const COLUMNS: &str = "shutter";

/// Width that thumbnails are scaled down to.
const THUMBNAIL_PX: usize = 160;
/// The gap between things.
const GAP_PX: usize = 8;

/// Writes the contact sheet and the page of the finished sequences in `folder` into it, and returns
/// their paths; nothing if there is no sequence.
///
/// # Errors
/// A sequence is damaged, or a file cannot be written.
pub fn write(folder: &Path) -> Result<Option<[PathBuf; 2]>, SequenceError> {
    let mut sequences = Sequence::open_all(folder)?;
    sequences.retain(|sequence| !sequence.manifest.frames.is_empty());
    if sequences.is_empty() {
        return Ok(None);
    }
    sequences.sort_by(|a, b| natural(&folder_name(a)).cmp(&natural(&folder_name(b))));
    let [sheet, page] = [SHEET, PAGE].map(|name| folder.join(name));
    write_atomically(&sheet, &contact_sheet(&sequences)?.to_png()?)?;
    write_atomically(&page, index_page(&sequences).as_bytes())?;
    Ok(Some([sheet, page]))
}

fn folder_name(sequence: &Sequence) -> Cow<'_, str> {
    sequence.folder.file_name().unwrap_or_default().to_string_lossy()
}

/// What puts names in the order in which one counts, A2 before A10: runs of digits by their value, the
/// rest letter by letter, numbers before letters. Where only leading zeros differ, the name decides.
fn natural(name: &str) -> (Vec<(usize, &[u8])>, &str) {
    let runs = name.as_bytes().chunk_by(|a, b| a.is_ascii_digit() == b.is_ascii_digit());
    let keys = runs.map(|run| {
        if !run[0].is_ascii_digit() {
            return (usize::MAX, run);
        }
        let zeros = run.iter().take_while(|digit| **digit == b'0').count();
        (run.len() - zeros, &run[zeros..])
    });
    (keys.collect(), name)
}

/// One block of the sheet: sequences that differ in the axes of its rows and columns alone.
#[derive(Default)]
struct Block<'a> {
    cells: IndexMap<[&'a str; 2], &'a Sequence>,
}

fn contact_sheet(sequences: &[Sequence]) -> Result<EncodedImage, SequenceError> {
    let mut blocks: IndexMap<String, Block<'_>> = IndexMap::new();
    for sequence in sequences {
        let stimulus = &sequence.manifest.stimulus;
        let block = blocks.entry(block_title(stimulus)).or_default();
        let cell = [ROWS, COLUMNS].map(|axis| stimulus.levels.get(axis).map_or("", String::as_str));
        block.cells.insert(cell, sequence);
    }
    let scaled = |sequence: &Sequence| {
        let [width, _] = sequence.manifest.stimulus.frame_size_px();
        (width as usize).div_ceil(THUMBNAIL_PX)
    };
    let thumbnail_px = |sequence: &Sequence| {
        let factor = scaled(sequence);
        sequence.manifest.stimulus.frame_size_px().map(|side| (side as usize / factor).max(1))
    };
    let largest = |axis: usize| sequences.iter().map(|s| thumbnail_px(s)[axis]).max().unwrap_or(1);
    let [width, height] = [largest(0), largest(1)];
    let levels = |axis: usize| -> IndexSet<&str> {
        let mut levels: Vec<&str> =
            blocks.values().flat_map(|block| block.cells.keys().map(|cell| cell[axis])).collect();
        levels.sort_unstable_by(|a, b| natural(a).cmp(&natural(b)));
        levels.into_iter().collect()
    };
    let [rows, columns] = [levels(0), levels(1)];
    let margin = GAP_PX + LETTER_PX * rows.iter().map(|row| row.len()).max().unwrap_or(0);
    let block_width = GAP_PX + margin + columns.len() * (width + GAP_PX);
    let block_height = GAP_PX + 3 * LETTER_PX + rows.len() * (height + GAP_PX);
    // Blocks in rows of about as many as there are rows of them.
    let across = (blocks.len() as f64).sqrt().ceil() as usize;
    let mut sheet = Canvas::new(across * block_width, blocks.len().div_ceil(across) * block_height);
    for (number, (title, block)) in blocks.iter().enumerate() {
        let [left, top] = [number % across * block_width, number / across * block_height];
        sheet.text(left + GAP_PX, top + GAP_PX, title);
        let header = top + GAP_PX + 2 * LETTER_PX - LETTER_PX / 2;
        for (column, name) in columns.iter().enumerate() {
            sheet.text(left + GAP_PX + margin + column * (width + GAP_PX), header, name);
        }
        for (row, name) in rows.iter().enumerate() {
            let y = top + GAP_PX + 3 * LETTER_PX + row * (height + GAP_PX);
            sheet.text(left + GAP_PX, y + height / 2, name);
            for (column, shutter) in columns.iter().enumerate() {
                let Some(sequence) = block.cells.get(&[*name, *shutter]) else { continue };
                let frames = &sequence.manifest.frames;
                let frame = sequence.read_frame(&frames[frames.len() / 2])?;
                let x = left + GAP_PX + margin + column * (width + GAP_PX);
                sheet.picture(x, y, &frame, scaled(sequence));
            }
        }
    }
    Ok(sheet.0)
}

/// The levels of the axes that a block has one of: `M2 S2`.
fn block_title(stimulus: &Stimulus) -> String {
    let others =
        stimulus.levels.iter().filter(|(axis, _)| ![ROWS, COLUMNS].contains(&axis.as_str()));
    let mut title = others.map(|(_, level)| level.as_str()).collect::<Vec<_>>().join(" ");
    if stimulus.exemplar > 0 {
        title += &format!(" E{}", stimulus.exemplar);
    }
    title
}

struct Canvas(EncodedImage);

impl Canvas {
    /// A white one.
    fn new(width: usize, height: usize) -> Self {
        let bytes = vec![255; 3 * width * height];
        Self(EncodedImage { width: width as u32, height: height as u32, bytes })
    }

    fn set(&mut self, x: usize, y: usize, color: [u8; 3]) {
        let (width, height) = (self.0.width as usize, self.0.height as usize);
        if x < width && y < height {
            self.0.bytes[3 * (y * width + x)..][..3].copy_from_slice(&color);
        }
    }

    fn text(&mut self, x: usize, y: usize, text: &str) {
        letters::write(&mut self.0, [x, y], text, 1);
    }

    /// `image` at 1/`factor` of its size, each pixel the mean of `factor`² code values.
    fn picture(&mut self, x: usize, y: usize, image: &EncodedImage, factor: usize) {
        let row_bytes = 3 * image.width as usize;
        for j in 0..image.height as usize / factor {
            for i in 0..image.width as usize / factor {
                let mean = |channel: usize| {
                    let rows = image.bytes.chunks(row_bytes).skip(j * factor).take(factor);
                    let codes = rows.flat_map(|row| {
                        row[3 * i * factor..][..3 * factor].iter().skip(channel).step_by(3)
                    });
                    (codes.map(|&code| usize::from(code)).sum::<usize>() / (factor * factor)) as u8
                };
                self.set(x + i, y + j, [mean(0), mean(1), mean(2)]);
            }
        }
    }
}

/// The page, which finds the frames beside itself.
fn index_page(sequences: &[Sequence]) -> String {
    let list: Vec<_> = sequences
        .iter()
        .map(|sequence| {
            let stimulus = &sequence.manifest.stimulus;
            serde_json::json!({
                "folder": folder_name(sequence),
                "grid": sequence.manifest.grid,
                "levels": stimulus.levels,
                "exemplar": stimulus.exemplar,
                "size": stimulus.frame_size_px(),
                "fps": stimulus.image.fps,
                "frames": sequence.manifest.frames.iter().map(|f| f.index).collect::<Vec<_>>(),
            })
        })
        .collect();
    // Within a script no text may look like a tag.
    let list = serde_json::Value::from(list).to_string().replace('<', "\\u003c");
    include_str!("overview.html").replace("[/*SEQUENCES*/]", &list)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_averaged_and_nothing_is_drawn_outside() {
        let mut canvas = Canvas::new(4, 2);
        let bytes = [10, 10, 10, 20, 20, 20, 30, 30, 30, 40, 40, 40];
        let image = EncodedImage { width: 2, height: 2, bytes: bytes.into() };
        canvas.picture(3, 0, &image, 1);
        canvas.picture(1, 1, &image, 2);
        let red: Vec<u8> = canvas.0.bytes.iter().step_by(3).copied().collect();
        assert_eq!(red, [255, 255, 255, 10, 255, 25, 255, 30]);
    }

    #[test]
    fn names_are_in_the_order_in_which_one_counts() {
        let mut names = ["A10-T2", "B1", "A2-T10", "A02", "A2", "A2-T9", "A", "10", "9"];
        names.sort_by(|a, b| natural(a).cmp(&natural(b)));
        assert_eq!(names, ["9", "10", "A", "A02", "A2", "A2-T9", "A2-T10", "A10-T2", "B1"]);
    }
}

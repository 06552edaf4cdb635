//! The analysis for people: a text for the terminal, one HTML page, and files with every table and
//! figure.

pub mod document;
mod files;
mod html;
pub(crate) mod labels;
mod picture;
pub mod plot;
pub mod quality;
pub mod section;
pub mod terminal;
mod text;

use std::collections::BTreeMap;

pub use document::Document;
pub use files::{csv, files, files_of};
pub use html::html;
pub use text::text;

/// What a report says beside the analysis.
#[derive(Clone, Copy, Debug)]
pub struct ReportContext<'a> {
    /// What the experiment was about, in one line.
    pub title: &'a str,
    /// A thumbnail of each stimulus, PNG, by stimulus id. Stimuli may be missing.
    pub thumbnails: &'a BTreeMap<String, Vec<u8>>,
    /// The exact command that made the report.
    pub command: &'a str,
    /// The version of the program that made it.
    pub version: &'a str,
}

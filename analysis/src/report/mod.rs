//! The analysis for people: a text for the terminal, tables as CSV, and one HTML page.

mod figures;
mod html;
mod labels;
mod sentences;
mod tables;
mod text;

use std::collections::BTreeMap;

pub use html::html;
pub use tables::tables;
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

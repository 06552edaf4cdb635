//! Why an input cannot be analysed: each message names the file, the field, the value and what was
//! allowed.

use shutterlab_data_schema::definition::DefinitionError;
use shutterlab_data_schema::item_table::TableError;

/// The input could not be read or cannot be analysed.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// A file or folder could not be read.
    #[error("{file}: cannot be read: {source}")]
    Unreadable {
        /// The file or folder.
        file: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// A line of a file does not hold what it should.
    #[error("{file}: line {line}: {field}: {value}: {allowed}")]
    Line {
        /// The file.
        file: String,
        /// The line, from 1.
        line: u64,
        /// The column, or what the line was read as.
        field: String,
        /// What was found.
        value: String,
        /// What was allowed.
        allowed: String,
    },
    /// A file as a whole does not hold what it should.
    #[error("{file}: {field}: {value}: {allowed}")]
    Value {
        /// The file or folder.
        file: String,
        /// What was looked at.
        field: String,
        /// What was found.
        value: String,
        /// What was allowed.
        allowed: String,
    },
    /// A table of votes could not be read.
    #[error(transparent)]
    Votes(#[from] TableError),
    /// A study's protocol could not be read.
    #[error(transparent)]
    Protocol(#[from] DefinitionError),
    /// The level of significance is no probability.
    #[error("alpha: {0}: a number above 0 and below 1 is needed")]
    Alpha(f64),
    /// The margin of equivalence is no part of one half.
    #[error("margin: {0}: a number above 0 and below 0.5 is needed")]
    Margin(f64),
}

impl InputError {
    pub(crate) fn value(
        file: &str,
        field: impl Into<String>,
        value: impl ToString,
        allowed: impl Into<String>,
    ) -> Self {
        Self::Value {
            file: file.into(),
            field: field.into(),
            value: value.to_string(),
            allowed: allowed.into(),
        }
    }

    pub(crate) fn line(
        file: &str,
        line: u64,
        field: impl Into<String>,
        value: impl ToString,
        allowed: impl Into<String>,
    ) -> Self {
        Self::Line {
            file: file.into(),
            line,
            field: field.into(),
            value: value.to_string(),
            allowed: allowed.into(),
        }
    }
}

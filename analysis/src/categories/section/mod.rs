//! Matching and same/different in words, tables and figures.

mod matching;
mod method;
mod same_different;
mod sentences;
mod tables;

use super::{Matching, SameDifferent};
use crate::outcome::Outcome;
use crate::report::section::Section;

/// The section on matching; `matching` says why there is none.
pub fn matching(matching: &Outcome<Matching>) -> Section {
    or_reason("Matching", matching, matching::section)
}

/// The section on same/different; `same_different` says why there is none.
pub fn same_different(same_different: &Outcome<SameDifferent>) -> Section {
    or_reason("Same or different", same_different, same_different::section)
}

fn or_reason<T>(heading: &str, result: &Outcome<T>, section: fn(&T) -> Section) -> Section {
    let section = match result {
        Ok(result) => section(result),
        Err(reason) => {
            Section { sentences: vec![format!("Not known: {reason}.")], ..Section::default() }
        }
    };
    Section { heading: heading.into(), ..section }
}

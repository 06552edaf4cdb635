//! The axes of a grid of stimuli, read from their ids.

use crate::outcome::Outcome;

/// An axis along which the stimuli differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// Its levels, in order: `T3`, `T4`, `T10`.
    pub levels: Vec<String>,
    /// For each stimulus, the place of its level among `levels`.
    pub of_item: Vec<usize>,
}

impl Axis {
    /// A name for people: its levels.
    pub fn name(&self) -> String {
        self.levels.join("/")
    }
}

/// The axes along which `items` differ. An id such as `M2-S2-T3-A4` joins one level per axis by `-`.
///
/// # Errors
/// In words: the ids have no common form, or do not differ in any part.
pub fn axes(items: &[String]) -> Outcome<Vec<Axis>> {
    let ids: Vec<Vec<&str>> = items.iter().map(|item| item.split('-').collect()).collect();
    let parts = ids.first().map_or(0, Vec::len);
    if parts < 2 || ids.iter().any(|id| id.len() != parts) {
        return Err(
            "the ids of the stimuli do not join one level per axis, as M2-S2-T3-A4 does".into()
        );
    }
    let axes: Vec<Axis> = (0..parts)
        .map(|part| {
            let mut levels: Vec<&str> = ids.iter().map(|id| id[part]).collect();
            levels.sort_by_key(|level| numbered(level));
            levels.dedup();
            let place = |level| levels.iter().position(|other| *other == level).unwrap_or(0);
            Axis {
                of_item: ids.iter().map(|id| place(id[part])).collect(),
                levels: levels.iter().map(ToString::to_string).collect(),
            }
        })
        .filter(|axis| axis.levels.len() > 1)
        .collect();
    match axes.is_empty() {
        true => Err("the stimuli do not differ along any axis".into()),
        false => Ok(axes),
    }
}

/// A level's letters and number, so that `T10` comes after `T9`.
fn numbered(level: &str) -> (&str, u64, &str) {
    let letters = level.trim_end_matches(|c: char| c.is_ascii_digit());
    (letters, level[letters.len()..].parse().unwrap_or(0), level)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_come_in_the_order_of_their_numbers() {
        let items = ["M2-T10", "M2-T9", "M2-T9"].map(String::from);
        let axes = axes(&items).unwrap();
        assert_eq!(axes.len(), 1);
        assert_eq!(axes[0].levels, ["T9", "T10"]);
        assert_eq!(axes[0].of_item, [1, 0, 0]);
        assert_eq!(axes[0].name(), "T9/T10");
    }

    #[test]
    fn ids_of_another_form_are_refused_in_words() {
        for items in [["a-b", "a"], ["A4T3", "A5T4"]] {
            let error = axes(&items.map(String::from)).unwrap_err();
            assert!(error.starts_with("the ids of the stimuli do not"), "{error}");
        }
        let same = axes(&["a-b", "a-b"].map(String::from)).unwrap_err();
        assert!(same.starts_with("the stimuli do not differ"), "{same}");
    }
}

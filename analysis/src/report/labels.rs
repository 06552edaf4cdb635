//! Short names and words: stimulus ids without the levels that all of them share, letters for groups,
//! counts.

/// Labels of `items` for people: an id such as `M2-S2-T3-A4` joins one level per axis by `-`; the
/// levels that all items have in common are dropped (`T3-A4`).
pub fn labels(items: &[String]) -> Vec<String> {
    let levels: Vec<Vec<&str>> = items.iter().map(|item| item.split('-').collect()).collect();
    let Some(first) = levels.first() else { return Vec::new() };
    if levels.iter().any(|item| item.len() != first.len()) {
        return items.to_vec();
    }
    let varies: Vec<bool> =
        (0..first.len()).map(|axis| levels.iter().any(|item| item[axis] != first[axis])).collect();
    levels
        .iter()
        .map(|item| {
            let kept = item.iter().zip(&varies).filter(|(_, varies)| **varies);
            kept.map(|(level, _)| *level).collect::<Vec<_>>().join("-")
        })
        .collect()
}

/// The levels that all `items` have in common, joined by `-`; empty if there are none.
pub fn common_levels(items: &[String]) -> String {
    let levels: Vec<Vec<&str>> = items.iter().map(|item| item.split('-').collect()).collect();
    let Some(first) = levels.first() else { return String::new() };
    if levels.iter().any(|item| item.len() != first.len()) {
        return String::new();
    }
    let common =
        (0..first.len()).filter(|axis| levels.iter().all(|item| item[*axis] == first[*axis]));
    common.map(|axis| first[axis]).collect::<Vec<_>>().join("-")
}

/// How many: `1 trial`, `2 trials`.
pub(crate) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// The letter of group `index` from 0: a, b, … z, then a2, b2, ….
pub fn letter(index: usize) -> String {
    let letter = char::from(b'a' + (index % 26) as u8);
    match index / 26 {
        0 => letter.to_string(),
        round => format!("{letter}{}", round + 1),
    }
}

/// The letters of the groups that `item` belongs to.
pub fn letters(item: &str, groups: &[Vec<String>]) -> String {
    let of_item = groups.iter().enumerate().filter(|(_, group)| group.iter().any(|i| i == item));
    of_item.map(|(index, _)| letter(index)).collect()
}

/// A number with four significant digits, without zeros at its end.
pub(crate) fn significant(value: f64) -> String {
    let size = libm::log10(value.abs());
    if value == 0.0 || !(-4.0..7.0).contains(&size) {
        return if value == 0.0 { "0".into() } else { format!("{value:.3e}") };
    }
    let decimals = (3 - size.floor() as i32).max(0) as usize;
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').into(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(items: &[&str]) -> (Vec<String>, String) {
        let items: Vec<String> = items.iter().map(ToString::to_string).collect();
        (labels(&items), common_levels(&items))
    }

    #[test]
    fn levels_that_all_share_are_dropped() {
        let (labels, common) = of(&["M2-S2-T3-A4", "M2-S2-T4-A4", "M2-S2-T3-A5"]);
        assert_eq!(labels, ["T3-A4", "T4-A4", "T3-A5"]);
        assert_eq!(common, "M2-S2");
    }

    #[test]
    fn names_of_another_form_stay() {
        assert_eq!(of(&["A4T3", "A5T4"]), (vec!["A4T3".into(), "A5T4".into()], String::new()));
        assert_eq!(of(&["a-b", "a"]), (vec!["a-b".into(), "a".into()], String::new()));
    }

    #[test]
    fn groups_have_letters() {
        assert_eq!([letter(0), letter(25), letter(26)], ["a", "z", "a2"]);
        let groups = [vec!["A".to_string(), "B".into()], vec!["B".into(), "C".into()]];
        assert_eq!(letters("B", &groups), "ab");
        assert_eq!(letters("D", &groups), "");
    }

    #[test]
    fn numbers_have_four_digits() {
        for (value, text) in [
            (0.0, "0"),
            (7.3, "7.3"),
            (-0.123_456, "-0.1235"),
            (1234.56, "1235"),
            (120_000.0, "120000"),
            (0.001, "0.001"),
            (3.21e-7, "3.210e-7"),
        ] {
            assert_eq!(significant(value), text);
        }
    }
}

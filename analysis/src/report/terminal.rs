//! Sections as text for the terminal, at most [`WIDTH`] columns wide.

use super::section::{Cell, Kind, Section, Table};

/// Columns of the terminal that are used.
pub const WIDTH: usize = 96;

/// Space between two columns of a table.
const GAP: usize = 2;

/// A section: heading, sentences and tables. Method and references are for the page.
pub fn section(section: &Section) -> String {
    let mut out = format!("{}\n", section.heading);
    for sentence in &section.sentences {
        out += &paragraph(sentence, "  ");
    }
    for table in &section.tables {
        out += &format!("\n{}{}", paragraph(&table.caption, "  "), grid(table));
    }
    out
}

/// `text` in lines that begin with `indent`; further lines stand a little deeper.
pub fn paragraph(text: &str, indent: &str) -> String {
    let lines = wrap(text, WIDTH - indent.len() - 2);
    let line = |(number, line): (usize, &String)| {
        format!("{indent}{}{line}\n", if number == 0 { "" } else { "  " })
    };
    lines.iter().enumerate().map(line).collect()
}

/// `text` in lines of at most `width` characters, broken between words but not within `p = 0.02`.
pub(crate) fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    let length = |text: &str| text.chars().count();
    let whole = [" = ", " < ", " ≥ ", " ≤ "]
        .iter()
        .fold(text.to_string(), |text, sign| text.replace(sign, &sign.replace(' ', "\u{a0}")));
    for word in whole.split([' ', '\n']).filter(|word| !word.is_empty()) {
        let word = word.replace('\u{a0}', " ");
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(&word),
            Some(line) if length(line) + 1 + length(&word) <= width => {
                line.push(' ');
                line.push_str(&word);
            }
            _ => lines.push(word),
        }
    }
    lines
}

/// One row of a table: cells of these `widths`, wrapped, to the left or to the right.
pub(crate) fn row(cells: &[String], widths: &[usize], to_right: &[bool]) -> String {
    let wrapped: Vec<Vec<String>> =
        cells.iter().zip(widths).map(|(cell, width)| wrap(cell, *width)).collect();
    let height = wrapped.iter().map(Vec::len).max().unwrap_or(0);
    let gap = " ".repeat(GAP);
    let line = |number: usize| {
        let columns = wrapped.iter().zip(widths.iter().zip(to_right));
        let cells = columns.map(|(lines, (width, right))| {
            let text = lines.get(number).map_or("", String::as_str);
            if *right { format!("{text:>width$}") } else { format!("{text:width$}") }
        });
        format!("{gap}{}\n", cells.collect::<Vec<_>>().join(&gap).trim_end())
    };
    (0..height).map(line).collect()
}

fn grid(table: &Table) -> String {
    let titles: Vec<String> = table.columns.iter().map(|column| column.title.clone()).collect();
    let kinds: Vec<Kind> = table.columns.iter().map(|column| column.kind).collect();
    let rows: Vec<Vec<String>> = table
        .rows
        .iter()
        .map(|row| row.iter().zip(&kinds).map(|(cell, kind)| text(cell, *kind)).collect())
        .collect();
    let longest = |texts: &mut dyn Iterator<Item = &str>| {
        texts.map(|text| text.chars().count()).max().unwrap_or(0)
    };
    // A column is as wide as its longest cell and the longest word of its title.
    let mut widths: Vec<usize> = titles
        .iter()
        .enumerate()
        .map(|(column, title)| {
            let cells = longest(&mut rows.iter().map(|row| row[column].as_str()));
            cells.max(longest(&mut title.split_whitespace()))
        })
        .collect();
    // What is too wide takes from the widest column.
    let mut excess = (widths.iter().sum::<usize>() + GAP * widths.len()).saturating_sub(WIDTH);
    while excess > 0 {
        match widths.iter_mut().max() {
            Some(widest) if *widest > 12 => *widest -= 1,
            _ => break,
        }
        excess -= 1;
    }
    let to_right: Vec<bool> = kinds.iter().map(|kind| *kind != Kind::Text).collect();
    let head = row(&titles, &widths, &to_right);
    rows.iter().fold(head, |out, cells| out + &row(cells, &widths, &to_right))
}

/// A value as people read it.
fn text(cell: &Cell, kind: Kind) -> String {
    match (cell, kind) {
        (Cell::Text(text), _) => text.clone(),
        (Cell::Integer(number), _) => number.to_string(),
        (Cell::Number(number), Kind::Number(decimals)) => format!("{number:.decimals$}"),
        (Cell::Number(number), _) => number.to_string(),
        (Cell::P(p), _) => p.to_string(),
        (Cell::Flag(true), _) => "yes".into(),
        (Cell::Flag(false), _) => "no".into(),
        (Cell::Missing, _) => "–".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::section::Column;

    #[test]
    fn no_line_is_too_long_and_no_word_is_lost() {
        let words = "lorem ipsum dolor sit amet consectetur ".repeat(8);
        let column = |name: &str, kind| Column::new(name, name, kind, "");
        let table = Table {
            name: "t".into(),
            caption: words.clone(),
            columns: vec![column("a", Kind::Text), column("b", Kind::Number(2))],
            rows: vec![vec![words.as_str().into(), 1.25.into()], vec!["x".into(), Cell::Missing]],
        };
        let section = Section {
            heading: "Heading".into(),
            sentences: vec![words.clone()],
            tables: vec![table],
            ..Section::default()
        };
        let text = super::section(&section);
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH), "{text}");
        let count = |text: &str, word: &str| text.split_whitespace().filter(|w| *w == word).count();
        assert_eq!(count(&text, "ipsum"), 24);
        assert_eq!((count(&text, "1.25"), count(&text, "–")), (1, 1));
    }
}

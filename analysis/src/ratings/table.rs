//! Reading tables for the fits: ratings by image, spatial frequencies by level of detail, and points.

use super::answers::Ratings;
use super::images::{Counts, Image};
use super::points::{Frequencies, Point};
use crate::error::InputError;
use crate::input::columns::{Columns, Row, text_of};
use shutterlab_data_schema::fitted::VelocityUnit;
use std::path::Path;

const RATING: [&str; 6] = ["model", "r", "level_of_detail", "speed", "same", "different"];
const ABOVE_0: &str = "a number above 0";

/// A table of ratings.
#[derive(Clone, Debug, PartialEq)]
pub struct RatingTable {
    /// The answers of all observers together.
    pub ratings: Ratings,
    /// The spatial frequencies, if it has the column `frequency`.
    pub frequencies: Option<Frequencies>,
}

/// Whether the file at `path` begins like a table of ratings and not like responses.
///
/// # Errors
/// It cannot be read.
pub fn is_rating_table(path: &Path) -> Result<bool, InputError> {
    let text = text_of(path)?;
    let header = text.lines().find(|line| !line.starts_with('#')).unwrap_or_default();
    Ok(header.split(',').any(|name| name.trim() == "different"))
}

/// Reads the CSV `model,r,level_of_detail,speed,same,different` at `path`, perhaps with a column
/// `frequency`. Its speeds are in `unit`.
///
/// # Errors
/// The file cannot be read, or as [`parse_ratings`].
pub fn read_ratings(path: &Path, unit: VelocityUnit) -> Result<RatingTable, InputError> {
    parse_ratings(&text_of(path)?, &path.display().to_string(), unit)
}

/// Parses a table of ratings; `file` is what an error calls it.
///
/// # Errors
/// A column is missing or unknown; a cell does not hold what it should; an image comes twice; a model has
/// two frequencies at one level of detail for one r.
pub fn parse_ratings(
    text: &str,
    file: &str,
    unit: VelocityUnit,
) -> Result<RatingTable, InputError> {
    let table = Columns::parse(text, file, &RATING, &["frequency"])?;
    let mut rows: Vec<(Image, Counts)> = Vec::new();
    let mut frequencies = Frequencies::default();
    for row in table.rows() {
        let from_0 = |name| row.number(name, |n| n >= 0.0, "a number from 0");
        let image = Image {
            model: row.name("model")?.into(),
            r: from_0("r")? + 0.0,
            speed: from_0("speed")? + 0.0,
            level_of_detail: level(&row)?,
        };
        if rows.iter().any(|(other, _)| *other == image) {
            let allowed = "with this r and speed each level may come once";
            return Err(row.refuse("level_of_detail", image.level_of_detail, allowed));
        }
        if table.has("frequency") {
            insert(&row, &image.model, image.level_of_detail, &mut frequencies)?;
        }
        let [same, different] = [row.count("same")?, row.count("different")?];
        rows.push((image, Counts { same, different, not_sure: 0 }));
    }
    let frequencies = table.has("frequency").then_some(frequencies);
    Ok(RatingTable { ratings: Ratings::together(rows, unit), frequencies })
}

/// Reads the CSV `model,level_of_detail,frequency` at `path`.
///
/// # Errors
/// The file cannot be read; a cell does not hold what it should; a model has two frequencies at one level.
pub fn read_frequencies(path: &Path) -> Result<Frequencies, InputError> {
    let file = path.display().to_string();
    let table =
        Columns::parse(&text_of(path)?, &file, &["model", "level_of_detail", "frequency"], &[])?;
    let mut frequencies = Frequencies::default();
    for row in table.rows() {
        insert(&row, row.name("model")?, level(&row)?, &mut frequencies)?;
    }
    Ok(frequencies)
}

/// Reads the CSV `speed,frequency` at `path`, perhaps with a column `model`.
///
/// # Errors
/// The file cannot be read, or as [`parse_points`].
pub fn read_points(path: &Path) -> Result<Vec<Point>, InputError> {
    parse_points(&text_of(path)?, &path.display().to_string())
}

/// Parses a table of points; `file` is what an error calls it.
///
/// # Errors
/// A column is missing or unknown; a cell does not hold what it should.
pub fn parse_points(text: &str, file: &str) -> Result<Vec<Point>, InputError> {
    let table = Columns::parse(text, file, &["speed", "frequency"], &["model"])?;
    let point = |row: Row| {
        Ok(Point {
            model: table.has("model").then(|| row.name("model").map(str::to_string)).transpose()?,
            speed: row.number("speed", |speed| speed >= 0.0, "a number from 0")?,
            frequency: row.number("frequency", |frequency| frequency > 0.0, ABOVE_0)?,
        })
    };
    table.rows().map(point).collect()
}

fn level(row: &Row) -> Result<f64, InputError> {
    let allowed = |level: f64| level > 0.0 && level <= 1.0;
    row.number("level_of_detail", allowed, "a share of the original's faces, above 0 to 1,")
}

fn insert(
    row: &Row,
    model: &str,
    level: f64,
    frequencies: &mut Frequencies,
) -> Result<(), InputError> {
    let frequency = row.number("frequency", |frequency| frequency > 0.0, ABOVE_0)?;
    frequencies.insert(model, level, frequency).map_err(|known| {
        let allowed = format!("{known} is known already for `{model}` at this level of detail");
        row.refuse("frequency", frequency, allowed)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: VelocityUnit = VelocityUnit::PixelsPerShutter;

    #[test]
    fn ratings_are_read_with_their_frequencies() {
        let text = "model,r,level_of_detail,speed,same,different,frequency\n\
                    igea,4,0.1,10,18,2,0.2\nbunny,4,0.1,10,18,2,0.3\nbunny,4,0.1,30,20,0,0.3\n";
        let RatingTable { ratings, frequencies } = parse_ratings(text, "t", UNIT).unwrap();
        assert_eq!(ratings.images().len(), 3);
        assert_eq!(ratings.images()[2].model, "igea");
        assert_eq!(ratings.counts()[0].same, 18);
        assert_eq!(frequencies.unwrap().at("bunny", 0.1), Ok(0.3));
    }

    #[test]
    fn bad_tables_are_refused_by_name() {
        let header = "model,r,level_of_detail,speed,same,different";
        for (text, expected) in [
            (
                format!("{header}\nb,4,0,10,1,1\n"),
                "t.csv: line 2: level_of_detail: `0`: a share of",
            ),
            (
                format!("{header}\nb,4,5,10,1,1\n"),
                "t.csv: line 2: level_of_detail: `5`: a share of",
            ),
            (format!("{header}\nb,-4,0.5,10,1,1\n"), "t.csv: line 2: r: `-4`: a number from 0"),
            (format!("{header}\nb,4,0.5,10,1.5,1\n"), "t.csv: line 2: same: `1.5`: a whole number"),
            (
                format!("{header}\nb,4,0.5,10,1,1\nb,4,0.5,10,1,1\n"),
                "t.csv: line 3: level_of_detail: 0.5: with this r and speed each level may come once",
            ),
            (
                format!("{header},frequency\nb,4,0.5,10,1,1,0.2\nb,4,0.5,20,1,1,0.3\n"),
                "t.csv: line 3: frequency: 0.3: 0.2 is known already for `b`",
            ),
            (
                format!("{header},frequency\nb,4,0.5,10,1,1,\n"),
                "t.csv: line 2: frequency: ``: a number above 0 is needed",
            ),
            (header.replace("same", "sane"), "t.csv: line 1: header: `sane`: the columns are"),
        ] {
            let error = parse_ratings(&text, "t.csv", UNIT).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{text:?} gave {error}");
        }
        for (text, expected) in [
            ("speed,frequency\n10,0\n", "p.csv: line 2: frequency: `0`: a number above 0"),
            ("speed,frequency,model\n10,0.2,\n", "p.csv: line 2: model: empty"),
            ("speed\n10\n", "p.csv: line 1: header: no column `frequency`"),
        ] {
            let error = parse_points(text, "p.csv").unwrap_err().to_string();
            assert!(error.starts_with(expected), "{text:?} gave {error}");
        }
    }
}

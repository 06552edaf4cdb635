//! Reading a definition (grid, scene, protocol) from TOML: one error that names the file, the
//! line, the key and what was allowed; unknown keys are refused with the nearest known one.

use serde::de::DeserializeOwned;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// The definition could not be read.
#[derive(Debug, thiserror::Error)]
pub enum DefinitionError {
    /// The file could not be opened.
    #[error("{}: cannot be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The text is no definition of this type.
    #[error("{file}: line {line}: {message}")]
    Malformed {
        /// The file, or the shipped definition's name.
        file: String,
        /// The line where it goes wrong, from 1.
        line: usize,
        /// What is wrong and what was allowed.
        message: String,
    },
    /// The text is well formed, but a value cannot be used.
    #[error("{file}: {field}: {value}: {allowed}")]
    Value {
        /// The file, or the shipped definition's name.
        file: String,
        /// The key, with its tables: `image.width_px`.
        field: String,
        /// The value found.
        value: String,
        /// What was allowed.
        allowed: String,
    },
}

impl DefinitionError {
    /// A [`DefinitionError::Value`] from its parts.
    pub fn value(
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
}

/// The text of the definition called `name` among the `shipped` pairs of name and text, or of the file
/// of that name. `argument` is what an error calls the place where the name was given, and `kind` what
/// is shipped.
///
/// # Errors
/// There is neither, and the shipped ones are listed; or the file cannot be read.
pub fn find(
    name: &str,
    shipped: &[(&str, &'static str)],
    [place, argument]: [&str; 2],
    kind: &str,
) -> Result<Cow<'static, str>, DefinitionError> {
    if let Some((_, text)) = shipped.iter().find(|(shipped, _)| *shipped == name) {
        return Ok(Cow::Borrowed(text));
    }
    let path = Path::new(name);
    if !path.exists() {
        let known: Vec<&str> = shipped.iter().map(|(name, _)| *name).collect();
        let allowed = format!("neither a file nor one of the shipped {kind}: {}", known.join(", "));
        return Err(DefinitionError::value(place, argument, name, allowed));
    }
    let text = std::fs::read_to_string(path);
    text.map(Cow::Owned).map_err(|source| DefinitionError::Unreadable { path: path.into(), source })
}

/// Reads the definition in the file at `path`.
///
/// # Errors
/// The file cannot be read, or its text is no `T`: see [`parse`].
pub fn read<T: DeserializeOwned>(path: &Path) -> Result<T, DefinitionError> {
    let text = std::fs::read_to_string(path)
        .map_err(|source| DefinitionError::Unreadable { path: path.into(), source })?;
    parse(&text, &path.display().to_string())
}

/// Parses `text` as a definition; `file` is what an error calls it.
///
/// # Errors
/// The text is not TOML, lacks a key, has an unknown one (the nearest known one is named), or a
/// value has the wrong type.
pub fn parse<T: DeserializeOwned>(text: &str, file: &str) -> Result<T, DefinitionError> {
    toml::from_str(text).map_err(|error| DefinitionError::Malformed {
        file: file.into(),
        line: error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count()),
        message: with_nearest_key(error.message()),
    })
}

/// Refuses a `schema` other than 1, the only one there has been.
///
/// # Errors
/// `schema` is not 1.
pub fn check_schema(schema: u32, file: &str) -> Result<(), DefinitionError> {
    match schema {
        1 => Ok(()),
        _ => Err(DefinitionError::value(file, "schema", schema, "this version reads schema 1")),
    }
}

/// serde says "unknown field `x`, expected one of `a`, `b`": put the nearest known name first.
fn with_nearest_key(message: &str) -> String {
    let message = message.trim().replace('\n', " ");
    let names: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    match (message.starts_with("unknown "), names.split_first()) {
        (true, Some((unknown, known))) => match nearest(unknown, known.iter().copied()) {
            Some(name) => format!("{message}; did you mean `{name}`?"),
            None => message,
        },
        _ => message,
    }
}

/// The known name most like `unknown`, if any is like it at all.
pub fn nearest<'a>(unknown: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known
        .into_iter()
        .map(|name| (strsim::jaro_winkler(unknown, name), name))
        .filter(|(likeness, _)| *likeness > 0.7)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Lens {
        #[serde(rename = "focal_length_mm")]
        _focal_length_mm: f64,
        #[serde(default, rename = "aperture")]
        _aperture: Option<f64>,
    }

    fn message(text: &str) -> String {
        parse::<Lens>(text, "lens.toml").unwrap_err().to_string()
    }

    #[test]
    fn an_unknown_key_names_the_nearest_known_one_and_its_line() {
        let error = message("aperture = 2.8\nfocal_lenght_mm = 50");
        assert!(error.starts_with("lens.toml: line 2: unknown field `focal_lenght_mm`"), "{error}");
        assert!(error.ends_with("did you mean `focal_length_mm`?"), "{error}");
    }

    #[test]
    fn a_missing_key_and_a_wrong_type_are_named() {
        assert!(message("aperture = 2.8").contains("missing field `focal_length_mm`"));
        assert!(message("focal_length_mm = \"long\"").contains("expected f64"));
    }
}

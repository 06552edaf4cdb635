//! Participants are codes. Names, e-mail addresses and paths are refused.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A participant's code: 1 to 32 ASCII letters and digits (the characters that Psych-DS allows in
/// the value of a file-name keyword).
#[derive(
    Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(try_from = "String", into = "String")]
#[schemars(extend("pattern" = "^[A-Za-z0-9]{1,32}$"))]
pub struct ParticipantCode(String);

/// The text is no participant code.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "participant code: {0:?}: 1 to 32 letters and digits are allowed, no names, addresses or paths"
)]
pub struct CodeError(String);

impl TryFrom<String> for ParticipantCode {
    type Error = CodeError;
    fn try_from(text: String) -> Result<Self, CodeError> {
        let fits =
            (1..=32).contains(&text.len()) && text.bytes().all(|b| b.is_ascii_alphanumeric());
        if fits { Ok(Self(text)) } else { Err(CodeError(text)) }
    }
}

impl std::str::FromStr for ParticipantCode {
    type Err = CodeError;
    fn from_str(text: &str) -> Result<Self, CodeError> {
        text.trim().to_string().try_into()
    }
}

impl From<ParticipantCode> for String {
    fn from(code: ParticipantCode) -> Self {
        code.0
    }
}

impl ParticipantCode {
    /// The code as the name of a file: of two codes that differ in case only, one can be used.
    pub fn file_name(&self) -> String {
        self.0.to_ascii_lowercase()
    }
}

impl fmt::Display for ParticipantCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// The columns that `participants.csv` has in every study: who sat down, and what decided the order of
/// their trials. After them come the protocol's own fields.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Participant {
    /// The participant's code.
    pub subject: ParticipantCode,
    /// `participant`, or `simulated:NAME` for a simulated observer.
    pub observer: String,
    /// Seed of this participant's order of pairs and order within the pairs.
    pub seed: u64,
    /// Place among the participants of the study, from 1, in the order in which they were entered; it
    /// decides the row of a Latin square.
    #[schemars(range(min = 1))]
    pub ordinal: u32,
    /// When the participant was entered, before the first session (UTC, RFC 3339).
    #[schemars(extend("format" = "date-time"))]
    pub first_session: String,
    /// When the participant agreed to the protocol's consent text (UTC, RFC 3339); empty if none was
    /// asked for.
    #[schemars(extend("format" = "date-time"))]
    pub consented_at: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_letters_and_digits() {
        for good in ["01", "P7", "a"] {
            assert_eq!(good.parse::<ParticipantCode>().unwrap().to_string(), good);
        }
        for bad in ["", "../01", "a/b", "Ada Lovelace", "ada@lab.org", "é1", &"9".repeat(33)] {
            let error = bad.parse::<ParticipantCode>().unwrap_err().to_string();
            assert!(error.contains(&format!("{bad:?}")), "{error}");
        }
    }
}

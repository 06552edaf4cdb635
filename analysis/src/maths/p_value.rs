//! A probability value as it may be printed: never 0, never not-a-number.

use serde::{Serialize, Serializer};
use std::fmt;

/// Below this a p-value is only known to be smaller: sums of products near the end of the range of
/// `f64` have lost their digits.
const SMALLEST_REPORTED: f64 = 1e-300;

/// A p-value in (0, 1].
///
/// In JSON it is a number; only below 10⁻³⁰⁰ it is the string `"< 1e-300"`, so a reader has one
/// special case and no p-value of 0.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct PValue(f64);

impl PValue {
    /// A computed probability. Rounding may have carried it a little over 1.
    pub(crate) fn new(p: f64) -> Self {
        debug_assert!((0.0..1.0 + 1e-9).contains(&p), "{p} is no probability");
        Self(p.clamp(0.0, 1.0))
    }

    /// The probability; 0 stands for "below the range of `f64`" and must not be printed.
    pub fn value(self) -> f64 {
        self.0
    }

    /// The p-value as an equation: `p = 0.012`, `p = 1.2e-5`, `p < 1e-300`.
    pub fn equation(self) -> String {
        match self.0 < SMALLEST_REPORTED {
            true => format!("p {self}"),
            false => format!("p = {self}"),
        }
    }
}

impl fmt::Display for PValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            p if p < SMALLEST_REPORTED => write!(f, "< 1e-300"),
            p if p < 1e-3 => write!(f, "{p:.2e}"),
            p => write!(f, "{p:.4}"),
        }
    }
}

impl Serialize for PValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 < SMALLEST_REPORTED {
            true => serializer.serialize_str("< 1e-300"),
            false => serializer.serialize_f64(self.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_size_of_p_prints_as_the_field_prints_it() {
        for (p, equation) in [
            (1.0, "p = 1.0000"),
            (0.01234, "p = 0.0123"),
            (0.000123, "p = 1.23e-4"),
            (0.0, "p < 1e-300"),
        ] {
            assert_eq!(PValue::new(p).equation(), equation);
        }
    }

    #[test]
    fn json_has_a_number_or_one_string() {
        assert_eq!(serde_json::to_string(&PValue::new(0.25)).unwrap(), "0.25");
        assert_eq!(serde_json::to_string(&PValue::new(1e-305)).unwrap(), "\"< 1e-300\"");
    }
}

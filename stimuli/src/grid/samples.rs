//! How many samples a level of a grid has: a number, or as many as the speed needs.

use crate::stimulus::MAX_SAMPLES;
use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// How many samples a pixel has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    /// So many.
    Count(u32),
    /// As the speed needs it: 1.6 for each pixel that goes by while the shutter is open, and 16 at least, the 16, 48, 144
    /// and 432 that Zhang et al. (2014) take for 10, 30, 90 and 270 pixels.
    Adaptive,
}

impl Samples {
    /// How many they are at a screen velocity.
    pub(super) fn at(self, px_per_shutter: f64) -> u32 {
        match self {
            Self::Count(count) => count,
            // What rounding adds to a speed makes no further sample.
            Self::Adaptive => ((1.6 * px_per_shutter - 1e-3).ceil() as u32).clamp(16, MAX_SAMPLES),
        }
    }
}

impl std::fmt::Display for Samples {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Count(count) => count.fmt(f),
            Self::Adaptive => f.write_str(ADAPTIVE),
        }
    }
}

/// How files call samples that follow the speed.
const ADAPTIVE: &str = "adaptive";

impl Serialize for Samples {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Count(count) => serializer.serialize_u32(*count),
            Self::Adaptive => serializer.serialize_str(ADAPTIVE),
        }
    }
}

impl<'de> Deserialize<'de> for Samples {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SamplesVisitor)
    }
}

struct SamplesVisitor;

impl Visitor<'_> for SamplesVisitor {
    type Value = Samples;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "u32 or {ADAPTIVE:?}")
    }

    fn visit_i64<E: Error>(self, count: i64) -> Result<Samples, E> {
        let fitting = u32::try_from(count).map(Samples::Count);
        fitting.map_err(|_| E::invalid_value(Unexpected::Signed(count), &self))
    }

    fn visit_u64<E: Error>(self, count: u64) -> Result<Samples, E> {
        let fitting = u32::try_from(count).map(Samples::Count);
        fitting.map_err(|_| E::invalid_value(Unexpected::Unsigned(count), &self))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Samples, E> {
        let found = (text == ADAPTIVE).then_some(Samples::Adaptive);
        found.ok_or_else(|| E::invalid_value(Unexpected::Str(text), &self))
    }
}

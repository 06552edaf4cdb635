//! A result, or in words why there is none.

use serde::Serialize;
use serde::ser::SerializeMap;

/// A result, or the reason why it does not follow from the data.
pub type Outcome<T> = Result<T, String>;

/// Writes `outcome` as the field `name`: its value, or `null` and the reason as `name_reason`.
pub(crate) fn entry<M: SerializeMap, T: Serialize>(
    map: &mut M,
    name: &str,
    outcome: &Outcome<T>,
) -> Result<(), M::Error> {
    match outcome {
        Ok(value) => map.serialize_entry(name, value),
        Err(reason) => {
            map.serialize_entry(name, &None::<T>)?;
            map.serialize_entry(&format!("{name}_reason"), reason)
        }
    }
}

/// Implements `Serialize`: the fields named first as they are, then each [`Outcome`] as [`entry`] does.
macro_rules! serialize_outcomes {
    ($type:ty, [$($plain:ident),*], [$($outcome:ident),*]) => {
        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let mut map = serde::Serializer::serialize_map(serializer, None)?;
                $(serde::ser::SerializeMap::serialize_entry(
                    &mut map, stringify!($plain), &self.$plain)?;)*
                $($crate::outcome::entry(&mut map, stringify!($outcome), &self.$outcome)?;)*
                serde::ser::SerializeMap::end(map)
            }
        }
    };
}
pub(crate) use serialize_outcomes;

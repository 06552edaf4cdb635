//! Protocols by name: those that come with Shutterlab, and those in files.

use shutterlab_data_schema::Protocol;
use shutterlab_data_schema::definition::{self, DefinitionError};

macro_rules! shipped {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../protocols/", $name, ".toml")))),*]
    };
}

/// Protocols that come with Shutterlab, by name.
const SHIPPED: &[(&str, &str)] = shipped![
    "mono1",
    "mono2shutter",
    "mono2samples",
    "mono2preference",
    "mono3",
    "stereo1",
    "stereo2shutter",
    "stereo2samples",
    "stereo3",
    "samedifferent",
    "zhang-r",
    "zhang-lod",
    "zhang-validation",
    "demo",
    "quick",
];

/// Loads the shipped protocol called `protocol`, or the protocol in the file of that name.
///
/// # Errors
/// There is neither, and the shipped ones are listed; or as [`Protocol::parse`].
pub fn load(protocol: &str) -> Result<Protocol, DefinitionError> {
    let text = definition::find(protocol, SHIPPED, ["run", "PROTOCOL"], "protocols")?;
    Protocol::parse(&text, protocol)
}

/// All protocols that come with Shutterlab.
///
/// # Errors
/// None, if they are what the tests found them to be.
pub fn shipped() -> Result<Vec<Protocol>, DefinitionError> {
    SHIPPED.iter().map(|(name, text)| Protocol::parse(text, name)).collect()
}

#[cfg(test)]
mod tests;

//! Protocols by name: those that come with Shutterlab, and those in files.

use shutterlab_data_schema::Protocol;
use shutterlab_data_schema::definition::{self, DefinitionError};

/// Protocols that come with Shutterlab, by name.
const SHIPPED: &[(&str, &str)] = &[("demo", include_str!("../protocols/demo.toml"))];

/// Loads the shipped protocol called `protocol`, or the protocol in the file of that name.
///
/// # Errors
/// There is neither, and the shipped ones are listed; or as [`Protocol::parse`].
pub fn load(protocol: &str) -> Result<Protocol, DefinitionError> {
    let text = definition::find(protocol, SHIPPED, ["run", "PROTOCOL"], "protocols")?;
    Protocol::parse(&text, protocol)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_protocol_loads_under_its_own_name() {
        for (name, _) in SHIPPED {
            assert_eq!(load(name).unwrap().name, *name);
        }
    }

    #[test]
    fn an_unknown_name_lists_the_shipped_ones() {
        let error = load("dmo").unwrap_err().to_string();
        assert!(error.contains("dmo: neither a file nor one of the shipped protocols: demo"));
    }

    #[test]
    fn a_protocol_file_is_found_by_its_path() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.toml");
        std::fs::write(&path, SHIPPED[0].1).unwrap();
        assert_eq!(load(path.to_str().unwrap()).unwrap(), load("demo").unwrap());
    }
}

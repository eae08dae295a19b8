//! Which of the formats a mechanism file is written in.

use std::path::Path;

use serde::Deserialize;

/// True if a text is XML.
pub(crate) fn is_xml(text: &str) -> bool {
    text.trim_start().starts_with('<')
}

/// True if a name is that of a URDF file.
pub(crate) fn is_urdf(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("urdf"))
}

/// A TOML file with the key `urdf`, or `None` if it has no such key.
pub(crate) fn names_a_urdf(text: &str) -> Option<String> {
    #[derive(Deserialize)]
    struct Key {
        urdf: Option<String>,
    }
    toml::from_str::<Key>(text).ok().and_then(|k| k.urdf)
}

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

/// True for a text that begins as a mechanism file does: XML, a list of TOML, or a key with a value.
pub(crate) fn begins_a_mechanism(text: &str) -> bool {
    let first = first_line(text);
    let is_key = |key: &str| !key.is_empty() && key.bytes().all(|b| b.is_ascii_lowercase() || b == b'_');
    let key = first.split_once('=').map(|(key, _)| key.trim());
    first.starts_with('<') || first.starts_with("[[") || key.is_some_and(|key| key != "sep" && is_key(key))
}

/// True for a text that begins as a table does: with names that commas, semicolons or tabs separate.
pub(crate) fn begins_a_table(text: &str) -> bool {
    let first = first_line(text);
    first.starts_with("sep=") || !first.contains(['=', '[', '<']) && first.split([',', ';', '\t']).nth(2).is_some()
}

/// The first line with content that is no comment.
fn first_line(text: &str) -> &str {
    let is_comment = |line: &str| line.starts_with('#') || line.starts_with("//");
    text.lines().map(str::trim).find(|line| !line.is_empty() && !is_comment(line)).unwrap_or("")
}

//! Opens a mechanism file, whichever of the formats it is written in.

use std::path::Path;

use crate::files::error::{FileError, read_text};
use crate::files::format::{begins_a_table, is_urdf, is_xml, names_a_urdf};
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::read::build;
use crate::files::mechanism::reader::Reader;
use crate::files::read_options::ReadOptions;
#[cfg(feature = "urdf")]
use crate::files::urdf::read as urdf;
use crate::mechanism::GeometryError;

impl Machine {
    /// Reads a mechanism file: TOML, or URDF with what stands beside it.
    ///
    /// # Errors
    /// [`FileError`] naming the place and what to do.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, FileError> {
        Self::read_with(path, &ReadOptions::default())
    }

    /// Reads a mechanism file with effects and conditions of your own, or with options that supply what a URDF file lacks.
    ///
    /// # Errors
    /// [`FileError`] naming the place and what to do; also if options of URDF are given for another file.
    pub fn read_with(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Self, FileError> {
        let path = path.as_ref();
        let text = read_text(path)?;
        let value = |place: &str, problem: String| FileError::Value { path: path.into(), place: place.into(), problem };
        if is_xml(&text) || is_urdf(path) {
            return urdf::read(path, &text, options);
        }
        if let Some(robot) = names_a_urdf(&text) {
            return urdf::read_named(path, &text, &robot, options);
        }
        if !options.urdf.is_empty() {
            let problem = "closures, links and joint coordinates are for URDF files only, and this is not one";
            return Err(value("the command line", format!("{problem}; leave the options out")));
        }
        let machine = Self::from_text_with(&text, path, options);
        let robot = path.with_extension("urdf");
        if matches!(
            &machine,
            Err(FileError::Geometry { cause: GeometryError::LegCount { found: 0 }, .. } | FileError::Toml { .. })
        ) && robot.is_file()
            && !text.contains("[[leg]]")
        {
            let problem = format!("is missing; this file belongs to '{}', name that one", robot.display());
            return Err(value("[[leg]]", problem));
        }
        machine
    }

    /// Reads the text of a mechanism file, TOML or URDF; `path` is only named in errors, and nothing beside it is read.
    ///
    /// # Errors
    /// [`FileError`] naming the place and what to do.
    pub fn from_text(text: &str, path: &Path) -> Result<Self, FileError> {
        Self::from_text_with(text, path, &ReadOptions::default())
    }

    /// Reads the text of a mechanism file as [`read_with`](Self::read_with) reads a file; `path` is only named in errors.
    ///
    /// # Errors
    /// [`FileError`] naming the place and what to do.
    pub fn from_text_with(text: &str, path: &Path, options: &ReadOptions) -> Result<Self, FileError> {
        if is_xml(text) {
            return urdf::from_text(path, text, options);
        }
        let document: MechanismDocument = toml::from_str(text).map_err(|e| {
            let message = if begins_a_table(text) {
                "is a table and not a mechanism file; name the mechanism file first and the table after it".into()
            } else {
                e.to_string().trim_end().to_owned()
            };
            FileError::Toml { path: path.into(), message }
        })?;
        Self::from_document_with(document, path, options)
    }

    /// The machine of a document; `path` is only named in errors.
    ///
    /// # Errors
    /// [`FileError`] naming the place and what to do.
    pub fn from_document(document: MechanismDocument, path: &Path) -> Result<Self, FileError> {
        Self::from_document_with(document, path, &ReadOptions::default())
    }

    /// The machine of a document with effects and conditions of one's own; `path` is only named in errors.
    ///
    /// # Errors
    /// [`FileError`] naming the place and what to do.
    pub fn from_document_with(
        document: MechanismDocument,
        path: &Path,
        options: &ReadOptions,
    ) -> Result<Self, FileError> {
        build(&Reader::of(path, &document)?, document, options)
    }

    /// The machine of another document, with the effects and conditions that this one was read with.
    ///
    /// # Errors
    /// [`FileError`] naming the place and what to do.
    pub fn with_document(&self, document: MechanismDocument) -> Result<Self, FileError> {
        let options = ReadOptions {
            catalogue: self.catalogue.clone(),
            condition_kinds: self.condition_kinds().clone(),
            mechanism: self.own.clone(),
            ..ReadOptions::default()
        };
        let mut other = Self::from_document_with(document, &self.path, &options)?;
        other.inputs.clone_from(&self.inputs);
        Ok(other)
    }
}

/// A library without the feature `urdf` knows a URDF when it sees one.
#[cfg(not(feature = "urdf"))]
mod urdf {
    use super::{FileError, Machine, Path, ReadOptions};

    fn refused(path: &Path) -> FileError {
        let problem = "is a URDF; it is read with the feature `urdf` of the library".into();
        FileError::Value { path: path.into(), place: "the file".into(), problem }
    }

    pub(super) fn read(path: &Path, _text: &str, _options: &ReadOptions) -> Result<Machine, FileError> {
        Err(refused(path))
    }

    pub(super) fn from_text(path: &Path, _text: &str, _options: &ReadOptions) -> Result<Machine, FileError> {
        Err(refused(path))
    }

    pub(super) fn read_named(
        _toml: &Path,
        _text: &str,
        robot: &str,
        _options: &ReadOptions,
    ) -> Result<Machine, FileError> {
        Err(refused(Path::new(robot)))
    }
}

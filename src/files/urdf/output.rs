//! Mechanism files among the outputs of a command: TOML, or URDF with its side file.

use std::path::{Path, PathBuf};

use super::side::{SideDocument, is_closure_yaml, names};
use crate::files::error::FileError;
use crate::files::format::is_urdf;
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::kinds::six_hardpoint::KIND;
use crate::files::outputs::Outputs;

/// Files that were added to the outputs.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct WrittenMechanism {
    /// The side file, if one is written.
    pub side: Option<PathBuf>,
    /// Properties that could not be kept, and what was chosen instead.
    pub warnings: Vec<String>,
}

impl Outputs {
    /// Adds a mechanism file: URDF and its side file if the name ends in `.urdf`, else TOML.
    ///
    /// # Errors
    /// As [`add`](Self::add), also for the side file; [`FileError::Write`] if that would replace a mechanism file, or
    /// an input with something that would be lost.
    pub fn add_mechanism(&mut self, path: &Path, document: &MechanismDocument) -> Result<WrittenMechanism, FileError> {
        if !is_urdf(path) {
            self.add(path, document.to_text())?;
            return Ok(WrittenMechanism::default());
        }
        // Effects and sensors go to the side file as they stand: whoever wrote them knows effects that are not known here.
        let plain = MechanismDocument { effects: Vec::new(), sensors: Vec::new(), ..document.clone() };
        let mut machine = Machine::from_document(plain, path)?;
        machine.document = document.clone();
        let files = machine.to_urdf()?;
        self.add(path, files.robot)?;
        let mut written = WrittenMechanism { side: None, warnings: files.warnings };
        let side = path.with_extension("toml");
        let refused = |problem: String| FileError::Write { path: side.clone(), cause: std::io::Error::other(problem) };
        let robot = path.display();
        match self.check(&side) {
            Ok(()) => {}
            Err(FileError::OverInput { .. }) if !files.side_needed => {
                written.warnings.push(format!(
                    "{} is an input and is left as it is, so {robot} has no side file and is read in m and rad",
                    side.display()
                ));
                return Ok(written);
            }
            Err(FileError::OverInput { .. }) => {
                return Err(refused(format!(
                    "it is an input, and what URDF cannot express would have to go into it; choose a different stem \
                     from that of {robot} for the output"
                )));
            }
            Err(error) => return Err(error),
        }
        if side.exists()
            && let Err(reason) = replaceable(&side, path)
        {
            return Err(refused(format!(
                "{reason}, and the side file of {robot} would replace it; choose another name for the output, or move it \
                 away"
            )));
        }
        for extension in ["yaml", "yml"] {
            let yaml = path.with_extension(extension);
            if std::fs::read_to_string(&yaml).is_ok_and(|text| is_closure_yaml(&text)) {
                let problem = format!("'{}' has closures for a URDF of that stem; choose another name", yaml.display());
                return Err(FileError::Write { path: path.into(), cause: std::io::Error::other(problem) });
            }
        }
        self.add(&side, files.side)?;
        written.side = Some(side);
        Ok(written)
    }
}

/// Fails with the reason, unless a file is the side file of a URDF that is there.
fn replaceable(side: &Path, robot: &Path) -> Result<(), String> {
    let text = std::fs::read_to_string(side).map_err(|cause| format!("it cannot be read as text ({cause})"))?;
    let table: toml::Table =
        toml::from_str(&text).map_err(|e| format!("it cannot be read as TOML ({})", e.message()))?;
    if table.contains_key("leg") {
        return Err("it is a mechanism file of its own".into());
    }
    if let Some(kind) = table.get("type").and_then(toml::Value::as_str).filter(|k| *k != KIND.name) {
        return Err(format!("it is a mechanism file of kind '{kind}'"));
    }
    if let Err(e) = toml::from_str::<SideDocument>(&text) {
        return Err(format!("it is not a side file of a URDF ({})", e.message()));
    }
    if let Some(other) = table.get("urdf").and_then(toml::Value::as_str).filter(|o| !names(side, o, robot)) {
        return Err(format!("it belongs to '{other}'"));
    }
    if !robot.is_file() {
        return Err("there is no URDF with its stem next to it".into());
    }
    Ok(())
}

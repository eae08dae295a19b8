//! The files that stand beside a URDF: its side file in TOML, and closures in YAML.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::closures::{Motion, Source};
use super::pairs::Pair;
use super::settings::Settings;
use super::side::{SideDocument, is_closure_yaml, names, parse, toml_error};
use crate::files::error::{FileError, read_text};
use crate::files::urdf_options::{HomeJoint, UrdfOptions};

/// A YAML file with the keys of gepetto's "extended URDF"; other keys are passed over.
#[derive(Debug, Default, Deserialize)]
struct YamlDocument {
    #[serde(default)]
    closed_loop: Vec<[String; 2]>,
    #[serde(default, rename = "type")]
    kinds: Vec<String>,
    #[serde(default)]
    name_mot: Vec<String>,
    #[serde(default)]
    joint_name: Vec<String>,
    #[serde(default)]
    joint_type: Vec<String>,
}

/// Contents of the side files of a URDF.
#[derive(Debug, Default)]
pub(super) struct Beside {
    /// The TOML file that is used.
    pub(super) toml: Option<(PathBuf, SideDocument)>,
    yaml: YamlDocument,
    /// Every file that was read.
    pub(super) files: Vec<PathBuf>,
    pub(super) warnings: Vec<String>,
}

impl Beside {
    /// The files of the same stem beside a URDF; `naming` is the TOML that named it, if one did.
    pub(super) fn find(urdf: &Path, naming: Option<(PathBuf, SideDocument)>) -> Result<Self, FileError> {
        let mut beside = Self::default();
        if let Some((path, document)) = naming {
            beside.files.push(path.clone());
            beside.toml = Some((path, document));
        } else {
            beside.read_toml(urdf, urdf.with_extension("toml"))?;
        }
        for extension in ["yaml", "yml"] {
            let path = urdf.with_extension(extension);
            if path.is_file() && path != urdf {
                let text = read_text(&path)?;
                if !is_closure_yaml(&text) {
                    continue;
                }
                beside.yaml = serde_saphyr::from_str(&text)
                    .map_err(|e| toml_error(&path, &format!("cannot be read as YAML with closures: {e}")))?;
                beside.check_yaml(&path)?;
                beside.files.push(path);
                break;
            }
        }
        Ok(beside)
    }

    fn read_toml(&mut self, urdf: &Path, path: PathBuf) -> Result<(), FileError> {
        if !path.is_file() || path == urdf {
            return Ok(());
        }
        let text = read_text(&path)?;
        let shown = path.display();
        let table: toml::Table = toml::from_str(&text).map_err(|e| toml_error(&path, &e.to_string()))?;
        if table.contains_key("leg") {
            self.warnings.push(format!(
                "{shown} is not used, since it has legs of its own; what belongs to {} goes into a TOML without [[leg]]",
                urdf.display()
            ));
            return Ok(());
        }
        let named = table.get("urdf").and_then(toml::Value::as_str);
        if let Some(other) = named.filter(|other| !names(&path, other, urdf)) {
            self.warnings.push(format!("{shown} is not used, since it belongs to '{other}'"));
            return Ok(());
        }
        let document = parse(&text, &path)?;
        self.files.push(path.clone());
        self.toml = Some((path, document));
        Ok(())
    }

    fn check_yaml(&self, path: &Path) -> Result<(), FileError> {
        let y = &self.yaml;
        let wrong = |place: &str, problem: String| FileError::Value { path: path.into(), place: place.into(), problem };
        if !y.kinds.is_empty() && y.kinds.len() != y.closed_loop.len() {
            let problem = format!("has {} entries for {} pairs of `closed_loop`", y.kinds.len(), y.closed_loop.len());
            return Err(wrong("type", problem + "; state one for each pair"));
        }
        if let Some(kind) = y.kinds.iter().find(|k| !["3d", "6d"].contains(&k.to_lowercase().as_str())) {
            return Err(wrong(
                "type",
                format!("'{kind}' is not a kind of closure; use 3d (a point) or 6d (a fixed flange)"),
            ));
        }
        if y.joint_name.len() != y.joint_type.len() {
            return Err(wrong(
                "joint_type",
                "does not have as many entries as `joint_name`; state one for each".into(),
            ));
        }
        if let Some(kind) = y.joint_type.iter().find(|k| joint_motion(k).is_none()) {
            return Err(wrong("joint_type", format!("'{kind}' is not known; use SPHERICAL or UJOINT")));
        }
        Ok(())
    }

    /// Settings of the call and the side files combined. The call wins where they conflict.
    pub(super) fn settings(&self, options: &UrdfOptions) -> Result<Settings, FileError> {
        let option =
            |names: &[String; 2]| Pair { names: names.clone(), motion: Motion::Undecided, source: Source::Option };
        let mut settings = Settings {
            pairs: options.close.iter().map(option).collect(),
            base_link: options.base_link.clone(),
            platform_link: options.platform_link.clone(),
            home: options.home.clone(),
            tolerance: options.tolerance,
            motors: self.yaml.name_mot.clone(),
            ..Settings::default()
        };
        if let Some((path, side)) = &self.toml {
            let wrong =
                |place: &str, problem: String| FileError::Value { path: path.clone(), place: place.into(), problem };
            for names in &side.close {
                let motion = match names.get(2).map(String::as_str) {
                    None => Motion::Undecided,
                    Some("ball") => Motion::Point(3),
                    Some("fixed") => Motion::Fixed,
                    Some(other) => {
                        let problem =
                            format!("'{other}' is not a kind of closure; use \"ball\", \"fixed\" or leave it out");
                        return Err(wrong("close", problem));
                    }
                };
                let [a, b, ..] = &names[..] else {
                    let problem = "each entry is a pair of links or joints, such as [\"leg1_tip\", \"anchor1\"]".into();
                    return Err(wrong("close", problem));
                };
                settings.pairs.push(Pair { names: [a.clone(), b.clone()], motion, source: Source::SideFile });
            }
            settings.base_link = settings.base_link.or_else(|| side.base_link.clone());
            settings.platform_link = settings.platform_link.or_else(|| side.platform_link.clone());
            settings.strokes_stated = side.strokes.is_some();
            settings.home_stated = side.home.is_some();
        }
        for (k, names) in self.yaml.closed_loop.iter().enumerate() {
            let fixed = self.yaml.kinds.get(k).map(|kind| kind.eq_ignore_ascii_case("6d"));
            let motion = fixed.map_or(Motion::Undecided, |f| if f { Motion::Fixed } else { Motion::Point(3) });
            settings.pairs.push(Pair { names: names.clone(), motion, source: Source::SideFile });
        }
        let joints = self.yaml.joint_name.iter().zip(&self.yaml.joint_type);
        settings.motions = joints.filter_map(|(name, kind)| Some((name.clone(), joint_motion(kind)?))).collect();
        Ok(settings)
    }

    /// Joint coordinates at home that the side file states and the call does not, in the units of the side file.
    pub(super) fn home_joints(&self) -> Vec<(String, f64)> {
        let stated = self.toml.iter().flat_map(|(_, side)| &side.home_joints);
        let mut list: Vec<(String, f64)> = stated.map(|(n, v)| (n.clone(), *v)).collect();
        list.sort_by(|a, b| a.0.cmp(&b.0));
        list
    }
}

/// Types of joints that a YAML file can give; the axes of a universal joint are not stated, so only its point counts.
fn joint_motion(kind: &str) -> Option<Motion> {
    match kind.to_uppercase().as_str() {
        "SPHERICAL" => Some(Motion::Point(3)),
        "UJOINT" | "UNIVERSAL" => Some(Motion::Point(2)),
        _ => None,
    }
}

/// Adds to the options what the side file says in its own units.
pub(super) fn add_home(settings: &mut Settings, stated: Vec<(String, f64)>, value: impl Fn(&str, f64) -> f64) {
    for (joint, number) in stated {
        if !settings.home.iter().any(|h| h.joint == joint) {
            let value = value(&joint, number);
            settings.home.push(HomeJoint { joint, value, dimension: None });
        }
    }
}

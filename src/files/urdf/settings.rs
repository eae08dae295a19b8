//! All that is stated beside a URDF, by the call and by side files.

use std::collections::HashMap;

use super::closures::Motion;
use super::pairs::Pair;
use crate::files::urdf_options::HomeJoint;

/// All that is stated beside the file, by the call and by side files.
#[derive(Clone, Debug, Default)]
pub(super) struct Settings {
    pub(super) pairs: Vec<Pair>,
    pub(super) base_link: Option<String>,
    pub(super) platform_link: Option<String>,
    pub(super) home: Vec<HomeJoint>,
    pub(super) tolerance: Option<f64>,
    /// The joints that are driven; all slides if empty.
    pub(super) motors: Vec<String>,
    /// Types given to joints that URDF cannot name.
    pub(super) motions: HashMap<String, Motion>,
    /// True if the side file states ranges of the lengths, or that there are none.
    pub(super) strokes_stated: bool,
    /// True if the side file states the home pose.
    pub(super) home_stated: bool,
}

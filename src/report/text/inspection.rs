//! Text output of `inspect`.

use nalgebra::Vector3;

use super::{SHOWN, heading, table};
use crate::identification::WeakDirection;
use crate::mechanism::{Mechanism, Survey};
use crate::pose::PoseConvention;
use crate::selection::Preview;
use crate::units::{Dimension, fixed, show_angle, show_length, show_quantity, three_digits};

/// Results of `inspect`.
pub struct Inspection<'a> {
    /// The mechanism.
    pub mechanism: &'a dyn Mechanism,
    /// How its poses are written.
    pub convention: &'a PoseConvention,
    /// Platform points by leg, platform frame, m.
    pub platform: Vec<(usize, Vector3<f64>)>,
    /// Base points by leg, base frame, m.
    pub base: Vec<(usize, Vector3<f64>)>,
    /// Lengths of the legs as the file states them, m; NaN where it states none.
    pub lengths: Vec<f64>,
    /// Joints at home.
    pub home_joints: Vec<f64>,
    /// Mean radius of the platform points, m.
    pub radius: f64,
    /// Condition of `J₁` at home.
    pub home_condition: f64,
    /// Extremes over the workspace.
    pub survey: Option<Survey>,
    /// Information that 20 well-chosen poses would give.
    pub preview: Option<Preview>,
    /// Directions that these poses would not determine.
    pub weak: Vec<WeakDirection>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

impl Inspection<'_> {
    /// Number of legs: of pairs of points, or of joints where there are none.
    pub fn legs(&self) -> usize {
        let most = self.platform.iter().chain(&self.base).map(|(leg, _)| leg + 1).max();
        most.unwrap_or(self.home_joints.len())
    }
}

/// Text output of `inspect`.
pub fn inspection(i: &Inspection<'_>) -> String {
    let mm = |v: f64| fixed(1e3 * v, 3);
    let point = |points: &[(usize, Vector3<f64>)], k: usize| {
        points
            .iter()
            .find(|(leg, _)| *leg == k)
            .map_or_else(|| "-".into(), |(_, p)| format!("{} {} {}", mm(p.x), mm(p.y), mm(p.z)))
    };
    // Points are lengths; joints need not be, and say so then.
    let lengths = i.mechanism.joints().iter().all(|j| j.dimension == Dimension::Length);
    // Several rods on a carriage, or a cable along several segments: points and joints are listed apart.
    let legs = i.legs();
    let together = legs == i.home_joints.len();
    let mut header =
        if together { vec!["joint", "platform point", "base point", "home"] } else { vec!["joint", "home"] };
    if i.survey.is_some() {
        header.push("over the workspace");
    }
    let row = |(k, joint): (usize, &crate::mechanism::JointSpec)| {
        let (unit, per_si) = joint.dimension.in_tables();
        let unit = if lengths { String::new() } else { format!(" {unit}") };
        let shown = |v: f64| fixed(per_si * v, 3);
        let mut cells = vec![joint.name.clone()];
        if together {
            cells.extend([point(&i.platform, k), point(&i.base, k)]);
        }
        cells.push(format!("{}{unit}", shown(i.home_joints[k])));
        let range = |[from, to]: [f64; 2]| format!("{} {}{unit}", shown(from), shown(to));
        cells.extend(i.survey.as_ref().map(|s| range(s.joint_range[k])));
        cells
    };
    let rows: Vec<Vec<String>> = i.mechanism.joints().iter().enumerate().map(row).collect();
    let mut text = format!("{}: {} parameters\n\nmm\n", heading(i.mechanism.name()), i.mechanism.parameters().len());
    if !together {
        let row = |k: usize| vec![(k + 1).to_string(), point(&i.platform, k), point(&i.base, k)];
        text += &table(&["leg", "platform point", "base point"], &(0..legs).map(row).collect::<Vec<_>>());
        text.push('\n');
    }
    text += &table(&header, &rows);
    let q = i.convention.coordinates(&i.mechanism.home());
    text += &format!(
        "\nHome: x {} y {} z {} mm, rx {} ry {} rz {} deg\n",
        mm(q[0]),
        mm(q[1]),
        mm(q[2]),
        fixed(q[3].to_degrees(), 5),
        fixed(q[4].to_degrees(), 5),
        fixed(q[5].to_degrees(), 5)
    );
    text += &format!(
        "Condition number of the mechanism (angles times the platform radius, {}): {:.2} at home",
        show_length(i.radius),
        i.home_condition
    );
    text += &i
        .survey
        .as_ref()
        .map_or_else(|| "\n".into(), |s| format!(", at most {:.2} over the workspace\n", s.worst_condition));
    if let Some(p) = &i.preview {
        text += &preview(i.mechanism, p, &i.weak);
    }
    for w in &i.warnings {
        text += &format!("\nNote: {w}.");
    }
    text.trim_end().to_owned()
}

fn preview(mechanism: &dyn Mechanism, p: &Preview, weak: &[WeakDirection]) -> String {
    let f = &p.forecast;
    let total = mechanism.parameters().len();
    let mut text = format!("\nWhat {} well-chosen poses in the workspace would determine:\n", p.poses.len());
    text += &format!("  {} of {total} parameter directions", total - weak.len());
    text += &format!(
        ", parameters to {} (RMS sigma{})\n",
        sigmas(mechanism, p).join(" and "),
        if f.prior { ", tolerances as prior" } else { "" }
    );
    let e = &f.error;
    text +=
        &format!("  poses in the workspace to {} and {}\n", show_length(e.position_rms), show_angle(e.rotation_rms));
    for w in weak.iter().take(SHOWN) {
        text += &format!("  not determined ({}): {}\n", three_digits(w.sigma), w.text);
    }
    if weak.len() > SHOWN {
        text += &format!("  and {} more\n", weak.len() - SHOWN);
    }
    text
}

/// RMS of the predicted σ of the parameters, for each dimension that they have.
fn sigmas(mechanism: &dyn Mechanism, p: &Preview) -> Vec<String> {
    let specs = mechanism.parameters();
    let mut dimensions: Vec<Dimension> = Vec::new();
    for spec in specs {
        if !dimensions.contains(&spec.dimension) {
            dimensions.push(spec.dimension);
        }
    }
    let rms = |dimension: &Dimension| {
        let variances: Vec<f64> = (0..specs.len())
            .filter(|k| specs[*k].dimension == *dimension)
            .map(|k| p.forecast.covariance[(k, k)] * p.scale[k] * p.scale[k])
            .collect();
        show_quantity((variances.iter().sum::<f64>() / variances.len() as f64).sqrt(), *dimension)
    };
    dimensions.iter().map(rms).collect()
}

//! Options about URDF files, of every command.

use crate::files::{HomeJoint, UrdfOptions};
use crate::units::{Dimension, parse_quantity};
use anyhow::{Result, anyhow, bail};

/// Options that supply what a URDF file lacks.
#[derive(clap::Args)]
#[command(next_help_heading = "URDF files")]
pub(crate) struct UrdfArgs {
    /// Two links or joints whose frames coincide when the mechanism is assembled; may be repeated.
    #[arg(long, global = true, value_name = "LINK=LINK")]
    close: Vec<String>,
    /// Link whose frame is the base frame.
    #[arg(long, global = true, value_name = "LINK")]
    base_link: Option<String>,
    /// Link whose frame is the platform frame.
    #[arg(long, global = true, value_name = "LINK")]
    platform_link: Option<String>,
    /// Joint coordinate of the assembled home, in m or rad or with a unit; may be repeated.
    #[arg(long, global = true, value_name = "JOINT=VALUE", allow_hyphen_values = true)]
    home: Vec<String>,
    /// How far axes may be from their common point, and closing frames from each other at home [default: 1e-4 of a
    /// leg].
    #[arg(long, global = true, value_name = "LENGTH")]
    urdf_tolerance: Option<String>,
}

impl UrdfArgs {
    /// The options of the library.
    pub(crate) fn options(&self) -> Result<UrdfOptions> {
        let two = |option: &str, text: &str, example: &str| match text.split_once('=') {
            Some((a, b)) if !a.trim().is_empty() && !b.trim().is_empty() => Ok([a.trim().into(), b.trim().into()]),
            _ => Err(anyhow!("--{option} {text}: write two names with '=' between them, such as {example}")),
        };
        let pair = |text: &String| two("close", text, "leg1_tip=anchor1");
        let tolerance = match &self.urdf_tolerance {
            None => None,
            Some(text) => match parse_quantity(text, Dimension::Length) {
                Ok(v) if v > 0.0 && v.is_finite() => Some(v),
                Ok(_) => bail!("--urdf-tolerance {text}: must be positive"),
                Err(cause) => bail!("--urdf-tolerance: {cause}"),
            },
        };
        let home = |text: &String| {
            let [joint, value]: [String; 2] = two("home", text, "leg1_slide=0.05")?;
            let plain = value.parse::<f64>().ok().map(|v| (v, None));
            let with_unit = |d| parse_quantity(&value, d).ok().map(|v| (v, Some(d)));
            let found = plain.or_else(|| with_unit(Dimension::Length)).or_else(|| with_unit(Dimension::Angle));
            let (value, dimension) = found.filter(|(v, _)| v.is_finite()).ok_or_else(|| {
                anyhow!(
                    "--home {text}: '{value}' is not a number with or without a unit of length or \
                                        angle"
                )
            })?;
            Ok(HomeJoint { joint, value, dimension })
        };
        Ok(UrdfOptions {
            close: self.close.iter().map(pair).collect::<Result<_>>()?,
            base_link: self.base_link.clone(),
            platform_link: self.platform_link.clone(),
            home: self.home.iter().map(home).collect::<Result<_>>()?,
            tolerance,
        })
    }
}

//! Campaigns that are only planned: poses, and the conditions under which they will be measured.
//!
//! Where nobody states conditions there is a reference campaign, kind to whoever looks for causes: what an effect may
//! depend on changes, and no two of these change together. It is a fixed function of the row, so that lists
//! of poses can be compared.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;

use crate::conditions::{ConditionKind, Conditions, Extent, Part, Role, TIME, Variation, of_leg};
use crate::effect::EffectContext;
use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::readings::reading_columns;
use crate::files::table::cells::is_missing;
use crate::files::table::column::Meaning;
use crate::files::table::states::States;
use crate::files::table::text_table::Table;
use crate::files::table::writer::CsvTable;
use crate::measurement::{DataRow, Sample};
use crate::mechanism::{Body, KinematicsError};
use crate::pose::Pose;
use crate::units::Dimension;

/// Conditions of a list, row by row.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PlannedConditions {
    /// The conditions in order, outside of a run.
    pub states: Vec<Conditions>,
    /// Their columns as they stand in the file.
    pub columns: CsvTable,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

/// Reads the conditions of planned measurements: the columns of a measurement file that are not measured (temperatures,
/// elevation, azimuth, payload, time, others with numbers). Other columns are not looked at.
///
/// # Errors
/// [`FileError`] naming row, column and what to do.
pub fn read_conditions(path: impl AsRef<Path>, machine: &Machine) -> Result<PlannedConditions, FileError> {
    let path = path.as_ref();
    let table = Table::read(path, machine, &reading_columns(None))?;
    let States { states, ignored, warnings } = States::read(&table, machine)?;
    let is_condition =
        |k: &usize| matches!(table.columns[*k].meaning, Meaning::Covariate(_) | Meaning::Clock) && !ignored.contains(k);
    let columns: Vec<usize> = (0..table.columns.len()).filter(is_condition).collect();
    if columns.is_empty() {
        return Err(FileError::Header {
            path: path.into(),
            problem:
                "has no column of conditions; expected temp_leg1_degC …, temp_platform_degC, elevation_deg, payload_kg \
                      or others with numbers"
                    .into(),
        });
    }
    for k in columns.iter().copied() {
        if let Some(row) = table.rows.iter().position(|(_, cells)| is_missing(&cells[k])) {
            return Err(table.cell_error(row, k, "must not be empty; write what is planned, or delete the column"));
        }
    }
    Ok(PlannedConditions { states, columns: table.excerpt(&columns), warnings })
}

/// Air: amplitude, K, cycles in the run, phase at its beginning.
const AIR: (f64, f64, f64) = (3.0, 1.5, 0.25 * PI);
/// By how many radians of the air's cycle the platform and the base are behind it; their amplitude is less accordingly.
const BEHIND: [f64; 2] = [1.2, 1.65];
/// How far each body wanders about that by itself, K (standard deviation).
const WANDER: f64 = 0.8;
/// Sines that make up a wander, and the cycles in the run above which it has half of its variance: those of a temperature
/// that forgets over a fifteenth of the run.
const SINES: usize = 7;
const CORNER: f64 = 2.4;
/// °C where the mechanism file states no reference temperature.
const LEVEL: f64 = 20.0;
/// Steps of three sequences that fill a cube evenly, powers of the root of x⁴ = x + 1; and that of one, the golden ratio.
const STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_3, 0.549_700_477_901_970_3];
const GOLDEN: f64 = 0.618_033_988_749_894_9;

impl Machine {
    /// The reference campaign in words.
    pub fn reference_conditions_in_words(&self) -> String {
        let air = "air temperature through 1.5 cycles of 3 K amplitude during the run, each leg varying by 0.8 K about it on its \
                   own, platform and base lagging";
        let varied: Vec<String> = self.condition_kinds().iter().filter_map(in_words).collect();
        let varied = if varied.is_empty() { String::new() } else { format!("; {}", varied.join(", ")) };
        format!("{air}{varied}")
    }

    /// The conditions of the reference campaign of so many rows, outside of a run: temperatures follow the air, and every
    /// other kind takes the variation of its entry, none together with another.
    pub fn reference_conditions(&self, rows: usize) -> Vec<Conditions> {
        let bodies = self.heated_bodies();
        let spread = self.spread_covariates();
        let level = self.environment().reference_temperature.unwrap_or(LEVEL);
        let axis = self.document.gravity_axis.unwrap_or_default();
        let state = |row: usize| {
            let passed = row as f64 / rows.saturating_sub(1).max(1) as f64;
            let mut state = Conditions::unknown();
            for (k, (name, part)) in bodies.iter().enumerate() {
                state.covariates.insert(name.clone(), level + air(*part, passed) + wander(k, passed));
            }
            for (k, (name, kind)) in spread.iter().enumerate() {
                let Some(value) = spread_value(kind, (0.5 + step(k) * row as f64).fract()) else { continue };
                if kind.role == Role::Direction {
                    state.gravity = Some(axis.gravity(value));
                }
                state.covariates.insert(name.clone(), value);
            }
            state
        };
        (0..rows).map(state).collect()
    }

    /// The temperatures that follow the air, and of what they are; those of legs as one where legs do not grow.
    fn heated_bodies(&self) -> Vec<(String, Part)> {
        let context = EffectContext::new(self.plain(), self.environment());
        let growing = context.joints_are_lengths() && !context.is_pose_space();
        let mut bodies = Vec::new();
        for kind in self.condition_kinds().iter().filter(|kind| kind.variation == Variation::Air) {
            let Role::Temperature(part) = kind.role else { continue };
            match kind.extent {
                Extent::Machine => bodies.push((kind.name.to_string(), part)),
                Extent::EachLeg if growing => {
                    bodies.extend((0..context.joints()).map(|leg| (of_leg(&kind.name, leg), part)));
                }
                Extent::EachLeg => bodies.push((kind.of_all_legs(), part)),
                Extent::Family => {}
            }
        }
        let part = |body| if body == Body::Platform { Part::Platform } else { Part::Base };
        bodies.extend(self.environment().sensors.iter().map(|s| (s.covariate.clone(), part(s.body))));
        bodies
    }

    /// The other covariates that are varied.
    fn spread_covariates(&self) -> Vec<(String, &ConditionKind)> {
        let joints = self.mechanism.joints().len();
        let names = |kind: &ConditionKind| match kind.extent {
            Extent::Machine => vec![kind.name.to_string()],
            Extent::EachLeg => (0..joints).map(|leg| of_leg(&kind.name, leg)).collect(),
            Extent::Family => Vec::new(),
        };
        let varied = self.condition_kinds().iter().filter(|kind| kind.ends().is_some());
        varied.flat_map(|kind| names(kind).into_iter().map(move |name| (name, kind))).collect()
    }

    /// The samples of a campaign: these poses in this order, commanded by the geometry without effects, each under the
    /// conditions of its row. Fewer conditions than poses repeat, and then the time of the conditions is not taken.
    ///
    /// # Errors
    /// Index of the pose and [`KinematicsError`] if there are no joints for it.
    pub fn planned_samples(
        &self,
        poses: &[Pose],
        conditions: &[Conditions],
    ) -> Result<Vec<Sample>, (usize, KinematicsError)> {
        let mechanism = self.plain();
        let joints: Vec<Vec<f64>> = poses
            .iter()
            .enumerate()
            .map(|(k, p)| mechanism.inverse(mechanism.values(), p, &Conditions::unknown()).map_err(|e| (k, e)))
            .collect::<Result<_, _>>()?;
        let mut states: Vec<Conditions> = conditions.iter().cycle().take(poses.len()).cloned().collect();
        states.resize(poses.len(), Conditions::unknown());
        if conditions.len() < poses.len() {
            for state in &mut states {
                state.covariates.remove(TIME);
            }
        }
        Conditions::put_in_run(&mut states, joints.clone(), self.environment().home_joints.as_deref());
        let sample = |(row, (joints, conditions))| Sample { id: None, row: DataRow(row), joints, conditions };
        Ok(joints.into_iter().zip(states).enumerate().map(sample).collect())
    }
}

/// The step of the `k`-th sequence: the first three fill a cube evenly, further ones step by a root of a prime each, so that
/// no two keep in step.
fn step(k: usize) -> f64 {
    let is_prime = |n: &u32| (2..*n).take_while(|d| d * d <= *n).all(|d| !n.is_multiple_of(d));
    let root = |k: usize| (2..).filter(is_prime).nth(k).map_or(GOLDEN, |prime: u32| f64::from(prime).sqrt().fract());
    STEPS.get(k).copied().unwrap_or_else(|| root(k - STEPS.len()))
}

/// The value of a kind at a part of its variation between 0 and 1, SI.
fn spread_value(kind: &ConditionKind, part: f64) -> Option<f64> {
    let value = match &kind.variation {
        Variation::Unplanned | Variation::Air => return None,
        Variation::Evenly([from, to]) => from + (to - from) * part,
        Variation::Steps(values) => {
            *values.get(((part * values.len() as f64) as usize).min(values.len().max(1) - 1))?
        }
    };
    Some(kind.unit().to_si(value))
}

/// What a kind does in the reference campaign: `elevation 20 to 90 deg`, `payload 0, 50 or 100 kg`.
fn in_words(kind: &ConditionKind) -> Option<String> {
    let unit = if kind.dimension == Dimension::None { String::new() } else { format!(" {}", kind.unit().name) };
    let label = &kind.label;
    match &kind.variation {
        Variation::Unplanned | Variation::Air => None,
        Variation::Evenly([from, to]) if unit == " deg" && to - from == TAU.to_degrees() => {
            Some(format!("{label} all around"))
        }
        Variation::Evenly([from, to]) => Some(format!("{label} {from} to {to}{unit}")),
        Variation::Steps(values) => {
            let (last, before) = values.split_last()?;
            let before: Vec<String> = before.iter().map(f64::to_string).collect();
            let or = if before.is_empty() { "" } else { " or " };
            Some(format!("{label} {}{or}{last}{unit}", before.join(", ")))
        }
    }
}

/// The air as a part of the machine follows it, K from its mean. Legs follow at once.
fn air(part: Part, passed: f64) -> f64 {
    let behind = match part {
        Part::Leg | Part::Other => 0.0,
        Part::Platform => BEHIND[0],
        Part::Base => BEHIND[1],
    };
    let (amplitude, cycles, phase) = AIR;
    amplitude / behind.hypot(1.0) * (TAU * cycles * passed + phase - behind.atan()).sin()
}

/// What the `k`-th body does by itself, K: sines whose frequencies divide the variance of a forgetful walk evenly, with
/// frequencies and phases of its own.
fn wander(k: usize, passed: f64) -> f64 {
    let golden = |number: usize| (GOLDEN * number as f64).fract();
    let sine = |j: usize| {
        // The fastest twentieth of the variance is left out.
        let share = 0.95 * (j as f64 + golden((k + 1) * (j + 1))) / SINES as f64;
        let cycles = CORNER * (FRAC_PI_2 * share).tan();
        (TAU * (cycles * passed + golden(SINES * k + j))).sin()
    };
    WANDER * (2.0 / SINES as f64).sqrt() * (0..SINES).map(sine).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Standard deviation of a series, and its correlation with another.
    fn spread_and_correlation(a: &[f64], b: &[f64]) -> (f64, f64) {
        let n = a.len() as f64;
        let mean = |v: &[f64]| v.iter().sum::<f64>() / n;
        let (ma, mb) = (mean(a), mean(b));
        let product =
            |x: &[f64], mx: f64, y: &[f64], my: f64| x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum::<f64>() / n;
        let (aa, ab, bb) = (product(a, ma, a, ma), product(a, ma, b, mb), product(b, mb, b, mb));
        (aa.sqrt(), ab / (aa * bb).sqrt())
    }

    #[test]
    fn the_reference_campaign_is_kind() {
        let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/table5.toml"));
        let machine = Machine::from_text(text, "m.toml".as_ref()).unwrap();
        for rows in [20, 60, 120] {
            let states = machine.reference_conditions(rows);
            let passed = |row: usize| row as f64 / (rows - 1) as f64;
            let own: Vec<Vec<f64>> = (0..8).map(|k| (0..rows).map(|row| wander(k, passed(row))).collect()).collect();
            for (k, one) in own.iter().enumerate() {
                let others = own[..k].iter().map(|other| spread_and_correlation(one, other).1.abs());
                assert!((0.7..1.0).contains(&spread_and_correlation(one, one).0), "{k}");
                assert!(others.fold(0.0, f64::max) < 0.65, "{k}");
            }
            let column = |name: &str| states.iter().map(|s| s.get(name).unwrap()).collect::<Vec<_>>();
            let names = ["temp_leg1", "temp_platform", "temp_base", "elevation", "azimuth", "payload"];
            for (k, name) in names.iter().enumerate() {
                for other in &names[k + 1..] {
                    let together = spread_and_correlation(&column(name), &column(other)).1.abs();
                    assert!(together < 0.75, "{name}, {other}: {together}");
                }
            }
            let elevations = column("elevation");
            assert!(elevations.iter().all(|e| (20_f64.to_radians()..90_f64.to_radians()).contains(e)));
            assert!((states[0].gravity.unwrap().norm() - 1.0).abs() < 1e-15);
        }
    }
}

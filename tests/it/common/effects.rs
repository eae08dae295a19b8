//! Machines with everything that effects ask for, and every effect of the catalogue with values.

use paracal::conditions::Conditions;
use paracal::effect::{ActsOn, AvailableData, Catalogue, Effect, EffectContext, Scan, ScanPoint};
use paracal::files::{EffectEntry, Machine};
use paracal::nalgebra::Vector3;
use paracal::pose::Pose;

/// Sections that state everything.
pub const STATED: &str = "\n[platform]\nmass_kg = 500.0\ncentre_of_mass = [0.0, 0.0, 150.0]\n\
    payload_centre = [20.0, -30.0, 300.0]\n\n[actuator]\nscrew_pitch = 5.0\n\n\
    [[sensor]]\ncovariate = \"temp_base1\"\nbase = [1400.0, 0.0, 0.0]\n\n\
    [[sensor]]\ncovariate = \"temp_base2\"\nbase = [-700.0, 1200.0, 0.0]\n\n\
    [[sensor]]\ncovariate = \"temp_base3\"\nbase = [-700.0, -1200.0, 50.0]\n";

/// The mechanism of Table 5 with these lines at its head and these sections at its end.
pub fn hexapod(head: &str, further: &str) -> String {
    let text = super::text("mechanisms/table5.toml");
    format!("{head}{text}{STATED}{further}")
}

/// A positioner in pose space.
pub fn positioner(head: &str, further: &str) -> String {
    format!("{head}name = \"stage\"\ntype = \"pose\"\nlength_unit = \"mm\"\nangle_unit = \"deg\"\n{further}")
}

pub fn read(text: &str) -> Machine {
    Machine::from_text(text, "m.toml".as_ref()).unwrap()
}

/// A state in which every effect acts: three rows of a run, of which this is the last.
pub fn state(joints: &[f64]) -> Conditions {
    let mut states = vec![Conditions::unknown(); 3];
    let around = |by: f64| joints.iter().enumerate().map(|(k, h)| h + by * (k as f64 - 2.2)).collect();
    let rows = vec![around(3e-3), around(-2e-5), joints.to_vec()];
    Conditions::put_in_run(&mut states, rows, None);
    let mut state = states.swap_remove(2);
    for leg in 1..=6 {
        state.covariates.insert(format!("temp_leg{leg}"), 20.0 + 0.7 * f64::from(leg));
    }
    for (name, value) in [
        ("temp_platform", 24.0),
        ("temp_base", 17.0),
        ("temp_base1", 21.5),
        ("temp_base2", 18.5),
        ("temp_base3", 22.0),
        ("elevation", 0.7),
        ("payload", 80.0),
        ("time", 600.0),
    ] {
        state.covariates.insert(name.into(), value);
    }
    // Along no axis.
    state.gravity = Some(Vector3::new(0.6, 0.48, -0.64));
    state
}

/// A place for an effect in its scan.
fn place(effect: &dyn Effect, context: &EffectContext<'_>) -> ScanPoint {
    let everything = AvailableData::everything(context, effect, &ScanPoint::none());
    match effect.scan(context, &everything) {
        Scan::None => ScanPoint::none(),
        Scan::Legs => ScanPoint::leg(3),
        Scan::Rows => ScanPoint { row: Some(1), ..ScanPoint::none() },
        Scan::LegsAndRows => ScanPoint { row: Some(2), ..ScanPoint::leg(4) },
        Scan::Covariates(names) => {
            let chosen = names.iter().find(|n| *n == "temp_base1").or(names.get(2)).cloned();
            ScanPoint { covariate: chosen, ..ScanPoint::none() }
        }
    }
}

/// Every effect that a machine can have, with values of their usual size.
pub fn entries(machine: &Machine) -> Vec<EffectEntry> {
    let context = EffectContext::new(machine.plain(), machine.environment());
    let mut all = Vec::new();
    for effect in &Catalogue::standard() {
        let at = place(effect.as_ref(), &context);
        if !effect.missing(&context, &AvailableData::everything(&context, effect.as_ref(), &at)).is_empty() {
            continue;
        }
        let size = |(k, p): (usize, paracal::effect::EffectParameter)| (p.name, p.scale * (1.0 - 0.3 * k as f64));
        all.push(EffectEntry {
            name: effect.name().into(),
            leg: at.leg.map(|leg| leg + 1),
            row: at.row,
            of: at.covariate.clone(),
            parameters: effect.parameters(&context).into_iter().enumerate().map(size).collect(),
            ..EffectEntry::default()
        });
    }
    all
}

/// True if an effect moves the platform.
pub fn moves(entry: &EffectEntry) -> bool {
    Catalogue::standard().get(&entry.name).unwrap().acts_on() == ActsOn::Mechanism
}

/// The machine of a text with further effects.
pub fn with_effects(text: &str, entries: &[EffectEntry]) -> Machine {
    let mut document = read(text).document().clone();
    document.effects.extend(entries.iter().cloned());
    Machine::from_document(document, "m.toml".as_ref()).unwrap()
}

/// A pose beside home.
pub fn pose_beside_home(machine: &Machine) -> Pose {
    let motion = [6e-3, -4e-3, 3e-3, 4e-3, -5e-3, 6e-3];
    machine.mechanism.home().moved(&paracal::nalgebra::Vector6::from_column_slice(&motion))
}

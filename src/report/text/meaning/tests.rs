//! Sentences of all effects.

use super::*;
use crate::diagnosis::AddedVariable;
use crate::effect::{ActsOn, Catalogue};

fn cause(effect: &str, values: &[(f64, Dimension)]) -> Cause {
    let parameter = |(k, (value, dimension)): (usize, &(f64, Dimension))| CauseParameter {
        name: format!("value{}", k + 1),
        value: *value,
        sigma: None,
        dimension: *dimension,
        scale: 1.0,
    };
    Cause {
        effect: effect.into(),
        cause: "something else happens".into(),
        remedy: "look".into(),
        acts_on: ActsOn::Mechanism,
        leg: Some(1),
        row: Some(40),
        of: Some("20um".into()),
        lag: None,
        parameters: values.iter().enumerate().map(parameter).collect(),
        p_value: 0.0,
        evidence: 1.0,
        tied_with: Vec::new(),
        not_excluded: Vec::new(),
        size_over_limit: 1.0,
        tentative: false,
        plausible: true,
        added_variable: AddedVariable::default(),
    }
}

fn joints() -> Vec<String> {
    (1..=6).map(|k| format!("leg{k}")).collect()
}

#[test]
fn every_effect_of_the_catalogue_has_a_sentence() {
    let values = [(2e-5, Dimension::Length), (-3e-5, Dimension::Angle)];
    for effect in Catalogue::standard().iter() {
        let said = meaning(&joints(), &cause(effect.name(), &values));
        assert!(said.starts_with(char::is_uppercase) && said.ends_with('.') && said.contains(": "), "{said}");
        assert!(!said.contains("something else"), "{}", effect.name());
    }
    let said = meaning(&joints(), &cause("of.a.consumer", &values));
    assert_eq!(said, "Something else happens (value1 20.0 um, value2 -6.19 arcsec): look.");
}

#[test]
fn sentences_state_the_values_in_units_of_their_size() {
    let of = |effect: &str, values: &[(f64, Dimension)]| meaning(&joints(), &cause(effect, values));
    let cases = [
        (
            of("thermal.leg.single", &[(1.35e-5, Dimension::PerKelvin)]),
            "Leg 2 grows with its temperature by 13.5 ppm/K more than the others: look at its material",
        ),
        (of("thermal.leg.single", &[(-2e-6, Dimension::PerKelvin)]), "by 2.00 ppm/K less than"),
        (
            of("scale.per_leg", &[(1e-4, Dimension::None), (-9e-4, Dimension::None)]),
            "leg 2, by 900 ppm less than commanded",
        ),
        (of("length.quadratic", &[(0.05, Dimension::PerLength)]), "leg 1, by 5.00 um at 10.0 mm from home"),
        (of("cyclic.pitch", &[(3e-6, Dimension::Length), (4e-6, Dimension::Length)]), "leg 1, by ±5.00 um"),
        (of("hysteresis.play", &[(1.0, Dimension::None)]), "shorter than 20 um are lost"),
        (of("step.leg", &[(-4e-5, Dimension::Length)]), "Leg 2 jumped by 40.0 um at data row 40, towards shorter"),
        (of("joint.screw_coupling", &[(8e-4, Dimension::LengthPerAngle)]), "by 5.03 mm for each turn"),
        (of("sag.frame", &[(2e-5, Dimension::Length), (1e-5, Dimension::Angle)]), "by 20.0 um and 2.06 arcsec"),
    ];
    for (said, wanted) in cases {
        assert!(said.contains(wanted), "{said}");
    }
    let coordinates = ["cmd_x".to_owned(), "cmd_rz".to_owned()];
    let said = meaning(&coordinates, &cause("drift.leg", &[(1e-5, Dimension::Angle)]));
    assert!(said.starts_with("The coordinate rz crept by 2.06 arcsec"), "{said}");
}

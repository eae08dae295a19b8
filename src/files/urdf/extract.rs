//! From a robot to six legs: base, platform, anchors, lengths and home.

use std::collections::{HashMap, HashSet};

use nalgebra::Point3;

use super::agree::{add_closures, size};
use super::bodies::Bodies;
use super::choice::Choice;
use super::closures::Motion;
use super::description::Description;
use super::findings::{Findings, did_you_mean};
use super::found::{Found, FoundLeg};
use super::graph::Graph;
use super::home::Assembly;
use super::leg::{Allowed, Measured, measure};
use super::model::Model;
use super::pairs::closing_frames;
use super::settings::Settings;
use crate::files::finding::FindingKind as K;
use crate::pose::Pose;
use crate::units::Dimension;

/// Finds the legs of a robot; `None` if something is wrong, which is then reported.
pub(super) fn extract(description: &Description, settings: &Settings, findings: &mut Findings) -> Option<Found> {
    let mut model = Model::of(description, &settings.motions, findings);
    if model.roots.is_empty() && model.links.is_empty() {
        findings.add(K::MissingPart, "", None, "the robot has no links; check that it is the right file");
        return None;
    }
    let values = home_values(&model, settings, findings);
    check_joints(&model, settings, findings);
    let base_link = named_link(&model, settings.base_link.as_deref(), "base", findings);
    let platform_link = named_link(&model, settings.platform_link.as_deref(), "platform", findings);
    let places = model.places(&values);
    let allowed_roots = if platform_link.is_some() { 2 } else { 1 };
    model.check_roots(&places, allowed_roots, findings);
    let mut closures: Vec<_> = settings.pairs.iter().filter_map(|p| p.closure(description, findings)).collect();
    closures.extend(description.closures.iter().cloned());
    closures.extend(closing_frames(description, findings));
    add_closures(&mut model, closures, &places, findings);
    if findings.any_error() {
        return None;
    }

    let bodies = Bodies::of(&model);
    bodies.check(&model, settings.tolerance.unwrap_or(1e-4 * size(&model)), findings);
    let platform_body = platform_link.map(|l| bodies.of[l]);
    // With a platform of its own root, the base is the other root.
    let root =
        model.roots.iter().copied().find(|r| Some(bodies.of[*r]) != platform_body).or(model.roots.first().copied())?;
    let base = bodies.of[base_link.unwrap_or(root)];
    if platform_body == Some(base) {
        platform_on_base(settings, findings);
        return None;
    }
    let motors: HashSet<&str> = settings.motors.iter().map(String::as_str).collect();
    let actuated = |k: usize| motors.is_empty() || motors.contains(model.edges[k].name.as_str());
    let (platform, legs) = Graph::new(&model, &bodies, &actuated).legs(base, platform_body, findings)?;
    let allowed = Allowed { distance: settings.tolerance };
    let mut measured = Vec::with_capacity(legs.len());
    for leg in &legs {
        match measure(&model, &bodies, leg, [base, platform], allowed) {
            Ok(leg) => measured.push(leg),
            Err(finding) => findings.push(finding),
        }
    }
    let frames = Choice { model: &model, bodies: &bodies, base, platform };
    if base_link.is_none() && platform_link.is_none() {
        frames.check_names(findings);
    }
    let base_link = base_link.unwrap_or_else(|| frames.base(root, findings));
    let platform_link = platform_link.unwrap_or_else(|| frames.platform(findings));
    let frames = [base_link, platform_link].map(|l| bodies.frames[l].inverse());
    let leg = |leg: &Measured| {
        let [base, platform] = [0, 1].map(|k| (frames[k] * Point3::from(leg.anchors[k])).coords);
        let (joint, reversed, length) = (leg.joint.clone(), leg.reversed, leg.length);
        FoundLeg { joint, reversed, platform, base, length, range: range(&model, leg, settings, findings) }
    };
    let legs = measured.iter().map(leg).collect();
    let mut found = Found { legs, home: None };
    if findings.any_error() {
        return None;
    }
    if !settings.home_stated
        && let (Some(b), Some(p)) = (places[base_link], places[platform_link])
        && model.roots.len() == 1
    {
        let tree = b.inverse() * p;
        let tree = Pose { position: tree.translation.vector, rotation: tree.rotation.to_rotation_matrix() };
        let seen = Assembly { model: &model, measured: &measured, places: &places, links: [base_link, platform_link] };
        found.home = seen.home(&found.legs, tree, &values, allowed, findings);
    }
    Some(found)
}

/// Reports joints of the side file that do not exist.
fn check_joints(model: &Model, settings: &Settings, findings: &mut Findings) {
    for name in settings.motors.iter().chain(settings.motions.keys()) {
        if !model.edges.iter().any(|e| e.name == *name) {
            let hint = did_you_mean(name, model.edges.iter().map(|e| e.name.as_str()));
            let text = format!("the side file names the joint '{name}', which does not exist{hint}");
            findings.add(K::UnknownJoint, name, None, text);
        }
    }
}

/// The link that is named as base or platform; one that does not exist is reported.
fn named_link(model: &Model, name: Option<&str>, what: &str, findings: &mut Findings) -> Option<usize> {
    let name = name?;
    let link = model.link(name);
    if link.is_none() {
        let hint = did_you_mean(name, model.links.iter().map(String::as_str));
        let text = format!("'{name}', named as the {what} link, does not exist{hint}");
        findings.add(K::UnknownLink, name, None, text);
    }
    link
}

/// Reports a platform that is fixed to the base.
fn platform_on_base(settings: &Settings, findings: &mut Findings) {
    let name = settings.platform_link.clone().unwrap_or_default();
    let advice = if settings.base_link.is_some() {
        "name another link"
    } else {
        "name the base with `--base-link` if it is another, or name another platform"
    };
    let text = format!("'{name}' is named as the platform, but is fixed to the base; {advice}");
    findings.add(K::DisconnectedPlatform, name, None, text);
}

/// Coordinates of the joints at home, by joint.
fn home_values(model: &Model, settings: &Settings, findings: &mut Findings) -> HashMap<usize, f64> {
    let mut values = HashMap::new();
    for stated in &settings.home {
        let name = &stated.joint;
        let Some(k) = (0..model.joints).find(|k| model.edges[*k].name == *name) else {
            let hint = did_you_mean(name, model.edges[..model.joints].iter().map(|e| e.name.as_str()));
            findings.add(K::UnknownJoint, name, None, format!("joint '{name}', given at home, does not exist{hint}"));
            continue;
        };
        let dimension = match model.edges[k].motion {
            Motion::Slide(_) => Dimension::Length,
            Motion::Hinge(_) => Dimension::Angle,
            _ => {
                let text = format!("joint '{name}', given at home, has no single coordinate; name a slide or a hinge");
                findings.add(K::BadSetting, name, model.edges[k].line, text);
                continue;
            }
        };
        if stated.dimension.is_some_and(|d| d != dimension) || !stated.value.is_finite() {
            let text = format!(
                "joint '{name}', given at home, needs a finite number with one of the units {}",
                dimension.choices()
            );
            findings.add(K::BadSetting, name, model.edges[k].line, text);
        }
        if values.insert(k, stated.value).is_some() {
            findings.add(K::BadSetting, name, None, format!("joint '{name}' is given at home twice; keep one"));
        }
    }
    values
}

/// The lengths that the limits of a slide leave.
fn range(model: &Model, leg: &Measured, settings: &Settings, findings: &mut Findings) -> Option<[f64; 2]> {
    let joint = &leg.joint;
    let mut wrong = |kind, text: String| {
        // A side file may state the range instead, or that there is none.
        if !settings.strokes_stated {
            let advice =
                "correct <limit lower upper>, or state `strokes` in a side file (`[]` for a leg without limits)";
            findings.add(kind, joint, leg.line, format!("joint '{joint}' {text}; {advice}"));
        }
        None
    };
    let Some([lower, upper]) = model.edges[leg.edge].limit else {
        return wrong(K::NoLimit, "has no limits".into());
    };
    if !(lower < upper) {
        return wrong(K::EmptyRange, format!("has the limits {lower} to {upper} m, which leave no travel"));
    }
    let ends =
        if leg.reversed { [leg.length - upper, leg.length - lower] } else { [leg.length + lower, leg.length + upper] };
    if !(ends[0] > 0.0) {
        let text = format!("can move until the leg is {:.3} mm long, which is not a length", 1e3 * ends[0]);
        return wrong(K::EmptyRange, text);
    }
    Some(ends)
}

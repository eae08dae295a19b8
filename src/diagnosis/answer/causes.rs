//! The names of the search as causes, with values, uncertainties and rivals.

use crate::diagnosis::answer::evidence::added_variable;
use crate::diagnosis::answer::limits::lambda;
use crate::diagnosis::answer::not_excluded::Unseen;
use crate::diagnosis::answer::result::{Cause, CauseParameter};
use crate::diagnosis::answer::rivals::Named;
use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::hypotheses::Hypotheses;
use crate::diagnosis::linear::model::Model;
use crate::diagnosis::search::iteration::SearchState;
use crate::diagnosis::search::stepwise::scores;
use crate::effect::EffectParameter;
use crate::measurement::DataRow;
use crate::units::Dimension;

/// A size below this many limits is tentative.
const TENTATIVE: f64 = 2.0;
/// A value that is known to this many usual sizes only is not known.
const UNSEEN: f64 = 1e6;

/// Every name with its values and what speaks for it, by evidence.
pub(crate) fn causes(
    subject: &Hypotheses<'_>,
    state: &SearchState,
    model: &Model,
    unseen: &Unseen,
) -> Result<Vec<Cause>, DiagnoseError> {
    let step = model.step();
    let covariance = model.effect_covariance() * (model.noise.variance() * state.fitting.inflation);
    let rows: Vec<DataRow> = subject.data.iter().map(|s| s.row).collect();
    let mut all = Vec::with_capacity(state.names().len());
    let mut at = 0;
    for (k, name) in state.names().iter().enumerate() {
        let group = &subject.groups[name.group];
        let p = group.parameters.len();
        let values: Vec<f64> = step.rows(model.table().nuisance + at, p).iter().copied().collect();
        let mut others = state.names().to_vec();
        others.remove(k);
        let without = state.with_names(subject, others.clone())?;
        let scores = scores(&without, &subject.groups);
        let tests = scores.iter().filter(|s| s.rank > 0).count();
        let own = &scores[name.group];
        let place = name.at(&subject.groups, &rows);
        let variance = model.noise.variance() * state.fitting.inflation;
        let sigma = model.noise.variance().sqrt();
        let named = Named {
            subject,
            state,
            without: &without,
            others: &others,
            scores: &scores,
            name,
            values: &values,
            variance,
        };
        let tied_with = named.rivals()?;
        let lambda_limit = lambda(&without, own.rank, tests, own.places);
        let size = (own.gain / without.noise.variance_after(own.gain, own.rank as f64) / lambda_limit).sqrt();
        let weight = state.fitting.scale * state.fitting.scale;
        let not_excluded = unseen.alike(&without, subject, own, weight)?;
        let parameter = |(i, spec): (usize, &EffectParameter)| CauseParameter {
            name: spec.name.clone(),
            value: values[i],
            sigma: Some(covariance[(at + i, at + i)].max(0.0).sqrt()).filter(|s| *s < UNSEEN * spec.scale),
            dimension: dimension(subject, spec.dimension, place.leg),
            scale: spec.scale,
        };
        all.push(Cause {
            effect: group.effect.name().into(),
            cause: group.effect.cause().into(),
            remedy: group.effect.remedy().into(),
            acts_on: group.effect.acts_on(),
            leg: place.leg,
            row: place.row,
            of: place.covariate,
            lag: place.lag,
            parameters: group.parameters.iter().enumerate().map(parameter).collect(),
            p_value: own.p_value,
            evidence: own.evidence,
            tied_with,
            tentative: size < TENTATIVE || !not_excluded.is_empty(),
            not_excluded,
            size_over_limit: size,
            added_variable: added_variable(&subject.groups, &without, name, &values, sigma),
            plausible: group.parameters.iter().enumerate().all(|(i, p)| {
                let sigma = covariance[(at + i, at + i)].max(0.0).sqrt();
                p.is_plausible(values[i], sigma)
            }),
        });
        at += p;
    }
    all.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    Ok(all)
}

/// What a parameter measures at a leg: where joints differ, that of the joint of the leg and not of the first one.
fn dimension(subject: &Hypotheses<'_>, stated: Dimension, leg: Option<usize>) -> Dimension {
    let joints = subject.mechanism.joints();
    match leg.and_then(|leg| joints.get(leg)) {
        Some(joint) if stated == joints[0].dimension => joint.dimension,
        _ => stated,
    }
}

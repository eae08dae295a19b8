//! `[[effect]]`: from entries of a mechanism file to effects with values, and back.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::conditions::Conditions;
use crate::effect::{
    ActiveEffect, ActsOn, AvailableData, Catalogue, Effect, EffectContext, Environment, Extended, Scan, ScanPoint,
    effects_of, without_effects,
};
use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::reader::Reader;
use crate::files::mechanism::sections::EffectEntry;
use crate::measurement::Frames;
use crate::mechanism::{Mechanism, Workspace, mount};

/// A problem with an entry: the key, if it is about one, and the problem.
struct Trouble {
    key: Option<&'static str>,
    problem: String,
}

fn trouble(key: &'static str, problem: impl Into<String>) -> Trouble {
    Trouble { key: Some(key), problem: problem.into() }
}

/// The effect that an entry states.
fn active(entry: &EffectEntry, context: &EffectContext<'_>, catalogue: &Catalogue) -> Result<ActiveEffect, Trouble> {
    let name = &entry.name;
    let Some(found) = catalogue.get(name).cloned() else {
        let all: Vec<String> = catalogue.iter().map(|e| e.name().to_owned()).collect();
        return Err(trouble("name", format!("'{name}' is not an effect; the known ones are {}", all.join(", "))));
    };
    let at = place(entry, found.as_ref(), context)?;
    let lacking = found.missing(context, &AvailableData::everything(context, found.as_ref(), &at));
    if !lacking.is_empty() {
        let problem = format!("needs {}; state it, or delete the effect", lacking.join(" and "));
        return Err(Trouble { key: None, problem });
    }
    let expected: Vec<String> = found.parameters(context).into_iter().map(|p| p.name).collect();
    for (key, values) in [("parameters", &entry.parameters), ("sigma", &entry.sigma)] {
        if let Some(unknown) = values.keys().find(|k| !expected.contains(k)) {
            return Err(trouble(
                key,
                format!(
                    "'{unknown}' is not one of its parameters; those are \
                                             {}",
                    expected.join(", ")
                ),
            ));
        }
    }
    let mut values = Vec::with_capacity(expected.len());
    for name in &expected {
        let Some(value) = entry.parameters.get(name) else {
            return Err(trouble(
                "parameters",
                format!(
                    "'{name}' is missing; the parameters are {}",
                    expected.join(
                        ", \
                                "
                    )
                ),
            ));
        };
        values.push(*value);
    }
    let numbers = [("parameters", &entry.parameters), ("sigma", &entry.sigma), ("reference", &entry.reference)];
    let ranges = entry.range.iter().flat_map(|(name, range)| range.iter().map(move |v| ("range", name, v)));
    let all =
        numbers.iter().flat_map(|(key, values)| values.iter().map(move |(name, v)| (*key, name, v))).chain(ranges);
    if let Some((key, name, value)) = all.into_iter().find(|(_, _, v)| !v.is_finite()) {
        return Err(trouble(key, format!("'{name}' is {value}, not a finite number; write a number")));
    }
    if let Some((name, [low, high])) = entry.range.iter().find(|(_, [low, high])| low > high) {
        return Err(trouble(
            "range",
            format!(
                "'{name}' is [{low}, {high}], which is not an interval; write [smallest, \
                            largest]"
            ),
        ));
    }
    Ok(ActiveEffect { effect: found, at, values, range: entry.range.clone() })
}

/// Where in its scan an effect acts.
fn place(entry: &EffectEntry, effect: &dyn Effect, context: &EffectContext<'_>) -> Result<ScanPoint, Trouble> {
    let leg = entry.leg.map(|leg| leg.wrapping_sub(1));
    let at = ScanPoint { leg, row: entry.row, covariate: entry.of.clone(), lag: entry.lag_s };
    let scan = effect.scan(context, &AvailableData::everything(context, effect, &at));
    let legs = context.joints();
    let choices = match &scan {
        Scan::Covariates(names) => names.join(", "),
        _ => String::new(),
    };
    let stated = [
        ("leg", entry.leg.is_some(), matches!(scan, Scan::Legs | Scan::LegsAndRows), format!("the leg, 1 to {legs}")),
        ("row", entry.row.is_some(), matches!(scan, Scan::Rows | Scan::LegsAndRows), "the data row, from 0".into()),
        ("of", entry.of.is_some(), matches!(scan, Scan::Covariates(_)), format!("one of {choices}")),
    ];
    for (key, stated, needed, what) in stated {
        if needed && !stated {
            return Err(trouble(key, format!("is missing; state {what}")));
        }
        if stated && !needed {
            return Err(trouble(key, "does not apply to this effect; delete it"));
        }
    }
    if entry.lag_s.is_some() && !effect.may_lag() {
        return Err(trouble("lag_s", "does not apply to this effect; delete it"));
    }
    if let Some(lag) = entry.lag_s.filter(|lag| !(*lag > 0.0 && lag.is_finite())) {
        return Err(trouble("lag_s", format!("is {lag}; state a time above zero in s, or delete it for no lag")));
    }
    if at.leg.is_some_and(|leg| leg >= legs) {
        let leg = entry.leg.unwrap_or(0);
        return Err(trouble("leg", format!("there is no leg {leg}; legs are numbered from 1 to {legs}")));
    }
    if let (Scan::Covariates(names), Some(of)) = (&scan, &entry.of)
        && !names.contains(of)
        && !is_width(names, of)
    {
        return Err(trouble("of", format!("'{of}' is not possible; state one of {choices}")));
    }
    Ok(at)
}

/// True for a width of play such as `12um` where widths are expected: any will do, not only those that are tried out.
fn is_width(tried: &[String], of: &str) -> bool {
    let width = |text: &str| text.strip_suffix("um").and_then(|v| v.parse::<f64>().ok()).is_some_and(|v| v > 0.0);
    tried.iter().all(|t| width(t)) && width(of)
}

/// Effects and environment from the entries of a document.
pub(crate) struct Effects {
    pub(crate) mechanism: Box<dyn Mechanism>,
    pub(crate) instrument: Vec<ActiveEffect>,
    pub(crate) environment: Arc<Environment>,
}

/// Puts the effects of a document around a mechanism.
pub(crate) fn with_effects(
    r: &Reader<'_>,
    document: &MechanismDocument,
    mechanism: Box<dyn Mechanism>,
    environment: Environment,
    catalogue: &Catalogue,
) -> Result<Effects, FileError> {
    let mut environment = environment;
    let place = |k: usize| format!("effect {} '{}'", k + 1, document.effects[k].name);
    for (k, entry) in document.effects.iter().enumerate() {
        for (covariate, value) in &entry.reference {
            let wrong = |problem: String| r.value(format!("{}, `reference`", place(k)), problem);
            if environment.reference_temperature.is_some() {
                return Err(wrong("cannot be combined with reference_temperature_degC; delete one of them".into()));
            }
            let known = environment.references.insert(covariate.clone(), *value).filter(|known| known != value);
            if let Some(known) = known {
                return Err(wrong(format!(
                    "'{covariate}' is {value}, but {known} in an earlier entry; state one value"
                )));
            }
        }
    }
    let mut all: Vec<ActiveEffect> = Vec::with_capacity(document.effects.len());
    {
        let context = EffectContext::new(mechanism.as_ref(), &environment);
        for (k, entry) in document.effects.iter().enumerate() {
            let found = active(entry, &context, catalogue).map_err(|t| about(r, &place(k), t))?;
            if all.iter().any(|other| other.label() == found.label()) {
                let problem = format!("{} is stated twice; keep one of them", found.label());
                return Err(r.value(place(k), problem));
            }
            all.push(found);
        }
    }
    let environment = Arc::new(environment);
    let (moving, instrument): (Vec<_>, Vec<_>) = all.into_iter().partition(|e| e.effect.acts_on() == ActsOn::Mechanism);
    let mechanism: Box<dyn Mechanism> = match moving.is_empty() {
        true => mechanism,
        false => Box::new(Extended::new(mechanism, Arc::clone(&environment), moving)),
    };
    Ok(Effects { mechanism, instrument, environment })
}

fn about(r: &Reader<'_>, place: &str, trouble: Trouble) -> FileError {
    let place = trouble.key.map_or_else(|| place.to_owned(), |key| format!("{place}, `{key}`"));
    r.value(place, trouble.problem)
}

impl Machine {
    /// The effects of its file that act on the measurement and not on the mechanism. Data that are read are seen through
    /// them.
    pub fn instrument(&self) -> &[ActiveEffect] {
        &self.instrument
    }

    /// The same with the values that were identified: the last of the parameters `own` of the data.
    pub fn instrument_with(&self, own: &[f64]) -> Vec<ActiveEffect> {
        let count: usize = self.instrument.iter().map(|e| e.values.len()).sum();
        ActiveEffect::with_values(&self.instrument, own[own.len().saturating_sub(count)..].iter().copied())
    }

    /// All effects of its file: those on the mechanism, then those on the measurement.
    pub fn effects(&self) -> Vec<ActiveEffect> {
        effects_of(self.mechanism.as_ref()).iter().chain(&self.instrument).cloned().collect()
    }

    /// The effect that an entry states for this machine; `place` is what errors call the entry.
    ///
    /// # Errors
    /// [`FileError::Value`] for what a mechanism file with this entry would be refused for.
    pub fn effect(&self, entry: &EffectEntry, place: &str) -> Result<ActiveEffect, FileError> {
        let r = Reader { path: &self.path, units: self.units() };
        let context = EffectContext::new(self.plain(), &self.environment);
        active(entry, &context, &self.catalogue).map_err(|t| about(&r, place, t))
    }

    /// Takes the means of temperatures of these states for the references that the file does not state but an effect
    /// needs, and says so; `list` is what the states are called.
    pub fn refer_to<'a>(&mut self, states: impl Iterator<Item = &'a Conditions>, list: &str) -> Option<String> {
        let effects = self.effects();
        let mut wanted: Vec<String> = {
            let context = EffectContext::new(self.plain(), &self.environment);
            let names = effects.iter().flat_map(|e| e.temperatures(&context));
            names.filter(|name| self.environment.reference(name).is_none()).collect()
        };
        wanted.sort();
        wanted.dedup();
        if wanted.is_empty() {
            return None;
        }
        let means = self.environment.with_references_among(states).references;
        let mut environment = Environment::clone(&self.environment);
        let mut said = Vec::new();
        for name in wanted {
            if let Some(mean) = means.get(&name) {
                said.push(format!("{name} {mean:.3} degC"));
                environment.references.insert(name, *mean);
            }
        }
        self.environment = Arc::new(environment);
        let drawn = without_effects(self.mechanism.as_ref());
        // The values are those of the mechanism itself, which it takes.
        if let Ok(inner) = drawn.with_values(drawn.values(), drawn.home()) {
            let moving = effects_of(self.mechanism.as_ref()).to_vec();
            if !moving.is_empty() {
                let extended = Box::new(Extended::new(inner, Arc::clone(&self.environment), moving));
                self.mechanism = match self.mechanism.mounting() {
                    Some((base, target)) => mount(extended, &base, &target),
                    None => extended,
                };
            }
        }
        let means = said.join(", ");
        let message = "reference temperatures that the mechanism file does not state are taken as the means";
        (!said.is_empty()).then(|| format!("{message} of {list}: {means}"))
    }

    /// The file for another state of the mechanism without effects, and with these effects: what [`Self::document_of`]
    /// writes, and one entry for each effect with the reference temperatures in `environment` that it needs. `sigmas` are
    /// 1σ of the values of each effect, or empty.
    ///
    /// # Errors
    /// [`FileError::Value`] for a mechanism of another kind.
    pub fn document_with_effects(
        &self,
        mechanism: &dyn Mechanism,
        workspace: Option<&Workspace>,
        frames: &Frames,
        effects: &[ActiveEffect],
        sigmas: &[Vec<f64>],
        environment: &Environment,
    ) -> Result<MechanismDocument, FileError> {
        let mut document = self.document_of(mechanism, workspace, frames)?;
        document.effects = self.effect_entries(effects, sigmas, environment);
        Ok(document)
    }

    /// One entry for each effect, with the reference temperatures that it needs and `environment` has. `sigmas` are 1σ of
    /// the values of each effect, or empty; what is not finite is left out.
    pub fn effect_entries(
        &self,
        effects: &[ActiveEffect],
        sigmas: &[Vec<f64>],
        environment: &Environment,
    ) -> Vec<EffectEntry> {
        let context = EffectContext::new(self.plain(), environment);
        let entry = |(k, effect)| entry(effect, sigmas.get(k).map_or(&[], Vec::as_slice), &context);
        effects.iter().enumerate().map(entry).collect()
    }
}

fn entry(active: &ActiveEffect, sigma: &[f64], context: &EffectContext<'_>) -> EffectEntry {
    let names: Vec<String> = active.effect.parameters(context).into_iter().map(|p| p.name).collect();
    let table = |values: &[f64]| -> BTreeMap<String, f64> {
        let known = names.iter().cloned().zip(values.iter().copied());
        known.filter(|(_, v)| v.is_finite()).collect()
    };
    let environment = context.environment;
    let common = environment.reference_temperature.is_some();
    let temperatures = active.temperatures(context).into_iter().filter(|_| !common);
    let reference = temperatures.filter_map(|name| Some((name.clone(), *environment.references.get(&name)?)));
    EffectEntry {
        name: active.effect.name().to_owned(),
        leg: active.at.leg.map(|leg| leg + 1),
        row: active.at.row,
        of: active.at.covariate.clone(),
        lag_s: active.at.lag,
        parameters: table(&active.values),
        sigma: table(sigma),
        range: active.range.clone(),
        reference: reference.collect(),
    }
}

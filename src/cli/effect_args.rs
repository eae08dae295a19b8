//! `--effect 'NAME[leg=3]=VALUE,…'`.

use crate::effect::{ActiveEffect, EffectContext, EffectParameter};
use crate::files::{EffectEntry, Machine};
use anyhow::{Result, anyhow, bail};

/// Reads one effect of the call for a machine.
///
/// # Errors
/// The argument, what is wrong with it, and how an effect is written.
pub fn effect_entry(text: &str, machine: &Machine) -> Result<(EffectEntry, ActiveEffect)> {
    let place = format!("--effect '{text}'");
    let (mut entry, values) = parse(text).map_err(|problem| {
        anyhow!(
            "{place}: {problem}; write NAME=VALUE,… or NAME[leg=3]=VALUE,…, values in SI, such as drift.leg[leg=3]=2e-5"
        )
    })?;
    if let Some(known) = machine.catalogue().get(&entry.name) {
        let expected = known.parameters(&EffectContext::new(machine.plain(), machine.environment()));
        if values.len() != expected.len() {
            let found = values.len();
            bail!("{place}: has {found} of the {} values {}", expected.len(), listed(&expected));
        }
        entry.parameters = expected.into_iter().map(|p| p.name).zip(values).collect();
    }
    let active = machine.effect(&entry, &place)?;
    Ok((entry, active))
}

fn listed(parameters: &[EffectParameter]) -> String {
    let shown: Vec<String> = parameters.iter().map(|p| format!("{} ({})", p.name, p.dimension.si())).collect();
    shown.join(", ")
}

/// Name, place and values of `NAME[leg=3,row=40]=VALUE,…`.
fn parse(text: &str) -> Result<(EffectEntry, Vec<f64>), String> {
    let mut entry = EffectEntry::default();
    let split = |at: &str| text.split_once(at).map(|(name, rest)| (name.trim().to_owned(), rest.to_owned()));
    let bracketed = text.find('[').is_some_and(|b| text.find('=').is_none_or(|e| b < e));
    let values = if bracketed {
        let (name, rest) = split("[").unwrap_or_default();
        let Some((places, rest)) = rest.split_once(']') else { return Err("has no ']'".into()) };
        entry.name = name;
        for part in places.split(',') {
            place(part, &mut entry)?;
        }
        rest.trim().strip_prefix('=').map(str::to_owned)
    } else {
        split("=").map(|(name, rest)| {
            entry.name = name;
            rest
        })
    };
    let values = values.ok_or("has no '=' followed by values")?;
    let number = |v: &str| v.trim().parse::<f64>().map_err(|_| format!("'{}' is not a number", v.trim()));
    let values = values.split(',').map(number).collect::<Result<_, String>>()?;
    Ok((entry, values))
}

fn place(part: &str, entry: &mut EffectEntry) -> Result<(), String> {
    let (key, value) = part.split_once('=').ok_or_else(|| format!("'{part}' is not a place"))?;
    let number = || value.trim().parse::<usize>().map_err(|_| format!("'{part}' is not a whole number"));
    match key.trim() {
        "leg" => entry.leg = Some(number()?),
        "row" => entry.row = Some(number()?),
        "of" => entry.of = Some(value.trim().to_owned()),
        "lag_s" => {
            let lag = value.trim().parse::<f64>().map_err(|_| format!("'{part}' is not a number"))?;
            entry.lag_s = Some(lag);
        }
        other => return Err(format!("'{other}' is none of leg, row, of, lag_s")),
    }
    Ok(())
}

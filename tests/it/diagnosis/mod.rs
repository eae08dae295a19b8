//! The diagnosis against causes that a generator of its own has hidden: names, sizes, limits, commands.

#[cfg(feature = "cli")]
mod bad_data;
mod causes;
#[cfg(feature = "cli")]
mod commands;
mod detection_limits;
mod hidden_cases;
mod instruments_and_lags;
mod misread;
#[cfg(feature = "cli")]
mod nameless;
mod other_machines;

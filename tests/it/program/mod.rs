//! The program as its users run it: options, outputs, pages, the guide, and what goes wrong.

mod bad_input;
mod command_line;
mod effects;
mod guard;
mod guide;
mod mutated_calls;
mod new;
mod other_programs;
mod reports;
mod reproduction;
mod robustness;
mod streams;
mod urdf;

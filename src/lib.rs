//! Calibration of parallel mechanisms: six-hardpoint mirror positioners, hexapods, Stewart platforms, and
//! mechanisms that a consumer of this library writes.
//!
//! # The problem
//!
//! A platform stands on legs. A program commands leg lengths; the pose that the platform takes depends on where
//! the legs really begin and end, which differs from the drawing by some tenths of a millimetre. From measured
//! poses for known commands one finds these **kinematic parameters**, how far to trust them, and the lengths to
//! command from now on. The method is that of Yu, Wu and Wang, *Kinematic Calibration Method for Six-Hardpoint
//! Positioning Mechanisms Using Optimal Measurement Pose*, Applied Sciences 13 (2023) 4824, made generic, with
//! rows weighted by the noise and with what the data do not tell said in words.
//!
//! # Notation
//!
//! | paper | meaning | in code |
//! |---|---|---|
//! | `q = (x, y, z, α, β, γ)` | pose of the platform, eq. (2) | [`pose::Pose`], written by a [`pose::PoseConvention`] |
//! | `t`, `R` | position and rotation | [`pose::Pose::position`], [`pose::Pose::rotation`] |
//! | `aᵢ`, `bᵢ` | where leg `i` meets platform and base | [`mechanism::Leg::platform`], [`mechanism::Leg::base`] |
//! | `hᵢ` | length of leg `i`; its error `dhᵢ` | [`mechanism::Leg::length`], [`mechanism::Leg::length_offset`] |
//! | `H` | joint coordinates (leg lengths) | `joints: &[f64]` |
//! | `C` | all parameters, eq. (15) | `c: &[f64]`, described by [`mechanism::ParameterSpec`] |
//! | `f(q, H, C) = 0` | closure, eqs. (12), (16) | [`mechanism::Mechanism::linearize`] |
//! | `J₁`, `J₂` | its derivatives, eqs. (19), (21) | [`mechanism::Linearization`] |
//! | `J_b = -J₁⁻¹ J₂` | motion per parameter, eq. (23) with the sign of eq. (17) | [`mechanism::MotionBlock`] |
//! | `J_B`, `dq_B` | stacked over the poses, eqs. (27)–(29) | [`identification::CalibrationProblem`] |
//! | `σ₁ … σ_L` | singular values of the scaled `J_B` | [`observability::Spectrum`] |
//! | `O₁ … O₅` | observability indices, eqs. (34)–(38) | [`observability::O1`] … [`observability::O5`] |
//! | `Ω`, `ζ_n`, `η_m` | candidates, chosen set, tabu list (section 3.2) | [`selection::Candidates`], [`observability::PoseSet`], [`selection::TabuDetmax`] |
//! | `n`, `L` | number of poses, of parameters | |
//!
//! Inside, numbers are SI: metres and radians. Derivatives are along a small motion `(δt, δω)` of the platform
//! rather than along the angles, for the reason given in [`pose`].
//!
//! # The modules follow the work
//!
//! | module | holds |
//! |---|---|
//! | [`pose`], [`units`], [`conditions`] | poses and how they are written; units at the edges; the state of a sample |
//! | [`solve`] | argmin solvers with typed outcomes; they know no mechanism |
//! | [`mechanism`] | the trait [`mechanism::Mechanism`], its kinematics, [`mechanism::SixHardpoint`] |
//! | [`measurement`] | samples, readings, noise; the trait [`measurement::MeasurementModel`] |
//! | [`effect`] | the trait [`effect::Effect`], the catalogue of causes, [`effect::Extended`] mechanisms |
//! | [`observability`] | the trait [`observability::ObservabilityIndex`], O1–O5, the predicted pose error, fast scans |
//! | [`identification`] | the trait [`identification::Identifier`] and [`identification::calibrate`] |
//! | [`selection`] | the trait [`selection::PoseSelector`], candidates, the certified bound |
//! | [`diagnosis`] | what the model gets wrong, and why: [`diagnosis::diagnose`] |
//! | [`simulation`] | true mechanisms, noise, Monte Carlo, work that survives a stop |
//! | [`files`] | mechanism files (TOML, URDF), measurements and pose lists (CSV) |
//! | [`report`] | results as text, JSON, charts and pages |
//! | `conformance` | test suites for mechanisms, measurements, identifiers, indices and selectors (feature `conformance`) |
//!
//! # An example
//!
//! ```no_run
//! use paracal::files::{Machine, read_measurement};
//! use paracal::identification::{CalibrationOptions, LevenbergMarquardt, calibrate};
//!
//! let machine = Machine::read("mechanisms/table5.toml")?;
//! let measured = read_measurement("examples/data/hardpoint-noisy.csv", &machine)?;
//! let result = calibrate(
//!     machine.mechanism.as_ref(),
//!     &measured.data,
//!     machine.workspace.as_ref(),
//!     &LevenbergMarquardt::default(),
//!     &CalibrationOptions::default(),
//! )?;
//! assert!(result.verdict.trusted);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Features
//!
//! | feature | adds | default |
//! |---|---|---|
//! | `files` | [`files`]: mechanism files in TOML, measurements and lists of poses in CSV | yes |
//! | `urdf` | mechanism files in URDF | yes |
//! | `report` | [`report`]: text, JSON, pages | yes |
//! | `cli` | the program `paracal`, with all of these | yes |
//! | `conformance` | `conformance`: test suites for implementations of your own | no |
//!
//! Without them the library is kinematics, measurement, observability, identification, effects, selection, diagnosis and
//! simulation, on half of the crates.

#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
pub mod conditions;
#[cfg(feature = "conformance")]
pub mod conformance;
pub mod diagnosis;
pub mod effect;
#[cfg(feature = "files")]
pub mod files;
pub mod identification;
pub mod measurement;
pub mod mechanism;
pub mod observability;
pub mod pose;
#[cfg(feature = "report")]
pub mod report;
pub mod selection;
pub mod simulation;
pub mod solve;
pub mod units;

/// The linear algebra and the random numbers in the public signatures, so that versions cannot mismatch.
pub use {nalgebra, rand};

/// The examples of the README are compiled with the documentation.
#[cfg(all(doctest, feature = "files"))]
#[doc = include_str!("../README.md")]
struct Readme;

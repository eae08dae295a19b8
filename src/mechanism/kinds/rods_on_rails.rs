//! Six rods of fixed length on carriages: one carriage to each (6-PUS, the hexaglide), or one to two (the linear delta, with
//! its parallelograms as they are).

use nalgebra::Vector3;

use super::{Tolerances, count, positive, rods_in_words, unit};
use crate::mechanism::closure::{Closure, ClosureMechanism, Column, Outline, Real, State, length};
use crate::mechanism::{GeometryError, ParameterRole};
use crate::pose::Pose;
use crate::units::Dimension;

/// One of the six rods, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Rod {
    /// Where it meets the platform, platform frame; the frame's origin is the tool.
    pub platform: Vector3<f64>,
    /// Where it meets its carriage when the carriage stands at coordinate zero, base frame.
    pub base: Vector3<f64>,
    /// Its length.
    pub length: f64,
    /// Its carriage, from 0.
    pub carriage: usize,
    /// Direction in which the carriage's coordinate counts, base frame; any length.
    pub rail: Vector3<f64>,
    /// Smallest and largest coordinate of the carriage.
    pub stroke: Option<[f64; 2]>,
}

/// Closure of six rods on carriages.
#[derive(Clone, Debug, PartialEq)]
pub struct RodsOnRails {
    /// Carriage of each rod, and the direction of its rail.
    rails: Vec<(usize, Vector3<f64>)>,
}

/// Three carriages with two rods each.
#[derive(Clone, Copy, Debug)]
pub struct LinearDelta;

/// Six carriages with one rod each.
#[derive(Clone, Copy, Debug)]
pub struct SixCarriages;

const RODS: usize = 6;
const PER_ROD: usize = 7;

impl LinearDelta {
    /// A linear delta. Its joints control x, y and z. Of the two carriage positions that reach home the one within the
    /// stroke is taken; if that does not decide, the one farther along the rail.
    ///
    /// # Errors
    /// [`GeometryError`] for anything but two rods on each of three carriages that reach home and hold the
    /// platform there.
    #[allow(clippy::new_ret_no_self)]
    pub fn new(
        name: &str,
        rods: &[Rod],
        home: Pose,
        tolerances: Option<Tolerances>,
    ) -> Result<ClosureMechanism<RodsOnRails>, GeometryError> {
        count("linear delta", "rods", RODS, rods.len())?;
        let outline = Outline::new(name, RODS, home).controls([true, true, true, false, false, false]);
        RodsOnRails::on_carriages(outline, rods, 3, "a linear delta has two on each of three carriages", tolerances)
    }
}

impl SixCarriages {
    /// Six carriages, of which each moves one rod; `carriage` of a rod is its own number. The carriage positions at home are
    /// chosen as for [`LinearDelta::new`].
    ///
    /// # Errors
    /// [`GeometryError`] for anything but six rods, each on a carriage of its own, that reach home and hold the platform
    /// there.
    #[allow(clippy::new_ret_no_self)]
    pub fn new(
        name: &str,
        rods: &[Rod],
        home: Pose,
        tolerances: Option<Tolerances>,
    ) -> Result<ClosureMechanism<RodsOnRails>, GeometryError> {
        count("machine of six carriages", "rods", RODS, rods.len())?;
        let outline = Outline::new(name, RODS, home);
        RodsOnRails::on_carriages(outline, rods, RODS, "each of six carriages has one", tolerances)
    }
}

impl RodsOnRails {
    /// Rods that share so many carriages evenly.
    fn on_carriages(
        mut outline: Outline,
        rods: &[Rod],
        carriages: usize,
        shared: &str,
        tolerances: Option<Tolerances>,
    ) -> Result<ClosureMechanism<Self>, GeometryError> {
        let mut rails = Vec::with_capacity(RODS);
        for (leg, rod) in rods.iter().enumerate() {
            positive(leg, "length", rod.length)?;
            rails.push((rod.carriage, unit(leg, "rail", &rod.rail)?));
            let sigma = |f: fn(&Tolerances) -> f64| tolerances.as_ref().map(f);
            let role = ParameterRole::LegDimension { leg };
            outline = outline
                .platform_point(leg, rod.platform.into(), sigma(|t| t.anchor))
                .base_point(leg, rod.base.into(), sigma(|t| t.anchor))
                .parameter(format!("s{}", leg + 1), Dimension::Length, rod.length, sigma(|t| t.length), role);
        }
        for carriage in 0..carriages {
            let mine: Vec<usize> = (0..RODS).filter(|k| rods[*k].carriage == carriage).collect();
            if mine.len() != RODS / carriages {
                let (number, found) = (carriage + 1, rods_in_words(mine.len()));
                return Err(GeometryError::Outline(format!("carriage {number} has {found}; {shared}")));
            }
            let first = mine[0];
            for other in &mine[1..] {
                if (rails[first].1 - rails[*other].1).norm() > 1e-9 || rods[first].stroke != rods[*other].stroke {
                    return Err(GeometryError::Outline(format!(
                        "legs {} and {} are on the same carriage but state different rails or strokes",
                        first + 1,
                        other + 1
                    )));
                }
            }
            let stroke = rods[first].stroke;
            let near = carriage_at_home(&rods[first], &rails[first].1, &outline.home).ok_or_else(|| {
                GeometryError::Outline(format!("leg {}: its rod does not reach the platform at home", first + 1))
            })?;
            outline = outline.joint(format!("leg{}", carriage + 1), Dimension::Length, near, stroke);
        }
        ClosureMechanism::new(Self { rails }, outline)
    }
}

fn carriage_at_home(rod: &Rod, rail: &Vector3<f64>, home: &Pose) -> Option<f64> {
    // |e - h d| = s, so h = e·d ± √(s² - |e|² + (e·d)²).
    let e = home.place(&rod.platform) - rod.base;
    let middle = e.dot(rail);
    let half = (rod.length.powi(2) - e.norm_squared() + middle.powi(2)).sqrt();
    let within = |h: f64| rod.stroke.is_some_and(|[from, to]| from <= h && h <= to);
    let (far, near) = (middle + half, middle - half);
    let chosen = if within(near) && !within(far) { near } else { far };
    chosen.is_finite().then_some(chosen)
}

impl Closure for RodsOnRails {
    fn residual<T: Real>(&self, s: &State<'_, T>, out: &mut [T]) {
        for (rod, (carriage, rail)) in self.rails.iter().enumerate() {
            let first = PER_ROD * rod;
            let (tip, foot, h) = (s.place(&s.point(first)), s.point(first + 3), s.joints[*carriage]);
            let along_rod = Vector3::from_fn(|k, _| tip[k] - foot[k] - h * rail[k]);
            out[rod] = length(&along_rod) - s.parameters[first + 6];
        }
    }

    fn depends(&self, row: usize, on: Column) -> bool {
        match on {
            Column::Parameter(k) => k / PER_ROD == row,
            Column::Joint(k) => self.rails[row].0 == k,
        }
    }
}

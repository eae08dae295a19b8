//! Operating states from the columns of a table: covariates, clock times, and the direction of gravity.
//!
//! Gravity in the base frame stands in the columns `gravity_x`, `gravity_y`, `gravity_z`, or follows from the elevation:
//! `(cos el, 0, -sin el)`, with `gravity_axis = "y"` in the mechanism file `(0, cos el, -sin el)`.

use nalgebra::Vector3;

use crate::conditions::{Conditions, ELEVATION, TIME};
use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::sections::GravityAxis;
use crate::files::table::clock::{Clock, backwards};
use crate::files::table::column::{Column, GRAVITY_NAMES, Meaning, ZENITH_DISTANCE};
use crate::files::table::text_table::Table;
use crate::units::Dimension;

/// The states of the rows of a table, outside of a run.
pub(crate) struct States {
    pub(crate) states: Vec<Conditions>,
    /// Columns of no known meaning that hold no number at all, such as remarks.
    pub(crate) ignored: Vec<usize>,
    /// Warnings for the user.
    pub(crate) warnings: Vec<String>,
}

/// A vector of gravity may be this much longer or shorter than one.
const LENGTH_ERROR: f64 = 1e-3;
/// °C.
const ABSOLUTE_ZERO: f64 = -273.15;

impl States {
    /// Reads the states.
    ///
    /// # Errors
    /// [`FileError`] naming row, column and what to do.
    pub(crate) fn read(table: &Table, machine: &Machine) -> Result<Self, FileError> {
        let mut warnings = table.warnings.clone();
        let ignored: Vec<usize> = (0..table.columns.len()).filter(|k| table.is_remark(*k)).collect();
        if !ignored.is_empty() {
            let names: Vec<&str> = ignored.iter().map(|k| table.columns[*k].name.as_str()).collect();
            warnings.push(format!("columns without numbers are not used: {}", names.join(", ")));
        }
        let gravity = Gravity::of(table, machine.document.gravity_axis.unwrap_or_default(), &mut warnings)?;
        let timed = |c: &Column| matches!(&c.meaning, Meaning::Covariate(name) if name == TIME);
        let mut clock = (!table.columns.iter().any(timed)).then(Clock::default);
        let mut states = Vec::with_capacity(table.rows.len());
        for row in 0..table.rows.len() {
            let mut state = Conditions::unknown();
            for (k, column) in table.columns.iter().enumerate() {
                match &column.meaning {
                    Meaning::Covariate(name) if !ignored.contains(&k) => {
                        let Some(value) = table.number(row, k)? else { continue };
                        if machine.condition_kinds().is_temperature(name) && value < ABSOLUTE_ZERO {
                            return Err(table.cell_error(
                                row,
                                k,
                                "is below absolute zero; check the cell and the unit",
                            ));
                        }
                        match gravity.elevation == Some(Elevation::Zenith(k)) {
                            // So that the two mean one covariate.
                            true => state.covariates.insert(ELEVATION.into(), std::f64::consts::FRAC_PI_2 - value),
                            false => state.covariates.insert(name.clone(), value),
                        };
                    }
                    Meaning::Clock => {
                        let since = clock.as_mut().map(|clock| clock.since_first(table, row, k)).transpose()?;
                        state.covariates.extend(since.flatten().map(|since| (TIME.to_owned(), since)));
                    }
                    _ => {}
                }
            }
            state.gravity = gravity.at(table, row, &state)?;
            states.push(state);
        }
        warnings.extend(backwards(&states));
        Ok(Self { states, ignored, warnings })
    }
}

/// The column from which the elevation comes.
#[derive(Clone, Copy, PartialEq)]
enum Elevation {
    Stated,
    Zenith(usize),
}

/// Where the direction of gravity comes from.
struct Gravity {
    columns: Option<[usize; 3]>,
    elevation: Option<Elevation>,
    axis: GravityAxis,
}

impl Gravity {
    fn of(table: &Table, axis: GravityAxis, warnings: &mut Vec<String>) -> Result<Self, FileError> {
        let find = |name: &str| {
            table.columns.iter().position(|c| matches!(&c.meaning, Meaning::Covariate(covariate) if covariate == name))
        };
        let header = |problem: String| FileError::Header { path: table.path.clone(), problem };
        let found = GRAVITY_NAMES.map(find);
        let missing: Vec<&str> =
            GRAVITY_NAMES.iter().zip(&found).filter(|(_, c)| c.is_none()).map(|(n, _)| *n).collect();
        let columns = match found {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]),
            [None, None, None] => None,
            _ => return Err(header(format!("a direction of gravity needs {} too", missing.join(" and ")))),
        };
        if let Some(k) = columns.iter().flatten().find(|k| table.columns[**k].unit.is_some()) {
            return Err(FileError::Column {
                path: table.path.clone(),
                column: table.columns[*k].name.clone(),
                problem: "is a component of a direction and has no unit; write gravity_x, gravity_y, gravity_z".into(),
            });
        }
        let mut angle = |name: &str| {
            let k = find(name)?;
            let known = table.columns[k].unit.is_some_and(|u| u.dimension == Dimension::Angle);
            if !known {
                let column = &table.columns[k].name;
                let message = format!("column '{column}' states no unit of angle, so gravity is not taken from it");
                warnings.push(format!("{message}; call it {name}_deg"));
            }
            known.then_some(k)
        };
        let elevation = match (angle(ELEVATION), angle(ZENITH_DISTANCE)) {
            (Some(_), Some(zenith)) => {
                return Err(FileError::Column {
                    path: table.path.clone(),
                    column: table.columns[zenith].name.clone(),
                    problem: "means the same as the elevation; keep one of them".into(),
                });
            }
            (Some(_), None) => Some(Elevation::Stated),
            (None, zenith) => zenith.map(Elevation::Zenith),
        };
        Ok(Self { columns, elevation, axis })
    }

    /// The direction at a row, whose covariates have been read.
    fn at(&self, table: &Table, row: usize, state: &Conditions) -> Result<Option<Vector3<f64>>, FileError> {
        if let Some(columns) = self.columns {
            let mut g = [None; 3];
            for (component, column) in g.iter_mut().zip(columns) {
                *component = table.number(row, column)?;
            }
            match g {
                [Some(x), Some(y), Some(z)] => {
                    return unit_vector(table, row, columns[0], Vector3::new(x, y, z)).map(Some);
                }
                [None, None, None] => {}
                _ => {
                    let problem = "belongs to a direction of gravity that is only partly filled; fill all three cells \
                                   or none";
                    return Err(table.cell_error(row, columns[0], problem));
                }
            }
        }
        let elevation = self.elevation.and_then(|_| state.get(ELEVATION));
        Ok(elevation.map(|el| self.axis.gravity(el)))
    }
}

impl GravityAxis {
    /// The direction of gravity in the base frame at an elevation.
    pub(crate) fn gravity(self, elevation: f64) -> Vector3<f64> {
        let (sine, cosine) = elevation.sin_cos();
        match self {
            Self::X => Vector3::new(cosine, 0.0, -sine),
            Self::Y => Vector3::new(0.0, cosine, -sine),
        }
    }
}

fn unit_vector(table: &Table, row: usize, column: usize, g: Vector3<f64>) -> Result<Vector3<f64>, FileError> {
    let length = g.norm();
    if (length - 1.0).abs() <= LENGTH_ERROR {
        return Ok(g / length);
    }
    let problem = format!(
        "belongs to a direction of gravity of length {length:.6}; it must be 1, correct gravity_x, gravity_y, gravity_z"
    );
    Err(table.cell_error(row, column, problem))
}

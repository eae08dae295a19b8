//! The numbers that the paper prints, and the settings that it does not state.
//!
//! | setting | value | how sure |
//! |---|---|---|
//! | geometry of Table 1 and section 5 | Table 5 | sure: σ₁ implied by Table 1 |
//! | units of the indices | mm and rad, rows unweighted | sure: O3/√n is the same in all columns |
//! | workspace | ±100 mm, ±10° about home, a box | sure along a line of equal random means |
//! | candidates | uniform random; 2000 as stated fit, 3000 fit better | likely |
//! | noise | normal; 0.001 mm and at most 1e-4° in section 5 | normal: stated; the angle fits Table 7 |
//! | estimator | plain least squares on mm and rad | sure: Tables 4, 7, 8 |
//! | workspace of section 4 | not determined; the same is taken | open |
//! | targets | not determined; uniform in the workspace is taken | open |

use std::path::Path;

use crate::files::{FileError, Machine};
use crate::measurement::Noise;
use crate::mechanism::{GeometryError, Mechanism, Workspace};
use crate::pose::PoseConvention;

/// Section 5: length of the tabu list.
pub const TABU_LENGTH: usize = 100;
/// Iterations of the tabu search. The paper found its best after 219.
pub const TABU_ITERATIONS: usize = 400;
/// Section 5: number of measured poses.
pub const POSES: usize = 20;
/// Section 5: number of random sets of Figure 7.
pub const RANDOM_SETS: u64 = 1000;
/// Section 4.2 and section 5: numbers of target poses.
pub const TARGETS: (usize, usize) = (30, 150);
/// Section 4.3: standard deviation of the parameter errors, m.
pub const ERROR_SD: f64 = 0.5e-3;
/// Half-ranges of the workspace, mm and degrees: recovered, see above.
pub const WORKSPACE: (f64, f64) = (100.0, 10.0);

/// Table 1: index, then tabu DETMAX for 20, 30, 40 poses, then DETMAX for the same.
pub const TABLE_1: [(&str, [f64; 3], [f64; 3]); 5] = [
    ("o1", [0.0357, 0.0361, 0.0362], [0.0352, 0.0355, 0.0355]),
    ("o2", [2.459e-4, 2.457e-4, 2.463e-4], [2.432e-4, 2.443e-4, 2.441e-4]),
    ("o3", [1.395e-3, 1.709e-3, 1.973e-3], [1.393e-3, 1.707e-3, 1.970e-3]),
    ("o4", [3.413e-7, 4.165e-7, 4.784e-7], [3.337e-7, 4.104e-7, 4.738e-7]),
    ("o5", [4.361e-4, 5.399e-4, 6.255e-4], [4.314e-4, 5.379e-4, 6.247e-4]),
];
/// Numbers of poses of Table 1.
pub const TABLE_1_POSES: [usize; 3] = [20, 30, 40];

/// A measurement condition of Table 3 with the mean integrated errors of Table 4 (O1 to O5), mm + degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// As the paper numbers it.
    pub name: &'static str,
    /// Number of measured poses.
    pub poses: usize,
    /// Standard deviation of a position coordinate, mm.
    pub position_mm: f64,
    /// Standard deviation of an angle, degrees.
    pub rotation_deg: f64,
    /// Table 4.
    pub integrated: [f64; 5],
}

impl Condition {
    /// The noise of a measured coordinate.
    pub fn noise(&self) -> Noise {
        Noise::stated(1e-3 * self.position_mm, self.rotation_deg.to_radians())
    }
}

/// Tables 3 and 4.
pub const CONDITIONS: [Condition; 4] = [
    Condition {
        name: "I",
        poses: 10,
        position_mm: 0.003,
        rotation_deg: 0.0003,
        integrated: [0.01050, 0.02936, 0.03388, 0.04805, 0.01727],
    },
    Condition {
        name: "II",
        poses: 15,
        position_mm: 0.05,
        rotation_deg: 0.005,
        integrated: [0.15785, 0.24408, 0.15933, 0.22564, 0.24932],
    },
    Condition {
        name: "III",
        poses: 22,
        position_mm: 0.01,
        rotation_deg: 0.001,
        integrated: [0.02415, 0.06181, 0.04541, 0.05333, 0.02554],
    },
    Condition {
        name: "IV",
        poses: 30,
        position_mm: 0.1,
        rotation_deg: 0.01,
        integrated: [0.21662, 0.36087, 0.27937, 0.32318, 0.27659],
    },
];

/// Table 6, mm: a row for each leg, columns xA yA zA xB yB zB h.
pub const TABLE_6: [[f64; 7]; 6] = [
    [-0.5, -0.2, -1.0, -0.4, 0.2, 0.6, 0.6],
    [0.1, -0.3, -0.7, 0.4, 0.2, -0.3, -0.1],
    [0.0, -0.4, -0.3, -0.1, -0.3, 0.7, 0.1],
    [0.3, 1.1, -0.2, -0.1, -0.7, 0.2, -0.2],
    [-0.4, 0.3, -0.7, -1.3, 0.8, 0.7, 0.3],
    [-0.9, -0.2, 1.1, 0.4, -0.4, -0.3, -0.2],
];

/// Table 7 as printed, mm. It is transposed: its rows are xA yA zA xB yB zB, its first six columns the legs; the seventh
/// repeats the first.
pub const TABLE_7: [[f64; 7]; 6] = [
    [-0.476, 0.134, -0.032, 0.275, -0.432, -0.882, -0.476],
    [-0.221, -0.275, -0.380, 1.121, 0.277, -0.232, -0.221],
    [-1.012, -0.708, -0.307, -0.200, -0.710, 1.104, -1.012],
    [-0.381, 0.426, -0.162, -0.128, -1.343, 0.410, -0.381],
    [0.184, 0.246, -0.287, -0.686, 0.791, -0.430, 0.184],
    [0.597, -0.324, 0.708, 0.195, 0.678, -0.288, 0.597],
];
/// Names of the columns of Table 6, as parameters are called before the number of the leg.
pub const COLUMNS: [&str; 7] = ["xA", "yA", "zA", "xB", "yB", "zB", "h"];

/// Table 8: position maximum and mean, mm; attitude maximum and mean, degrees; with O1, then traditional.
pub const TABLE_8: [[f64; 4]; 2] = [[0.001498, 0.000771, 0.000492, 0.000262], [0.006933, 0.001424, 0.001675, 0.000839]];

/// Section 5: O1 of the chosen set, iterations of tabu DETMAX to it and of DETMAX to its end.
pub const SEARCH: (f64, f64, f64) = (0.03571, 219.0, 21.0);
/// Section 5: mean and largest O1 of the random sets.
pub const RANDOM_O1: (f64, f64) = (0.01713, 0.02199);

/// The mechanism of Table 2 (section 4).
///
/// # Errors
/// Never in practice: the file is part of the program.
pub fn table_2() -> Result<Machine, FileError> {
    Machine::from_text(include_str!("../../../mechanisms/table2.toml"), Path::new("mechanisms/table2.toml"))
}

/// The mechanism of Table 5 (Table 1 and section 5).
///
/// # Errors
/// Never in practice: the file is part of the program.
pub fn table_5() -> Result<Machine, FileError> {
    Machine::from_text(include_str!("../../../mechanisms/table5.toml"), Path::new("mechanisms/table5.toml"))
}

/// The mechanism of Table 5 with the errors of Table 6.
///
/// # Errors
/// Never in practice: the values make a mechanism.
pub fn with_table_6(nominal: &dyn Mechanism) -> Result<Box<dyn Mechanism>, GeometryError> {
    let values: Vec<f64> =
        nominal.values().iter().zip(in_order(&TABLE_6)).map(|(nominal, mm)| nominal + 1e-3 * mm).collect();
    nominal.with_values(&values, nominal.home())
}

/// A table of legs in the order of the parameters, eq. (15), which has h before xB.
pub fn in_order(table: &[[f64; 7]; 6]) -> Vec<f64> {
    table.iter().flat_map(|&[xa, ya, za, xb, yb, zb, h]| [xa, ya, za, h, xb, yb, zb]).collect()
}

/// The box of ±`mm` and ±`degrees` about home.
pub fn workspace(mechanism: &dyn Mechanism, (mm, degrees): (f64, f64)) -> Workspace {
    let convention = PoseConvention::default();
    let (p, r) = (1e-3 * mm, degrees.to_radians());
    Workspace { convention, centre: convention.coordinates(&mechanism.home()), half: [p, p, p, r, r, r] }
}

/// The noise of section 5: 1 µm as stated, and 1e-4°, which fits Table 7 best.
pub fn noise() -> Noise {
    Noise::stated(1e-6, 1e-4_f64.to_radians())
}

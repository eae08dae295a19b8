//! Files that are read wrongly: what their header says is not what their writer meant.
//!
//! A mistake changes the numbers of a correct file and leaves its header. The diagnosis must say which reading would
//! make sense of it.

use rand::Rng;
use rand::seq::SliceRandom;

use super::hexapod::{HOME_LENGTH, Pose};
use super::text::Sheet;

/// A mistake: the reading that undoes it, and its form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    pub reading: &'static str,
    pub form: &'static str,
}

/// Every reading in every form.
pub const FORMS: [(&str, &str); 22] = [
    ("axis-sign", "x"),
    ("axis-sign", "y"),
    ("axis-sign", "z"),
    ("axis-sign", "rx"),
    ("axis-sign", "ry"),
    ("axis-sign", "rz"),
    ("inverse-pose", "rotation transposed"),
    ("inverse-pose", "full inverse"),
    ("euler-order", "xyz"),
    ("angle-unit", "rad"),
    ("angle-unit", "mrad"),
    ("angle-unit", "arcsec"),
    ("length-unit", "pose in m"),
    ("length-unit", "pose in in"),
    ("joint-unit", "legs in m"),
    ("joint-unit", "legs in in"),
    ("axes-swapped", "x y"),
    ("axes-swapped", "rx ry"),
    ("leg-order", ""),
    ("leg-sign", ""),
    ("row-shift", "poses one row late"),
    ("row-shift", "poses one row early"),
];

impl Mistake {
    pub fn of(number: usize) -> Self {
        let (reading, form) = FORMS[number % FORMS.len()];
        Self { reading, form }
    }

    /// Makes the mistake; says what was done where the form leaves it open.
    pub fn make<R: Rng + ?Sized>(&self, sheet: &mut Sheet, rng: &mut R) -> String {
        let axis = ["x", "y", "z", "rx", "ry", "rz"].iter().position(|a| *a == self.form);
        let poses = |sheet: &mut Sheet, change: &dyn Fn([f64; 6]) -> [f64; 6]| {
            sheet.poses.iter_mut().for_each(|q| *q = change(*q));
        };
        let angles = |by: f64| move |q: [f64; 6]| [q[0], q[1], q[2], q[3] * by, q[4] * by, q[5] * by];
        let places = |by: f64| move |q: [f64; 6]| [q[0] * by, q[1] * by, q[2] * by, q[3], q[4], q[5]];
        // A file in degrees and millimetres: the factor is of the numbers that stand in it, all held in SI here.
        let (degree, millimetre) = (1_f64.to_radians(), 1e-3);
        match (self.reading, self.form) {
            ("axis-sign", _) => {
                let axis = axis.unwrap_or(0);
                sheet.poses.iter_mut().for_each(|q| q[axis] = -q[axis]);
            }
            ("inverse-pose", form) => poses(sheet, &|q| {
                let pose = Pose::of(q);
                let r = pose.r.transpose();
                let t = if form == "full inverse" { -(r * pose.t) } else { pose.t };
                Pose { t, r }.coordinates()
            }),
            ("euler-order", _) => poses(sheet, &|q| {
                // R = Rx(α) Ry(β) Rz(γ): the transpose of Rz(−γ) Ry(−β) Rx(−α).
                let r = Pose::of(q).r;
                let turned = Pose { t: -Pose::of(q).t, r: r.transpose() }.coordinates();
                turned.map(|v| -v)
            }),
            ("angle-unit", "rad") => poses(sheet, &angles(degree)),
            ("angle-unit", "mrad") => poses(sheet, &angles(1e3 * degree)),
            ("angle-unit", _) => poses(sheet, &angles(3600.0)),
            ("length-unit", "pose in m") => poses(sheet, &places(millimetre)),
            ("length-unit", "pose in in") => poses(sheet, &places(1.0 / 25.4)),
            ("joint-unit", form) => {
                let by = if form == "legs in m" { millimetre } else { 1.0 / 25.4 };
                sheet.legs.iter_mut().flatten().for_each(|l| *l *= by);
            }
            ("axes-swapped", form) => {
                let [i, j] = if form == "x y" { [0, 1] } else { [3, 4] };
                sheet.poses.iter_mut().for_each(|q| q.swap(i, j));
            }
            ("leg-order", _) => {
                let mut order = [0, 1, 2, 3, 4, 5];
                while order == [0, 1, 2, 3, 4, 5] {
                    order.shuffle(rng);
                }
                sheet.legs.iter_mut().for_each(|l| *l = order.map(|i| l[i]));
                return format!("column i holds leg {:?}", order.map(|i| i + 1));
            }
            ("leg-sign", _) => sheet.legs.iter_mut().flatten().for_each(|l| *l = 2.0 * HOME_LENGTH - *l),
            // A row without a pose, or a pose without a row, is what is left at an end, and is deleted.
            (_, "poses one row late") => sheet.shift(1, 0),
            _ => sheet.shift(0, 1),
        }
        self.form.to_owned()
    }
}

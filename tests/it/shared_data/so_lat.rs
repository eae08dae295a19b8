//! The mirrors of a large telescope, measured at four corners against elevation: they sag, and something slips between 90°
//! and 100° on the way up and on the way down.

use std::fmt::Write;

use paracal::diagnosis::{Diagnosis, UnknownTest, Verdict};
use paracal::nalgebra::{Matrix3, Rotation3, Vector3};

use super::folder;
use crate::common::asked::{asked, said};

const POSITIONER: &str =
    "name = \"mirror\"\ntype = \"pose\"\nlength_unit = \"um\"\nangle_unit = \"arcsec\"\ngravity_axis = \"x\"\n";

struct Row {
    elevation: f64,
    direction: f64,
    /// Millimetres; a corner that was not seen has none.
    corners: [Option<Vector3<f64>>; 4],
}

fn rows(name: &str) -> Option<Vec<Row>> {
    let text = std::fs::read_to_string(folder("so-lat")?.join(name)).unwrap();
    let row = |line: &str| {
        let cells: Vec<Option<f64>> = line.split(',').map(|cell| cell.parse().ok()).collect();
        let corner = |k: usize| Some(Vector3::new(cells[2 + 3 * k]?, cells[3 + 3 * k]?, cells[4 + 3 * k]?));
        Row { elevation: cells[0].unwrap(), direction: cells[1].unwrap(), corners: std::array::from_fn(corner) }
    };
    Some(text.lines().skip(1).map(row).collect())
}

/// Rotation and shift that take the drawn corners nearest to the seen ones (Kabsch).
fn rigid(drawn: &[Vector3<f64>; 4], seen: &[Option<Vector3<f64>>; 4]) -> (Rotation3<f64>, Vector3<f64>) {
    let pairs: Vec<_> = drawn.iter().zip(seen).filter_map(|(a, b)| Some((*a, (*b)?))).collect();
    let n = pairs.len() as f64;
    let (a0, b0) = pairs.iter().fold((Vector3::zeros(), Vector3::zeros()), |(a, b), p| (a + p.0 / n, b + p.1 / n));
    let spread: Matrix3<f64> = pairs.iter().map(|(a, b)| (b - b0) * (a - a0).transpose()).sum();
    let svd = spread.svd(true, true);
    let (u, v_t) = (svd.u.unwrap(), svd.v_t.unwrap());
    let sign = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, (u * v_t).determinant().signum()));
    let turn = Rotation3::from_matrix_unchecked(u * sign * v_t);
    (turn, b0 - turn * a0)
}

/// A measurement file of the poses of a mirror, relative to the mean of its whole rows. Two corners do not hold a body.
fn poses(rows: &[Row]) -> String {
    let whole: Vec<[Vector3<f64>; 4]> =
        rows.iter().filter_map(|r| Some([r.corners[0]?, r.corners[1]?, r.corners[2]?, r.corners[3]?])).collect();
    let drawn: [Vector3<f64>; 4] =
        std::array::from_fn(|k| whole.iter().map(|r| r[k]).sum::<Vector3<f64>>() / whole.len() as f64);
    let mut text = String::from("elevation_deg,direction,x_um,y_um,z_um,rx_arcsec,ry_arcsec,rz_arcsec\n");
    for row in rows.iter().filter(|row| row.corners.iter().flatten().count() >= 3) {
        let (turn, shift) = rigid(&drawn, &row.corners);
        let (rx, ry, rz) = turn.euler_angles();
        write!(text, "{},{}", row.elevation, row.direction).unwrap();
        shift.iter().for_each(|v| write!(text, ",{:.4}", 1e3 * v).unwrap());
        [rx, ry, rz].iter().for_each(|v| write!(text, ",{:.5}", v.to_degrees() * 3600.0).unwrap());
        text.push('\n');
    }
    text
}

#[track_caller]
fn slips_beside_the_sag(found: &Diagnosis) {
    assert_eq!(found.verdict, Verdict::Unknown, "{}", said(found));
    assert!(found.causes.iter().any(|c| c.effect == "sag.linear"), "{}", said(found));
    assert!(found.outlier_rows.is_empty(), "{}", said(found));
    let unknown = found.unknown.as_ref().unwrap();
    assert_eq!((unknown.test, unknown.covariate.as_deref()), (UnknownTest::Jump, Some("elevation")), "{unknown:?}");
    let place = unknown.from.unwrap().to_degrees();
    assert!(place > 90.0 && place < 100.0, "{place}");
}

#[test]
fn the_mirrors_of_a_large_telescope_sag_and_slip_between_90_and_100_degrees() {
    for name in ["primary.csv", "secondary.csv"] {
        let Some(rows) = rows(name) else { return };
        assert_eq!(rows.len(), 21, "{name}");
        slips_beside_the_sag(&asked(POSITIONER, &poses(&rows)));
    }
}

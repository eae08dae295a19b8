//! The bundled measured machines: what `docs/measured.md` says of them.

use paracal::diagnosis::{UnknownTest, Verdict};

use crate::common::asked::said;

// Its `main` is not called here.
#[allow(dead_code, unreachable_pub)]
#[path = "../../examples/measured.rs"]
mod bench;

#[test]
fn mirrors_sag_and_slip_as_they_were_measured() {
    for name in ["primary", "secondary"] {
        let found = bench::mirror(name).unwrap();
        assert_eq!(found.verdict, Verdict::Unknown, "{name}: {}", said(&found));
        assert!(found.causes.iter().any(|c| c.effect == "sag.linear"), "{name}: {}", said(&found));
        // The end of the range, which was measured once.
        let left_out: Vec<usize> = found.outlier_rows.iter().map(|row| row.0).collect();
        assert!(left_out.iter().all(|row| *row == 10), "{name}: {}", said(&found));
        let unknown = found.unknown.as_ref().unwrap();
        assert_eq!((unknown.test, unknown.covariate.as_deref()), (UnknownTest::Jump, Some("elevation")), "{unknown:?}");
        assert!((90.0..100.0).contains(&unknown.from.unwrap().to_degrees()), "{unknown:?}");
        assert!((5e-4..8e-4).contains(&unknown.size.unwrap()), "{unknown:?}");
    }
}

#[test]
fn winches_of_a_cable_robot_are_found_with_all_positions_and_with_nine() {
    let [before, after, held_out] = bench::winches().unwrap();
    assert!(before > 10.0 && after < 3.5 && held_out < 4.0, "{before} {after} {held_out}");
    let missed = bench::nine_positions().unwrap();
    assert!(missed < 6.0, "{missed}");
}

//! Machines that are no hexapods, by a generator that shares nothing with the library.

use paracal::diagnosis::Verdict;

use crate::common::asked::{asked, said};
use crate::common::hidden::others::{Other, draw};

const ROWS: usize = 120;

/// Every effect of the machine once, at six times its detection limit.
#[track_caller]
fn each_effect_is_named_or_tied(machine: Other, effects: usize) {
    for number in 0..effects {
        let case = draw(machine, Some(6.0), ROWS, 5, number).unwrap();
        let found = asked(&case.mechanism, &case.data);
        let hidden = &case.truth.effects[0];
        let leg = case.truth.legs[0].map(|leg| leg - 1);
        let named = found.causes.iter().any(|c| c.effect == *hidden && c.leg == leg);
        let tied = found.causes.iter().flat_map(|c| c.rivals()).any(|r| r.effect == *hidden);
        assert!((named || tied) && found.unknown.is_none(), "{hidden}: {}", said(&found));
    }
}

#[track_caller]
fn nothing_is_found_where_nothing_is(machine: Other) {
    for number in 0..6 {
        let case = draw(machine, None, ROWS, 5, number).unwrap();
        let found = asked(&case.mechanism, &case.data);
        assert!(found.verdict == Verdict::Clean && found.outlier_rows.is_empty(), "{number}: {}", said(&found));
    }
}

#[test]
fn effects_of_a_delta_are_named() {
    each_effect_is_named_or_tied(Other::Delta, 9);
    nothing_is_found_where_nothing_is(Other::Delta);
}

/// A positioner has no size, and is in no unit that could be a wrong one.
#[test]
fn effects_of_a_positioner_are_named() {
    each_effect_is_named_or_tied(Other::Positioner, 6);
    nothing_is_found_where_nothing_is(Other::Positioner);
}

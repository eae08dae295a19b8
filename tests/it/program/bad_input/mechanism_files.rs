//! Mechanism files.

use super::{CALIBRATE, LEG_1, LEG_2, Row, all_are_refused, file, mechanism, poses, replaced, row};
use crate::common::bench::{NOISY, TABLE_5};

/// The bundled file with its first `from` replaced.
fn changed(name: &'static str, from: &str, to: &str, parts: &[&str]) -> Row {
    mechanism(name, replaced(TABLE_5, from, to), parts.iter().copied())
}

#[test]
fn texts_units_and_keys() {
    all_are_refused(&[
        row("missing", [], "calibrate no.toml d.csv -o o.toml", ["no.toml: cannot be read", "check its name"]),
        mechanism("empty", "", ["m.toml: the file is empty; check"]),
        mechanism("not UTF-8", b"name = \"\xb5m\"\n", ["m.toml: line 1: is not UTF-8"]),
        mechanism("a table", NOISY, ["m.toml: is a table", "mechanism file first"]),
        mechanism("not TOML", "name is m\n", ["m.toml: ", "line 1, column 6", "expected `=`"]),
        changed(
            "unknown unit of length",
            "length_unit = \"mm\"",
            "length_unit = \"furlong\"",
            &["m.toml: length_unit", "'furlong'", "use m | mm | um | in"],
        ),
        changed(
            "unit of another dimension",
            "angle_unit = \"deg\"",
            "angle_unit = \"mm\"",
            &["m.toml: angle_unit", "'mm'", "use rad | mrad | deg | arcsec"],
        ),
        changed("unknown key", "length_unit", "lenght_unit", &["m.toml: ", "line 6", "`lenght_unit`", "`length_unit`"]),
        changed(
            "unknown key of a leg",
            "length = 800.0",
            "length = 800.0\nofset = 1.0",
            &["m.toml: ", "line 13", "`ofset`", "`length_offset`"],
        ),
        changed(
            "misspelt section",
            "[tolerance]",
            "[tolerence]",
            &["m.toml: ", "line 43", "`tolerence`", "`tolerance`"],
        ),
        changed(
            "unknown type of mechanism",
            "six-hardpoint\"",
            "delta\"",
            &["m.toml: type", "'delta'", "use one of \"six-hardpoint\"", "\"linear-delta\""],
        ),
        mechanism(
            "effect without its parameters",
            format!("{TABLE_5}\n[[effect]]\nname = \"thermal.legs.uniform\"\n"),
            ["m.toml: effect 1 'thermal.legs.uniform', `parameters`", "'expansion' is missing"],
        ),
    ]);
}

#[test]
fn numbers() {
    all_are_refused(&[
        changed(
            "negative length",
            "length = 800.0",
            "length = -800.0",
            &["m.toml: leg 1, `length`", "-800", "must be positive"],
        ),
        changed(
            "stroke that is no interval",
            "length = 800.0",
            "length = 800.0\nstroke = [900.0, 700.0]",
            &["m.toml: leg 1, `stroke`", "[900, 700]", "[shortest, longest]"],
        ),
        changed(
            "tolerance of zero",
            "anchor = 0.5",
            "anchor = 0.0",
            &["m.toml: [tolerance] anchor", "must be positive, found 0", "leave the section out"],
        ),
        changed(
            "noise of zero",
            "rotation = 0.0001",
            "rotation = 0.0",
            &["m.toml: [noise] rotation", "must be positive, found 0", "leave the section out"],
        ),
        changed(
            "NaN in a leg",
            "length = 800.0",
            "length = nan",
            &["m.toml: leg 1, `length`", "NaN", "finite", "write a number"],
        ),
        changed(
            "infinity in a leg",
            "[1299.170, 348.112",
            "[1299.170, inf",
            &["m.toml: leg 2, `platform`", "inf", "finite"],
        ),
        // It would be written to the calibrated file, which nothing could read again.
        mechanism(
            "NaN in a section that is only handed on",
            format!("{TABLE_5}\n[platform]\nmass_kg = nan\n"),
            ["m.toml: [platform] mass_kg", "NaN", "finite"],
        ),
        mechanism(
            "NaN in a key that is only handed on",
            format!("reference_temperature_degC = nan\n{TABLE_5}"),
            ["m.toml: reference_temperature_degC", "NaN", "finite"],
        ),
        changed(
            "point with two coordinates",
            "[1299.170, -348.112, 0.0]",
            "[1299.170, -348.112]",
            &["m.toml: ", "line 10", "length 2", "length 3"],
        ),
    ]);
}

#[test]
fn planes() {
    let plane = |name, section: &str, parts: &[&str]| {
        mechanism(name, format!("{TABLE_5}\n[plane]\n{section}\n"), parts.iter().copied())
    };
    all_are_refused(&[
        plane(
            "normal without direction",
            "normal = [0, 0, 0.0]",
            &["m.toml: [plane] normal", "[0.0, 0.0, 0.0] has no direction", "such as [0, 0, 1]"],
        ),
        plane("normal at infinity", "normal = [0, 0, inf]", &["m.toml: [plane] normal", "inf is not a finite number"]),
        plane("normal of two numbers", "normal = [0, 1]", &["m.toml: ", "normal = [0, 1]", "array of length 3"]),
        plane("distance NaN", "distance = nan", &["m.toml: [plane] distance", "NaN is not a finite number"]),
        plane("tip at infinity", "tip = [0, inf, 0]", &["m.toml: [plane] tip", "inf is not a finite number"]),
        plane("identify is a number", "identify = 1", &["m.toml: ", "identify = 1", "boolean"]),
        plane(
            "unknown key of a plane",
            "offset = 1",
            &["m.toml: ", "unknown field `offset`", "`normal`, `distance`, `tip`, `identify`"],
        ),
    ]);
}

/// Platform and base point of each leg.
const POINTS: [[&str; 2]; 6] = [
    ["[1299.170, -348.112, 0.0]", "[1164.388, -977.037, 0.0]"],
    ["[1299.170, 348.112, 0.0]", "[1164.388, 977.037, 0.0]"],
    ["[-348.112, 1299.170, 0.0]", "[263.945, 1496.908, 0.0]"],
    ["[-951.059, 951.059, 0.0]", "[-1428.333, 519.871, 0.0]"],
    ["[-951.059, -951.059, 0.0]", "[-1428.333, -519.871, 0.0]"],
    ["[-348.112, -1299.170, 0.0]", "[263.945, -1496.908, 0.0]"],
];

/// All anchors on one line.
fn singular() -> String {
    let mut text = format!("{TABLE_5}\n[home]\nposition = [0.0, 0.0, 475.7]\n");
    for (leg, points) in POINTS.iter().enumerate() {
        let on_line = [100.0, 200.0].map(|step| format!("[{}, 0.0, 0.0]", step * (leg as f64 + 1.0)));
        for (point, on_line) in points.iter().zip(&on_line) {
            text = replaced(&text, point, on_line);
        }
    }
    text
}

/// Both legs lean as before, but meet in the middle of the platform's edge.
pub(super) fn with_a_shared_anchor() -> String {
    let met = |side: f64| format!("platform = [1299.170, 0.0, 0.0]\nbase = [1164.388, {}, 0.0]", side * 628.925);
    replaced(&replaced(TABLE_5, LEG_1, &met(-1.0)), LEG_2, &met(1.0))
}

#[test]
fn geometry() {
    let (last, rest) = (TABLE_5.rfind("[[leg]]").unwrap(), TABLE_5.find("[workspace]").unwrap());
    let five = format!("{}{}", &TABLE_5[..last], &TABLE_5[rest..]);
    all_are_refused(&[
        mechanism("five legs", five, ["m.toml: ", "six legs", "found 5"]),
        changed(
            "two equal platform anchors",
            "[1299.170, 348.112, 0.0]",
            "[1299.170, -348.112, 0.0]",
            &["m.toml: legs 1 and 2, `platform`", "[1299.17, -348.112, 0.0]", "correct one", "shared_anchors = true"],
        ),
        changed(
            "two equal base anchors",
            "[1164.388, 977.037, 0.0]",
            "[1164.388, -977.037, 0.0]",
            &["m.toml: legs 1 and 2, `base`", "[1164.388, -977.037, 0.0]", "correct one", "shared_anchors = true"],
        ),
        row(
            "shared anchors that are not stated",
            [file("m.toml", with_a_shared_anchor()), poses()],
            "compensate m.toml p.csv -o lengths.csv",
            ["m.toml: legs 1 and 2, `platform`"],
        ),
        row(
            "singular home",
            [file("m.toml", singular())],
            CALIBRATE,
            ["m.toml: ", "singular at home", "check the anchors and the home"],
        ),
        changed(
            "lengths without a home",
            "length = 800.0",
            "length = 9000.0",
            &["m.toml: no home pose", "state [home] or correct the lengths"],
        ),
    ]);
}

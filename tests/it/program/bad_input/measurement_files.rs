//! Measurement files and lists of poses.

use super::{CALIBRATE, Content, Entry, Row, all_are_refused, data, few, file, row};
use crate::common::bench::NOISY;

/// The data with the cell of a line (0 is the header) replaced.
fn cell(line: usize, column: usize, value: &str) -> String {
    let mut lines: Vec<Vec<&str>> = NOISY.lines().map(|l| l.split(',').collect()).collect();
    lines[line][column] = value;
    lines.iter().map(|l| l.join(",") + "\n").collect()
}

/// The first columns of the data with further ones: their header and the same cells in every row.
fn columns_with(columns: usize, header: &str, cells: &str) -> String {
    let first = |line: &str| line.split(',').take(columns).collect::<Vec<_>>().join(",");
    let row = |(k, line): (usize, &str)| format!("{},{}\n", first(line), if k == 0 { header } else { cells });
    NOISY.lines().enumerate().map(row).collect()
}

#[test]
fn texts() {
    let mut not_text = NOISY.as_bytes().to_vec();
    let at = NOISY.find('\n').unwrap() + 5;
    not_text[at] = 0xff;
    let place = format!("d.csv: line 2: is not UTF-8 text (first bad byte at {at})");
    let folder = || [Entry("sub", Content::Folder)];
    let mut rows = vec![
        row("missing data", [], "calibrate m.toml no.csv -o o.toml", ["no.csv: cannot be read", "check its name"]),
        row("missing data of an evaluation", [], "evaluate m.toml no.csv", ["no.csv: cannot be read"]),
        row("missing poses to compensate", [], "compensate m.toml no.csv -o o.csv", ["no.csv: cannot be read"]),
        row("missing poses to simulate", [], "simulate m.toml --poses no.csv -o o.csv", ["no.csv: cannot be read"]),
        row(
            "folder instead of a mechanism",
            folder(),
            "calibrate sub d.csv -o o.toml",
            ["sub: is a folder; name a file"],
        ),
        row("folder instead of data", folder(), "calibrate m.toml sub -o o.toml", ["sub: is a folder; name a file"]),
        data("empty", " \n\n", ["d.csv: the file is empty; check"]),
        data("not UTF-8", not_text, [place.as_str(), "save it as UTF-8"]),
        data("bracketed unit", NOISY.replacen("x_mm", "X [mm]", 1), ["d.csv", "'X [mm]'", "write it as 'x_mm'"]),
        data(
            "unit in parentheses",
            NOISY.replacen("leg1_mm", "leg1 (mm)", 1),
            ["d.csv", "'leg1 (mm)'", "write it as 'leg1_mm'"],
        ),
    ];
    for (separator, name) in [(";", "semicolons and decimal commas"), ("\t", "tabs and decimal commas")] {
        let text = NOISY.replace(',', separator).replace('.', ",");
        rows.push(data(name, text, ["d.csv: data row 0", "decimal comma", "decimal points"]));
    }
    let commas = NOISY.replace('.', ",");
    rows.push(data(
        "decimal commas among commas",
        commas,
        ["d.csv: data row 0 (line 2)", "24 cells", "decimal commas?"],
    ));
    all_are_refused(&rows);
}

#[test]
fn columns() {
    all_are_refused(&[
        data("unknown unit", cell(0, 6, "x_furlong"), ["d.csv: column 'x_furlong'", "m | mm | um | in", "'x_mm'"]),
        data("unit of another dimension", cell(0, 0, "leg1_deg"), ["d.csv: column 'leg1_deg'", "m | mm | um | in"]),
        data("header without unit", cell(0, 2, "leg3"), ["d.csv: column 'leg3'", "must end in a unit", "'leg3_mm'"]),
        data("column twice", cell(0, 7, "x_mm"), ["d.csv: column 'x_mm'", "twice", "delete or rename"]),
        data(
            "two columns of one meaning",
            cell(0, 7, "x_um"),
            ["d.csv: column 'x_um'", "the same as column 'x_mm'", "keep one"],
        ),
        data("seventh leg", cell(0, 5, "leg7_mm"), ["d.csv: column 'leg7_mm'", "legs 1 to 6", "delete the column"]),
        data("missing leg", cell(0, 5, "other_mm"), ["d.csv: no column for leg6", "'leg6_mm'"]),
        data(
            "pose and targets together",
            columns_with(12, "p1x_mm", "1.0"),
            ["d.csv: ", "both a measured pose and measured targets", "keep one"],
        ),
        data(
            "pose and contacts together",
            columns_with(12, "contact_mm", "1.0"),
            ["d.csv: ", "both a measured pose and measured contacts", "keep one"],
        ),
        data(
            "targets and contacts together",
            columns_with(6, "p1x_mm,p1y_mm,p1z_mm,contact_mm", "1,2,3,4"),
            ["d.csv: ", "both measured targets and measured contacts", "keep one"],
        ),
        data(
            "nothing measured",
            NOISY.lines().map(|l| l.split(',').take(6).collect::<Vec<_>>().join(",") + "\n").collect::<String>(),
            ["d.csv: ", "no measured column", "expected x_mm"],
        ),
        data(
            "targets without a cell",
            columns_with(6, "p1x_mm,p1y_mm,p1z_mm", ",,"),
            ["d.csv: ", "no cell of the measured targets is filled"],
        ),
    ]);
}

#[test]
fn contacts() {
    let contacts = |name, header: &str, cells: &str, parts: &[&str]| {
        data(name, columns_with(6, header, cells), parts.iter().copied())
    };
    all_are_refused(&[
        contacts(
            "contacts without a cell",
            "contact_mm",
            "",
            &["d.csv: ", "no cell of the measured contacts is filled"],
        ),
        contacts(
            "contact without unit",
            "contact",
            "1",
            &["d.csv: column 'contact'", "must end in a unit (m | mm | um | in)", "'contact_mm'"],
        ),
        contacts(
            "contact with the unit of an angle",
            "contact_deg",
            "1",
            &["d.csv: column 'contact_deg'", "'deg' is not a unit for it", "m | mm | um | in"],
        ),
        contacts(
            "contact that is no number",
            "contact_mm",
            "high",
            &["d.csv: data row 0 (line 2), column 'contact_mm'", "'high' is not a number"],
        ),
        contacts(
            "sigma of zero",
            "contact_mm,sigma_contact_mm",
            "1,0",
            &["column 'sigma_contact_mm'", "'0' must be positive"],
        ),
        contacts(
            "sigma of a pose",
            "contact_mm,sigma_x_mm",
            "1,1",
            &["column 'sigma_x_mm'", "has no column 'x_…'", "add that one, or delete this"],
        ),
        contacts(
            "sigma without a contact",
            "sigma_contact_mm",
            "1",
            &["d.csv: column 'sigma_contact_mm'", "has no column 'contact_…'", "add that one"],
        ),
    ]);
}

#[test]
fn rows_and_cells() {
    let mut rows = vec![
        data("header only", few(0), ["d.csv: ", "no data row", "add rows"]),
        data(
            "row too short",
            NOISY.replace(",-4.697230491850", ""),
            ["d.csv: data row 0 (line 2)", "11 cells", "12", "one cell for each column"],
        ),
        data(
            "row too long",
            NOISY.replace(",5.207265650406", ",5.207265650406,1.0"),
            ["d.csv: data row 1 (line 3)", "13 cells", "12", "one cell for each column"],
        ),
        data(
            "text in a number cell",
            cell(2, 0, "abc"),
            ["d.csv: data row 1 (line 3), column 'leg1_mm'", "'abc'", "not a number", "delete the row"],
        ),
        data(
            "NaN for a length",
            cell(2, 0, "NaN"),
            ["d.csv: data row 1 (line 3), column 'leg1_mm'", "'NaN'", "must not be empty"],
        ),
        data(
            "infinity in a cell",
            cell(2, 11, "inf"),
            ["d.csv: data row 1 (line 3), column 'rz_deg'", "'inf'", "finite", "leave the cell empty"],
        ),
        data(
            "number too large for a cell",
            cell(3, 1, "1e999"),
            ["d.csv: data row 2 (line 4), column 'leg2_mm'", "'1e999'", "finite", "delete the row"],
        ),
        data(
            "empty leg cell",
            cell(2, 3, ""),
            ["d.csv: data row 1 (line 3), column 'leg4_mm'", "must not be empty", "fill it in or delete the row"],
        ),
        data(
            "quaternion of wrong length",
            columns_with(9, "qw,qx,qy,qz", "0.9,0.1,0.0,0.0"),
            ["d.csv: data row 0 (line 2), column 'qw'", "'0.9'", "length 0.905539", "must be 1"],
        ),
    ];
    for (name, time) in [
        ("time in words", "noon"),
        ("time beyond all years", "9223372036854775807-01-01T00:00:00"),
        ("time in a zone beyond all hours", "2026-01-01T00:00:00+4294967295:00"),
    ] {
        let line = |(k, line): (usize, &str)| format!("{},{line}\n", if k == 0 { "time_utc" } else { time });
        let text: String = NOISY.lines().enumerate().map(line).collect();
        let parts = ["d.csv: data row 0 (line 2), column 'time_utc'", time, "write 2026-03-01T12:30:00"];
        rows.push(data(name, text, parts));
    }
    all_are_refused(&rows);
}

#[test]
fn lengths_and_poses() {
    let compensate = |name, list: &str, parts: &[&str]| -> Row {
        row(name, [file("p.csv", list)], "compensate m.toml p.csv -o o.csv", parts.iter().copied())
    };
    let out = [
        "d.csv: data row 1: ",
        "out of reach",
        "leg1",
        "3000.000 mm",
        "(home 800.000 mm)",
        "correct or delete the row",
    ];
    let far = || [file("d.csv", cell(2, 0, "3000.0"))];
    all_are_refused(&[
        row("length out of reach", far(), CALIBRATE, out),
        row("length out of reach of an evaluation", far(), "evaluate m.toml d.csv", out),
        row(
            "held-out length out of reach",
            [file("held.csv", cell(3, 4, "3000.0"))],
            "calibrate m.toml d.csv -o o.toml --holdout held.csv",
            ["held.csv: data row 2: ", "out of reach", "leg5", "3000.000 mm", "correct or delete the row"],
        ),
        compensate(
            "quaternion of zero",
            "x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,475,1,0,0,0\n0,0,475,0,0,0,0\n",
            &["p.csv: data row 1 (line 3), column 'qw'", "'0'", "length 0.000000", "must be 1"],
        ),
        compensate(
            "part of a quaternion",
            "x_mm,y_mm,z_mm,qw,qx,qy\n0,0,475,1,0,0\n",
            &["p.csv: ", "all of qw, qx, qy and qz"],
        ),
        compensate(
            "pose too far for a length",
            "x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n0,0,475,0,0,0\n1e300,0,475,0,0,0\n",
            &["p.csv: data row 1", "too far", "correct it"],
        ),
    ]);
}

//! Options, alone and for data that they do not fit.

use super::{CALIBRATE, all_are_refused, few, file, poses, row, without_tolerance};

#[test]
fn calibrations() {
    let few_equations = ["d.csv: 30 equations (5 samples)", "42 parameters", "at least 7 samples", "[tolerance]"];
    let mut rows = vec![
        row(
            "fewer equations than parameters, without prior",
            [file("d.csv", few(5))],
            format!("{CALIBRATE} --prior none"),
            few_equations,
        ),
        row(
            "fewer equations than parameters, without tolerance",
            [file("d.csv", few(5)), file("m.toml", without_tolerance())],
            CALIBRATE,
            few_equations,
        ),
        row(
            "prior without tolerance",
            [file("m.toml", without_tolerance())],
            format!("{CALIBRATE} --prior tolerance"),
            ["m.toml: ", "no [tolerance]", "state one, or calibrate without a prior"],
        ),
        row(
            "prior with unweighted rows",
            [],
            format!("{CALIBRATE} --prior tolerance --weights none"),
            ["drop `--weights none` or `--prior tolerance`"],
        ),
        row(
            "robust with unweighted rows",
            [],
            format!("{CALIBRATE} --identifier robust --weights none"),
            ["--weights none", "robust", "use least-squares"],
        ),
        row(
            "unknown identifier",
            [],
            format!("{CALIBRATE} --identifier foo"),
            ["'foo'", "--identifier", "levenberg-marquardt, least-squares, robust"],
        ),
        row(
            "absurd number of threads",
            [],
            format!("{CALIBRATE} --threads 100000"),
            ["'100000'", "--threads", "1..=256"],
        ),
        row(
            "held-out part in per cent",
            [],
            format!("{CALIBRATE} --holdout 20%"),
            ["--holdout: 20%: cannot be read", "check its name"],
        ),
    ];
    for part in ["1.5", "0", "1", "-0.2", "nan", "inf"] {
        let parts = ["--holdout", part, "between 0 and 1", "such as 0.2", "name a file"];
        rows.push(row("held-out part", [], format!("{CALIBRATE} --holdout={part}"), parts));
    }
    all_are_refused(&rows);
}

#[test]
fn simulations() {
    let simulate = "simulate m.toml --poses p.csv -o s.csv";
    let with = |name, option: &str, parts: &[&str]| {
        row(name, [poses()], format!("{simulate} {option}"), parts.iter().copied())
    };
    let errors = |name, text: &str, parts: &[&str]| {
        let call = format!("{simulate} --errors e.csv");
        row(name, [poses(), file("e.csv", text)], call, parts.iter().copied())
    };
    all_are_refused(&[
        with(
            "noise without unit",
            "--noise-position 1",
            &["--noise-position", "'1'", "write a number and a unit", "2um"],
        ),
        // A sign of more than one byte must not split in the middle.
        with("noise with another sign for micro", "--noise-position 1µm", &["'1µm'", "2um"]),
        with("error with an unknown unit", "--error-sd 1parsec", &["--error-sd", "'parsec'", "use m | mm | um | in"]),
        with("negative error", "--error-sd=-1mm", &["--error-sd -1mm", "must not be negative"]),
        with(
            "errors that no pose survives",
            "--error-sd 1000mm",
            &["p.csv: data row ", "out of reach", "smaller errors"],
        ),
        errors("errors without a row", "leg,xA_mm\n", &["e.csv: ", "no data row"]),
        errors("errors twice", "leg,xA_mm,xA_um\n1,2,3\n", &["e.csv: column 'xA_um'", "'xA_mm'", "keep one"]),
        errors(
            "errors of a leg twice",
            "leg,xA_mm\n1,2\n1,3\n",
            &["e.csv: data row 1 (line 3), column 'leg'", "'1' appears twice"],
        ),
        errors(
            "errors of a seventh leg",
            "leg,xA_mm\n7,2\n",
            &["e.csv: data row 0 (line 2), column 'leg'", "'7'", "from 1 to 6"],
        ),
        errors(
            "errors of an unknown parameter",
            "leg,xC_mm\n1,2\n",
            &["e.csv: column 'xC_mm'", "use xA yA zA h xB yB zB"],
        ),
        errors(
            "errors with an empty cell",
            "leg,xA_mm\n1,\n",
            &["e.csv: data row 0 (line 2), column 'xA_mm'", "write 0"],
        ),
    ]);
}

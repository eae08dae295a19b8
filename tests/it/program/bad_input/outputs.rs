//! Outputs that must not or cannot be written.

use super::{CALIBRATE, Content, Entry, all_are_refused, few, file, poses, row};

const OVER: [&str; 3] = ["is also an input", "never overwritten", "choose another name"];

fn with_over(output: &str) -> Vec<&str> {
    [&[output][..], &OVER].concat()
}

#[test]
fn outputs_over_an_input() {
    let mut rows = vec![
        row("held-out data", [poses()], "calibrate m.toml d.csv -o p.csv --holdout p.csv", OVER),
        row("list of poses", [poses()], "compensate m.toml p.csv -o p.csv", OVER),
        row("truth", [poses()], "simulate m.toml --poses p.csv -o o.csv --truth m.toml", OVER),
        row(
            "through a hard link",
            [Entry("link.csv", Content::HardLink("d.csv"))],
            "calibrate m.toml d.csv -o link.csv",
            with_over("link.csv"),
        ),
        #[cfg(unix)]
        row(
            "through a symbolic link",
            [Entry("link.toml", Content::SymbolicLink("m.toml"))],
            "calibrate m.toml d.csv -o link.toml",
            with_over("link.toml"),
        ),
    ];
    for output in ["m.toml", "./m.toml", "d.csv"] {
        let call = format!("calibrate m.toml d.csv -o {output}");
        rows.push(row("calibrated mechanism", [poses()], call, with_over(output)));
        let call = format!("{CALIBRATE} --covariance {output}");
        rows.push(row("covariance", [poses()], call, with_over(output)));
    }
    all_are_refused(&rows);
}

#[test]
fn outputs_that_cannot_be_written() {
    let folder = || [Entry("sub", Content::Folder)];
    let mut rows = vec![
        row("a folder", folder(), "calibrate m.toml d.csv -o sub", ["sub: is a folder; name a file"]),
        row("a folder with a slash", folder(), "calibrate m.toml d.csv -o sub/", ["sub/: is a folder; name a file"]),
        row(
            "in a file",
            [],
            "calibrate m.toml d.csv -o m.toml/o.toml",
            ["m.toml/o.toml: cannot be written", "'m.toml' is a file", "nothing was written"],
        ),
        row(
            "in a folder that does not exist",
            [],
            "calibrate m.toml d.csv -o no/o.toml",
            ["no/o.toml: cannot be written", "folder 'no'", "create it", "nothing was written"],
        ),
        row(
            "the second of two",
            [],
            "calibrate m.toml d.csv -o o.toml --covariance no/x.csv",
            ["no/x.csv: cannot be written", "create it", "nothing was written"],
        ),
        row(
            "the first of two",
            [poses()],
            "simulate m.toml --poses p.csv -o no/s.csv --truth t.toml",
            ["no/s.csv", "nothing was written"],
        ),
        row(
            "an old output survives",
            [file("d.csv", few(5)), file("o.toml", "kept")],
            "calibrate m.toml d.csv -o o.toml --prior none",
            ["30 equations"],
        ),
    ];
    for covariance in ["o.toml", "./o.toml", "sub/../o.toml"] {
        let call = format!("{CALIBRATE} --covariance {covariance}");
        rows.push(row(
            "one file for two outputs",
            folder(),
            call,
            [covariance, "named twice as an output", "a name of its own"],
        ));
    }
    if cfg!(target_os = "linux") {
        for call in ["calibrate m.toml d.csv -o /dev/full", "calibrate m.toml d.csv -o o.toml --covariance /dev/full"] {
            rows.push(row("disk full", [], call, ["/dev/full: cannot be written", "nothing was written"]));
        }
    }
    all_are_refused(&rows);
}

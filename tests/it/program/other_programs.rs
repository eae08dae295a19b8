//! Tables that the program writes, read with numpy and pandas as their users read them. `PARACAL_PYTHON` names the
//! interpreter; where it has not both packages, the test says so and is passed.

use std::process::Command;

use crate::common::bench::Bench;

const READ: &str = r##"
import csv, sys
import numpy, pandas
for path in sys.argv[1:]:
    with open(path, newline="") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    names, cells = rows[0], rows[1:]
    frame = pandas.read_csv(path, comment="#")
    assert list(frame.columns) == names, (path, list(frame.columns), names)
    array = numpy.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8")
    assert list(array.dtype.names) == names, (path, array.dtype.names, names)
    assert len(frame) == len(array) == len(cells), path
    for k, name in enumerate(names):
        for cell, a, b in zip((row[k] for row in cells), frame[name], array[name]):
            try:
                value = float(cell)
            except ValueError:
                assert cell == "" or cell == a == b, (path, name, cell, a, b)
                continue
            assert value == a == b, (path, name, cell, a, b)
print(len(sys.argv) - 1, "tables")
"##;

#[test]
fn numpy_and_pandas_read_what_is_written() {
    let python = std::env::var("PARACAL_PYTHON").unwrap_or_else(|_| "python3".into());
    if !Command::new(&python).args(["-c", "import numpy, pandas"]).output().is_ok_and(|out| out.status.success()) {
        println!("skipped: {python} has not numpy and pandas");
        return;
    }
    let bench = Bench::bundled();
    bench.write(
        "k.csv",
        "temp_legs_degC,elevation_deg,time_utc\n20,30,2026-03-01T12:30:00\n21,40,2026-03-01T12:31:00\n",
    );
    let quick = "--candidates 100 --no-polish";
    bench.done(&format!("select m.toml -n 8 {quick} --conditions k.csv --resolution 1um -o poses.csv"));
    bench.done(&format!("select m.toml -n 9 {quick} --given poses.csv -o more.csv"));
    bench.done("simulate m.toml --poses more.csv -o data.csv");
    bench.done("simulate m.toml --poses poses.csv --effect thermal.legs.uniform=12e-6 -o warm.csv");
    bench.done("calibrate m.toml d.csv -o c.toml --covariance covariance.csv");
    bench.done("compensate c.toml poses.csv -o lengths.csv");
    let tables = ["poses.csv", "more.csv", "data.csv", "warm.csv", "covariance.csv", "lengths.csv"];
    let output = Command::new(&python).current_dir(bench.path()).args(["-c", READ]).args(tables).output().unwrap();
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{printed}{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(printed.trim(), format!("{} tables", tables.len()));
}

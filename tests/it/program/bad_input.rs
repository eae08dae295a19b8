//! Wrong files and wrong calls: the program says what is wrong, where, and what to do, and writes nothing.

use std::collections::BTreeMap;
use std::fs;
use std::process::Output;

use bench::{Bench, DATA, LEG_1, LEG_2, MECHANISM, poses, replaced};

/// A folder with a mechanism file and a measurement file, and what a run leaves in it.
mod bench {
    use super::{BTreeMap, Output, fs};
    use std::path::Path;
    use tempfile::TempDir;

    pub(crate) const MECHANISM: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/table5.toml"));
    pub(crate) const DATA: &str =
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/data/hardpoint-noisy.csv"));
    pub(crate) const LEG_1: &str = "platform = [1299.170, -348.112, 0.0]\nbase = [1164.388, -977.037, 0.0]";
    pub(crate) const LEG_2: &str = "platform = [1299.170, 348.112, 0.0]\nbase = [1164.388, 977.037, 0.0]";

    /// A temporary folder with `m.toml` and `d.csv`; the program runs in it.
    pub(crate) struct Bench {
        pub(crate) folder: TempDir,
    }

    impl Bench {
        pub(crate) fn new() -> Self {
            let bench = Self { folder: tempfile::tempdir().unwrap() };
            bench.file("m.toml", MECHANISM).file("d.csv", DATA)
        }

        /// The same with another mechanism file.
        pub(crate) fn with_mechanism(text: impl AsRef<[u8]>) -> Self {
            Self::new().file("m.toml", text)
        }

        /// The same with another measurement file.
        pub(crate) fn with_data(text: impl AsRef<[u8]>) -> Self {
            Self::new().file("d.csv", text)
        }

        pub(crate) fn file(self, name: &str, text: impl AsRef<[u8]>) -> Self {
            fs::write(self.folder.path().join(name), text).unwrap();
            self
        }

        pub(crate) fn path(&self) -> &Path {
            self.folder.path()
        }

        pub(crate) fn run(&self, call: &str) -> Output {
            let words: Vec<&str> = call.split_whitespace().collect();
            assert_cmd::cargo::cargo_bin_cmd!("paracal").current_dir(self.path()).args(words).output().unwrap()
        }

        /// Names and contents of everything in the folder.
        pub(crate) fn listing(&self) -> BTreeMap<String, Vec<u8>> {
            let entries = fs::read_dir(self.path()).unwrap().map(Result::unwrap);
            let content = |p: &Path| if p.is_dir() { b"folder".to_vec() } else { fs::read(p).unwrap() };
            entries.map(|e| (e.file_name().into_string().unwrap(), content(&e.path()))).collect()
        }

        /// Requires that a call is refused with exit code 2 and a message with all these parts, and that nothing
        /// reaches standard output or the disk.
        pub(crate) fn refuses(&self, call: &str, parts: &[&str]) {
            let before = self.listing();
            let output = self.run(call);
            let message = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(2), "{call}: {message}");
            assert!(message.starts_with("error: "), "{call}: {message}");
            for part in parts {
                assert!(message.contains(part), "{call}: '{part}' is not in\n{message}");
            }
            assert!(output.stdout.is_empty(), "{call}: {}", String::from_utf8_lossy(&output.stdout));
            assert!(self.listing() == before, "{call}: the folder has changed: {:?}", self.listing().keys());
        }

        /// Requires that the usual calibration is refused in that way.
        pub(crate) fn refuses_calibration(&self, parts: &[&str]) {
            self.refuses(CALIBRATE, parts);
        }

        /// Requires that a call succeeds and adds only these files.
        pub(crate) fn writes(&self, call: &str, files: &[&str]) -> Output {
            let mut expected: Vec<String> =
                self.listing().into_keys().chain(files.iter().map(|f| (*f).into())).collect();
            expected.sort();
            expected.dedup();
            let output = self.run(call);
            assert_eq!(output.status.code(), Some(0), "{call}: {}", String::from_utf8_lossy(&output.stderr));
            assert_eq!(self.listing().into_keys().collect::<Vec<_>>(), expected, "{call}");
            output
        }
    }

    pub(crate) const CALIBRATE: &str = "calibrate m.toml d.csv -o o.toml";

    /// The text with its first `from` replaced, which must be there.
    pub(crate) fn replaced(text: &str, from: &str, to: &str) -> String {
        assert!(text.contains(from), "'{from}' is not in the text");
        text.replacen(from, to, 1)
    }

    /// The measured poses of the data as a list of poses.
    pub(crate) fn poses() -> String {
        let pose = |line: &str| line.splitn(7, ',').last().unwrap().to_owned() + "\n";
        DATA.lines().map(pose).collect()
    }
}

/// The data with the cell of a line (0 is the header) replaced.
fn cell(line: usize, column: usize, value: &str) -> String {
    let mut lines: Vec<Vec<&str>> = DATA.lines().map(|l| l.split(',').collect()).collect();
    lines[line][column] = value;
    lines.iter().map(|l| l.join(",") + "\n").collect()
}

/// The first `rows` data rows.
fn few(rows: usize) -> String {
    DATA.lines().take(1 + rows).map(|l| l.to_owned() + "\n").collect()
}

fn without_tolerance() -> String {
    replaced(MECHANISM, "[tolerance]\nanchor = 0.5\nlength = 0.5\n", "")
}

/// Every leg with this stroke.
fn with_stroke(stroke: &str) -> String {
    MECHANISM.replace("length = 800.0", &format!("length = 800.0\nstroke = {stroke}"))
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

// Files that cannot be read.

#[test]
fn missing_mechanism_file() {
    Bench::new().refuses("calibrate no.toml d.csv -o o.toml", &["no.toml: cannot be read", "check its name"]);
}

#[test]
fn missing_data_file() {
    Bench::new().refuses("calibrate m.toml no.csv -o o.toml", &["no.csv: cannot be read", "check its name"]);
    Bench::new().refuses("evaluate m.toml no.csv", &["no.csv: cannot be read"]);
    Bench::new().refuses("compensate m.toml no.csv -o o.csv", &["no.csv: cannot be read"]);
    Bench::new().refuses("simulate m.toml --poses no.csv -o o.csv", &["no.csv: cannot be read"]);
}

#[test]
fn folder_instead_of_a_file() {
    let bench = Bench::new();
    fs::create_dir(bench.path().join("sub")).unwrap();
    bench.refuses("calibrate sub d.csv -o o.toml", &["sub: is a folder; name a file"]);
    bench.refuses("calibrate m.toml sub -o o.toml", &["sub: is a folder; name a file"]);
}

#[test]
fn empty_file() {
    Bench::with_mechanism("").refuses_calibration(&["m.toml: the file is empty; check"]);
    Bench::with_data(" \n\n").refuses_calibration(&["d.csv: the file is empty; check"]);
}

#[test]
fn text_that_is_not_utf_8() {
    let mut data = DATA.as_bytes().to_vec();
    let at = DATA.find('\n').unwrap() + 5;
    data[at] = 0xff;
    let place = format!("d.csv: line 2: is not UTF-8 text (first bad byte at {at})");
    Bench::with_data(data).refuses_calibration(&[&place, "save it as UTF-8"]);
    Bench::with_mechanism(b"name = \"\xb5m\"\n").refuses_calibration(&["m.toml: line 1: is not UTF-8"]);
}

// Mechanism files.

#[test]
fn text_that_is_not_toml() {
    Bench::with_mechanism(DATA).refuses_calibration(&["m.toml: ", "line 1, column 8", "expected `=`"]);
}

#[test]
fn unknown_length_unit() {
    let text = replaced(MECHANISM, "length_unit = \"mm\"", "length_unit = \"furlong\"");
    Bench::with_mechanism(text).refuses_calibration(&["m.toml: length_unit", "'furlong'", "use m | mm | um | in"]);
}

#[test]
fn unit_of_another_dimension() {
    let text = replaced(MECHANISM, "angle_unit = \"deg\"", "angle_unit = \"mm\"");
    Bench::with_mechanism(text).refuses_calibration(&["m.toml: angle_unit", "'mm'", "use rad | mrad | deg | arcsec"]);
}

#[test]
fn unknown_key() {
    let text = replaced(MECHANISM, "length_unit", "lenght_unit");
    Bench::with_mechanism(text).refuses_calibration(&["m.toml: ", "line 6", "`lenght_unit`", "`length_unit`"]);
}

#[test]
fn unknown_key_of_a_leg() {
    let text = replaced(MECHANISM, "length = 800.0", "length = 800.0\nofset = 1.0");
    Bench::with_mechanism(text).refuses_calibration(&["m.toml: ", "line 13", "`ofset`", "`length_offset`"]);
}

#[test]
fn misspelt_section() {
    let text = replaced(MECHANISM, "[tolerance]", "[tolerence]");
    Bench::with_mechanism(text).refuses_calibration(&["m.toml: ", "line 43", "`tolerence`", "`tolerance`"]);
}

#[test]
fn five_legs() {
    let (last, rest) = (MECHANISM.rfind("[[leg]]").unwrap(), MECHANISM.find("[workspace]").unwrap());
    let text = format!("{}{}", &MECHANISM[..last], &MECHANISM[rest..]);
    Bench::with_mechanism(text).refuses_calibration(&["m.toml: ", "six legs", "found 5"]);
}

#[test]
fn two_equal_platform_anchors() {
    let text = replaced(MECHANISM, "[1299.170, 348.112, 0.0]", "[1299.170, -348.112, 0.0]");
    let parts =
        ["m.toml: legs 1 and 2, `platform`", "[1299.17, -348.112, 0.0]", "correct one", "shared_anchors = true"];
    Bench::with_mechanism(text).refuses_calibration(&parts);
}

#[test]
fn two_equal_base_anchors() {
    let text = replaced(MECHANISM, "[1164.388, 977.037, 0.0]", "[1164.388, -977.037, 0.0]");
    let parts = ["m.toml: legs 1 and 2, `base`", "[1164.388, -977.037, 0.0]", "correct one", "shared_anchors = true"];
    Bench::with_mechanism(text).refuses_calibration(&parts);
}

#[test]
fn shared_anchors_are_accepted_when_stated() {
    // Both legs lean as before, but meet in the middle of the platform's edge.
    let met = |side: f64| format!("platform = [1299.170, 0.0, 0.0]\nbase = [1164.388, {}, 0.0]", side * 628.925);
    let text = replaced(&replaced(MECHANISM, LEG_1, &met(-1.0)), LEG_2, &met(1.0));
    let call = "compensate m.toml p.csv -o lengths.csv";
    let refused = Bench::with_mechanism(&text).file("p.csv", poses());
    refused.refuses(call, &["m.toml: legs 1 and 2, `platform`"]);
    let stated = replaced(&text, "angle_unit", "shared_anchors = true\nangle_unit");
    Bench::with_mechanism(stated).file("p.csv", poses()).writes(call, &["lengths.csv"]);
}

#[test]
fn negative_length() {
    let text = replaced(MECHANISM, "length = 800.0", "length = -800.0");
    Bench::with_mechanism(text).refuses_calibration(&["m.toml: leg 1, `length`", "-800", "must be positive"]);
}

#[test]
fn stroke_that_is_no_interval() {
    let text = replaced(MECHANISM, "length = 800.0", "length = 800.0\nstroke = [900.0, 700.0]");
    Bench::with_mechanism(text).refuses_calibration(&["m.toml: leg 1, `stroke`", "[900, 700]", "[shortest, longest]"]);
}

#[test]
fn zero_tolerance() {
    let text = replaced(MECHANISM, "anchor = 0.5", "anchor = 0.0");
    let parts = ["m.toml: [tolerance] anchor", "must be positive, found 0", "leave the section out"];
    Bench::with_mechanism(text).refuses_calibration(&parts);
}

#[test]
fn zero_noise() {
    let text = replaced(MECHANISM, "rotation = 0.0001", "rotation = 0.0");
    let parts = ["m.toml: [noise] rotation", "must be positive, found 0", "leave the section out"];
    Bench::with_mechanism(text).refuses_calibration(&parts);
}

#[test]
fn nan_in_a_leg() {
    let text = replaced(MECHANISM, "length = 800.0", "length = nan");
    Bench::with_mechanism(text).refuses_calibration(&["m.toml: leg 1, `length`", "NaN", "finite", "write a number"]);
    let text = replaced(MECHANISM, "[1299.170, 348.112", "[1299.170, inf");
    Bench::with_mechanism(text).refuses_calibration(&["m.toml: leg 2, `platform`", "inf", "finite"]);
}

#[test]
fn nan_in_a_section_that_is_only_handed_on() {
    // It would be written to the calibrated file, which nothing could read again.
    let text = format!("{MECHANISM}\n[platform]\nmass_kg = nan\n");
    Bench::with_mechanism(text).refuses_calibration(&["m.toml: [platform] mass_kg", "NaN", "finite"]);
    let text = format!("reference_temperature_degC = nan\n{MECHANISM}");
    Bench::with_mechanism(text).refuses_calibration(&["m.toml: reference_temperature_degC", "NaN", "finite"]);
}

#[test]
fn point_with_two_coordinates() {
    let text = replaced(MECHANISM, "[1299.170, -348.112, 0.0]", "[1299.170, -348.112]");
    Bench::with_mechanism(text).refuses_calibration(&["m.toml: ", "line 10", "length 2", "length 3"]);
}

#[test]
fn unknown_type_of_mechanism() {
    let text = replaced(MECHANISM, "six-hardpoint\"", "delta\"");
    Bench::with_mechanism(text).refuses_calibration(&[
        "m.toml: type",
        "'delta'",
        "use one of \"six-hardpoint\"",
        "\"linear-delta\"",
    ]);
}

#[test]
fn effects_without_their_parameters() {
    let text = format!("{MECHANISM}\n[[effect]]\nname = \"thermal.legs.uniform\"\n");
    Bench::with_mechanism(text)
        .refuses_calibration(&["m.toml: effect 1 'thermal.legs.uniform', `parameters`", "'expansion' is missing"]);
}

#[test]
fn singular_home() {
    let mut text = format!("{MECHANISM}\n[home]\nposition = [0.0, 0.0, 475.7]\n");
    for (leg, points) in LINES.iter().enumerate() {
        let on_line = [100.0, 200.0].map(|step| format!("[{}, 0.0, 0.0]", step * (leg as f64 + 1.0)));
        for (point, on_line) in points.iter().zip(&on_line) {
            text = replaced(&text, point, on_line);
        }
    }
    Bench::with_mechanism(text).refuses_calibration(&[
        "m.toml: ",
        "singular at home",
        "check the anchors and the home",
    ]);
}

/// Platform and base point of each leg.
const LINES: [[&str; 2]; 6] = [
    ["[1299.170, -348.112, 0.0]", "[1164.388, -977.037, 0.0]"],
    ["[1299.170, 348.112, 0.0]", "[1164.388, 977.037, 0.0]"],
    ["[-348.112, 1299.170, 0.0]", "[263.945, 1496.908, 0.0]"],
    ["[-951.059, 951.059, 0.0]", "[-1428.333, 519.871, 0.0]"],
    ["[-951.059, -951.059, 0.0]", "[-1428.333, -519.871, 0.0]"],
    ["[-348.112, -1299.170, 0.0]", "[263.945, -1496.908, 0.0]"],
];

#[test]
fn lengths_without_a_home() {
    let text = replaced(MECHANISM, "length = 800.0", "length = 9000.0");
    Bench::with_mechanism(text).refuses_calibration(&["m.toml: no home pose", "state [home] or correct the lengths"]);
}

// Columns of measurement files.

#[test]
fn unknown_unit_of_a_column() {
    Bench::with_data(cell(0, 6, "x_furlong")).refuses_calibration(&[
        "d.csv: column 'x_furlong'",
        "m | mm | um | in",
        "'x_mm'",
    ]);
}

#[test]
fn unit_of_a_column_of_another_dimension() {
    Bench::with_data(cell(0, 0, "leg1_deg")).refuses_calibration(&["d.csv: column 'leg1_deg'", "m | mm | um | in"]);
}

#[test]
fn header_without_unit() {
    Bench::with_data(cell(0, 2, "leg3")).refuses_calibration(&[
        "d.csv: column 'leg3'",
        "must end in a unit",
        "'leg3_mm'",
    ]);
}

#[test]
fn column_twice() {
    let parts = ["d.csv: column 'x_mm'", "twice", "delete or rename"];
    Bench::with_data(cell(0, 7, "x_mm")).refuses_calibration(&parts);
}

#[test]
fn two_columns_of_one_meaning() {
    let parts = ["d.csv: column 'x_um'", "the same as column 'x_mm'", "keep one"];
    Bench::with_data(cell(0, 7, "x_um")).refuses_calibration(&parts);
}

#[test]
fn seventh_leg() {
    let parts = ["d.csv: column 'leg7_mm'", "legs 1 to 6", "delete the column"];
    Bench::with_data(cell(0, 5, "leg7_mm")).refuses_calibration(&parts);
}

#[test]
fn missing_leg() {
    Bench::with_data(cell(0, 5, "other_mm")).refuses_calibration(&["d.csv: no column for leg6", "'leg6_mm'"]);
}

#[test]
fn pose_and_targets_together() {
    let row = |(k, line): (usize, &str)| format!("{line},{}\n", if k == 0 { "p1x_mm" } else { "1.0" });
    let text: String = DATA.lines().enumerate().map(row).collect();
    Bench::with_data(text).refuses_calibration(&["d.csv: ", "both a measured pose and measured targets", "keep one"]);
}

/// The joints of the data with further columns: their header and the same cells in every row.
fn joints_with(header: &str, cells: &str) -> String {
    let joints = |line: &str| line.split(',').take(6).collect::<Vec<_>>().join(",");
    let row = |(k, line): (usize, &str)| format!("{},{}\n", joints(line), if k == 0 { header } else { cells });
    DATA.lines().enumerate().map(row).collect()
}

#[test]
fn contacts_together_with_something_else() {
    let row = |(k, line): (usize, &str)| format!("{line},{}\n", if k == 0 { "contact_mm" } else { "1.0" });
    let text: String = DATA.lines().enumerate().map(row).collect();
    Bench::with_data(text).refuses_calibration(&["d.csv: ", "both a measured pose and measured contacts", "keep one"]);
    let text = joints_with("p1x_mm,p1y_mm,p1z_mm,contact_mm", "1,2,3,4");
    Bench::with_data(text).refuses_calibration(&["d.csv: ", "both measured targets and measured contacts", "keep one"]);
}

#[test]
fn contacts_stated_wrongly() {
    let refuses = |header: &str, cells: &str, parts: &[&str]| {
        Bench::with_data(joints_with(header, cells)).refuses_calibration(parts);
    };
    refuses("contact_mm", "", &["d.csv: ", "no cell of the measured contacts is filled"]);
    refuses("contact", "1", &["d.csv: column 'contact'", "must end in a unit (m | mm | um | in)", "'contact_mm'"]);
    refuses("contact_deg", "1", &["d.csv: column 'contact_deg'", "'deg' is not a unit for it", "m | mm | um | in"]);
    refuses("contact_mm", "high", &["d.csv: data row 0 (line 2), column 'contact_mm'", "'high' is not a number"]);
    refuses("contact_mm,sigma_contact_mm", "1,0", &["column 'sigma_contact_mm'", "'0' must be positive"]);
    refuses("contact_mm,sigma_x_mm", "1,1", &["column 'sigma_x_mm'", "sigma of a pose", "sigma_contact_"]);
    refuses("sigma_contact_mm", "1", &["d.csv: ", "sigma_contact_… without a column contact_…"]);
}

#[test]
fn plane_stated_wrongly() {
    let refuses = |section: &str, parts: &[&str]| {
        Bench::with_mechanism(format!("{MECHANISM}\n[plane]\n{section}\n")).refuses_calibration(parts);
    };
    refuses(
        "normal = [0, 0, 0.0]",
        &["m.toml: [plane] normal", "[0.0, 0.0, 0.0] has no direction", "such as [0, 0, 1]"],
    );
    refuses("normal = [0, 0, inf]", &["m.toml: [plane] normal", "inf is not a finite number"]);
    refuses("normal = [0, 1]", &["m.toml: ", "normal = [0, 1]", "array of length 3"]);
    refuses("distance = nan", &["m.toml: [plane] distance", "NaN is not a finite number"]);
    refuses("tip = [0, inf, 0]", &["m.toml: [plane] tip", "inf is not a finite number"]);
    refuses("identify = 1", &["m.toml: ", "identify = 1", "boolean"]);
    refuses("offset = 1", &["m.toml: ", "unknown field `offset`", "`normal`, `distance`, `tip`, `identify`"]);
}

#[test]
fn nothing_measured() {
    let joints = |line: &str| line.split(',').take(6).collect::<Vec<_>>().join(",") + "\n";
    let text: String = DATA.lines().map(joints).collect();
    Bench::with_data(text).refuses_calibration(&["d.csv: ", "no measured column", "expected x_mm"]);
    let targets = |(k, line): (usize, &str)| {
        let cells: Vec<&str> = line.split(',').take(6).collect();
        cells.join(",") + if k == 0 { ",p1x_mm,p1y_mm,p1z_mm\n" } else { ",,,\n" }
    };
    let text: String = DATA.lines().enumerate().map(targets).collect();
    Bench::with_data(text).refuses_calibration(&["d.csv: ", "no cell of the measured targets is filled"]);
}

// Rows and cells of measurement files.

#[test]
fn tables_of_spreadsheets_elsewhere() {
    for (separator, name) in [(";", "semicolons"), ("\t", "tabs")] {
        let bench = Bench::with_data(DATA.replace(',', separator));
        bench.refuses_calibration(&["d.csv", name, "save the table with commas"]);
    }
    let bench = Bench::with_data(DATA.replacen("x_mm", "X [mm]", 1));
    bench.refuses_calibration(&["d.csv", "'X [mm]'", "write it as 'x_mm'"]);
    let bench = Bench::with_data(DATA.replacen("leg1_mm", "leg1 (mm)", 1));
    bench.refuses_calibration(&["d.csv", "'leg1 (mm)'", "write it as 'leg1_mm'"]);
}

#[test]
fn header_only() {
    Bench::with_data(few(0)).refuses_calibration(&["d.csv: ", "no data row", "add rows"]);
}

#[test]
fn row_too_short() {
    let text = DATA.replace(",-4.697230491850", "");
    Bench::with_data(text).refuses_calibration(&[
        "d.csv: data row 0 (line 2)",
        "11 cells",
        "12",
        "one cell for each column",
    ]);
}

#[test]
fn row_too_long() {
    let text = DATA.replace(",5.207265650406", ",5.207265650406,1.0");
    Bench::with_data(text).refuses_calibration(&[
        "d.csv: data row 1 (line 3)",
        "13 cells",
        "12",
        "one cell for each column",
    ]);
}

#[test]
fn text_in_a_number_cell() {
    let parts = ["d.csv: data row 1 (line 3), column 'leg1_mm'", "'abc'", "not a number", "delete the row"];
    Bench::with_data(cell(2, 0, "abc")).refuses_calibration(&parts);
}

#[test]
fn nan_in_a_cell() {
    let parts = ["d.csv: data row 1 (line 3), column 'rz_deg'", "'NaN'", "finite", "leave the cell empty"];
    Bench::with_data(cell(2, 11, "NaN")).refuses_calibration(&parts);
    let parts = ["d.csv: data row 2 (line 4), column 'leg2_mm'", "'1e999'", "finite", "delete the row"];
    Bench::with_data(cell(3, 1, "1e999")).refuses_calibration(&parts);
}

#[test]
fn empty_leg_cell() {
    let parts = ["d.csv: data row 1 (line 3), column 'leg4_mm'", "must not be empty", "fill it in or delete the row"];
    Bench::with_data(cell(2, 3, "")).refuses_calibration(&parts);
}

#[test]
fn quaternion_of_wrong_length() {
    let line = |(k, line): (usize, &str)| {
        let cells: Vec<&str> = line.split(',').take(9).collect();
        cells.join(",") + if k == 0 { ",qw,qx,qy,qz\n" } else { ",0.9,0.1,0.0,0.0\n" }
    };
    let text: String = DATA.lines().enumerate().map(line).collect();
    let parts = ["d.csv: data row 0 (line 2), column 'qw'", "'0.9'", "length 0.905539", "must be 1"];
    Bench::with_data(text).refuses_calibration(&parts);
    let list = "x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,475,1,0,0,0\n0,0,475,0,0,0,0\n";
    let parts = ["p.csv: data row 1 (line 3), column 'qw'", "'0'", "length 0.000000", "must be 1"];
    Bench::new().file("p.csv", list).refuses("compensate m.toml p.csv -o o.csv", &parts);
}

#[test]
fn part_of_a_quaternion() {
    let list = "x_mm,y_mm,z_mm,qw,qx,qy\n0,0,475,1,0,0\n";
    let bench = Bench::new().file("p.csv", list);
    bench.refuses("compensate m.toml p.csv -o o.csv", &["p.csv: ", "all of qw, qx, qy and qz"]);
}

#[test]
fn times_that_are_none() {
    for time in ["noon", "9223372036854775807-01-01T00:00:00", "2026-01-01T00:00:00+4294967295:00"] {
        let line = |(k, line): (usize, &str)| format!("{},{line}\n", if k == 0 { "time_utc" } else { time });
        let text: String = DATA.lines().enumerate().map(line).collect();
        let parts = ["d.csv: data row 0 (line 2), column 'time_utc'", time, "write 2026-03-01T12:30:00"];
        Bench::with_data(text).refuses_calibration(&parts);
    }
}

#[test]
fn lengths_out_of_reach() {
    let parts = [
        "d.csv: data row 1: ",
        "out of reach",
        "leg1",
        "3000.000 mm",
        "(home 800.000 mm)",
        "correct or delete the row",
    ];
    let bench = Bench::with_data(cell(2, 0, "3000.0"));
    bench.refuses_calibration(&parts);
    bench.refuses("evaluate m.toml d.csv", &parts);
}

#[test]
fn held_out_lengths_out_of_reach() {
    let bench = Bench::new().file("held.csv", cell(3, 4, "3000.0"));
    let parts = ["held.csv: data row 2: ", "out of reach", "leg5", "3000.000 mm", "correct or delete the row"];
    bench.refuses("calibrate m.toml d.csv -o o.toml --holdout held.csv", &parts);
}

#[test]
fn pose_too_far_for_a_length() {
    let list = "x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n0,0,475,0,0,0\n1e300,0,475,0,0,0\n";
    let bench = Bench::new().file("p.csv", list);
    bench.refuses("compensate m.toml p.csv -o o.csv", &["p.csv: data row 1", "too far", "correct it"]);
}

// Data that are too few.

#[test]
fn fewer_equations_than_parameters_without_prior() {
    let parts = ["d.csv: 30 equations (5 samples)", "42 parameters", "at least 7 samples", "[tolerance]"];
    Bench::with_data(few(5)).refuses("calibrate m.toml d.csv -o o.toml --prior none", &parts);
    Bench::with_data(few(5)).file("m.toml", without_tolerance()).refuses_calibration(&parts);
}

#[test]
fn prior_without_tolerance() {
    let bench = Bench::with_mechanism(without_tolerance());
    let parts = ["m.toml: ", "no [tolerance]", "state one, or calibrate without a prior"];
    bench.refuses("calibrate m.toml d.csv -o o.toml --prior tolerance", &parts);
}

#[test]
fn prior_with_unweighted_rows() {
    let call = "calibrate m.toml d.csv -o o.toml --prior tolerance --weights none";
    Bench::new().refuses(call, &["drop `--weights none` or `--prior tolerance`"]);
}

#[test]
fn robust_with_unweighted_rows() {
    let call = "calibrate m.toml d.csv -o o.toml --identifier robust --weights none";
    Bench::new().refuses(call, &["--weights none", "robust", "use least-squares"]);
}

#[test]
fn rows_without_a_reading_cannot_be_held_out() {
    // Four of the five folds leave the only measured row; the fifth leaves nothing to fit.
    let line = |(k, line): (usize, &str)| match k {
        0 | 1 => format!("{line}\n"),
        _ => line.split(',').take(6).collect::<Vec<_>>().join(",") + ",,,,,,\n",
    };
    let text: String = DATA.lines().enumerate().map(line).collect();
    let output = Bench::with_data(text).writes("calibrate m.toml d.csv -o o.toml", &["o.toml"]);
    assert!(String::from_utf8_lossy(&output.stdout).contains("not held out"));
}

// Strokes are no hindrance.

#[test]
fn lengths_outside_the_strokes_are_warned_of() {
    let bench = Bench::with_mechanism(with_stroke("[700.0, 900.0]")).file("p.csv", poses());
    let output = bench.writes("calibrate m.toml d.csv -o o.toml", &["o.toml"]);
    assert!(stderr(&output).contains("warning: joints outside their stroke in data row 0"), "{}", stderr(&output));
    let output = bench.writes("compensate m.toml p.csv -o o.csv", &["o.csv"]);
    assert!(
        stderr(&output).contains("warning: data row 0: leg1 would be 513.616 mm, outside its stroke 700.000 to 900")
    );
    let output = bench.writes("simulate m.toml --poses p.csv -o s.csv", &["s.csv"]);
    assert!(stderr(&output).contains("warning: joints outside their stroke in data row 0, 1"));
}

// Outputs.

const OVER: [&str; 3] = ["is also an input", "never overwritten", "choose another name"];

#[test]
fn output_over_an_input() {
    let bench = Bench::new().file("p.csv", poses());
    for output in ["m.toml", "./m.toml", "d.csv"] {
        let parts = [&[output][..], &OVER].concat();
        bench.refuses(&format!("calibrate m.toml d.csv -o {output}"), &parts);
        bench.refuses(&format!("calibrate m.toml d.csv -o o.toml --covariance {output}"), &parts);
    }
    bench.refuses("calibrate m.toml d.csv -o p.csv --holdout p.csv", &OVER);
    bench.refuses("compensate m.toml p.csv -o p.csv", &OVER);
    bench.refuses("simulate m.toml --poses p.csv -o o.csv --truth m.toml", &OVER);
}

#[cfg(unix)]
#[test]
fn output_over_an_input_through_a_symbolic_link() {
    let bench = Bench::new();
    std::os::unix::fs::symlink("m.toml", bench.path().join("link.toml")).unwrap();
    bench.refuses("calibrate m.toml d.csv -o link.toml", &[&["link.toml"][..], &OVER].concat());
}

#[test]
fn output_over_an_input_through_a_hard_link() {
    let bench = Bench::new();
    fs::hard_link(bench.path().join("d.csv"), bench.path().join("link.csv")).unwrap();
    bench.refuses("calibrate m.toml d.csv -o link.csv", &[&["link.csv"][..], &OVER].concat());
}

#[test]
fn output_is_a_folder() {
    let bench = Bench::new();
    fs::create_dir(bench.path().join("sub")).unwrap();
    bench.refuses("calibrate m.toml d.csv -o sub", &["sub: is a folder; name a file"]);
    bench.refuses("calibrate m.toml d.csv -o sub/", &["sub/: is a folder; name a file"]);
}

#[test]
fn folder_of_the_output_is_a_file() {
    let parts = ["m.toml/o.toml: cannot be written", "'m.toml' is a file", "nothing was written"];
    Bench::new().refuses("calibrate m.toml d.csv -o m.toml/o.toml", &parts);
}

#[test]
fn folder_of_the_output_does_not_exist() {
    let parts = ["no/o.toml: cannot be written", "folder 'no'", "create it", "nothing was written"];
    Bench::new().refuses("calibrate m.toml d.csv -o no/o.toml", &parts);
}

#[test]
fn one_of_two_outputs_cannot_be_written() {
    let parts = ["no/x.csv: cannot be written", "create it", "nothing was written"];
    Bench::new().refuses("calibrate m.toml d.csv -o o.toml --covariance no/x.csv", &parts);
    let bench = Bench::new().file("p.csv", poses());
    bench.refuses("simulate m.toml --poses p.csv -o no/s.csv --truth t.toml", &["no/s.csv", "nothing was written"]);
}

#[test]
fn one_file_for_two_outputs() {
    let bench = Bench::new();
    fs::create_dir(bench.path().join("sub")).unwrap();
    for covariance in ["o.toml", "./o.toml", "sub/../o.toml"] {
        let call = format!("calibrate m.toml d.csv -o o.toml --covariance {covariance}");
        bench.refuses(&call, &[covariance, "named twice as an output", "a name of its own"]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn disk_full() {
    let parts = ["/dev/full: cannot be written", "nothing was written"];
    Bench::new().refuses("calibrate m.toml d.csv -o /dev/full", &parts);
    Bench::new().refuses("calibrate m.toml d.csv -o o.toml --covariance /dev/full", &parts);
}

#[test]
fn an_old_output_survives_a_failure() {
    let bench = Bench::with_data(few(5)).file("o.toml", "kept");
    bench.refuses("calibrate m.toml d.csv -o o.toml --prior none", &["30 equations"]);
}

// Options.

#[test]
fn held_out_part_above_one() {
    for part in ["1.5", "0", "1", "-0.2", "nan", "inf"] {
        let call = format!("calibrate m.toml d.csv -o o.toml --holdout={part}");
        Bench::new().refuses(&call, &["--holdout", part, "between 0 and 1", "such as 0.2", "name a file"]);
    }
    let parts = ["--holdout: 20%: cannot be read", "check its name"];
    Bench::new().refuses("calibrate m.toml d.csv -o o.toml --holdout 20%", &parts);
}

#[test]
fn noise_without_unit() {
    let bench = Bench::new().file("p.csv", poses());
    let parts = ["--noise-position", "'1'", "write a number and a unit", "2um"];
    bench.refuses("simulate m.toml --poses p.csv -o s.csv --noise-position 1", &parts);
    // A sign of more than one byte must not split in the middle.
    bench.refuses("simulate m.toml --poses p.csv -o s.csv --noise-position 1µm", &["'1µm'", "2um"]);
}

#[test]
fn error_with_an_unknown_unit() {
    let bench = Bench::new().file("p.csv", poses());
    let parts = ["--error-sd", "'parsec'", "use m | mm | um | in"];
    bench.refuses("simulate m.toml --poses p.csv -o s.csv --error-sd 1parsec", &parts);
    bench.refuses(
        "simulate m.toml --poses p.csv -o s.csv --error-sd=-1mm",
        &["--error-sd -1mm", "must not be negative"],
    );
}

#[test]
fn errors_that_no_pose_survives() {
    let bench = Bench::new().file("p.csv", poses());
    let parts = ["p.csv: data row ", "out of reach", "smaller errors"];
    bench.refuses("simulate m.toml --poses p.csv -o s.csv --error-sd 1000mm", &parts);
}

#[test]
fn parameter_errors_stated_wrongly() {
    let call = "simulate m.toml --poses p.csv -o s.csv --errors e.csv";
    let refuses =
        |text: &str, parts: &[&str]| Bench::new().file("p.csv", poses()).file("e.csv", text).refuses(call, parts);
    refuses("leg,xA_mm\n", &["e.csv: ", "no data row"]);
    refuses("leg,xA_mm,xA_um\n1,2,3\n", &["e.csv: column 'xA_um'", "'xA_mm'", "keep one"]);
    refuses("leg,xA_mm\n1,2\n1,3\n", &["e.csv: data row 1 (line 3), column 'leg'", "'1' appears twice"]);
    refuses("leg,xA_mm\n7,2\n", &["e.csv: data row 0 (line 2), column 'leg'", "'7'", "from 1 to 6"]);
    refuses("leg,xC_mm\n1,2\n", &["e.csv: column 'xC_mm'", "use xA yA zA h xB yB zB"]);
    refuses("leg,xA_mm\n1,\n", &["e.csv: data row 0 (line 2), column 'xA_mm'", "write 0"]);
}

#[test]
fn unknown_identifier() {
    let parts = ["'foo'", "--identifier", "levenberg-marquardt, least-squares, robust"];
    Bench::new().refuses("calibrate m.toml d.csv -o o.toml --identifier foo", &parts);
}

#[test]
fn absurd_number_of_threads() {
    let parts = ["'100000'", "--threads", "1..=256"];
    Bench::new().refuses("calibrate m.toml d.csv -o o.toml --threads 100000", &parts);
}

// What is printed where.

/// Calls that succeed with warnings.
fn warned() -> (Bench, [&'static str; 3]) {
    let bench = Bench::with_mechanism(with_stroke("[700.0, 900.0]")).file("p.csv", poses());
    let calls = [
        "calibrate m.toml d.csv -o o.toml",
        "compensate m.toml p.csv -o o.csv",
        "simulate m.toml --poses p.csv -o s.csv",
    ];
    (bench, calls)
}

#[test]
fn json_is_one_object_also_with_warnings() {
    let (bench, calls) = warned();
    for call in calls.into_iter().chain(["evaluate m.toml d.csv"]) {
        let output = bench.run(&format!("{call} --json"));
        assert_eq!(output.status.code(), Some(0), "{call}: {}", stderr(&output));
        assert_eq!(stderr(&output).contains("warning: "), !call.starts_with("evaluate"), "{call}");
        let parsed: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(parsed.is_object(), "{call}");
    }
}

#[test]
fn json_says_nothing_when_the_call_is_refused() {
    Bench::with_data(few(0)).refuses("calibrate m.toml d.csv -o o.toml --json", &["no data row"]);
}

#[test]
fn quiet_silences_warnings() {
    let (bench, calls) = warned();
    for call in calls {
        let output = bench.run(&format!("{call} --quiet"));
        assert_eq!(output.status.code(), Some(0), "{call}");
        assert!(output.stderr.is_empty(), "{call}: {}", stderr(&output));
        assert!(!output.stdout.is_empty(), "{call}");
    }
}

#[test]
fn readers_that_went_away_do_no_harm() {
    let (bench, calls) = warned();
    for call in calls {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let status = std::process::Command::new(assert_cmd::cargo::cargo_bin!("paracal"))
            .current_dir(bench.path())
            .args(call.split_whitespace())
            .stdout(writer.try_clone().unwrap())
            .stderr(writer)
            .status()
            .unwrap();
        assert_eq!(status.code(), Some(0), "{call}");
    }
    for file in ["o.toml", "o.csv", "s.csv"] {
        assert!(bench.path().join(file).is_file(), "{file}");
    }
}

/// A list of poses like the data, cut to some rows.
fn some_poses(rows: usize) -> String {
    poses().lines().take(1 + rows).map(|l| l.to_owned() + "\n").collect()
}

#[test]
fn select_without_a_workspace() {
    let text = MECHANISM.split("[workspace]").next().unwrap();
    Bench::with_mechanism(text).refuses("select m.toml -o p.csv", &["m.toml", "[workspace]"]);
}

#[test]
fn select_with_too_few_poses() {
    let bench = Bench::new();
    bench.refuses("select m.toml -o p.csv -n 6", &["6 poses give 36 rows for 42", "o1 = 0", "at least 7"]);
    bench.refuses("select m.toml -o p.csv -n 0", &["-n 0", "at least one"]);
    let three = bench.file("g.csv", some_poses(3));
    three.refuses("select m.toml -o p.csv -n 3 --given g.csv", &["3 poses are given", "-n"]);
}

#[test]
fn select_without_a_feasible_candidate() {
    let bench = Bench::with_mechanism(with_stroke("[799.0, 800.0]"));
    let before = bench.listing();
    let output = bench.run("select m.toml -o p.csv --candidates 3 --selector random -n 3 --index o3 --quiet");
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    for part in ["m.toml", "none of 600", "600 need a joint outside its stroke", "make the workspace smaller"] {
        assert!(message.contains(part), "'{part}' is not in {message}");
    }
    assert!(output.stdout.is_empty() && bench.listing() == before);
}

#[test]
fn select_by_an_unknown_index_or_selector() {
    let bench = Bench::new();
    bench.refuses("select m.toml -o p.csv --index o6", &["o6", "o1", "pose-error"]);
    bench.refuses("select m.toml -o p.csv --selector best", &["best", "tabu-detmax"]);
    bench.refuses("select m.toml -o p.csv --scaling metres", &["metres", "whitened", "paper"]);
}

#[test]
fn select_with_a_requirement_that_cannot_be_met() {
    let bench = Bench::new();
    let call = "select m.toml -o p.csv --candidates 50 --no-polish --no-corners --require";
    bench.refuses(&format!("{call} 0.01um"), &["50 poses are predicted", "does not meet", "times as precisely"]);
    bench.refuses(&format!("{call} fast"), &["'fast'", "2um", "0.5arcsec"]);
    bench.refuses(&format!("{call} 1um,2um"), &["one length and one angle"]);
    bench.refuses(&format!("{call} 0um"), &["'0um' must be positive"]);
    bench.refuses(&format!("{call} 1um -n 20"), &["--require", "-n"]);
}

#[test]
fn select_without_noise_or_tolerance() {
    let bench = Bench::with_mechanism(without_tolerance());
    bench.refuses("select m.toml -o p.csv --scaling whitened", &["[tolerance]", "xA1", "--scaling paper"]);
    bench.refuses("select m.toml -o p.csv --index pose-error", &["pose-error", "[tolerance]"]);
    bench.refuses("select m.toml -o p.csv --require 1um", &["[noise] and [tolerance]"]);
    let output = bench.writes("select m.toml -o p.csv --candidates 30 --no-polish", &["p.csv"]);
    assert!(stderr(&output).contains("mm and rad"), "{}", stderr(&output));
}

#[test]
fn select_from_lists_that_are_wrong() {
    let bench = Bench::new().file("list.csv", some_poses(5)).file("empty.csv", some_poses(0));
    bench.refuses("select m.toml -o p.csv -n 9 --candidates list.csv", &["9 poses are requested", "only 5 candidates"]);
    bench.refuses("select m.toml -o p.csv --candidates empty.csv", &["empty.csv", "no data row"]);
    bench.refuses("select m.toml -o p.csv --candidates missing.csv", &["missing.csv"]);
    bench.refuses("select m.toml -o p.csv --candidates 0 --no-corners", &["--candidates 0", "nothing to choose"]);
    bench.refuses("select m.toml -o p.csv --candidates -5", &["-5"]);
    bench.refuses("select m.toml -o list.csv --candidates list.csv", &["list.csv", "input"]);
    bench.refuses("select m.toml -o m.toml", &["m.toml", "input"]);
    bench.refuses("select m.toml -o p.csv --given missing.csv", &["missing.csv"]);
    let far = some_poses(1) + "1e9,0.0,0.0,0.0,0.0,0.0\n";
    let bench = Bench::new().file("far.csv", far);
    bench.refuses("select m.toml -o p.csv -n 9 --candidates far.csv", &["9 poses are requested", "only 1 candidates"]);
}

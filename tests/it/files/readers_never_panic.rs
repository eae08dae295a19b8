//! Whatever a file holds, its reader returns in time, with a value or with an error that names the file; and what is read
//! goes through the commands.
//!
//! Each group of readers (mechanisms, measurements, lists of poses, conditions, parameter errors, journals) gets 20,000
//! mutated files, and a hundredth of that goes on through the commands.
//! `PARACAL_MUTATIONS=1000000 cargo test --test it readers_never_panic` makes that a million, `PARACAL_SEED=1` makes it others.
//! The longest that has been run is 140,000 with seed 2 (840,000 texts in 423 s).

use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::mpsc::channel;
use std::time::Duration;

use crate::common::mutations::mutations;
use paracal::cli::reproduction::{Journal, JournalError};
use paracal::conditions::Conditions;
use paracal::diagnosis::{Question, diagnose, settle};
use paracal::effect::Compensator;
use paracal::files::{
    Machine, Measurement, read_conditions, read_measurement, read_parameter_errors, read_pose_list, read_poses,
};
use paracal::identification::{CalibrationOptions, Weights, calibrate, evaluate, identifier};
use paracal::measurement::{Frames, Noise};
use paracal::mechanism::{Mechanism, Survey};
use paracal::observability::{O1, Scaling};
use paracal::report::html::{self, Measured, ModelResiduals};
use paracal::report::{json, text};
use paracal::selection::{Campaign, Candidates, Objective, SelectionTask, Sources, preview, select_among, selector};
use paracal::simulation::{Command, draw_parameters, simulate_run};
use proptest::prelude::*;
use proptest::sample::{Index, select};
use tempfile::TempDir;

const MECHANISM: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/table5.toml"));
const DATA: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/data/hardpoint-noisy.csv"));

/// Every section that the format knows.
static RICH_MECHANISM: LazyLock<String> = LazyLock::new(|| {
    let first =
        MECHANISM.replacen("length = 800.0", "length = 800.0\nlength_offset = 0.1\nstroke = [400.0, 1200.0]", 1);
    let head = "rotation_order = \"xyz\"\npivot = [0.0, 0.0, 10.0]\ngravity_axis = \"y\"\n\
                reference_temperature_degC = 20.0\nshared_anchors = false\n";
    let tail = "\n[home]\nposition = [0.0, 0.0, 485.696]\nrotation = [0.0, 0.0, 0.0]\n\n[platform]\nmass_kg = 500.0\n\
                centre_of_mass = [0.0, 0.0, 150.0]\n\n[actuator]\nscrew_pitch = 5.0\n\n[[target]]\nname = \"p1\"\n\
                platform = [1300.0, 0.0, 80.0]\n\n[[target]]\nname = \"ball\"\n\n[plane]\n\
                normal = [0.1, 0.0, 1.0]\ndistance = 5.0\ntip = [1.0, 2.0, -3.0]\nidentify = true\n\n[[sensor]]\n\
                covariate = \"temp_base1\"\nbase = [1400.0, 0.0, 0.0]\n\n[[effect]]\nname = \"thermal.leg.single\"\nleg = 1\n\
                parameters = { expansion = 1.17e-5 }\nsigma = { expansion = 1e-7 }\nrange = { temp_leg1 = [12.0, 25.0] }\n\n\
                [[effect]]\nname = \"step.frame\"\nrow = 7\n\
                parameters = { x = 1e-5, y = 0.0, z = 0.0, rx = 0.0, ry = 0.0, rz = 2e-6 }\n";
    format!("{head}{first}{tail}")
});

/// A positioner in pose space.
const POSITIONER: &str = "name = \"stage\"\ntype = \"pose\"\nlength_unit = \"um\"\nangle_unit = \"arcsec\"\n\n[home]\n\
    position = [1.0, 2.0, 3.0]\nrotation = [4.0, 5.0, 6.0]\n\n[tolerance]\nanchor = 100.0\nangle = 50.0\n\n[offset]\n\
    position = [1.0, 2.0, 3.0]\nrotation = [4.0, 5.0, 6.0]\n\n[[effect]]\nname = \"thermal.pose\"\nof = \"temp_mount\"\n\
    parameters = { x = 1e-6, y = 0.0, z = 0.0, rx = 0.0, ry = 0.0, rz = 2e-6 }\nreference = { temp_mount = 10.5 }\n";

/// The data with labels, times, temperatures, uncertainties, remarks, and quaternions instead of angles.
static RICH_DATA: LazyLock<String> = LazyLock::new(|| {
    let mut text = "# remarks\nid,time_utc,temp_leg1_degC,time_s,sigma_x_mm,note,elevation_deg,\"free\",\
                    gravity_x,gravity_y,gravity_z,"
        .to_owned();
    for (k, line) in DATA.lines().enumerate() {
        let cells: Vec<&str> = line.split(',').take(9).collect();
        if k == 0 {
            text += &format!("{},qw,qx,qy,qz\n", cells.join(","));
        } else {
            let clock = format!("2026-03-01T12:{k:02}:00+01:00");
            text += &format!(
                "r{k},{clock},20.5,{k},0.001,\"well, well\",45,{k}e-3,0.6,0,-0.8,{},1,0,0,0\n",
                cells.join(",")
            );
        }
    }
    text
});

/// Commanded poses, and measured targets.
const TARGETS: &str = "cmd_x_mm,cmd_y_mm,cmd_z_mm,cmd_rx_deg,p1x_mm,p1y_mm,p1z_mm,ballx_um,bally_um,ballz_um\n\
                       0,0,475,0,1300,0,555,1e3,2e3,475e3\n10,0,475,1,1310,0,555,,,\n0,-10,480,2,1300,-10,560,1,2,3\n";

/// Measured heights.
const HEIGHTS: &str = "leg1_mm,leg2_mm,leg3_mm,leg4_mm,leg5_mm,leg6_mm,contact_mm,sigma_contact_um\n\
                       800,800,800,800,800,800,480,2\n810,800,800,800,800,790,,\n800,810,800,800,790,800,0,1\n";

const POSES: &str = "id,x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg,temp_leg1_degC,time_utc\na,0,0,475,0,0,0,20,23:59:00\n\
                     b,10,-10,480,1,2,3,21.5,00:01:00\n,1,1,475.5,0,0,5,,\n";

const ERRORS: &str = "leg,xA_mm,yA_mm,zA_mm,xB_mm,yB_mm,zB_mm,h_mm\n1,0.1,0,0,0,0,0,0\n2,0,0.2,0,0,0,0,1e-3\n";

const CONDITIONS: &str = "temp_leg1_degC,temp_platform_degC,elevation_deg,payload_kg,time_s,free\n20,21,30,0,0,1\n\
                          21.5,20,60,50,10,2\n19,19.5,85,100,20,-3\n";

/// The heading is that of this version.
const JOURNAL: &str = concat!(
    "paracal journal of finished units, version ",
    env!("CARGO_PKG_VERSION"),
    "\n{\"unit\":\"a\",\"result\":[1.0,2.5e-7]}\n{\"unit\":\"b\",\"result\":[0.1,-3.0,4.0]}\n{\"unit\":\"c\",\"result\":null}\n"
);

/// One way to spoil a file. Places are taken modulo what there is.
#[derive(Clone, Debug)]
enum Damage {
    DropLine(Index),
    RepeatLine(Index),
    SwapLines(Index, Index),
    DropByte(Index),
    RepeatByte(Index),
    SwapBytes(Index, Index),
    SetByte(Index, u8),
    Insert(Index, Vec<u8>),
    ReplaceNumber(Index, String),
    Scale(Index, f64),
    ReplaceWord(Index, String),
    CutOff(Index),
    LineEnds(&'static str),
}

fn damage() -> impl Strategy<Value = Damage> {
    let at = any::<Index>;
    let numbers = vec![
        "nan",
        "inf",
        "-inf",
        "1e999",
        "-1e999",
        "1e308",
        "-1e300",
        "1e-320",
        "-0",
        "0",
        "",
        "-",
        "1e",
        "0x1f",
        "1_000",
        "９",
        "1,5",
        "99999999999999999999999",
        "true",
        "[]",
        "\"1\"",
        "1979-05-27",
        "{}",
        "#",
        "\"",
    ];
    let words =
        vec!["", "nan", "x", "leg", "leg1", "mm", "deg", "K", "h", "_", "é", "type", "p1x", "qw", "\u{0}", "[["];
    let blocks = prop_oneof![
        proptest::collection::vec(any::<u8>(), 1..64),
        (1_usize..3000).prop_map(|n| [b"x = ".to_vec(), b"[".repeat(n)].concat()),
        (1_usize..3000).prop_map(|n| [b"\nx = ".to_vec(), b"{a=".repeat(n)].concat()),
        (1_usize..3000).prop_map(|n| [b"\n[a".to_vec(), b".a".repeat(n), b"]\n".to_vec()].concat()),
        (1_usize..3000).prop_map(|n| [b"\n".to_vec(), b"a.".repeat(n), b"a = 1\n".to_vec()].concat()),
        (1_usize..30_000).prop_map(|n| [b"\n".to_vec(), b"1,".repeat(n), b"\n".to_vec()].concat()),
        (1_usize..100_000).prop_map(|n| b"y".repeat(n)),
        (1_usize..3000).prop_map(|n| b"\n".repeat(n)),
        Just(b"\"\"\"".to_vec()),
        Just("\u{feff}".into()),
    ];
    prop_oneof![
        1 => at().prop_map(Damage::DropLine),
        1 => at().prop_map(Damage::RepeatLine),
        1 => (at(), at()).prop_map(|(a, b)| Damage::SwapLines(a, b)),
        1 => at().prop_map(Damage::DropByte),
        1 => at().prop_map(Damage::RepeatByte),
        1 => (at(), at()).prop_map(|(a, b)| Damage::SwapBytes(a, b)),
        1 => (at(), any::<u8>()).prop_map(|(a, b)| Damage::SetByte(a, b)),
        1 => (at(), blocks).prop_map(|(a, b)| Damage::Insert(a, b)),
        4 => (at(), select(numbers)).prop_map(|(a, n)| Damage::ReplaceNumber(a, n.into())),
        2 => wild_number(),
        2 => (at(), select(words)).prop_map(|(a, w)| Damage::ReplaceWord(a, w.into())),
        1 => at().prop_map(Damage::CutOff),
        1 => select(vec!["\r\n", "\r", "\n\n", ""]).prop_map(Damage::LineEnds),
    ]
}

/// A number that a file may well hold, far from what makes sense there.
fn wild_number() -> impl Strategy<Value = Damage> {
    let values = vec![
        "0", "-0.0", "1", "-1", "2", "7.3", "-4e2", "1e3", "-1e5", "1e8", "1e18", "1e30", "-1e77", "1e154", "1e155",
        "-1e200", "1e308", "1e-3", "1e-8", "-1e-15", "1e-30", "1e-160", "1e-308", "5e-324",
    ];
    let factors = vec![-1.0, 1e-12, 1e-6, 1e-3, 0.5, 1.0 + 1e-15, 1.001, 2.0, 10.0, 25.4, 57.29, 1e3, 1e6, 1e12];
    prop_oneof![
        (any::<Index>(), select(values)).prop_map(|(a, v)| Damage::ReplaceNumber(a, v.into())),
        (any::<Index>(), select(factors)).prop_map(|(a, f)| Damage::Scale(a, f)),
    ]
}

/// A part of a text, by its first byte and the byte after its last.
type Span = (usize, usize);

/// The runs of bytes that belong to a number or to a word.
fn spans(text: &[u8], belongs: fn(u8) -> bool) -> Vec<Span> {
    let mut spans: Vec<Span> = Vec::new();
    for (k, _) in text.iter().enumerate().filter(|(_, b)| belongs(**b)) {
        match spans.last_mut().filter(|(_, end)| *end == k) {
            Some((_, end)) => *end = k + 1,
            None => spans.push((k, k + 1)),
        }
    }
    spans
}

fn with_lines(text: &[u8], change: impl FnOnce(&mut Vec<Vec<u8>>)) -> Vec<u8> {
    let mut lines: Vec<Vec<u8>> = text.split(|b| *b == b'\n').map(<[u8]>::to_vec).collect();
    change(&mut lines);
    lines.join(&b'\n')
}

fn in_number(byte: u8) -> bool {
    matches!(byte, b'0'..=b'9' | b'.' | b'-')
}

fn replace_span(mut text: Vec<u8>, at: &Index, belongs: fn(u8) -> bool, with: &str) -> Vec<u8> {
    let spans = spans(&text, belongs);
    if !spans.is_empty() {
        let (from, to) = spans[at.index(spans.len())];
        text.splice(from..to, with.bytes());
    }
    text
}

fn damaged(mut text: Vec<u8>, damage: &Damage) -> Vec<u8> {
    if text.is_empty() {
        return text;
    }
    let n = text.len();
    match damage {
        Damage::DropLine(a) => with_lines(&text, |l| drop(l.remove(a.index(l.len())))),
        Damage::RepeatLine(a) => with_lines(&text, |l| l.insert(a.index(l.len()), l[a.index(l.len())].clone())),
        Damage::SwapLines(a, b) => with_lines(&text, |l| {
            let (a, b) = (a.index(l.len()), b.index(l.len()));
            l.swap(a, b);
        }),
        Damage::DropByte(a) => {
            text.remove(a.index(n));
            text
        }
        Damage::RepeatByte(a) => {
            text.insert(a.index(n), text[a.index(n)]);
            text
        }
        Damage::SwapBytes(a, b) => {
            text.swap(a.index(n), b.index(n));
            text
        }
        Damage::SetByte(a, b) => {
            text[a.index(n)] = *b;
            text
        }
        Damage::Insert(a, block) => {
            let at = a.index(n);
            text.splice(at..at, block.iter().copied());
            text
        }
        Damage::ReplaceNumber(a, with) => replace_span(text, a, in_number, with),
        Damage::Scale(a, factor) => {
            let spans = spans(&text, in_number);
            let Some((from, to)) = (!spans.is_empty()).then(|| spans[a.index(spans.len())]) else { return text };
            let number = std::str::from_utf8(&text[from..to]).ok().and_then(|n| n.parse::<f64>().ok());
            let scaled = format!("{:?}", number.unwrap_or(1.0) * factor);
            text.splice(from..to, scaled.bytes());
            text
        }
        Damage::ReplaceWord(a, with) => replace_span(text, a, |b| b.is_ascii_alphanumeric(), with),
        Damage::CutOff(a) => {
            text.truncate(a.index(n));
            text
        }
        Damage::LineEnds(with) => {
            text.split(|b| *b == b'\n').map(<[u8]>::to_vec).collect::<Vec<_>>().join(with.as_bytes())
        }
    }
}

/// One of the good texts with a few damages.
fn bad_text(good: Vec<&'static str>) -> impl Strategy<Value = Vec<u8>> {
    (select(good), proptest::collection::vec(damage(), 1..4))
        .prop_map(|(good, damages)| damages.iter().fold(good.as_bytes().to_vec(), damaged))
}

/// Runs a reader in a thread of its own and fails if it panics or takes too long.
fn in_time<T: Send + 'static>(read: impl FnOnce() -> T + Send + 'static) -> Result<T, TestCaseError> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || sender.send(read()));
    receiver.recv_timeout(Duration::from_secs(20)).map_err(|e| TestCaseError::fail(format!("panic or hang: {e}")))
}

/// A file with this content in a folder of its own.
fn file(name: &str, content: &[u8]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    (folder, path)
}

/// An error names its file and gives a reason.
fn check_message(error: &impl std::fmt::Display, path: &Path) -> Result<(), TestCaseError> {
    let message = error.to_string();
    let rest = message.strip_prefix(&path.display().to_string());
    prop_assert!(rest.is_some_and(|r| r.len() > 10), "{message}");
    Ok(())
}

static MACHINE: LazyLock<Machine> =
    LazyLock::new(|| Machine::from_text(&RICH_MECHANISM, Path::new("rich.toml")).unwrap());

fn measurement(path: PathBuf) -> Result<Measurement, paracal::files::FileError> {
    read_measurement(path, &MACHINE)
}

#[test]
fn the_texts_are_good_before_they_are_spoilt() {
    Machine::from_text(MECHANISM, Path::new("plain.toml")).unwrap();
    Machine::from_text(POSITIONER, Path::new("stage.toml")).unwrap();
    assert_eq!((MACHINE.targets.len(), MACHINE.effects().len()), (2, 2));
    for text in [DATA, &RICH_DATA, TARGETS, HEIGHTS] {
        let (_folder, path) = file("d.csv", text.as_bytes());
        measurement(path).unwrap();
    }
    let (_folder, path) = file("p.csv", POSES.as_bytes());
    assert_eq!(read_poses(path, &MACHINE).unwrap().len(), 3);
    let (_folder, path) = file("e.csv", ERRORS.as_bytes());
    read_parameter_errors(path, MACHINE.plain()).unwrap();
}

#[test]
fn very_deep_and_very_large_mechanism_files() {
    let path = Path::new("deep.toml");
    for n in [1_000, 200_000] {
        for text in [
            format!("x = {}", "[".repeat(n)),
            format!("x = {}{}", "[".repeat(n), "]".repeat(n)),
            format!("x = {}", "{a=".repeat(n)),
            format!("[a{}]", ".a".repeat(n)),
            format!("a{} = 1", ".a".repeat(n)),
            format!("name = \"{}\"", "y".repeat(n)),
            format!("name = {}", "'".repeat(n)),
            "[[leg]]\n".repeat(n.min(20_000)),
            "\u{0}".repeat(n),
        ] {
            let read = in_time(move || Machine::from_text(&text, path)).unwrap();
            check_message(&read.unwrap_err(), path).unwrap();
        }
    }
}

#[test]
fn very_large_tables() {
    let row = |n: usize| format!("{}1\n", "1,".repeat(n));
    for text in [
        format!("{DATA}{}", row(1_000_000)),
        format!("a\n{}", "1\n".repeat(200_000)),
        format!("{}\n", "\"".repeat(1_000_001)),
        format!("{DATA}{}\n", "9".repeat(1_000_000)),
        format!("#{}\n", "y".repeat(1_000_000)),
        "\u{0}".repeat(1_000_000),
    ] {
        let (_folder, path) = file("large.csv", text.as_bytes());
        let named = path.clone();
        let read = in_time(move || measurement(path)).unwrap();
        check_message(&read.unwrap_err(), &named).unwrap();
    }
}

/// A mechanism file of every kind.
fn mechanism_texts() -> Vec<&'static str> {
    const KINDS: [&str; 4] = [
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/rotary-stewart.toml")),
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/linear-delta.toml")),
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/tripod-3rps.toml")),
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/planar-cables.toml")),
    ];
    [MECHANISM, &RICH_MECHANISM, POSITIONER].into_iter().chain(KINDS).collect()
}

proptest! {
    #![proptest_config(mutations(2))]

    /// What is accepted can also be written and read again, and has finite joints at home.
    #[test]
    fn mechanism_files(text in bad_text(mechanism_texts())) {
        let path = Path::new("bad.toml");
        let text = String::from_utf8_lossy(&text).into_owned();
        match in_time(move || Machine::from_text(&text, path))? {
            Err(error) => check_message(&error, path)?,
            Ok(machine) => {
                let mechanism = machine.mechanism.as_ref();
                let home = mechanism.inverse(mechanism.values(), &mechanism.home(), &Conditions::unknown());
                prop_assert!(home.as_ref().is_ok_and(|q| q.iter().all(|v| v.is_finite())), "{home:?}");
                let written = machine.document_of(mechanism, machine.workspace.as_ref(), &Frames::default());
                let written = written.unwrap().to_text();
                let again = Machine::from_text(&written, path);
                prop_assert!(again.is_ok(), "{}\n{written}", again.unwrap_err());
            }
        }
    }

    #[test]
    fn mechanism_files_of_any_bytes(text in bad_text(mechanism_texts())) {
        let (_folder, path) = file("bad.toml", &text);
        let named = path.clone();
        if let Err(error) = in_time(move || Machine::read(path))? {
            check_message(&error, &named)?;
        }
    }
}

proptest! {
    #![proptest_config(mutations(1))]

    /// What is accepted holds finite lengths, one set for each reading.
    #[test]
    fn measurement_files(text in bad_text(vec![DATA, &RICH_DATA, TARGETS, HEIGHTS])) {
        let (_folder, path) = file("bad.csv", &text);
        let named = path.clone();
        match in_time(move || measurement(path))? {
            Err(error) => check_message(&error, &named)?,
            Ok(read) => {
                prop_assert!(read.data.row_count() > 0);
                for sample in read.data.iter() {
                    prop_assert!(sample.joints.len() == 6 && sample.joints.iter().all(|v| v.is_finite()));
                    prop_assert!(sample.conditions.covariates.values().all(|v| v.is_finite()));
                }
            }
        }
    }

    #[test]
    fn pose_lists(text in bad_text(vec![POSES, DATA, &RICH_DATA])) {
        let (_folder, path) = file("bad.csv", &text);
        let named = path.clone();
        match in_time(move || read_poses(path, &MACHINE))? {
            Err(error) => check_message(&error, &named)?,
            Ok(poses) => prop_assert!(poses.iter().all(|p| p.pose.is_finite())),
        }
    }

    #[test]
    fn conditions_of_campaigns(text in bad_text(vec![CONDITIONS, POSES, &RICH_DATA])) {
        let (_folder, path) = file("bad.csv", &text);
        let named = path.clone();
        match in_time(move || read_conditions(path, &MACHINE))? {
            Err(error) => check_message(&error, &named)?,
            Ok(read) => prop_assert!(read.states.iter().all(|s| s.covariates.values().all(|v| v.is_finite()))),
        }
    }

    #[test]
    fn parameter_errors(text in bad_text(vec![ERRORS])) {
        let (_folder, path) = file("bad.csv", &text);
        let named = path.clone();
        match in_time(move || read_parameter_errors(path, MACHINE.plain()))? {
            Err(error) => check_message(&error, &named)?,
            Ok(errors) => prop_assert!(errors.iter().all(|e| e.is_finite())),
        }
    }

    /// What is no journal is left alone; what is one gives a result that was in it, or the work is done.
    #[test]
    fn journals(text in bad_text(vec![JOURNAL])) {
        let (_folder, path) = file("bad.journal", &text);
        let named = path.clone();
        let opened = in_time(move || Journal::open(path))?;
        match opened {
            Err(error) => {
                check_message(&error, &named)?;
                let foreign = matches!(error, JournalError::Foreign { .. });
                prop_assert!(foreign);
                prop_assert!(std::fs::read(&named).unwrap() == text);
            }
            Ok(journal) => {
                for unit in ["a", "b", "c", ""] {
                    let result = journal.unit(unit, || Ok::<_, JournalError>(vec![7.0]));
                    prop_assert!(result.is_ok());
                }
                drop(journal);
                let again = Journal::open(&named).unwrap();
                let known = again.unit("c", || Ok::<_, JournalError>(vec![8.0])).unwrap();
                prop_assert!(known != [8.0], "what was added after the damage is lost");
            }
        }
    }
}

/// A good text with a few wild numbers, which most readers accept.
fn wild_text(good: Vec<&'static str>) -> impl Strategy<Value = String> {
    (select(good), proptest::collection::vec(wild_number(), 0..4)).prop_map(|(good, numbers)| {
        let spoilt = numbers.iter().fold(good.as_bytes().to_vec(), damaged);
        String::from_utf8_lossy(&spoilt).into_owned()
    })
}

/// Rows of the data that are enough for each kind of mechanism and few enough for thousands of runs.
fn short(data: &str) -> String {
    data.lines().take(13).map(|l| format!("{l}\n")).collect()
}

fn subject<'a>(machine: &'a Machine, mechanism: &'a dyn Mechanism) -> html::Subject<'a> {
    let noise = machine.noise.map(|n| [n.position, n.rotation]);
    let settings = vec![("call".to_owned(), "paracal".to_owned())];
    let (convention, condition_kinds) = (&machine.convention, machine.condition_kinds());
    let frames = html::frames_of(mechanism, machine.commander());
    html::Subject { mechanism, frames, convention, condition_kinds, noise, warnings: Vec::new(), settings }
}

/// What the commands do with what they have read: `which` of them. The result of each may be an error; its text, its JSON
/// and its page are made.
fn go_on(which: usize, machine: &Machine, data: &Measurement, poses: &Path) -> usize {
    let mechanism = machine.mechanism.as_ref();
    let page = |html: &str| html.len();
    let data_of = &data.data;
    match which {
        0 => evaluate(mechanism, &[], &data.data).map_or(0, |errors| {
            let shown = text::evaluation(&errors, mechanism.name()).len() + json::evaluation(&errors).to_string().len();
            let models: Vec<ModelResiduals> =
                ModelResiduals::new("model", mechanism, &[], data_of).into_iter().collect();
            let measured = Measured { data: data_of, models: &models };
            shown + page(&html::evaluation(&errors, &subject(machine, mechanism), &measured).html())
        }),
        1..=4 => {
            let name = ["levenberg-marquardt", "least-squares", "robust"][which.min(3) - 1];
            let weights = if which == 2 { Weights::MillimetresAndRadians } else { Weights::Noise };
            let options =
                CalibrationOptions { weights, convention: machine.convention, ..CalibrationOptions::default() };
            let identifier = identifier(name).unwrap();
            let done = calibrate(mechanism, &data.data, machine.workspace.as_ref(), identifier.as_ref(), &options);
            done.map_or(0, |found| {
                let own = found.identification.own_values();
                let aligned = data_of.with_frames(found.registration.frames);
                let models = [
                    ModelResiduals::new("calibrated", found.mechanism.as_ref(), &own, data_of),
                    ModelResiduals::new("as given", mechanism, &[], &aligned),
                ];
                let models: Vec<ModelResiduals> = models.into_iter().flatten().collect();
                let measured = Measured { data: data_of, models: &models };
                let pages = html::calibration(&found, &subject(machine, found.mechanism.as_ref()), &measured);
                let written =
                    machine.document_of(found.mechanism.as_ref(), found.workspace.as_ref(), &found.registration.frames);
                let written = written.map_or(0, |d| d.to_text().len());
                written + page(&pages.html()) + json::calibration(&found, &[]).to_string().len()
            })
        }
        5 => {
            let question = Question::of(machine, data_of);
            diagnose(&question).map_or(0, |found| {
                let plans = settle(&question, &found);
                let plans = plans.unwrap_or_default();
                let planned =
                    text::settlement(&found, &plans, "m").len() + json::settlement(&found, &plans).to_string().len();
                let shown = text::diagnosis(&found, "m").len() + json::diagnosis(&found).to_string().len();
                let written = machine.extended_document(&found).map_or(0, |d| d.to_text().len());
                planned
                    + shown
                    + written
                    + page(&html::diagnosis(&found, &plans, &subject(machine, mechanism), data_of).html())
            })
        }
        6 => machine.workspace.as_ref().map_or(0, |w| {
            let survey = Survey::of(mechanism, w, &[mechanism.home()]);
            let noise = machine.noise.unwrap_or(Noise::stated(1e-6, 1e-6));
            survey.poses + preview(mechanism, w, &noise, 12, 0).map_or(0, |p| p.poses.len())
        }),
        7 => machine.workspace.as_ref().map_or(0, |w| {
            let Ok(campaign) = Campaign::new(mechanism, w, machine.noise.as_ref(), Scaling::Paper) else { return 0 };
            let sources = Sources { random: 30, ..Sources::default() };
            let Ok(candidates) = Candidates::collect(&campaign, &sources) else { return 0 };
            let aim = Objective::Index(&O1);
            let plan =
                SelectionTask { campaign: &campaign, forecaster: None, aim, given: &[], seed: 0, watch: &|_| {} };
            let chosen = selector("exchange").unwrap();
            select_among(&plan, chosen.as_ref(), &candidates, 12, true).map_or(0, |report| report.poses.len())
        }),
        _ => {
            let Ok(list) = read_pose_list(poses, machine) else { return 0 };
            let compensator = Compensator::new(machine.plain(), machine.environment(), &machine.effects(), false);
            let commanded = compensator.map_or(0, |mut compensator| {
                let found = list.poses.iter().map(|l| compensator.command(&l.pose, &l.conditions));
                found.filter(Result::is_ok).count()
            });
            let mut rng = rand::SeedableRng::seed_from_u64(0);
            let values = draw_parameters(mechanism, Some(1e-4), &mut rng);
            let Ok(truth) = mechanism.with_values(&values, mechanism.home()) else { return commanded };
            let run: Vec<Command> =
                list.poses.iter().map(|l| Command { pose: l.pose, state: l.conditions.clone() }).collect();
            let noise = machine.noise.unwrap_or(Noise::stated(1e-6, 1e-6));
            let convention = &machine.convention;
            let samples = simulate_run::<rand::rngs::ChaCha8Rng>(
                mechanism,
                truth.as_ref(),
                &run,
                None,
                convention,
                &noise,
                &mut rng,
            );
            commanded + samples.map_or(0, |s| s.len())
        }
    }
}

proptest! {
    #![proptest_config(mutations(100))]

    /// Numbers that no check of a reader refuses do not make a later step panic or hang.
    #[test]
    fn what_is_read_goes_through_the_commands(
        mechanism in wild_text(vec![MECHANISM, &RICH_MECHANISM, POSITIONER]),
        data in wild_text(vec![DATA, &RICH_DATA, TARGETS, HEIGHTS]),
        poses in wild_text(vec![POSES]),
        which in 0_usize..9,
    ) {
        let (folder, path) = file("wild.csv", short(&data).as_bytes());
        let list = folder.path().join("poses.csv");
        std::fs::write(&list, poses).unwrap();
        in_time(move || {
            let Ok(machine) = Machine::from_text(&mechanism, Path::new("wild.toml")) else { return 0 };
            let Ok(measured) = read_measurement(path, &machine) else { return 0 };
            go_on(which, &machine, &measured, &list)
        })?;
    }
}

/// The test above is worth something only if most of its files are accepted.
#[test]
fn good_files_reach_every_command() {
    let machine = Machine::from_text(MECHANISM, Path::new("plain.toml")).unwrap();
    let (folder, path) = file("d.csv", DATA.as_bytes());
    let list = folder.path().join("p.csv");
    std::fs::write(&list, "x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n1,2,475,0,1,0\n").unwrap();
    let measured = read_measurement(&path, &machine).unwrap();
    for which in 0..9 {
        assert!(go_on(which, &machine, &measured, &list) > 0, "{which}");
    }
}

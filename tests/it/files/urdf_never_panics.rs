//! Whatever is done to a URDF, its reader returns in time; and a change that must not matter does not, while one that
//! must be seen is seen.
//!
//! 20,000 damaged robots and 20,000 damaged side files; `PARACAL_MUTATIONS` and `PARACAL_SEED` ask for others. The longest that has been
//! run is 80,000 damaged robots and as many side files with seed 2 (304 s).

use std::any::Any;
use std::path::Path;
use std::sync::mpsc::channel;
use std::time::Duration;

use crate::common::mutations::mutations;
use crate::common::urdf_robots::{Style, expected, robot};
use paracal::files::{FileError, Machine};
use paracal::mechanism::{Leg, SixHardpoint};
use proptest::prelude::*;
use proptest::sample::{Index, select};

/// Styles whose file says everything.
const WHOLE: [Style; 9] = [
    Style::Frames,
    Style::HingeFrames,
    Style::FlangeFrames,
    Style::LoopJoint,
    Style::Drake,
    Style::UrdfPlus,
    Style::Parents,
    Style::Hung,
    Style::FromPlatform,
];

/// Longest that a file may take.
const PATIENCE: Duration = Duration::from_secs(10);

/// Legs and warnings, or the message of the refusal.
type Outcome = Result<(Vec<Leg>, Vec<String>), String>;

/// Reads a text in a thread of its own, so that a hang is seen.
fn read(text: String) -> Outcome {
    let (send, receive) = channel();
    std::thread::spawn(move || {
        let read = Machine::from_text(&text, Path::new("robot.urdf"));
        let outcome = read.map_err(|e| {
            if let FileError::Urdf { findings, .. } = &e {
                assert!(!findings.is_empty(), "a refusal without a reason");
            }
            e.to_string()
        });
        let legs = |m: &Machine| {
            let mechanism: &dyn Any = m.mechanism.as_ref();
            mechanism.downcast_ref::<SixHardpoint>().unwrap().to_legs()
        };
        let _ = send.send(outcome.map(|m| (legs(&m), m.warnings.clone())));
    });
    let outcome = receive.recv_timeout(PATIENCE).expect("the reader panicked or did not return in time");
    if let Err(message) = &outcome {
        assert!(message.contains("robot.urdf"), "{message}");
    }
    outcome
}

/// Largest difference of anchors, lengths and ranges from those of the mechanism, leg by leg.
fn off(legs: &[Leg]) -> f64 {
    let e = expected();
    let leg = |(k, l): (usize, &Leg)| {
        let range = l.stroke.map_or([0.0; 2], |s| [s[0] - e.range[k][0], s[1] - e.range[k][1]]);
        let anchors = (l.platform - e.a[k]).norm().max((l.base - e.b[k]).norm());
        anchors.max((l.length - e.length[k]).abs()).max(range[0].abs()).max(range[1].abs())
    };
    legs.iter().enumerate().map(leg).fold(0.0, f64::max)
}

/// A change of the text at large: no oracle but that the reader returns.
#[derive(Clone, Debug)]
enum Damage {
    DropLine(Index),
    RepeatLine(Index),
    SwapLines(Index, Index),
    SetByte(Index, u8),
    Insert(Index, String),
    Number(Index, &'static str),
    CutOff(Index),
}

fn damage() -> impl Strategy<Value = Damage> {
    let at = any::<Index>;
    let numbers = vec!["nan", "inf", "1e999", "-1e308", "1e-320", "0", "", "x", "1 2", "1,5", "9e99"];
    let blocks = prop_oneof![
        (1_usize..20_000).prop_map(|n| "<a>".repeat(n)),
        (1_usize..20_000).prop_map(|n| "<link name='x'/>".repeat(n)),
        (1_usize..5_000).prop_map(|n| (0..n).map(|k| format!("<link name='n{k}'/>")).collect()),
        (1_usize..3_000).prop_map(|n| {
            let joint =
                |k| format!("<joint name='c{k}' type='revolute'><parent link='base'/><child link='platform'/></joint>");
            (0..n).map(joint).collect()
        }),
        Just("<!DOCTYPE a [<!ENTITY b \"xxxxxxxxxx\"><!ENTITY c \"&b;&b;&b;&b;&b;&b;\">]>&c;".to_owned()),
        Just("<joint name='up' type='fixed'><parent link='platform'/><child link='base'/></joint>".to_owned()),
        Just("<joint name='self' type='revolute'><parent link='base'/><child link='base'/></joint>".to_owned()),
        "[<>/=\"'&;a-z ]{1,40}",
    ];
    prop_oneof![
        2 => at().prop_map(Damage::DropLine),
        2 => at().prop_map(Damage::RepeatLine),
        1 => (at(), at()).prop_map(|(a, b)| Damage::SwapLines(a, b)),
        1 => (at(), any::<u8>()).prop_map(|(a, b)| Damage::SetByte(a, b)),
        2 => (at(), blocks).prop_map(|(a, b)| Damage::Insert(a, b)),
        3 => (at(), select(numbers)).prop_map(|(a, n)| Damage::Number(a, n)),
        1 => at().prop_map(Damage::CutOff),
    ]
}

fn damaged(text: &str, damage: &Damage) -> String {
    if text.trim().is_empty() {
        return text.to_owned();
    }
    let mut lines: Vec<&str> = text.lines().collect();
    let n = lines.len();
    match damage {
        Damage::DropLine(at) => drop(lines.remove(at.index(n))),
        Damage::RepeatLine(at) => lines.insert(at.index(n), lines[at.index(n)]),
        Damage::SwapLines(a, b) => lines.swap(a.index(n), b.index(n)),
        Damage::SetByte(at, byte) => {
            let mut bytes = text.as_bytes().to_vec();
            let k = at.index(bytes.len());
            bytes[k] = *byte;
            return String::from_utf8_lossy(&bytes).into_owned();
        }
        Damage::Insert(at, block) => {
            let line = at.index(n);
            return lines[..line].join("\n") + "\n" + block + "\n" + &lines[line..].join("\n");
        }
        Damage::Number(at, number) => {
            let starts: Vec<usize> = text.match_indices(['"', ' ']).map(|(k, _)| k + 1).collect();
            let start = if starts.is_empty() { 0 } else { starts[at.index(starts.len())] };
            let end = start + text[start..].find(['"', ' ', '>']).unwrap_or(0);
            return format!("{}{number}{}", &text[..start], &text[end..]);
        }
        Damage::CutOff(at) => return text.chars().take(at.index(text.len())).collect(),
    }
    lines.join("\n")
}

/// A change that says nothing about the mechanism.
fn harmless() -> impl Strategy<Value = fn(String, Index) -> String> {
    fn after_links(text: &str, more: &str) -> String {
        let k = text.find("  <joint").unwrap();
        format!("{}{more}\n{}", &text[..k], &text[k..])
    }
    let changes: Vec<fn(String, Index) -> String> = vec![
        |text, _| text.replace("strut_", "part-9."),
        |text, _| text.replace("effort=\"1\"", "effort=\"1e9\" drag=\"3\""),
        |text, at| {
            // Links may stand in any order, unless their order names what nothing else does.
            let mut lines: Vec<&str> = text.lines().collect();
            let whole = |l: &str| l.starts_with("  <link") && l.ends_with("/>") && l.matches('<').count() == 1;
            let first = lines.iter().position(|l| whole(l)).unwrap();
            let count = lines[first..].iter().take_while(|l| whole(l)).count();
            lines[first..first + count].rotate_left(at.index(count));
            lines.join("\n")
        },
        |text, _| {
            // Another name for each.
            let n = text.len();
            let lid = format!(
                "  <link name=\"cover{n}\"><visual><geometry/></visual></link><joint name=\"lid{n}\" type=\"revolute\">\
                 <parent link=\"base\"/><child link=\"cover{n}\"/><axis xyz=\"0 1 0\"/></joint>"
            );
            after_links(&text, &lid)
        },
        |text, _| after_links(&text, "  <transmission name=\"t\"><joint name=\"drive_a\"/></transmission><!-- & < -->"),
        |text, _| {
            after_links(
                &text,
                "  <gazebo reference=\"base\"><plugin filename=\"x.so\"><joint>drive_a</joint></plugin></gazebo>",
            )
        },
        |text, _| text.replace("/><", "/>\r\n\t<"),
        |text, _| text.replace("name=\"asymmetric\"", "name=\"&lt;a&gt;\" xmlns:xacro=\"http://x\" version=\"1.0\""),
        |text, _| text.replace('"', "'"),
    ];
    select(changes)
}

/// A change that no reader may pass over.
fn fatal() -> impl Strategy<Value = fn(String, Index) -> String> {
    /// A line of a joint of a leg, chosen among those with a part.
    fn on_joint(text: &str, at: Index, part: &str, change: impl Fn(&str) -> String) -> String {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let legs: Vec<usize> =
            (0..lines.len()).filter(|k| lines[*k].contains("<joint") && lines[*k].contains(part)).collect();
        let k = legs[at.index(legs.len())];
        lines[k] = change(&lines[k]);
        lines.join("\n")
    }
    let changes: Vec<fn(String, Index) -> String> = vec![
        |text, at| on_joint(&text, at, "drive_", |_| String::new()),
        |text, at| on_joint(&text, at, "drive_", |l| format!("{l}\n{l}")),
        |text, at| on_joint(&text, at, "drive_", |l| l.replacen("type=\"prismatic\"", "type=\"revolute\"", 1)),
        |text, at| {
            on_joint(&text, at, "drive_", |l| l.replacen("xyz=\"", "xyz=\"nan ", 1).replacen(" rpy", "\" rpy", 0))
        },
        |text, at| on_joint(&text, at, "<axis", |l| l.replacen("<axis xyz=\"", "<axis xyz=\"0 0 0\" was=\"", 1)),
        |text, at| on_joint(&text, at, "<parent", |l| l.replacen("<parent link=\"", "<parent link=\"no such ", 1)),
        |text, at| on_joint(&text, at, "drive_", |l| l.replacen("lower=\"", "lower=\"99\" was=\"", 1)),
        |text, at| on_joint(&text, at, "drive_", |l| l.replacen("<axis xyz=\"0 0 ", "<axis xyz=\"0.3 0 ", 1)),
        |text, at| on_joint(&text, at, "<joint", |l| l.replacen("rpy=\"", "rpy=\"inf 0 0\" was=\"", 1)),
    ];
    select(changes)
}

proptest! {
    #![proptest_config(mutations(1))]

    #[test]
    fn nothing_makes_it_panic_or_hang(style in select(WHOLE.to_vec()), list in prop::collection::vec(damage(), 1..4)) {
        let text = list.iter().fold(robot(style).text(), |text, d| damaged(&text, d));
        // What is accepted is a mechanism of finite numbers.
        if let Ok((legs, _)) = read(text) {
            prop_assert!(legs.len() == 6 && off(&legs).is_finite());
        }
    }

    /// The TOML and the YAML that stand beside a URDF.
    #[test]
    fn side_files(yaml in any::<bool>(), list in prop::collection::vec(damage(), 1..4)) {
        let folder = tempfile::tempdir().unwrap();
        let (name, good) = if yaml { ("r.yaml", YAML) } else { ("r.toml", SIDE) };
        std::fs::write(folder.path().join("r.urdf"), robot(Style::Frames).text()).unwrap();
        let text = list.iter().fold(good.to_owned(), |text, d| damaged(&text, d));
        std::fs::write(folder.path().join(name), text).unwrap();
        let (send, receive) = channel();
        let path = folder.path().join("r.urdf");
        std::thread::spawn(move || send.send(Machine::read(path).map(drop).map_err(|e| e.to_string())));
        let read = receive.recv_timeout(PATIENCE);
        prop_assert!(read.is_ok(), "the reader panicked or did not return in time");
        if let Ok(Err(message)) = read {
            prop_assert!(message.contains("/r.") && message.len() > 20, "{message}");
        }
    }
}

const SIDE: &str = "name = \"robot\"\ntype = \"six-hardpoint\"\nlength_unit = \"mm\"\nangle_unit = \"deg\"\n\
    reference_temperature_degC = 20.0\n\n[workspace]\nposition = [20.0, 20.0, 15.0]\nrotation = [5.0, 5.0, 5.0]\n\n\
    [tolerance]\nanchor = 0.2\nlength = 0.2\n\n[noise]\nposition = 0.01\nrotation = 0.002\n";
const YAML: &str = "closed_loop: [[strut_A_tip, strut_A_seat], [strut_B_tip, strut_B_seat]]\n\
    type: ['3d', '3d']\nname_mot: [drive_a, drive_b]\nmore:\n  - &anchor {a: 1.5, b: [x, ~]}\n  - *anchor\n";

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_does_not_matter_changes_nothing(
        style in select(WHOLE.to_vec()),
        changes in prop::collection::vec((harmless(), any::<Index>()), 1..4),
    ) {
        let text = changes.into_iter().fold(robot(style).text(), |text, (change, at)| change(text, at));
        let (legs, _) = read(text).map_err(TestCaseError::fail)?;
        prop_assert!(off(&legs) < 1e-12, "off by {}", off(&legs));
    }

    #[test]
    fn what_is_wrong_is_never_passed_over(
        style in select(WHOLE.to_vec()),
        change in fatal(),
        at in any::<Index>(),
    ) {
        let text = change(robot(style).text(), at);
        prop_assert!(read(text).is_err());
    }

    /// A dropped line takes a link, a joint or a closure away: what is left is refused, or is the same mechanism.
    #[test]
    fn a_lost_line_is_seen(style in select(WHOLE.to_vec()), at in any::<Index>()) {
        let text = robot(style).text();
        let mut lines: Vec<&str> = text.lines().collect();
        let lost = lines.remove(at.index(lines.len()));
        if let Ok((legs, warnings)) = read(lines.join("\n")) {
            prop_assert!(off(&legs) < 1e-12 || !warnings.is_empty(), "without {lost}: off by {}", off(&legs));
        }
    }
}

#[test]
fn large_files_are_refused_or_read_in_time() {
    let good = robot(Style::Frames).text();
    let insert = |more: &str| good.replacen("</robot>", &format!("{more}</robot>"), 1);
    let links: String = (0..4_900).map(|k| format!("<link name='x{k}'/>")).collect();
    let chain = |kind: &str| -> String {
        let joint = |k: usize| {
            let parent = if k == 0 { "base".into() } else { format!("x{}", k - 1) };
            format!("<joint name='j{k}' type='{kind}'><parent link='{parent}'/><child link='x{k}'/></joint>")
        };
        (0..4_900).map(joint).collect()
    };
    for kind in ["fixed", "revolute"] {
        let (legs, _) = read(insert(&(links.clone() + &chain(kind)))).unwrap();
        assert!(off(&legs) < 1e-12);
    }
    assert!(read(insert(&links)).unwrap_err().contains("SeveralRoots"));
    let many: String = (0..6_000).map(|k| format!("<link name='x{k}'/>")).collect();
    assert!(read(insert(&many)).unwrap_err().contains("TooLarge"));
    assert!(read(insert(&"<a>".repeat(300_000))).unwrap_err().contains("TooLarge"));
    assert!(read(insert(&"<a/>".repeat(3_000_000))).unwrap_err().contains("TooLarge"));
    assert!(read(" ".repeat(70 << 20) + &good).unwrap_err().contains("TooLarge"));
    let rungs: String = (0..4_000)
        .map(|k| {
            format!(
                "<loop_joint name='l{k}' type='spherical'><link1 link='strut_A_rod'/><link2 link='base'/></loop_joint>"
            )
        })
        .collect();
    assert!(read(insert(&rungs)).unwrap_err().contains("LegBranches"));
}

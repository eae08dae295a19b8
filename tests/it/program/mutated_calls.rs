//! Whatever the call is, it is read or refused with a message: 20,000 mutated calls, or `PARACAL_MUTATIONS`.
//!
//! `PARACAL_MUTATIONS=1000000 PARACAL_SEED=1 cargo test --test it mutated_calls` has been run: a million calls and a
//! million effects.

use std::ffi::OsString;
use std::path::Path;
use std::sync::LazyLock;

use clap::{CommandFactory, FromArgMatches, Parser};
use paracal::cli::{Cli, effect_entry, run};
use paracal::files::Machine;
use proptest::prelude::*;
use proptest::sample::{Index, select};

use crate::common::mutations::mutations;

/// Valid calls; their files do not exist.
const CALLS: [&str; 12] = [
    "paracal inspect m.toml --json --threads 2",
    "paracal select m.toml -o p.csv -n 20 --index o1 --selector exchange --candidates 2000 --no-corners --no-polish \
     --scaling whitened --given g.csv --table --seed 0",
    "paracal select m.toml -o p.csv --require 2um,0.5arcsec --for-diagnosis --conditions c.csv --targets t.csv",
    "paracal select m.toml -o p.csv --selector tabu-detmax --tabu 100 --iterations 400 --quiet",
    "paracal simulate m.toml --poses p.csv -o d.csv --error-sd 0.5mm --effect drift.leg[leg=3]=2e-5 --noise-position 1um \
     --noise-rotation 0.0001deg --seed 0 --truth t.toml --measure contact",
    "paracal calibrate m.toml d.csv -o c.toml --identifier robust --prior auto --weights noise --holdout 0.2 --report r.html \
     --loss huber --solver qr --covariance v.csv",
    "paracal evaluate m.toml d.csv --report r.html",
    "paracal diagnose m.toml d.csv -o e.toml --noise-known --report r.html",
    "paracal settle m.toml d.csv -o x.csv",
    "paracal compensate m.toml p.csv -o l.csv --in-tracker-frame",
    "paracal convert m.urdf -o o.toml --close a=b --base-link base --platform-link top --home slide=3mm --urdf-tolerance 1um",
    "paracal reproduce table1 --out paper --draws 40 --candidates 200 --lists 3",
];

const ODD: [&str; 44] = [
    "",
    " ",
    "-",
    "--",
    "=",
    ",",
    "NaN",
    "nan",
    "inf",
    "-inf",
    "1e400",
    "-1e400",
    "-0",
    "0",
    "-1",
    "1",
    "256",
    "257",
    "65536",
    "4294967296",
    "18446744073709551615",
    "18446744073709551616",
    "1e12",
    "9999999999999999999999999",
    "0x10",
    "1_000",
    "+5",
    "٣",
    "µm",
    "1µm",
    "-1mm",
    "1e400mm",
    "nanmm",
    "1parsec",
    "é\u{301}",
    "\u{0}",
    "\u{feff}x",
    "a\nb",
    "\"'<b>&",
    "--help",
    "--version",
    "-o",
    "all",
    "a=b=c",
];

#[derive(Clone, Debug)]
enum Change {
    Drop(Index),
    Repeat(Index, Index),
    Swap(Index, Index),
    Replace(Index, String),
    Insert(Index, String),
    /// `--option=value`.
    Join(Index),
    Append(Index, String),
    Foreign(Index, Index, usize),
    NotText(Index),
}

fn change() -> impl Strategy<Value = Change> {
    let at = any::<Index>;
    let odd = || {
        prop_oneof![
            8 => select(ODD.to_vec()).prop_map(str::to_owned),
            1 => (1_usize..20_000).prop_map(|n| "y".repeat(n)),
            1 => any::<String>(),
            1 => any::<f64>().prop_map(|v| format!("{v:?}")),
            1 => (any::<f64>(), select(vec!["m", "mm", "um", "deg", "arcsec", "N", "degC"]))
                .prop_map(|(v, unit)| format!("{v:?}{unit}")),
        ]
    };
    prop_oneof![
        2 => at().prop_map(Change::Drop),
        1 => (at(), at()).prop_map(|(a, b)| Change::Repeat(a, b)),
        1 => (at(), at()).prop_map(|(a, b)| Change::Swap(a, b)),
        5 => (at(), odd()).prop_map(|(a, s)| Change::Replace(a, s)),
        1 => (at(), odd()).prop_map(|(a, s)| Change::Insert(a, s)),
        1 => at().prop_map(Change::Join),
        2 => (at(), odd()).prop_map(|(a, s)| Change::Append(a, s)),
        1 => (at(), at(), 0..CALLS.len()).prop_map(|(a, b, call)| Change::Foreign(a, b, call)),
        1 => at().prop_map(Change::NotText),
    ]
}

fn changed(mut words: Vec<OsString>, change: &Change) -> Vec<OsString> {
    // The name of the program stays.
    let n = words.len() - 1;
    let place = |at: &Index| 1 + at.index(n);
    if n == 0 {
        return words;
    }
    match change {
        Change::Drop(at) => drop(words.remove(place(at))),
        Change::Repeat(from, to) => words.insert(place(to), words[place(from)].clone()),
        Change::Swap(a, b) => words.swap(place(a), place(b)),
        Change::Replace(at, with) => words[place(at)] = with.into(),
        Change::Insert(at, word) => words.insert(place(at), word.into()),
        Change::Join(at) => {
            let k = place(at);
            if k < n {
                let value = words.remove(k + 1);
                words[k].push("=");
                words[k].push(value);
            }
        }
        Change::Append(at, more) => words[place(at)].push(more),
        Change::Foreign(at, from, call) => {
            let other: Vec<&str> = CALLS[*call].split_whitespace().collect();
            words.insert(place(at), other[from.index(other.len())].into());
        }
        Change::NotText(at) => {
            #[cfg(unix)]
            {
                use std::os::unix::ffi::OsStringExt;
                words[place(at)] = OsString::from_vec(vec![b'a', 0xff, 0xfe]);
            }
            #[cfg(not(unix))]
            drop(words.remove(place(at)));
        }
    }
    words
}

fn words(call: &str) -> Vec<OsString> {
    call.split_whitespace().map(OsString::from).collect()
}

/// What can be called, built once.
static COMMAND: LazyLock<clap::Command> = LazyLock::new(|| {
    let mut command = Cli::command();
    command.build();
    command
});

/// An empty folder in which the calls are run. It becomes the current one of the whole process: no other test depends
/// on where it runs.
static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    std::env::set_current_dir(folder.path()).unwrap();
    folder
});

fn is_empty(folder: &Path) -> bool {
    std::fs::read_dir(folder).unwrap().next().is_none()
}

#[test]
fn the_calls_are_good_before_they_are_changed() {
    for call in CALLS {
        assert!(Cli::try_parse_from(words(call)).is_ok(), "{call}");
    }
}

/// Numbers that would take all memory or all time are refused by the name of the option, the value and the limit.
#[test]
fn what_would_never_end_is_refused() {
    let folder = FOLDER.path();
    for (call, option, value, limit) in [
        ("select m.toml -o p.csv -n 1001", "-n", "1001", "1000"),
        ("select m.toml -o p.csv --candidates 1000001", "--candidates", "1000001", "1000000"),
        (
            "select m.toml -o p.csv --candidates 99999999999999999999999",
            "--candidates",
            "999999999999999999",
            "1000000",
        ),
        ("select m.toml -o p.csv --tabu 18446744073709551615", "--tabu", "18446744073709551615", "1000000"),
        ("select m.toml -o p.csv --iterations 1000000000000", "--iterations", "1000000000000", "1000000"),
        ("reproduce table1 --out paper --draws 1000000000000", "--draws", "1000000000000", "1000000"),
        ("reproduce table1 --out paper --lists 1001", "--lists", "1001", "1000"),
        ("reproduce all --out paper --candidates 100001", "--candidates", "100001", "100000"),
        ("inspect m.toml --threads 0", "--threads", "0", "1..=256"),
        ("inspect m.toml --threads 257", "--threads", "257", "1..=256"),
    ] {
        let message = match Cli::try_parse_from(words(&format!("paracal {call}"))) {
            Err(error) => error.to_string(),
            Ok(cli) => format!("{:#}", run(&cli).unwrap_err()),
        };
        for part in [option, value, limit] {
            assert!(message.contains(part), "{call}: '{part}' is not in {message}");
        }
    }
    assert!(is_empty(folder));
}

proptest! {
    #![proptest_config(mutations(1))]

    /// A call that can be read has no mechanism file; all that is checked before one is read is checked.
    #[test]
    fn calls(call in select(CALLS.to_vec()), list in prop::collection::vec(change(), 1..5)) {
        let folder = FOLDER.path();
        let call = list.iter().fold(words(call), changed);
        match COMMAND.clone().try_get_matches_from(&call) {
            Err(error) => {
                prop_assert!(!error.to_string().is_empty());
                prop_assert!(matches!(error.exit_code(), 0 | 2));
            }
            Ok(matches) => {
                prop_assert!(matches.get_one::<u16>("threads").is_none_or(|n| (1..=256).contains(n)));
                // It would work for minutes, and makes its folder.
                if matches.subcommand_name() != Some("reproduce") {
                    let refusal = run(&Cli::from_arg_matches(&matches).unwrap());
                    prop_assert!(refusal.is_err_and(|e| e.to_string().len() > 10), "{call:?}");
                }
            }
        }
        prop_assert!(is_empty(folder), "{call:?} wrote something");
    }

    /// Effects of a call, for a machine that is there.
    #[test]
    fn effects(
        good in select(vec![
            "drift.leg[leg=3]=2e-5",
            "step.frame[row=7]=1e-5,0,0,0,0,2e-6",
            "thermal.pose[of=temp_mount]=1e-6,0,0,0,0,2e-6",
            "step.leg[leg=2,row=40]=1e-5",
            "scale.common=1e-4",
        ]),
        list in prop::collection::vec((any::<Index>(), any::<Index>(), "[\\[\\]=,. a-z0-9é-]{0,4}|nan|1e999|18446744073709551616|leg|row|of"), 1..4),
    ) {
        static MACHINE: LazyLock<Machine> = LazyLock::new(|| {
            let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/table5-telescope.toml"));
            Machine::from_text(text, Path::new("m.toml")).unwrap()
        });
        let mut text: Vec<char> = good.chars().collect();
        for (from, to, with) in list {
            let (a, b) = (from.index(text.len() + 1), to.index(text.len() + 1));
            text.splice(a.min(b)..a.max(b).min(a.min(b) + 3), with.chars());
        }
        let text: String = text.into_iter().collect();
        match effect_entry(&text, &MACHINE) {
            Err(error) => prop_assert!(error.to_string().contains("--effect"), "{error}"),
            Ok((entry, active)) => {
                prop_assert!(entry.parameters.values().all(|v| v.is_finite()) && active.values.iter().all(|v| v.is_finite()));
                prop_assert!(active.at.leg.is_none_or(|leg| leg < 6));
            }
        }
    }
}

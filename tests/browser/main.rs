//! The pages as a browser shows them: wide and narrow, light and dark, on screen and on paper.
//!
//! `PARACAL_BROWSER` names the browser (`required`: one on the path, and its absence is an error), `PARACAL_PAGES` a
//! folder with further pages to check, `PARACAL_SCREENSHOTS` a folder for pictures of all that is checked.
#![cfg(unix)]
#![allow(missing_docs, unreachable_pub, clippy::unwrap_used, clippy::expect_used)]

mod broken;
mod devtools;
mod tracker;
mod view;

use std::path::{Path, PathBuf};
use std::process::Command;

use assert_cmd::cargo::cargo_bin;
use devtools::Browser;
use paracal::cli::reproduction::Journal;
use paracal::cli::reproduction::{self, Exhibit, ReproductionContext, Settings, reproduce};
use view::{VIEWS, View};

const LARGEST: u64 = 1_500_000;

/// The pages: name, and the calls that make it, the last one with `--report`. `{out}` is a folder of the test.
const PAGES: [(&str, &[&str]); 10] = [
    ("calibrate", &["calibrate mechanisms/table5.toml examples/data/hardpoint-noisy.csv -o {out}/a.toml"]),
    (
        "calibrate-bad",
        &["calibrate mechanisms/table5.toml examples/data/hardpoint-two-causes.csv -o {out}/b.toml --holdout 0.5"],
    ),
    (
        "calibrate-rotary",
        &[
            "select mechanisms/rotary-stewart.toml -n 30 --candidates 200 --selector random -o {out}/poses.csv",
            "simulate mechanisms/rotary-stewart.toml --poses {out}/poses.csv --error-sd tolerance -o {out}/rotary.csv",
            "calibrate mechanisms/rotary-stewart.toml {out}/rotary.csv -o {out}/c.toml",
        ],
    ),
    ("diagnose", &["diagnose mechanisms/table5-telescope.toml examples/data/hardpoint-two-causes.csv"]),
    ("diagnose-plain", &["diagnose mechanisms/table5.toml examples/data/hardpoint-noisy.csv"]),
    ("evaluate", &["evaluate mechanisms/table5.toml examples/data/hardpoint-targets.csv"]),
    ("select", &["select mechanisms/table5.toml -n 20 --candidates 100 --selector detmax --table -o {out}/table.csv"]),
    ("select-delta", &["select mechanisms/linear-delta.toml -n 10 --candidates 200 -o {out}/delta.csv"]),
    ("reproduce", &["reproduce figure8 --out {out}/paper --draws 40 --lists 3 --candidates 200"]),
    ("evaluate-bad", &["evaluate mechanisms/table5.toml examples/data/hardpoint-two-causes.csv"]),
];

/// Makes a page; a result that must not be trusted (exit code 3) has a page as well.
fn make(name: &str, calls: &[&str], out: &Path) -> PathBuf {
    let page = out.join(format!("{name}.html"));
    for (k, call) in calls.iter().enumerate() {
        let call = call.replace("{out}", out.to_str().unwrap());
        let mut command = Command::new(cargo_bin!("paracal"));
        command.args(call.split(' ')).arg("--quiet").current_dir(env!("CARGO_MANIFEST_DIR"));
        if k + 1 == calls.len() {
            command.arg("--report").arg(&page);
        }
        let output = command.output().unwrap();
        let fine = matches!(output.status.code(), Some(0 | 3));
        assert!(fine, "{call}: {}", String::from_utf8_lossy(&output.stderr));
    }
    page
}

/// The page of the reproduction, with the exhibits that are quick without optimisation.
fn paper(out: &Path) -> PathBuf {
    let settings = Settings { draws: 40, candidates: 200, lists: 3, seed: 0 };
    let journal = Journal::in_memory();
    let context = ReproductionContext::new(settings, &journal, &|_| {}).unwrap();
    let names = ["figure6", "figure7", "figure8", "table8", "figure9"];
    let exhibits: Vec<Exhibit> = names.iter().map(|name| reproduce(name, &context).unwrap()).collect();
    let path = out.join("exhibits.html");
    std::fs::write(&path, reproduction::page(&exhibits, &settings)).unwrap();
    path
}

/// Pages that were made by others.
fn further() -> Vec<PathBuf> {
    let Some(folder) = std::env::var_os("PARACAL_PAGES").filter(|f| !f.is_empty()) else { return Vec::new() };
    let all = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut pages: Vec<PathBuf> = all.filter(|p| p.extension().is_some_and(|e| e == "html")).collect();
    assert!(!pages.is_empty(), "PARACAL_PAGES has no pages");
    pages.sort();
    pages
}

#[test]
fn pages_are_whole_and_legible_in_every_view() {
    let Some(program) = devtools::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let made = PAGES.iter().map(|(name, calls)| make(name, calls, folder.path()));
    let of_tracker = tracker::Pages::make(folder.path());
    let pages = made.chain([paper(folder.path())]).chain(of_tracker.all()).chain(further());
    let pages: Vec<PathBuf> = pages.collect();
    let pictures = std::env::var_os("PARACAL_SCREENSHOTS").filter(|f| !f.is_empty()).map(PathBuf::from);
    let mut browser = Browser::start(&program);
    of_tracker.check(&mut browser);
    let mut faults = Vec::new();
    for page in &pages {
        let name = page.file_stem().unwrap().to_str().unwrap();
        let size = std::fs::metadata(page).unwrap().len();
        if size > LARGEST {
            faults.push(format!("{name}: size: {size} bytes"));
        }
        for view in &VIEWS {
            let own = view.faults(&mut browser, page);
            faults.extend(own.iter().map(|fault| format!("{name}, {}: {fault}", view.name)));
            if let Some(pictures) = &pictures {
                view.picture(&mut browser, pictures, name);
            }
        }
    }
    assert!(faults.is_empty(), "{} faults\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn every_fault_is_found_and_nothing_else() {
    let Some(program) = devtools::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut browser = Browser::start(&program);
    let page = folder.path().join("page.html");
    let mut kinds = |html: &str, view: &View| -> Vec<String> {
        std::fs::write(&page, html).unwrap();
        let faults = view.faults(&mut browser, &page);
        let mut kinds: Vec<String> = faults.iter().map(|f| f.split(':').next().unwrap().to_owned()).collect();
        kinds.dedup();
        kinds
    };
    let mut wrong = Vec::new();
    for (what, html, wanted, shown) in broken::faults() {
        for view in &VIEWS {
            let wanted: &[&str] = if shown(view) { &[wanted] } else { &[] };
            let found = kinds(&html, view);
            if found != wanted {
                wrong.push(format!("{what}, {}: {found:?}, not {wanted:?}", view.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

//! Runs that are killed, that run beside each other, on one thread and on two, and names that are no names.
//!
//! `PARACAL_KILLS=500 cargo test --test it robustness` kills each command that often instead of 24 times.

use std::fs;
use std::path::PathBuf;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant, SystemTime};

use crate::common::bench::{Bench, Listing, NOISY, TABLE_5, listing};
use crate::common::text;

/// Content of every output before a run that is killed.
const OLD: &[u8] = b"what was here before\n";

/// A folder with the files that the calls below name.
fn bench() -> Bench {
    let rows = |n: usize, skip: usize| -> String {
        NOISY.lines().take(n).map(|l| l.split(',').skip(skip).collect::<Vec<_>>().join(",") + "\n").collect()
    };
    Bench::bundled()
        .with("w.toml", text("mechanisms/table5-telescope.toml"))
        .with("w.csv", text("examples/data/hardpoint-two-causes.csv"))
        .with("p.csv", rows(21, 6))
        .with("few.csv", rows(4, 6))
}

fn started(bench: &Bench, call: &str) -> Child {
    bench.command(call).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

fn temporary_files(bench: &Bench) -> Vec<PathBuf> {
    let names = bench.listing().into_keys();
    names.filter(|n| n.starts_with(".paracal-") && n.ends_with(".part")).map(|n| bench.at(&n)).collect()
}

/// How often each command is killed.
fn kills() -> u32 {
    std::env::var("PARACAL_KILLS").map_or(24, |n| n.parse().unwrap())
}

/// Kills a process after a part of the time that a whole run takes, or as soon as it writes.
fn kill(bench: &Bench, mut child: Child, k: u32, whole: Duration) {
    if k.is_multiple_of(2) {
        std::thread::sleep(whole.mul_f64(1.1 * f64::from(k) / f64::from(kills())));
    } else {
        let before = temporary_files(bench).len();
        while child.try_wait().unwrap().is_none() && temporary_files(bench).len() == before {}
    }
    // It may be done already.
    let _ = child.kill();
    child.wait().unwrap();
}

#[test]
fn a_run_that_is_killed_leaves_the_old_or_the_new_file() {
    for (call, outputs) in [
        ("calibrate m.toml d.csv -o o.toml --report r.html --covariance v.csv", &["o.toml", "r.html", "v.csv"][..]),
        ("select m.toml -o o.csv -n 8 --candidates 40 --no-polish --no-corners", &["o.csv"]),
        ("simulate m.toml --poses p.csv -o o.csv --truth t.toml --error-sd 0.1mm", &["o.csv", "t.toml"]),
        ("compensate m.toml p.csv -o o.csv", &["o.csv"]),
        ("convert m.toml -o o.toml", &["o.toml"]),
        ("evaluate m.toml d.csv --report r.html", &["r.html"]),
        ("diagnose m.toml d.csv -o o.toml --report r.html", &["o.toml", "r.html"]),
    ] {
        let bench = bench();
        let inputs = bench.listing();
        let start = Instant::now();
        bench.done(call);
        let whole = start.elapsed();
        let new: Listing = bench.listing().into_iter().filter(|(n, _)| outputs.contains(&n.as_str())).collect();
        assert_eq!(new.len(), outputs.len(), "{call}");
        for k in 0..kills() {
            // Every third time nothing was there before.
            for name in outputs {
                let _ = fs::remove_file(bench.at(name));
                if k % 3 > 0 {
                    bench.write(name, OLD);
                }
            }
            kill(&bench, started(&bench, call), k, whole);
            for (name, content) in bench.listing() {
                if let Some(whole) = new.get(&name) {
                    let old = k % 3 > 0 && content == OLD;
                    assert!(old || content == *whole, "{call}: {name} is neither old nor new after kill {k}");
                } else if let Some(input) = inputs.get(&name) {
                    assert!(content == *input, "{call}: {name} has changed");
                } else {
                    assert!(name.starts_with(".paracal-") && name.ends_with(".part"), "{call}: {name}");
                }
            }
        }
        // Files that killed runs left behind disturb no later run, and an hour later the next one removes them.
        let long_ago = SystemTime::now() - Duration::from_secs(4000);
        let left = temporary_files(&bench);
        println!("{call}: {} temporary files left by {} kills", left.len(), kills());
        bench.write(".paracal-0-0.part", "of a process that never was");
        for path in left.iter().chain(&temporary_files(&bench)) {
            fs::File::options().write(true).open(path).unwrap().set_modified(long_ago).unwrap();
        }
        bench.done(call);
        let mut expected = inputs.clone();
        expected.extend(new);
        assert!(bench.listing() == expected, "{call}");
    }
}

/// Settings under which an exhibit takes a moment.
const LITTLE: &str = "--draws 40 --lists 3 --candidates 200";

#[test]
fn a_reproduction_that_is_killed_goes_on_to_the_same_files() {
    let bench = bench();
    let start = Instant::now();
    bench.done(&format!("reproduce figure9 --out lone {LITTLE}"));
    let (whole, lone) = (start.elapsed(), listing(&bench.at("lone")));
    assert!(lone.contains_key("figure9.csv"));
    let call = format!("reproduce figure9 --out killed {LITTLE}");
    for k in 0..kills().div_ceil(4) {
        let mut child = started(&bench, &call);
        std::thread::sleep(whole.mul_f64(f64::from(k + 1) / f64::from(kills().div_ceil(4) + 2)));
        let _ = child.kill();
        child.wait().unwrap();
        for (name, content) in listing(&bench.at("killed")) {
            let passing = name.ends_with(".journal") || name.ends_with(".part");
            assert!(passing || lone.get(&name) == Some(&content), "{name} after kill {k}");
        }
    }
    bench.done(&call);
    let done = listing(&bench.at("killed")).into_iter().filter(|(name, _)| !name.ends_with(".part"));
    assert!(done.collect::<Listing>() == lone);
}

#[test]
fn ten_runs_beside_each_other_do_not_disturb_each_other() {
    for (call, ending) in [
        ("calibrate m.toml d.csv -o", "toml"),
        ("select m.toml -n 8 --candidates 40 --no-polish --no-corners -o", "csv"),
        ("simulate m.toml --poses p.csv --error-sd 0.1mm -o", "csv"),
        ("compensate m.toml p.csv -o", "csv"),
        ("convert m.toml -o", "urdf"),
        ("diagnose m.toml d.csv -o", "toml"),
    ] {
        let bench = bench();
        let mut expected = bench.listing();
        bench.done(&format!("{call} lone.{ending}"));
        let lone = fs::read(bench.at(&format!("lone.{ending}"))).unwrap();
        let side = fs::read(bench.at("lone.toml")).ok().filter(|_| ending == "urdf");
        let names: Vec<String> = (0..10).map(|k| if k < 5 { "same".into() } else { format!("own{k}") }).collect();
        let children: Vec<Child> =
            names.iter().map(|name| started(&bench, &format!("{call} {name}.{ending}"))).collect();
        for mut child in children {
            assert_eq!(child.wait().unwrap().code(), Some(0), "{call}");
        }
        for name in names.iter().chain([&"lone".to_owned()]) {
            expected.insert(format!("{name}.{ending}"), lone.clone());
            if let Some(side) = &side {
                expected.insert(format!("{name}.toml"), side.clone());
            }
        }
        let found = bench.listing();
        assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>(), "{call}");
        let torn: Vec<&String> = found.keys().filter(|name| found[*name] != expected[*name]).collect();
        assert!(torn.is_empty(), "{call}: {torn:?}");
    }
}

#[test]
fn reproductions_into_one_folder_do_not_disturb_each_other() {
    let bench = bench();
    let calls = ["figure8", "figure9", "figure6"].map(|name| format!("reproduce {name} {LITTLE} --out"));
    calls.iter().for_each(|call| drop(bench.done(&format!("{call} lone"))));
    let children: Vec<Child> = (0..10).map(|k| started(&bench, &format!("{} together", calls[k % 3]))).collect();
    for mut child in children {
        assert_eq!(child.wait().unwrap().code(), Some(0));
    }
    // Neither a journal nor a temporary file is left.
    let (lone, together) = (listing(&bench.at("lone")), listing(&bench.at("together")));
    assert_eq!(together.keys().collect::<Vec<_>>(), lone.keys().collect::<Vec<_>>());
    assert!(together == lone);
}

/// What a run printed and wrote, without the time that it took and without the call itself.
fn traces(bench: &Bench, call: &str, threads: &str) -> (String, Listing) {
    let out = bench.at("out");
    let _ = fs::remove_dir_all(&out);
    fs::create_dir(&out).unwrap();
    let output = bench.run(&format!("{call} --threads {threads}"));
    assert!(matches!(output.status.code(), Some(0 | 3)), "{call}: {}", String::from_utf8_lossy(&output.stderr));
    let mut shown = String::from_utf8(output.stdout).unwrap();
    if let Ok(mut object) = serde_json::from_str::<serde_json::Value>(&shown) {
        if let Some(object) = object.as_object_mut() {
            object.remove("seconds");
        }
        shown = object.to_string();
    }
    let timeless: Vec<&str> = shown.lines().filter(|l| !(l.contains("written to") && l.contains(" s"))).collect();
    let mut files = listing(&out);
    for (_, content) in files.iter_mut().filter(|(name, _)| name.ends_with(".html")) {
        let page = String::from_utf8(std::mem::take(content)).unwrap();
        *content = page.replace(&format!("--threads {threads}"), "--threads").into_bytes();
    }
    let shown = format!("{}\n{}", timeless.join("\n"), String::from_utf8(output.stderr).unwrap());
    (shown, files)
}

#[test]
fn one_thread_and_two_give_the_same_bytes() {
    let bench = bench();
    let small = "-n 8 --candidates 40 --no-corners -o out/p.csv";
    let mut calls: Vec<(String, usize)> = [
        ("inspect m.toml", 0),
        ("simulate w.toml --poses p.csv --error-sd 0.5mm -o out/d.csv --truth out/t.toml", 2),
        ("calibrate m.toml d.csv -o out/c.toml --report out/r.html --covariance out/v.csv", 3),
        ("calibrate m.toml d.csv -o out/c.toml --identifier robust --holdout 0.2", 1),
        ("calibrate m.toml d.csv -o out/c.toml --identifier least-squares --weights none --prior none", 1),
        ("evaluate m.toml d.csv --report out/r.html", 1),
        ("diagnose w.toml w.csv -o out/e.toml --report out/r.html", 2),
        ("settle w.toml w.csv", 0),
        ("compensate m.toml p.csv -o out/l.csv", 1),
        ("convert m.toml -o out/o.urdf", 2),
        ("select m.toml --require 20um --candidates 40 --no-corners --no-polish -o out/p.csv", 1),
        ("select m.toml -n 12 --candidates 60 --no-corners --table --given few.csv --for-diagnosis -o out/p.csv", 1),
        ("select m.toml -n 8 --candidates p.csv --targets few.csv --index pose-error -o out/p.csv", 1),
    ]
    .map(|(call, files)| (call.to_owned(), files))
    .into();
    for selector in ["random", "detmax", "tabu-detmax", "exchange"] {
        calls.push((format!("select m.toml {small} --selector {selector} --seed 3"), 1));
    }
    for index in ["o1", "o2", "o3", "o4", "o5", "pose-error"] {
        calls.push((format!("select m.toml {small} --index {index}"), 1));
    }
    for exhibit in ["figure6", "figure8", "figure9"] {
        calls.push((format!("reproduce {exhibit} {LITTLE} --out out"), 3));
    }
    for (call, files) in calls {
        // The JSON of the dear ones says what their text says.
        let dear = call.starts_with("select") || call.starts_with("reproduce");
        for call in [Some(call.clone()), (!dear).then(|| format!("{call} --json"))].into_iter().flatten() {
            let (one, two) = (traces(&bench, &call, "1"), traces(&bench, &call, "2"));
            assert_eq!(one.0, two.0, "{call}");
            assert!(one.1.len() >= files, "{call}: {:?}", one.1.keys());
            let other: Vec<&String> = one.1.keys().filter(|name| one.1.get(*name) != two.1.get(*name)).collect();
            assert!(other.is_empty() && one.1.len() == two.1.len(), "{call}: {other:?}");
        }
    }
}

/// A name that means something to HTML, SVG, TOML and CSV.
const STRANGE: &str = "<script>alert(1)</script>&\"'\u{1f980},\t]]>";

#[test]
fn strange_names_are_escaped_wherever_they_are_written() {
    let bench = bench();
    let plain = text("mechanisms/table5-telescope.toml");
    let (first, rest) = plain.split_once("name = ").unwrap();
    let (_, rest) = rest.split_once('\n').unwrap();
    let name = serde_json::to_string(STRANGE).unwrap();
    bench.write("<b>.toml", format!("{first}name = {name}\n{rest}"));
    let data = text("examples/data/hardpoint-two-causes.csv");
    let quoted = STRANGE.replace('"', "\"\"");
    let mut header = true;
    let line = |(k, line): (usize, &str)| match line {
        l if l.starts_with('#') => format!("{l}\n"),
        l if std::mem::take(&mut header) => format!("id,{l},\"{quoted}\"\n"),
        l => format!("\"{quoted}\",{l},{}\n", (k * k) % 7),
    };
    bench.write("<i>.csv", data.lines().enumerate().map(line).collect::<String>());
    for call in [
        "diagnose <b>.toml <i>.csv -o o.toml --report r.html",
        "calibrate <b>.toml <i>.csv -o o.toml --report r.html",
        "evaluate <b>.toml <i>.csv --report r.html",
    ] {
        let output = bench.run(call);
        assert!(matches!(output.status.code(), Some(0 | 3)), "{call}: {}", String::from_utf8_lossy(&output.stderr));
        let page = bench.text("r.html");
        assert!(page.contains("&lt;script&gt;") && page.contains("&lt;b&gt;.toml"), "{call}");
        for raw in ["<script", "<b>", "<i>"] {
            assert!(!page.contains(raw), "{call}: {raw} is not escaped");
        }
    }
    // What was written can be read, and has the same name.
    let seen = bench.json("convert o.toml -o again.toml");
    assert_eq!(seen["name"], STRANGE);
    // Two of the measured poses are outside the workspace.
    bench.exits(3, "compensate <b>.toml <i>.csv -o l.csv");
    bench.exits(3, "compensate o.toml l.csv -o again.csv --quiet --force");
    // As a label of each row, as a column, and in the remark above.
    let table = bench.text("l.csv");
    let rows = data.lines().filter(|l| !l.starts_with('#')).count() - 1;
    assert_eq!(table.matches("<script>").count(), rows + 2);
}

/// Refused in one line.
#[track_caller]
fn refused(bench: &Bench, call: &str, parts: &[&str]) {
    let message = bench.refuses(call, parts);
    assert_eq!(message.trim_end().lines().count(), 1, "{call}: {message}");
}

#[test]
fn as_many_rows_as_nobody_measures() {
    let bench = bench();
    let (header, rows) = NOISY.split_once('\n').unwrap();
    bench.write("many.csv", format!("{header}\n{}", rows.repeat(501)));
    for command in ["diagnose", "settle"] {
        refused(
            &bench,
            &format!("{command} m.toml many.csv --quiet"),
            &["many.csv", "10020 samples", "at most 10000", "parts"],
        );
    }
    bench.done("evaluate m.toml many.csv");
    bench.done("compensate m.toml many.csv -o l.csv");
}

#[cfg(target_os = "linux")]
#[test]
fn places_where_nothing_can_be_written() {
    let bench = bench();
    for call in ["compensate m.toml p.csv -o", "calibrate m.toml d.csv -o", "calibrate m.toml d.csv -o o.toml --report"]
    {
        refused(&bench, &format!("{call} /proc/o.toml"), &["/proc/o.toml", "cannot be written", "nothing was written"]);
        refused(&bench, &format!("{call} /dev/full"), &["/dev/full", "cannot be written", "nothing was written"]);
    }
    // A table may go down a pipe; what is said of it follows.
    let shown = bench.done("compensate m.toml few.csv -o /dev/stdout").out;
    assert!(shown.starts_with("leg1_mm,") && shown.contains("3 poses: lengths to command"), "{shown}");
}

/// Numbers whose products overflow came back as a decomposition that never ended.
#[test]
fn numbers_beyond_any_machine() {
    let bench = bench();
    for (from, to, place) in [
        ("anchor = 0.5", "anchor = 1e300", "[tolerance] anchor"),
        ("anchor = 0.5", "anchor = 1e-300", "[tolerance] anchor"),
        ("position = 0.001", "position = 1e-150", "[noise] position"),
        ("rotation = 0.0001", "rotation = 1e31", "[noise] rotation"),
        ("length = 800.0", "length = 1e31", "leg 1, `length`"),
        ("[1299.170, -348.112, 0.0]", "[1299.170, -1e200, 0.0]", "leg 1, `platform`"),
    ] {
        assert!(TABLE_5.contains(from), "{from}");
        bench.write("x.toml", TABLE_5.replacen(from, to, 1));
        refused(&bench, "inspect x.toml", &["x.toml", place, "e", "correct the number"]);
    }
    let first = NOISY.lines().nth(1).unwrap().split(',').next().unwrap();
    bench.write("x.csv", NOISY.replacen(first, "1e200", 1));
    refused(
        &bench,
        "evaluate m.toml x.csv",
        &["x.csv", "data row 0 (line 2)", "'leg1_mm'", "'1e200'", "too far from zero"],
    );
}

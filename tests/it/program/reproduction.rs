//! The reproduction of Yu, Wu, Wang 2023 against numbers of an independent reproduction (numpy, linear propagation), and
//! what a user may rely on: the same bytes after a stop and on any number of threads.

use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::common;
use crate::common::bench::{Bench, listing};
use paracal::cli::reproduction::{
    Agreement, Comparison, EXHIBITS, Exhibit, Journal, ReproductionContext, Settings, page, paper, reproduce,
};

/// Few draws: enough for the claims that are tested here.
const QUICK: Settings = Settings { draws: 100, candidates: 2000, lists: 3, seed: 0 };

fn exhibit(name: &str, settings: Settings) -> Exhibit {
    let journal = Journal::in_memory();
    let context = ReproductionContext::new(settings, &journal, &|_| {}).unwrap();
    reproduce(name, &context).unwrap()
}

fn row<'a>(exhibit: &'a Exhibit, quantity: &str) -> &'a Comparison {
    let named = |c: &&Comparison| c.quantity == quantity;
    exhibit.comparisons.iter().find(named).unwrap_or_else(|| panic!("{quantity}: {:#?}", exhibit.comparisons))
}

/// A column of a table of an exhibit as numbers, rows by their first cells.
fn cell(exhibit: &Exhibit, stem: &str, words: &[&str], column: &str) -> f64 {
    let table = &exhibit.listings.iter().find(|l| l.stem == stem).unwrap().table;
    let k = table.header.iter().position(|h| h == column).unwrap();
    let of = |r: &&Vec<String>| words.iter().zip(r.iter()).all(|(w, c)| w == c);
    table.rows.iter().find(of).unwrap_or_else(|| panic!("{words:?}"))[k].parse().unwrap()
}

#[test]
fn the_search_takes_as_long_as_in_the_paper_and_random_sets_are_as_there() {
    let search = exhibit("figure6", Settings { lists: 4, ..QUICK });
    // Independent: 0.0345 ± 0.0010 (2000 candidates), 90 to 234 iterations of six starts, 19 to 25 for DETMAX.
    assert!((row(&search, "O1 of the chosen set, tabu DETMAX").ours.mean - 0.0349).abs() < 0.0010);
    let iterations = row(&search, "iterations to the end, DETMAX").ours.mean;
    assert!((17.0..29.0).contains(&iterations), "{iterations}");
    let random = exhibit("figure7", QUICK);
    // Independent: 0.0172 ± 0.0002 and 0.0218 ± 0.0006.
    assert!((row(&random, "mean O1 of 1000 random sets of 20 poses").ours.mean - 0.0172).abs() < 0.0003);
    assert!((row(&random, "largest O1 of 1000 random sets").ours.mean - 0.0218).abs() < 0.0008);
    assert_eq!(random.count(Agreement::NotReproduced), 0);
}

#[test]
fn the_iteration_converges_in_three_steps_and_table_7_is_transposed() {
    let found = exhibit("figure8", QUICK);
    let error = |k: u32| row(&found, &format!("largest error without noise after iteration {k}")).ours.mean;
    // Independent: 0.32, 1.9e-3, 3.4e-8 mm for another set of poses.
    assert!(error(1) > 0.05 && error(1) < 1.0 && error(3) < 1e-7, "{} {}", error(1), error(3));
    assert!(error(2) < 1e-2 && error(2) > error(3));
    let worst = row(&found, "largest |Table 7 - Table 6| over its predicted standard deviation").ours.mean;
    assert!(worst < 3.0, "{worst}");
    // Independent: 35 of 36.
    assert_eq!(row(&found, "entries of Table 7 that round to Table 6, of 36").ours.mean, 35.0);
    // Predicted standard deviations of the unweighted estimator, rms over the legs, mm; those of another set of poses
    // differ by a tenth.
    for (name, sigma) in
        [("xA", 0.034), ("yA", 0.035), ("zA", 0.013), ("xB", 0.036), ("yB", 0.037), ("zB", 0.015), ("h", 0.022)]
    {
        let ours = row(&found, &format!("error of the identified {name}, root mean square of six")).ours.mean;
        assert!((ours / sigma - 1.0).abs() < 0.2, "{name}: {ours} mm");
    }
    assert!(found.findings.iter().any(|f| f.contains("0.0243 mm transposed")), "{:?}", found.findings);
    // Independent: 1.57 mm and 0.128 degrees, before 0.73 mm and 0.094 degrees.
    let printed = found.findings.iter().find(|f| f.starts_with("Taken as printed")).unwrap();
    let numbers: Vec<f64> = printed.split_whitespace().filter_map(|w| w.parse().ok()).collect();
    for (found, expected) in numbers.iter().zip([7.0, 1.57, 0.128, 150.0, 0.73, 0.094]) {
        assert!((found / expected - 1.0).abs() < 0.1, "{printed}");
    }
}

#[test]
fn errors_at_targets_lie_where_the_independent_reproduction_has_them() {
    let found = exhibit("table8", Settings { draws: 200, ..QUICK });
    let mean = |way: &str, what: &str| row(&found, &format!("{way}: {what}")).ours.mean;
    // Independent: mean over noise draws, O1: 0.0025 and 0.00111 mm, 0.00066 and 0.00033 degrees; σ of one draw 20 to 55 %.
    for (what, expected) in [
        ("position, maximum", 0.0025),
        ("position, mean", 0.00111),
        ("attitude, maximum", 0.00066),
        ("attitude, mean", 0.00033),
    ] {
        let ours = mean("with O1", what);
        assert!((ours / expected - 1.0).abs() < 0.15, "{what}: {ours}");
    }
    // "In the middle of our distribution": attitude between the quartiles, position low but not impossible.
    let percentile = |what: &str| cell(&found, "table8", &["with O1", what], "percentile");
    assert!(
        (20.0..80.0).contains(&percentile("attitude, mean")) && (20.0..80.0).contains(&percentile("attitude, maximum"))
    );
    assert!(percentile("position, mean") < 15.0 && percentile("position, maximum") < 5.0);
    // 78.4 and 70.6 % are of the maxima.
    let stated = |what: &str| row(&found, &format!("reduction, {what}")).paper.unwrap();
    assert!((stated("position, maximum") - 78.4).abs() < 0.05 && (stated("attitude, maximum") - 70.6).abs() < 0.05);
    assert!((stated("position, mean") - 45.9).abs() < 0.05 && (stated("attitude, mean") - 68.8).abs() < 0.05);
    // Cramér–Rao bound for these poses: 0.00086 mm and 0.000062 degrees.
    assert!((mean("with O1, weighted rows", "position, mean") / 0.00086 - 1.0).abs() < 0.1);
    assert!((mean("with O1, weighted rows", "attitude, mean") / 0.000062 - 1.0).abs() < 0.1);
}

/// The output of a run with the default settings, which the documentation quotes.
fn documented(stem: &str) -> Vec<Vec<String>> {
    let text = common::text(&format!("docs/paper/{stem}.csv"));
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).has_headers(false).from_reader(text.as_bytes());
    reader.records().map(|r| r.unwrap().iter().map(String::from).collect()).collect()
}

#[test]
fn the_documented_table_4_agrees_with_the_independent_reproduction() {
    // Mean over six lists of 2000 candidates and 4000 noise draws, and its standard error, by linear propagation.
    let independent: [[(f64, f64); 5]; 4] = [
        [(0.00634, 7e-5), (0.0122, 1.2e-3), (0.0123, 1.2e-3), (0.0136, 1.5e-3), (0.0129, 9e-4)],
        [(0.1411, 4e-3), (0.286, 0.016), (0.206, 0.011), (0.299, 0.021), (0.1310, 2e-3)],
        [(0.0178, 3e-4), (0.0356, 1.7e-3), (0.0226, 6e-4), (0.0325, 8e-4), (0.0170, 2e-4)],
        [(0.1438, 1.6e-3), (0.277, 7e-3), (0.172, 5e-3), (0.249, 5e-3), (0.1368, 1.4e-3)],
    ];
    let rows = documented("table4");
    let column = |name: &str| rows[0].iter().position(|h| h == name).unwrap();
    let (ours, error) = (column("ours"), column("standard_error"));
    let of = |condition: &str, index: &str| {
        let row = rows.iter().find(|r| r[0] == condition && r[2] == index).unwrap();
        (row[ours].parse::<f64>().unwrap(), row[error].parse::<f64>().unwrap())
    };
    for (condition, expected) in paper::CONDITIONS.iter().zip(independent) {
        for (k, (mean, standard)) in expected.into_iter().enumerate() {
            let (found, own) = of(condition.name, &format!("o{}", k + 1));
            let distance = (found - mean).abs() / standard.hypot(own);
            assert!(distance < 3.0, "{} O{}: {found} against {mean}, {distance:.1} errors", condition.name, k + 1);
        }
        // "Halves to quarters the error of a random set", and the improved procedure is better still.
        let (o1, random, improved) =
            (of(condition.name, "o1").0, of(condition.name, "random").0, of(condition.name, "improved").0);
        assert!(o1 < 0.6 * random && improved < 0.75 * o1, "{}", condition.name);
    }
}

#[test]
fn the_documented_texts_are_what_the_program_says() {
    let settings = Settings::default();
    assert_eq!(exhibit("figure7", settings).text(&settings), common::text("docs/paper/figure7.txt"));
}

#[test]
fn few_poses_and_weights_are_as_in_the_independent_reproduction() {
    let settings = Settings { draws: 60, candidates: 300, ..QUICK };
    let found = exhibit("figure10", settings);
    let error = |n: &str, way: &str| cell(&found, "figure10", &[n, way], "error");
    // Independent, medians of random sets: .0104, .0157 for 10, 12 poses; .00142 for 50; weighted .00183 for 20.
    for (n, way, expected) in [
        ("12", "random", 0.0157),
        ("50", "random", 0.00142),
        ("20", "random, weighted rows", 0.00183),
        ("20", "random", 0.0038),
    ] {
        assert!((error(n, way) / expected - 1.0).abs() < 0.25, "{n} {way}: {}", error(n, way));
    }
    assert!(error("12", "random") > error("10", "random"), "more poses and unweighted rows");
    assert!(error("12", "random, weighted rows") < error("10", "random, weighted rows"));
    // The improved procedure: at most 0.65 of the paper's.
    let ratio = error("20", "improved poses, weighted rows") / error("20", "O1");
    assert!(ratio < 0.65, "{ratio}");
    let small =
        |space: &str, estimator: &str| cell(&found, "figure10-small-stroke", &[space, estimator], "parameter_error_mm");
    // h and the components along a leg are of second order in the workspace: parameters are lost, poses are not.
    assert!(small("10 mm, 0.5 deg", "weighted") > 100.0 * small("100 mm, 10 deg", "weighted"));
    assert!(small("10 mm, 0.5 deg", "weighted, tolerance as prior") < 0.5);
}

#[test]
fn exhibits_have_numbers_pictures_and_words() {
    let settings = Settings { draws: 40, candidates: 200, lists: 3, seed: 3 };
    let journal = Journal::in_memory();
    let context = ReproductionContext::new(settings, &journal, &|_| {}).unwrap();
    // Those of Table 4 take long without optimisation.
    let names = ["figure6", "figure7", "figure8", "table8", "figure9"];
    let all: Vec<Exhibit> = names.iter().map(|name| reproduce(name, &context).unwrap()).collect();
    for e in &all {
        assert!(
            !e.comparisons.is_empty() && !e.findings.is_empty() && !e.listings[0].table.rows.is_empty(),
            "{}",
            e.name
        );
        assert_eq!(e.listings[0].stem, e.name);
        assert!(e.comparisons.iter().all(|c| c.ours.mean.is_finite()), "{:#?}", e.comparisons);
        let svg = e.figure.svg();
        assert!(svg.starts_with("<svg") && svg.contains("<title") && !svg.contains("NaN"), "{}", e.name);
        let text = e.text(&settings);
        assert!(text.ends_with(&format!("{}\n", e.summary())) && text.contains("seed 3"), "{text}");
    }
    let page = page(&all, &settings);
    assert!(names.iter().all(|name| page.contains(&format!("id=\"{name}\""))));
    assert!(!page.contains("<script") && !page.contains("src=") && page.len() < 1_500_000);
}

#[test]
fn printed_tables_agree_with_the_bundled_files() {
    let machine = common::machine("table5");
    let file = common::table_6(machine.mechanism.as_ref());
    for (a, b) in file.iter().zip(paper::in_order(&paper::TABLE_6)) {
        assert!((1e3 * a - b).abs() < 1e-12);
    }
    // Table 7's seventh column repeats the first, which is how one sees that it is transposed.
    assert!(paper::TABLE_7.iter().all(|r| r[0] == r[6]));
}

#[test]
fn wrong_settings_are_refused_with_the_number() {
    let journal = Journal::in_memory();
    for (settings, what) in [
        (Settings { draws: 10, ..QUICK }, "number of draws is 10"),
        (Settings { candidates: 50, ..QUICK }, "number of candidates is 50"),
        (Settings { lists: 2, ..QUICK }, "number of lists is 2; it must be from 3 to 1000"),
        (Settings { draws: u64::MAX, ..QUICK }, "number of draws is 18446744073709551615"),
        (Settings { candidates: usize::MAX, ..QUICK }, "it must be from 200 to 100000"),
    ] {
        let error = ReproductionContext::new(settings, &journal, &|_| {}).err().unwrap().to_string();
        assert!(error.contains(what), "{error}");
    }
    let context = ReproductionContext::new(QUICK, &journal, &|_| {}).unwrap();
    let error = reproduce("table3", &context).unwrap_err().to_string();
    assert!(EXHIBITS.iter().all(|name| error.contains(name)), "{error}");
}

/// An exhibit of several parts, with few draws.
const TABLE_8: &str = "reproduce table8 --draws 40 --lists 3 --candidates 300 --quiet";

#[test]
fn a_run_that_is_killed_goes_on_to_the_same_bytes_on_any_number_of_threads() {
    let bench = Bench::empty();
    let files = |folder: &str| listing(&bench.at(folder));
    let start = Instant::now();
    bench.done(&format!("{TABLE_8} --out whole --threads 2"));
    let lasted = start.elapsed();
    assert_eq!(files("whole").into_keys().collect::<Vec<_>>(), ["table8.csv", "table8.svg", "table8.txt"]);
    // Kill at several places, going on each time; the journal keeps what was done.
    let go_on = format!("{TABLE_8} --out killed --threads 1");
    let mut kept = 0;
    for _ in 0..4 {
        let mut run = bench.command(&go_on).stdout(Stdio::null()).spawn().unwrap();
        std::thread::sleep((lasted / 4).max(Duration::from_millis(20)));
        run.kill().unwrap();
        run.wait().unwrap();
        kept += usize::from(files("killed").keys().any(|name| name.starts_with("unfinished-table8-40-300-3-0")));
    }
    assert!(kept > 0, "no run was stopped in the middle");
    bench.done(&go_on);
    assert!(files("killed") == files("whole"));
}

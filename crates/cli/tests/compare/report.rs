//! The HTML report and the charts.

use std::collections::BTreeSet;
use std::fs;

use serde_json::Value;

use crate::harness::Home;

/// Returns the numbers that a page shows for a key, in order.
fn numbers(page: &str, key: &str) -> Vec<f64> {
    let start = format!("<data class=\"{key}\" value=\"");
    let number = |rest: &str| rest.split('"').next().unwrap().parse().unwrap();
    page.split(&start).skip(1).map(number).collect()
}

/// Returns the numbers of the JSON reports for a key, in the order of the page: by measure, then the
/// distributions before the differences, then by mouse.
fn expected(reports: &[Value], key: &str) -> Vec<f64> {
    let mut numbers = Vec::new();
    for measure in MEASURES {
        for group in ["distribution", "difference"] {
            let statistics = reports.iter().map(|report| &report["statistics"][measure][group]);
            numbers.extend(statistics.filter_map(|statistics| statistics[key].as_f64()));
        }
    }
    numbers
}

const MEASURES: [&str; 12] = [
    "total_time_s",
    "search_time_s",
    "fast_run_time_s",
    "fast_run_loss_percent",
    "known_run_time_s",
    "steps_to_goal",
    "search_steps",
    "search_turns",
    "path_found",
    "steps_until_proven",
    "fast_run_steps",
    "processor_time_us",
];

#[test]
fn the_report_shows_the_numbers_of_the_json() {
    let home = Home::new();
    let arguments =
        ["compare", "--strategies", "flood-fill,left-wall,swing", "--json", "--jobs", "1"];
    let ended = home.run(&[&arguments[..], &["--html", "report.html"]].concat());
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    let page = fs::read_to_string(home.path().join("report.html")).unwrap();
    let reports = ended.json();
    for key in [
        "mean",
        "median",
        "lower_quartile",
        "upper_quartile",
        "standard_deviation",
        "minimum",
        "maximum",
        "better",
        "equal",
        "worse",
    ] {
        let (shown, expected) = (numbers(&page, key), expected(reports.as_array().unwrap(), key));
        assert!(
            !shown.is_empty() && shown.len() == expected.len(),
            "{key}: {shown:?} {expected:?}"
        );
        for (shown, expected) in shown.iter().zip(expected) {
            assert!((shown - expected).abs() < 1e-9, "{key}: {shown} instead of {expected}");
        }
    }
    for text in ["<td>18/18</td>", "loops over 139 cells, (0, 1) to (13, 8)", "01-harbour", "<svg"]
    {
        assert!(page.contains(text), "{text}");
    }
    for absent in ["<script", "http://", "https://"] {
        let found = page.replace("http://www.w3.org/2000/svg", "").contains(absent);
        assert!(!found, "{absent}");
    }
}

#[test]
fn a_chart_is_written_for_each_measure() {
    let home = Home::new();
    let arguments = ["compare", "harbour", "hedgerow", "--strategies", "flood-fill,swing"];
    let ended = home.run(&[&arguments[..], &["--charts", "new/charts"]].concat());
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    let files = fs::read_dir(home.path().join("new/charts")).unwrap();
    let names: BTreeSet<String> =
        files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    assert_eq!(names, MEASURES.map(|name| format!("{name}-distribution.svg")).into());
    home.write("file", "");
    for option in ["--charts", "--html"] {
        let ended = home.run(&[&arguments[..], &[option, "file/x"]].concat());
        assert_eq!(ended.code, Some(1));
        assert!(ended.stderr.starts_with("mmsim: cannot "), "{ended:?}");
    }
}

#[test]
fn the_report_on_a_trial_compares_all_robots() {
    let home = Home::new();
    let arguments = ["trial", "first steps", "hedgerow", "--compare", "--json"];
    let ended =
        home.run(&[&arguments[..], &["--html", "trial.html", "--charts", "charts"]].concat());
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    let page = fs::read_to_string(home.path().join("trial.html")).unwrap();
    let rows = ended.json();
    let rows = rows.as_array().unwrap().iter().filter(|row| row["table"] == "robots");
    let scores: Vec<f64> = rows.clone().filter_map(|row| row["score"].as_f64()).collect();
    let shown = numbers(&page, "minimum");
    let smallest = scores.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(shown.iter().any(|number| (number - smallest).abs() < 0.0005), "{smallest}: {shown:?}");
    for row in rows {
        assert!(page.contains(row["mouse"].as_str().unwrap()));
    }
    assert!(home.path().join("charts/score-distribution.svg").exists());
}

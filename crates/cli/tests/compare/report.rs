//! The HTML report and the charts.

use std::collections::BTreeSet;
use std::fs;

use serde_json::Value;

use crate::harness::Home;

/// Returns the cells of the row of a mouse in the table of each measure, in the order of the page.
fn rows<'a>(page: &'a str, mouse: &str) -> Vec<Vec<&'a str>> {
    let start = format!("<tr><th>{mouse}</th><td>");
    let cells = |section: &'a str| -> Option<Vec<&'a str>> {
        let (_, row) = section.split_once(&start)?;
        let (cells, _) = row.split_once("</td></tr>")?;
        Some(cells.split("</td><td>").collect())
    };
    page.split("<section>").skip(1).filter_map(cells).collect()
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
    for report in reports.as_array().unwrap() {
        let rows = rows(&page, report["mouse"].as_str().unwrap());
        assert_eq!(rows.len(), MEASURES.len(), "{report}");
        for (row, measure) in rows.into_iter().zip(MEASURES) {
            let Value::Object(statistics) = &report["statistics"][measure] else {
                panic!("{report}")
            };
            assert_eq!(row[0], statistics["maze_count"].to_string(), "{measure}");
            let (distribution, difference) =
                (&statistics["distribution"], &statistics["difference"]);
            let interval = &difference["confidence_interval"];
            let shown = row[1..4].iter().copied().chain(row[4].split(" to "));
            let expected = [&distribution["mean"], &distribution["median"], &difference["mean"]];
            let expected = expected.into_iter().chain([&interval["lower"], &interval["upper"]]);
            for (shown, expected) in shown.zip(expected) {
                match expected.as_f64() {
                    Some(number) => {
                        let shown: f64 = shown.parse().unwrap();
                        assert!((shown - number).abs() <= 0.05, "{measure}: {shown}, not {number}");
                    }
                    None => assert_eq!(shown, "-", "{measure}"),
                }
            }
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
    let cells = page.split("<td>").skip(1).filter_map(|rest| rest.split('<').next());
    let numbers: Vec<f64> = cells.filter_map(|cell| cell.parse().ok()).collect();
    for score in rows.clone().filter_map(|row| row["score"].as_f64()) {
        assert!(numbers.iter().any(|number| (number - score).abs() < 0.06), "{score}");
    }
    for row in rows {
        assert!(page.contains(row["mouse"].as_str().unwrap()));
    }
    assert!(home.path().join("charts/score-distribution.svg").exists());
}

//! Checks that the pictures and numbers in docs/strategies.md match the strategies' results.

mod harness;

use std::path::{Path, PathBuf};
use std::{env, fs};

use harness::Home;
use serde_json::Value;

const STRATEGIES: [&str; 6] = [
    "flood-fill",
    "weight-increment",
    "left-wall",
    "swing",
    "shortest-path-search",
    "fastest-path-search",
];

fn at_root(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

/// Set `MMSIM_UPDATE_PICTURES=1` to redraw the pictures after changing a strategy or the drawing
/// code.
#[test]
fn the_pictures_match_the_searches() {
    let home = Home::new();
    let server = home.serve(&["--port", "0", "left bank"]);
    for strategy in STRATEGIES {
        let search = ["solve", strategy, "--connect", &server.address, "--record", strategy];
        assert_eq!(home.run(&search).code, Some(0), "{strategy}");
        let drawn = format!("{strategy}.png");
        let export = ["export", strategy, "--no-numbers", "--width", "400", "-o", &drawn];
        assert_eq!(home.run(&export).code, Some(0), "{strategy}");
        let drawn = home.path().join(drawn);
        let shown = at_root("docs/strategies").join(format!("{strategy}.png"));
        if env::var_os("MMSIM_UPDATE_PICTURES").is_some() {
            fs::copy(&drawn, &shown).unwrap();
        }
        let same = fs::read(&drawn).unwrap() == fs::read(&shown).unwrap();
        assert!(same, "{} shows another search than that of today", shown.display());
    }
}

#[test]
fn the_figures_match_the_collection() {
    let mazes = at_root("../shared/mazes/classic");
    if !mazes.exists() {
        eprintln!("skipped: {} is not there", mazes.display());
        return;
    }
    let compare = |strategies| {
        let mazes = mazes.to_string_lossy();
        Home::new().run(&["compare", &mazes, "--strategies", strategies, "--json"]).json()
    };
    let page = fs::read_to_string(at_root("docs/strategies.md")).unwrap();
    // The left-wall mouse solves so few mazes that the others are compared without it.
    let reports = [
        compare("flood-fill,weight-increment,swing,shortest-path-search,fastest-path-search"),
        compare("left-wall"),
    ];
    let reports = reports.iter().map(|reports| reports.as_array().unwrap());
    for (all, report) in reports.flat_map(|all| all.iter().map(move |report| (all, report))) {
        let decimal = |mean: f64| format!("{mean:.1}");
        let mean = |key: &str| {
            decimal(report["statistics"][key]["distribution"]["mean"].as_f64().unwrap())
        };
        // The means are those of the mazes that all solved.
        let searches = report["mazes"].as_array().unwrap().iter().enumerate();
        let is_common =
            |maze: usize| all.iter().all(|it| it["mazes"][maze]["goal_reached"] == true);
        let shortest = searches.filter(|&(maze, _)| is_common(maze));
        let shortest: Vec<f64> =
            shortest.map(|(_, search)| search["shortest_path"].as_f64().unwrap()).collect();
        let count = f64::from(u32::try_from(shortest.len()).unwrap());
        let shortest_path = decimal(shortest.iter().sum::<f64>() / count);
        let row = [
            report["mouse"].as_str().unwrap().into(),
            format!("{}/{}", report["goal_reached"], report["reachable"]),
            mean("steps_to_goal"),
            report["proven"].to_string(),
            mean("search_steps"),
            mean("path_found"),
            shortest_path,
            report["shortest_path_found"].to_string(),
        ];
        let row = format!("| {} |\n", row.join(" | "));
        assert!(page.contains(&row), "docs/strategies.md lacks {row}");
    }
}

#[test]
fn the_misread_tables_match_the_collection() {
    let mazes = at_root("../shared/mazes/classic");
    if !mazes.exists() {
        eprintln!("skipped: {} is not there", mazes.display());
        return;
    }
    let page = fs::read_to_string(at_root("docs/strategies.md")).unwrap();
    let (anew, fixed) = page.split_once("with `--misread-fixed`:\n").unwrap();
    let (mazes, home) = (mazes.to_string_lossy(), Home::new());
    for (percent, (table, kind)) in ["0.1", "1", "3"].into_iter().flat_map(|percent| {
        [(anew, None), (fixed, Some("--misread-fixed"))].map(|one| (percent, one))
    }) {
        let probability = format!("{percent}%");
        let [before, after] = [None, Some("--recover")].map(|recover| {
            // All rows would take too long.
            let others = match percent {
                "1" => ",left-wall,weight-increment,fastest-path-search",
                _ => "",
            };
            let strategies = format!("flood-fill,swing,shortest-path-search{others}");
            let options = ["compare", &mazes, "--strategies", &strategies, "--json", "--misread"];
            let options = options.into_iter().chain([&*probability]).chain(kind).chain(recover);
            home.run(&options.collect::<Vec<_>>()).json()
        });
        for (before, after) in before.as_array().unwrap().iter().zip(after.as_array().unwrap()) {
            let columns = [before, after].map(misread_columns).join(" | ");
            let name = before["mouse"].as_str().unwrap();
            let row = format!("| {name}, {percent} % | {columns} |\n");
            assert!(table.contains(&row), "docs/strategies.md lacks {row}");
        }
    }
}

/// Returns the columns of a strategy in a table of wrong readings.
fn misread_columns(report: &Value) -> String {
    let searches = report["mazes"].as_array().unwrap().iter();
    let searches = || searches.clone().filter(|search| !search["shortest_path"].is_null());
    let has_fast_run =
        report["mouse"].as_str().is_some_and(|name| name == "swing" || name.ends_with("search"));
    let runs = || searches().filter(|search| !search["fast_run_steps"].is_null());
    let reached = || searches().filter(|search| search["goal_reached"] == true);
    let steps = |search: &Value| search["search_steps"].as_f64().unwrap();
    let steps: Vec<f64> =
        if has_fast_run { runs().map(steps).collect() } else { reached().map(steps).collect() };
    let mean = steps.iter().sum::<f64>() / f64::from(u32::try_from(steps.len()).unwrap());
    let crashes: u64 = searches().map(|search| search["crashes"].as_u64().unwrap()).sum();
    let [runs, mean] = [
        if has_fast_run { runs().count().to_string() } else { "–".into() },
        if steps.is_empty() { "–".into() } else { format!("{mean:.1}") },
    ];
    format!("{} | {runs} | {mean} | {crashes}", reached().count())
}

#[test]
fn the_times_match_the_collection() {
    let mazes = at_root("../shared/mazes/classic");
    if !mazes.exists() {
        eprintln!("skipped: {} is not there", mazes.display());
        return;
    }
    let page = fs::read_to_string(at_root("docs/strategies.md")).unwrap();
    let mazes = mazes.to_string_lossy();
    for (vehicle, tolerance) in [("expert", "0%"), ("expert", "3%"), ("ares", "0%"), ("ares", "3%")]
    {
        let strategy = ["compare", &mazes, "--strategies", "fastest-path-search", "--json"];
        let options = ["--vehicle", vehicle, "--tolerance", tolerance];
        let report = Home::new().run(&[&strategy[..], &options].concat()).json();
        let searches = report[0]["mazes"].as_array().unwrap();
        let solved = searches.iter().filter(|search| search["goal_reached"] == true);
        let figures = |key: &str| -> Vec<f64> {
            solved.clone().map(|search| search[key].as_f64().unwrap()).collect()
        };
        let (steps, losses) = (figures("search_steps"), figures("fast_run_loss_percent"));
        let count = f64::from(u32::try_from(losses.len()).unwrap());
        let mean = |figures: &[f64]| figures.iter().sum::<f64>() / count;
        let name = if tolerance == "0%" {
            vehicle.into()
        } else {
            format!("{vehicle}, `--tolerance {tolerance}`")
        };
        let row = format!(
            "| {name} | {:.1} | {} | {:.2} % | {:.2} % |\n",
            mean(&steps),
            losses.iter().filter(|&&loss| loss > 0.0).count(),
            mean(&losses),
            losses.iter().copied().fold(0.0, f64::max),
        );
        assert!(page.contains(&row), "docs/strategies.md lacks {row}");
    }
}

//! Checks the code, the output and the links in the documentation.

use std::fs;
use std::path::Path;

fn read(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name)).unwrap()
}

#[test]
fn the_client_in_the_readme_is_the_python_example() {
    let block = format!("```python\n{}```\n", read("examples/python/minimal.py"));
    assert!(read("README.md").contains(&block));
}

#[test]
fn the_strategy_in_the_readme_is_the_rust_example() {
    let example = read("examples/rust/own-strategy.rs");
    let strategy = &example[example.find("/// Goes to").unwrap()..example.find("fn main").unwrap()];
    assert!(read("README.md").contains(strategy.trim()));
}

#[test]
fn the_map_in_the_readme_is_the_output_of_the_demo() {
    let snapshot = read("crates/cli/tests/snapshots/solve__demo.snap");
    let (_, map) = snapshot.split_once("ended.stdout\n---\n").unwrap();
    assert!(read("README.md").contains(map));
}

#[test]
fn links_are_valid() {
    for page in [
        "README.md",
        "ARCHITECTURE.md",
        "CONTRIBUTING.md",
        "docs/compare.md",
        "docs/formats.md",
        "docs/mms.md",
        "docs/protocol.md",
        "docs/recordings.md",
        "docs/strategies.md",
        "docs/trial.md",
        "examples/README.md",
        "crates/client/README.md",
        "crates/drawing/README.md",
        "crates/formats/README.md",
        "crates/generator/README.md",
        "crates/maze/README.md",
        "crates/mms/README.md",
        "crates/protocol/README.md",
        "crates/recording/README.md",
        "crates/server/README.md",
        "crates/solvers/README.md",
        "crates/trial/README.md",
        "crates/viewer/README.md",
        "crates/zmtp/README.md",
        "mazes/README.md",
    ] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(page);
        for link in read(page).split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if link.starts_with("https://") {
                continue;
            }
            assert!(!is_published(page), "relative link in the published {page}: {link}");
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = folder.parent().unwrap().join(file);
            assert!(target.exists(), "broken link in {page}: {link}");
            let has_heading = |heading: &str| {
                fs::read_to_string(&target).unwrap().lines().any(|line| {
                    line.starts_with("## ") && anchor(line.trim_start_matches("## ")) == heading
                })
            };
            assert!(heading.is_empty() || has_heading(heading), "broken link in {page}: {link}");
        }
    }
}

/// Whether a README is part of a package that is read outside the repository.
fn is_published(page: &str) -> bool {
    ["maze", "protocol", "solvers", "zmtp"]
        .iter()
        .any(|name| page == format!("crates/{name}/README.md"))
}

/// Returns the anchor that GitHub generates for a heading.
fn anchor(heading: &str) -> String {
    let plain = heading.to_lowercase().replace(' ', "-");
    plain.chars().filter(|&c| c.is_alphanumeric() || c == '-').collect()
}

#[test]
fn the_picture_in_the_architecture_shows_all_dependencies() {
    let architecture = read("ARCHITECTURE.md");
    let picture = architecture.split("```").nth(1).unwrap();
    let rows: Vec<(&str, Vec<&str>)> = picture
        .lines()
        .filter(|line| !line.is_empty())
        .map(|line| {
            let (name, dependencies) = line.split_once("─►").unwrap_or((line, ""));
            (name.trim(), dependencies.split_whitespace().collect())
        })
        .collect();
    let names: Vec<&str> = rows.iter().map(|(name, _)| *name).collect();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates");
    assert_eq!(fs::read_dir(folder).unwrap().count(), names.len());
    for (index, (name, shown)) in rows.iter().enumerate() {
        let manifest = read(&format!("crates/{name}/Cargo.toml"));
        let (_, rest) = manifest.split_once("[dependencies]\n").unwrap();
        let mut actual: Vec<&str> = rest
            .lines()
            .take_while(|line| !line.starts_with('['))
            .filter_map(|line| line.strip_prefix("mmsim-")?.split(['.', ' ']).next())
            .collect();
        let mut sorted = shown.clone();
        actual.sort_unstable();
        sorted.sort_unstable();
        assert_eq!(sorted, actual, "dependencies of {name}");
        assert!(shown.iter().all(|other| names[index..].contains(other)), "{name} points back");
    }
}

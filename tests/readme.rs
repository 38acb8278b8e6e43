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
        "crates/generator/README.md",
        "crates/maze/README.md",
        "crates/mms/README.md",
        "crates/protocol/README.md",
        "crates/server/README.md",
        "crates/solvers/README.md",
        "crates/trial/README.md",
        "crates/viewer/README.md",
    ] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(page);
        for link in read(page).split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if link.starts_with("https://") {
                continue;
            }
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

/// Returns the anchor that GitHub generates for a heading.
fn anchor(heading: &str) -> String {
    let plain = heading.to_lowercase().replace(' ', "-");
    plain.chars().filter(|&c| c.is_alphanumeric() || c == '-').collect()
}

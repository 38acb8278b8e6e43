//! Checks the code, program output and links in the documentation.

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

/// The crates whose README is also shown outside the repository, where relative links do not work.
const PUBLISHED: [&str; 6] =
    ["crates/fastrun", "crates/maze", "crates/protocol", "crates/solvers", "crates/zmtp", "mazes"];

#[test]
fn licences_in_packages_equal_those_of_the_repository() {
    for (package, licence) in PUBLISHED
        .iter()
        .flat_map(|&package| ["LICENSE-MIT", "LICENSE-APACHE"].map(|licence| (package, licence)))
    {
        assert_eq!(read(&format!("{package}/{licence}")), read(licence), "{package}/{licence}");
    }
}

#[test]
fn the_short_client_has_40_lines_and_uses_only_published_libraries() {
    let example = read("examples/rust/short-client.rs");
    assert!(example.lines().count() <= 40);
    for import in example.lines().filter(|line| line.contains("mmsim_")) {
        let published =
            PUBLISHED.map(|folder| format!("use mmsim_{}::", folder.trim_start_matches("crates/")));
        assert!(published.iter().any(|name| import.starts_with(name)), "{import}");
    }
}

#[test]
fn links_are_valid() {
    for page in [
        "README.md",
        "ARCHITECTURE.md",
        "CONTRIBUTING.md",
        "docs/compare.md",
        "docs/fast-run.md",
        "docs/contest.md",
        "docs/formats.md",
        "docs/mms.md",
        "docs/protocol.md",
        "docs/recordings.md",
        "docs/run.md",
        "docs/strategies.md",
        "docs/trial.md",
        "examples/README.md",
        "crates/client/README.md",
        "crates/drawing/README.md",
        "crates/fastrun/README.md",
        "crates/formats/README.md",
        "crates/generator/README.md",
        "crates/maze/README.md",
        "crates/mms/README.md",
        "crates/protocol/README.md",
        "crates/recording/README.md",
        "crates/report/README.md",
        "crates/server/README.md",
        "crates/solvers/README.md",
        "crates/trial/README.md",
        "crates/viewer/README.md",
        "crates/zmtp/README.md",
        "mazes/README.md",
    ] {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let folder = root.join(page).parent().unwrap().to_path_buf();
        for link in read(page).split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = match path_in_repository(file) {
                Some(path) => root.join(path),
                None if file.is_empty() => root.join(page),
                None if link.starts_with("https://") => continue,
                None => {
                    let is_published = PUBLISHED.iter().any(|name| page.starts_with(name));
                    assert!(
                        !is_published,
                        "relative link in {page} breaks outside the repository: {link}"
                    );
                    folder.join(file)
                }
            };
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

/// Returns the path in this repository to which a GitHub URL refers.
fn path_in_repository(url: &str) -> Option<&str> {
    let path = url.strip_prefix("https://github.com/mmsim/mmsim/")?;
    path.strip_prefix("blob/main/").or(path.strip_prefix("tree/main/"))
}

/// Returns the anchor that GitHub generates for a heading.
fn anchor(heading: &str) -> String {
    let plain = heading.to_lowercase().replace(' ', "-");
    plain.chars().filter(|&c| c.is_alphanumeric() || c == '-').collect()
}

#[test]
fn the_diagram_in_architecture_md_shows_all_dependencies() {
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
    assert_eq!(fs::read_dir(folder).unwrap().count() + 1, names.len(), "all crates and mazes");
    for (index, (name, shown)) in rows.iter().enumerate() {
        let folder = if *name == "mazes" { "" } else { "crates/" };
        let manifest = read(&format!("{folder}{name}/Cargo.toml"));
        let (_, rest) = manifest.split_once("\n[dependencies]\n").unwrap_or_default();
        let mut actual: Vec<&str> = rest
            .lines()
            .take_while(|line| !line.starts_with('['))
            .filter_map(|line| line.strip_prefix("mmsim-")?.split(['.', ' ']).next())
            .collect();
        let mut sorted = shown.clone();
        actual.sort_unstable();
        sorted.sort_unstable();
        assert_eq!(sorted, actual, "dependencies of {name}");
        assert!(
            shown.iter().all(|other| names[index..].contains(other)),
            "a dependency of {name} is listed above it"
        );
    }
}

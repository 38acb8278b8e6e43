//! Checks the code, program output and links in the documentation.

use std::fs;
use std::path::Path;

fn read(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name)).unwrap()
}

#[test]
fn the_client_in_the_documentation_is_the_python_example() {
    let block = format!("```python\n{}```\n", read("examples/python/minimal.py"));
    assert!(read("docs/clients.md").contains(&block));
}

#[test]
fn the_strategy_in_the_documentation_is_the_rust_example() {
    let example = read("examples/rust/own-strategy.rs");
    let strategy = &example[example.find("/// Goes to").unwrap()..example.find("fn main").unwrap()];
    assert!(read("docs/clients.md").contains(strategy.trim()));
}

#[test]
fn the_map_in_the_documentation_is_the_output_of_the_demo() {
    let snapshot = read("crates/cli/tests/snapshots/solve__demo.snap");
    let (_, map) = snapshot.split_once("ended.stdout\n---\n").unwrap();
    assert!(read("docs/viewer.md").contains(map));
}

/// Returns the folders of all crates. Their READMEs are also shown outside the repository, where
/// relative links do not work.
fn crates() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates");
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let folders = names.map(|name| format!("crates/{}", name.into_string().unwrap()));
    folders.chain(["mazes".into()]).collect()
}

#[test]
fn licences_in_packages_equal_those_of_the_repository() {
    for package in crates() {
        for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
            assert_eq!(read(&format!("{package}/{licence}")), read(licence), "{package}/{licence}");
        }
    }
}

#[test]
fn the_short_client_has_40_lines_and_uses_only_published_libraries() {
    let example = read("examples/rust/short-client.rs");
    assert!(example.lines().count() <= 40);
    for import in example.lines().filter(|line| line.contains("mmsim_")) {
        let mut published = crates()
            .into_iter()
            .map(|folder| format!("use mmsim_{}::", folder.trim_start_matches("crates/")));
        assert!(published.any(|name| import.starts_with(&name)), "{import}");
    }
}

#[test]
fn links_are_valid() {
    let crates = crates();
    let readmes = crates.iter().map(|folder| format!("{folder}/README.md"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let docs = fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let docs = docs.filter(|path| path.extension().is_some_and(|extension| extension == "md"));
    let docs = docs.map(|path| format!("docs/{}", path.file_name().unwrap().to_str().unwrap()));
    let pages = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "examples/README.md"];
    for page in pages.map(String::from).into_iter().chain(docs).chain(readmes) {
        let folder = root.join(&page).parent().unwrap().to_path_buf();
        for link in read(&page).split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = match path_in_repository(file) {
                Some(path) => root.join(path),
                None if file.is_empty() => root.join(&page),
                None if link.starts_with("https://") => continue,
                None => {
                    assert!(
                        crates.iter().all(|name| page != format!("{name}/README.md")),
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
    assert_eq!(crates().len(), names.len());
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

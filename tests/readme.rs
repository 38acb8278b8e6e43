//! What the README shows is what there is.

use std::fs;
use std::path::Path;

fn read(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name)).unwrap()
}

#[test]
fn the_clients_are_the_example_files() {
    for (language, file) in
        [("python", "examples/python/minimal.py"), ("c", "examples/c/minimal.c")]
    {
        let block = format!("```{language}\n{}```\n", read(file));
        assert!(read("README.md").contains(&block), "README shows {file}");
    }
}

#[test]
fn the_strategy_is_that_of_the_example() {
    let example = read("examples/rust/own-strategy.rs");
    let strategy = &example[example.find("/// Goes to").unwrap()..example.find("fn main").unwrap()];
    assert!(read("README.md").contains(strategy.trim()));
}

#[test]
fn the_map_is_what_the_demo_prints() {
    let snapshot = read("crates/cli/tests/snapshots/solve__demo.snap");
    let (_, map) = snapshot.split_once("ended.stdout\n---\n").unwrap();
    assert!(read("README.md").contains(map));
}

#[test]
fn files_that_are_linked_are_there() {
    for page in ["README.md", "CONTRIBUTING.md", "docs/protocol.md", "examples/README.md"] {
        let text = read(page);
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(page);
            let target = folder.parent().unwrap().join(link);
            assert!(link.starts_with("https://") || target.exists(), "{page} links {link}");
        }
    }
}

//! Checks that the pictures in docs/trial.md and the programs in docs/robots.md are up to date.

mod harness;

use std::path::{Path, PathBuf};
use std::{env, fs};

use harness::Home;

fn at_root(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

/// Set `MMSIM_UPDATE_PICTURES=1` to replace the pictures.
#[test]
fn the_pictures_are_those_of_the_commands() {
    let page = fs::read_to_string(at_root("docs/trial.md")).unwrap();
    for command in [
        "trial orchard --robot swing -o race.png",
        "trial orchard --robot swing --tour tour.png",
        "trial \"wrong turn\" --robot count-expansion --robot swing --as-published -o wrong-turn.png",
    ] {
        assert!(page.contains(&format!("mmsim {command}\n")), "{command}");
        let home = Home::new();
        let words = command.split('"').enumerate().flat_map(|(part, text)| {
            // The odd parts are quoted.
            if part % 2 == 1 { vec![text] } else { text.split_whitespace().collect() }
        });
        let words: Vec<&str> = words.collect();
        assert_eq!(home.run(&words).code, Some(0), "{command}");
        let name = words[words.len() - 1];
        let drawn = fs::read(home.path().join(name)).unwrap();
        let shown = at_root("docs/trial").join(name);
        if env::var_os("MMSIM_UPDATE_PICTURES").is_some() {
            fs::create_dir_all(shown.parent().unwrap()).unwrap();
            fs::write(&shown, &drawn).unwrap();
        }
        let is_same = fs::read(&shown).is_ok_and(|shown| shown == drawn);
        assert!(is_same, "{} differs from the picture of today", shown.display());
        assert!(page.contains(&format!("(trial/{name})")), "{name} is not in docs/trial.md");
    }
}

#[test]
fn the_robots_are_those_of_the_examples() {
    let page = fs::read_to_string(at_root("docs/robots.md")).unwrap();
    for (language, file) in [("python", "python/trial_robot.py"), ("c", "c/trial_robot.c")] {
        let program = fs::read_to_string(at_root("examples").join(file)).unwrap();
        assert!(page.contains(&format!("```{language}\n{program}```\n")), "{file}");
        assert!(program.lines().count() <= 35, "{file} is short");
    }
}

//! `mmsim fast-run -o`: pictures of fast runs.

mod harness;

use std::fs;

use harness::{Home, Output};

const MAZE: &str = "\
o---o---o---o
|         G |
o   o---o   o
| S         |
o---o---o---o
";

const CUT_OFF: &str = "o---o---o\n| S | G |\no---o---o\n";

/// Runs `mmsim fast-run MAZE -o run.EXTENSION`, and returns the picture.
#[track_caller]
fn draw(home: &Home, extension: &str, arguments: &[&str]) -> (Output, Vec<u8>) {
    home.write("small.txt", MAZE);
    let file = format!("run.{extension}");
    let ended = home.run(&[&["fast-run", "small.txt", "-o", &file], arguments].concat());
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    let picture = fs::read(home.path().join(file)).unwrap();
    (ended, picture)
}

fn svg(arguments: &[&str]) -> String {
    String::from_utf8(draw(&Home::new(), "svg", arguments).1).unwrap()
}

/// Returns the number of samples of lines in the legend.
fn samples(svg: &str) -> usize {
    let legend = svg.split_once("<g class=\"legend\"").unwrap().1;
    legend.lines().filter(|line| line.contains("stroke-width") && line.contains('h')).count() - 1
}

#[test]
fn runs_are_drawn_with_a_legend() {
    let one = svg(&[]);
    assert_eq!(one.matches("<circle").count(), 2, "the start and the end");
    let two = svg(&["--vehicle", "ares", "--vehicle", "ukmars"]);
    assert_eq!((two.matches("<circle").count(), samples(&two)), (2, 2), "{two}");
    let routes = svg(&["--route", "all"]);
    assert_eq!(samples(&routes), 3);
    let six = svg(&["--route", "all", "--vehicle", "ares", "--vehicle", "ukmars"]);
    assert_eq!(samples(&six), 6);
    assert_ne!(svg(&["--theme", "dark"]), one);
}

#[test]
fn the_text_is_printed_as_well() {
    let home = Home::new();
    let (with, png) = draw(&home, "png", &["--width", "200", "--theme", "dark"]);
    assert!(png.starts_with(b"\x89PNG"));
    let width_px = u32::from_be_bytes(png[16..20].try_into().unwrap());
    assert_eq!(width_px, 200);
    assert_eq!(with.stdout, home.run(&["fast-run", "small.txt"]).stdout);
}

#[test]
fn an_animation_lasts_as_long_as_the_slowest_run() {
    let home = Home::new();
    let (_, gif) = draw(&home, "gif", &["--vehicle", "expert", "--vehicle", "ukmars"]);
    let vehicles = ["--vehicle", "ukmars", "--json"];
    let json = home.run(&[&["fast-run", "small.txt"], &vehicles[..]].concat()).json();
    let time = json[0]["time_s"].as_f64().unwrap();
    let mut decoder = gif::DecodeOptions::new().read_info(&gif[..]).unwrap();
    assert_eq!(decoder.width(), 640);
    let mut delays = Vec::new();
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        delays.push(frame.delay);
    }
    // The last frame stays for 2.5 s.
    assert_eq!(delays.pop(), Some(250));
    let hundredths: u16 = delays.iter().sum();
    let shown = f64::from(hundredths) / 100.0;
    assert!(shown >= time && shown < time + 0.04, "{shown} {time}");
}

#[test]
fn a_start_that_is_a_goal_can_be_drawn() {
    let home = Home::new();
    home.write("there.txt", "o---o---o\n|SG     |\no---o---o\n");
    for file in ["there.svg", "there.png", "there.gif"] {
        let ended = home.run(&["fast-run", "there.txt", "-o", file]);
        assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""), "{file}");
        assert!(home.path().join(file).exists());
    }
}

#[test]
fn errors_keep_the_old_file() {
    let home = Home::new();
    home.write("mazes/small.txt", MAZE);
    home.write("mazes/other.txt", MAZE);
    home.write("cut-off.txt", CUT_OFF);
    home.write("old.gif", "old");
    let four = ["ukmars", "ares", "expert", "kerise"].map(|name| ["--vehicle", name]).concat();
    let many = [&["mazes/small.txt", "--route", "all", "-o", "old.gif"], &four[..]].concat();
    for (arguments, code, error) in [
        (&["mazes", "-o", "old.gif"][..], 2, "--output takes one maze, found 2"),
        (&many, 2, "--output takes at most 6 runs, found 12"),
        (&["cut-off.txt", "-o", "old.gif"], 1, "goal unreachable"),
        (&["mazes/small.txt", "-o", "no/a.svg"], 1, "cannot write no/a.svg: "),
        (&["mazes/small.txt", "-o", "a.jpeg"], 2, "expected a file ending in .svg, .png or .gif"),
        (&["mazes/small.txt", "--width", "300"], 2, "--output <FILE>"),
        (&["mazes/small.txt", "--theme", "dark"], 2, "--output <FILE>"),
        (&["no.txt", "-o", "old.gif"], 1, "no such file or folder: no.txt"),
    ] {
        let ended = home.run(&[&["fast-run"], arguments].concat());
        assert_eq!(ended.code, Some(code), "{arguments:?}: {}", ended.stderr);
        let output = ended.stderr + &ended.stdout;
        assert!(output.contains(error), "{arguments:?}: {output}");
    }
    assert_eq!(fs::read(home.path().join("old.gif")).unwrap(), b"old");
}

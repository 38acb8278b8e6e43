//! `mmsim export`: pictures of mazes and recordings.

mod harness;

use std::fs;
use std::path::PathBuf;

use harness::Home;
use mmsim_maze::Maze;
use mmsim_protocol::Annotations;
use mmsim_recording::{RecordingWriter, UpdateEncoder, UpdateTracker};
use mmsim_server::Simulation;

const MAZE: &str = "\
o---o---o---o
|     G |   |
o   o---o   o
| S |       |
o---o---o---o
";

/// Records a mouse that moves back and forth and reports a nonexistent wall.
fn record(home: &Home, name: &str, states: u8) -> PathBuf {
    let simulation = Simulation::new("small", MAZE.parse::<Maze>().unwrap());
    let path = home.path().join(name);
    let mut writer =
        RecordingWriter::create(&path, &simulation.info(), Some(simulation.maze())).unwrap();
    for number in 0..states {
        let pose = if number % 2 == 0 { [0, 0, b'N'] } else { [0, 1, b'S'] };
        let weights = [number, 1, 2, 3, 4, 5];
        let walls = [0x0f | 16, 0, 0, 0, 0, 0];
        let message = [&b"S"[..], &pose, b"C", &weights, b"C", &walls].concat();
        writer.write(&message).unwrap();
    }
    writer.close().unwrap();
    path
}

fn read(home: &Home, name: &str) -> Vec<u8> {
    fs::read(home.path().join(name)).unwrap()
}

/// Returns the width and height of a PNG.
fn png_size(png: &[u8]) -> (u32, u32) {
    assert!(png.starts_with(b"\x89PNG\r\n"), "{:?}", &png[..8]);
    let number = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
    (number(16), number(20))
}

/// Returns the number of frames, the width and the height of a GIF.
fn gif_frames(gif: &[u8]) -> (usize, u16, u16) {
    let mut decoder = gif::DecodeOptions::new().read_info(gif).unwrap();
    let mut frames = 0;
    while decoder.read_next_frame().unwrap().is_some() {
        frames += 1;
    }
    (frames, decoder.width(), decoder.height())
}

#[test]
fn mazes_are_selected_by_file_or_words() {
    let home = Home::new();
    home.write("mazes/small.txt", MAZE);
    let ended = home.run(&["export", "mazes/small.txt", "-o", "file.svg", "--distances"]);
    assert_eq!((ended.code, &ended.stdout[..], &ended.stderr[..]), (Some(0), "", ""));
    home.run(&["export", "mazes", "SMALL", "--distances", "-o", "words.svg"]);
    let svg = String::from_utf8(read(&home, "file.svg")).unwrap();
    assert_eq!(svg.as_bytes(), read(&home, "words.svg"));
    assert_eq!(svg.matches("<rect class=\"cell").count(), 6);
    assert!(svg.contains("class=\"maze hide-heat hide-trail\""), "{svg}");
    let is_blank = |line: &&str| line.contains("class=\"number\"") && line.contains("d=\"\"");
    assert_eq!(svg.lines().filter(is_blank).count(), 3, "cells without a way to the goal");
    home.run(&["export", "training", "steps", "--theme", "dark", "--heat", "-o", "bundled.PNG"]);
    assert_eq!(png_size(&read(&home, "bundled.PNG")), (640, 640));
    home.run(&["export", "mazes/small.txt", "--width", "200", "-o", "small.png"]);
    assert_eq!(png_size(&read(&home, "small.png")), (200, 138));
}

#[test]
fn a_state_of_a_recording_is_drawn() {
    let home = Home::new();
    record(&home, "run.mcap", 5);
    let svg = |arguments: &[&str]| {
        let ended = home.run(&[&["export", "run.mcap", "-o", "run.svg"], arguments].concat());
        assert_eq!(ended.code, Some(0), "{ended:?}");
        String::from_utf8(read(&home, "run.svg")).unwrap()
    };
    let last = svg(&[]);
    assert!(last.contains("class=\"maze hide-heat\""));
    assert!(last.contains("class=\"wall mistaken\" data-wall=\"0,0,N\""), "{last}");
    let passage =
        |ends: &str| format!("data-passage=\"0,0,N\" stroke=\"url(#trail-v5)\" d=\"{ends}\"");
    assert!(last.contains(&passage("M10 10v20")), "{last}");
    assert!(last.contains("transform=\"translate(10 30) rotate(0)\""));
    let second = svg(&["--at", "1", "--heat", "--no-numbers", "--no-trail"]);
    assert!(second.contains("class=\"maze hide-numbers hide-trail no-labels\""));
    assert!(second.contains(&passage("M10 30v-20m-2.4 10.9l2.4-2.4 2.4 2.4")), "{second}");
    assert!(second.contains("transform=\"translate(10 10) rotate(180)\""));
    // The content of the file matters, not its name.
    fs::copy(home.path().join("run.mcap"), home.path().join("run.bin")).unwrap();
    assert_eq!(home.run(&["export", "run.bin", "-o", "run.png"]).code, Some(0));
    assert_eq!(png_size(&read(&home, "run.png")), (640, 440));
}

/// Records two states of a mouse that displays texts and colours.
fn record_display(home: &Home) {
    let simulation = Simulation::new("small", MAZE.parse::<Maze>().unwrap());
    let (path, size) = (home.path().join("run.mcap"), simulation.maze().size());
    let mut writer =
        RecordingWriter::create(&path, &simulation.info(), Some(simulation.maze())).unwrap();
    let (mut updates, mut encoder) = (UpdateTracker::default(), UpdateEncoder::new(size));
    for (number, annotations) in
        [b"AT\x01\0\x042000C\x02\0G", b"AT\x01\0\x04goalC\x02\0y"].into_iter().enumerate()
    {
        updates.annotate(Annotations::decode(annotations, size).unwrap()).unwrap();
        let pose = [0, u8::try_from(number).unwrap(), b'N'];
        let message = [&b"S"[..], &pose, b"C", &[1; 6], b"C", &[0; 6]].concat();
        writer.write_with_update(encoder.encode(updates.update(), &message), &message).unwrap();
        updates = UpdateTracker::default();
    }
    writer.close().unwrap();
}

#[test]
fn texts_and_colours_of_a_mouse_are_drawn() {
    let home = Home::new();
    record_display(&home);
    let svg = |arguments: &[&str]| {
        let ended = home.run(&[&["export", "run.mcap", "-o", "run.svg"], arguments].concat());
        assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
        String::from_utf8(read(&home, "run.svg")).unwrap()
    };
    let first = svg(&["--at", "0"]);
    assert!(first.contains("data-cell=\"1,0\" data-text=\"2000\""), "{first}");
    assert!(first.contains("fill=\"#004d00\""));
    let last = svg(&[]);
    assert!(last.contains("data-text=\"goal\"") && last.contains("fill=\"#b3b300\""), "{last}");
    let bare = svg(&["--no-texts", "--no-colours"]);
    assert!(!bare.contains("data-text") && !bare.contains("class=\"colour\""));
    assert_eq!(home.run(&["export", "run.mcap", "-o", "run.gif"]).code, Some(0));
    assert_eq!(gif_frames(&read(&home, "run.gif")).0, 2);
}

#[test]
fn a_recording_can_be_animated() {
    let home = Home::new();
    record(&home, "run.mcap", 5);
    let ended = home.run(&["export", "run.mcap", "-o", "run.gif", "--width", "128"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    assert_eq!(gif_frames(&read(&home, "run.gif")), (5, 128, 88));
    home.run(&["export", "run.mcap", "-o", "run.gif", "--width", "64", "--at", "2"]);
    assert_eq!(gif_frames(&read(&home, "run.gif")), (3, 64, 44));
}

#[test]
fn long_searches_have_at_most_400_frames() {
    let home = Home::new();
    let simulation = Simulation::new("one", "o---o\n|SG |\no---o\n".parse::<Maze>().unwrap());
    let path = home.path().join("long.mcap");
    let mut writer = RecordingWriter::create(&path, &simulation.info(), None).unwrap();
    for number in 0..1000_u32 {
        let letter = b"NESW"[number as usize % 4];
        writer.write(&[b'S', 0, 0, letter, b'C', 0, b'C', 0]).unwrap();
    }
    writer.close().unwrap();
    let ended = home.run(&["export", "long.mcap", "-o", "long.gif", "--width", "16"]);
    assert_eq!(ended.stderr, "long.gif: drawing 400 of 1000 states, evenly spaced\n");
    assert_eq!(gif_frames(&read(&home, "long.gif")).0, 400);
}

#[test]
fn a_recording_without_states_shows_the_maze() {
    let home = Home::new();
    record(&home, "empty.mcap", 0);
    assert_eq!(home.run(&["export", "empty.mcap", "-o", "empty.svg"]).code, Some(0));
    let svg = String::from_utf8(read(&home, "empty.svg")).unwrap();
    assert!(svg.contains("mouse absent") && svg.contains("wall true known"));
    let ended = home.run(&["export", "empty.mcap", "-o", "empty.gif"]);
    let error = "mmsim: empty.mcap: cannot animate a recording without states\n";
    assert_eq!((ended.code, &ended.stderr[..]), (Some(1), error));
}

#[test]
fn the_intact_part_of_a_damaged_recording_is_drawn() {
    let home = Home::new();
    let path = record(&home, "run.mcap", 200);
    let mut bytes = fs::read(path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle..middle + 100].fill(0xa5);
    home.write("damaged.mcap", &bytes);
    let ended = home.run(&["export", "damaged.mcap", "-o", "damaged.svg"]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.contains(": damaged after byte "), "{ended:?}");
    assert!(read(&home, "damaged.svg").starts_with(b"<svg "));
}

#[test]
fn undrawable_inputs_are_errors_and_keep_the_old_file() {
    let home = Home::new();
    home.write("small.txt", MAZE);
    home.write("old.gif", "old");
    record(&home, "run.mcap", 2);
    for (arguments, error) in [
        (
            &["small.txt", "-o", "old.gif"][..],
            "small.txt: a .gif file needs a recording, not a maze",
        ),
        (
            &["small.txt", "--at", "0", "-o", "a.svg"],
            "small.txt: --at needs a recording, not a maze",
        ),
        (
            &["small.txt", "--no-trail", "-o", "a.svg"],
            "small.txt: --no-trail needs a recording, not a maze",
        ),
        (
            &["small.txt", "--history-limit", "9", "-o", "a.svg"],
            "small.txt: --history-limit needs a recording, not a maze",
        ),
        (
            &["run.mcap", "--distances", "-o", "a.svg"],
            "run.mcap: --distances needs a maze, not a recording",
        ),
        (&["run.mcap", "--at", "2", "-o", "old.gif"], "run.mcap: no state 2 (--at takes 0 to 1)"),
        (&["no.mcap", "-o", "a.svg"], "no such file or folder: no.mcap\n"),
        (&["no such maze", "-o", "a.svg"], "no maze matches \"no such maze\" in "),
        (&["small.txt", "-o", "no/a.svg"], "cannot write no/a.svg: "),
    ] {
        let ended = home.run(&[&["export"], arguments].concat());
        assert_eq!(ended.code, Some(1), "{arguments:?}");
        let start = format!("mmsim: {error}");
        assert!(ended.stderr.starts_with(&start), "{arguments:?}: {}", ended.stderr);
    }
    for (arguments, error) in [
        (&["small.txt"][..], "--output <FILE>"),
        (
            &["small.txt", "-o", "a.jpeg"],
            "expected a file ending in .svg, .png, .gif, .html or .mcap, found .jpeg",
        ),
        (&["small.txt", "-o", "a.png", "--width", "15"], "15 is not in 16..=4096"),
        (&["small.txt", "-o", "a.svg", "--width", "300"], "--width needs a .png or .gif file"),
        (&["small.txt", "-o", "a.png", "--theme", "pink"], "[possible values: light, dark]"),
    ] {
        let ended = home.run(&[&["export"], arguments].concat());
        assert_eq!(ended.code, Some(2), "{arguments:?}");
        assert!(ended.stderr.contains(error), "{arguments:?}: {}", ended.stderr);
    }
    assert_eq!(read(&home, "old.gif"), b"old");
    let mut files: Vec<_> = fs::read_dir(home.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    assert_eq!(files, ["old.gif", "run.mcap", "small.txt"], "nothing else is left behind");
}

/// Each option changes what is written, or is refused.
#[test]
fn no_option_is_without_effect() {
    const OPTIONS: [&[&str]; 11] = [
        &["--at", "0"],
        &["--distances"],
        &["--heat"],
        &["--no-numbers"],
        &["--no-trail"],
        &["--no-texts"],
        &["--no-colours"],
        &["--theme", "dark"],
        &["--width", "64"],
        &["--vehicle", "own.toml"],
        &["--states-only"],
    ];
    let home = Home::new();
    home.write("small.txt", MAZE);
    home.write("own.toml", "base = 'ares'\nname = 'own'\n");
    record_display(&home);
    let mut effects = [0; OPTIONS.len()];
    for source in ["small.txt", "run.mcap"] {
        for file in ["a.svg", "a.png", "a.gif", "a.html", "a.mcap"] {
            let write = |option: &[&str]| {
                let ended = home.run(&[&["export", source, "-o", file], option].concat());
                let written = (ended.code == Some(0)).then(|| read(&home, file));
                assert!(written.is_some() || ended.stderr.contains("needs"), "{ended:?}");
                written
            };
            let plain = write(&[]);
            for (option, count) in OPTIONS.iter().zip(&mut effects) {
                let Some(written) = write(option) else { continue };
                assert_ne!(Some(written), plain, "{source} {file} {option:?}");
                *count += 1;
            }
        }
    }
    assert!(effects.iter().all(|&count| count > 0), "{effects:?}");
    let help = home.run(&["export", "-h"]).stdout;
    let (_, listed) = help.split_once("Options:\n").unwrap();
    let names = listed.split_whitespace().filter(|word| word.starts_with("--"));
    let general = ["--output", "--history-limit", "--quiet", "--verbose...", "--help"];
    for name in names.filter(|name| !general.contains(name)) {
        assert!(OPTIONS.iter().any(|option| option[0] == name), "{name}");
    }
}

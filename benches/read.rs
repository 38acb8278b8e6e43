//! Compares the time to read hex maze files, whose orientation and bit order must be inferred, with
//! the time to read maze files in the text format.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use mmsim_benches::{Row, compare};
use mmsim_formats::parse_maze;
use mmsim_generator::{Style, generate};
use mmsim_maze::{Cell, Heading, Maze, MazeSize, WyRand};

/// Formats a maze as hex digits, with the northernmost row first. `bits` contains the headings that
/// the bits 1, 2, 4 and 8 stand for.
fn hex(maze: &Maze, bits: [Heading; 4]) -> String {
    let digit = |x, y| {
        let sides = maze.walls().sides(Cell::new(x, y));
        let value: u32 =
            (0..).zip(bits).map(|(bit, heading)| u32::from(sides.has(heading)) << bit).sum();
        char::from_digit(value, 16).unwrap()
    };
    let size = maze.size();
    let row = |y| (0..size.width()).map(|x| digit(x, y)).chain(['\n']).collect::<String>();
    (0..size.height()).rev().map(row).collect()
}

fn read(criterion: &mut Criterion) {
    for (size, name) in [(MazeSize::CLASSIC, "16x16"), (MazeSize::HALF_SIZE, "32x32")] {
        let maze = generate(size, 1, Style::Contest);
        let usual = hex(&maze, Heading::ALL);
        let east_first = hex(&maze, [Heading::East, Heading::North, Heading::West, Heading::South]);
        let mut rng = WyRand::new(1);
        let mut random = |_| char::from_digit(rng.below(16), 16).unwrap();
        let random = usual.chars().map(|c| if c == '\n' { c } else { random(c) }).collect();
        let closed = usual.replace(|c| c != '\n', "f");
        let texts = [
            ("text", maze.to_string(), true),
            ("hex, usual bits", usual, true),
            ("hex, east first", east_first, true),
            ("hex, closed cells", closed, false),
            ("hex, random digits", random, false),
        ];
        let rows = texts.map(|(row, text, is_maze)| {
            assert_eq!(
                parse_maze(text.as_bytes()).is_ok_and(|read| read.walls() == maze.walls()),
                is_maze
            );
            Row::new(row, move |()| {
                let _ = black_box(parse_maze(black_box(text.as_bytes())));
            })
        });
        compare(criterion, &format!("read/{name}"), &[()], &rows);
    }
}

criterion_group!(benches, read);
criterion_main!(benches);

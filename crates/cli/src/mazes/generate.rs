//! `mmsim mazes generate`: new mazes.

use std::fs;
use std::path::{Path, PathBuf};

use mmsim_generator::generate;
use mmsim_maze::Maze;
use mmsim_solvers::MazeFacts;
use serde::Serialize;

use super::args::GenerateArgs;
use crate::Outcome;
use crate::output::{counted, own_command, print, replace, say};

/// A maze with what it is made from. The names are those of the JSON.
#[derive(Serialize)]
struct Generated {
    seed: u64,
    style: &'static str,
    width: u8,
    height: u8,
    goals: Vec<[u8; 2]>,
    shortest_path: Option<u16>,
    maze: String,
}

pub(super) fn run(args: &GenerateArgs) -> Outcome {
    let seed = args.seed.unwrap_or_else(|| {
        // Short enough to be typed.
        let seed = fastrand::u32(..).into();
        say(format_args!("--seed {seed} gives the same again"));
        seed
    });
    let mazes =
        (0..args.count).map(|number| Generated::new(args, seed.wrapping_add(number.into())));
    match &args.output {
        Some(output) => write(mazes, output, args)?,
        None if args.json => {
            let mazes: Vec<Generated> = mazes.collect();
            print(&(serde_json::to_string_pretty(&mazes)? + "\n"))?;
        }
        None => {
            for (number, generated) in mazes.enumerate() {
                let blank = if number == 0 { "" } else { "\n" };
                print(&format!("{blank}{}", generated.maze))?;
            }
        }
    }
    Ok(true)
}

impl Generated {
    fn new(args: &GenerateArgs, seed: u64) -> Self {
        let maze: Maze = generate(args.size, seed, args.style.0);
        Self {
            seed,
            style: args.style.0.name(),
            width: args.size.width(),
            height: args.size.height(),
            goals: maze.goals().iter().map(|cell| [cell.x, cell.y]).collect(),
            shortest_path: MazeFacts::of(&maze).shortest_path,
            maze: maze.to_string(),
        }
    }

    fn file_name(&self) -> String {
        let Self { seed, style, width, height, .. } = self;
        format!("{style}-{width}x{height}-{seed}.txt")
    }
}

/// Writes each maze into a file. One that holds something else stays as it is, unless told.
fn write(
    mazes: impl Iterator<Item = Generated>,
    output: &Path,
    args: &GenerateArgs,
) -> Result<(), String> {
    let is_folder = args.count > 1 || output.is_dir();
    if is_folder {
        fs::create_dir_all(output)
            .map_err(|error| format!("{}: cannot be created: {error}", output.display()))?;
    }
    for generated in mazes {
        let path: PathBuf =
            if is_folder { output.join(generated.file_name()) } else { output.into() };
        match fs::read(&path) {
            Ok(content) if content == generated.maze.as_bytes() => {}
            Ok(_) if !args.force => {
                let path = path.display();
                return Err(format!(
                    "{path}: expected no file or the same maze, found something else; --force replaces it"
                ));
            }
            // One that is not there, and of one that cannot be read the writing tells.
            Ok(_) | Err(_) => replace(&path, generated.maze.as_bytes())?,
        }
    }
    let (mazes, place) = (counted(args.count, "maze"), output.display());
    let serve = own_command(&format!("{place}"));
    say(format_args!(
        "{mazes} in {place}; {serve} serves {}",
        if is_folder { "one" } else { "it" }
    ));
    Ok(())
}

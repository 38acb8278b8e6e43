//! The command line of `mmsim mazes`.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand, ValueEnum};
use mmsim_formats::Format;
use mmsim_generator::Style;
use mmsim_maze::MazeSize;

use crate::args::parse_size;

#[derive(Debug, Args)]
pub(crate) struct MazesArgs {
    #[command(subcommand)]
    pub(crate) command: MazesCommand,
}

#[derive(Debug, Subcommand)]
pub(crate) enum MazesCommand {
    /// What mazes there are
    List {
        /// A maze file or a folder [default: ~/.mmsim where that exists, else the bundled mazes]
        mazes: Option<PathBuf>,
        /// Print a JSON array
        #[arg(long)]
        json: bool,
    },
    /// Draw a maze with the distance of each cell to the goal, in steps
    Show {
        /// A maze file, or words of the path of a maze
        #[arg(required = true)]
        name: Vec<String>,
        /// Where to look for it [default: ~/.mmsim where that exists, else the bundled mazes]
        #[arg(long, value_name = "PATH")]
        mazes: Option<PathBuf>,
        /// Read NAME, a maze file, as one in this format [default: told by its content]
        #[arg(long, value_parser = format(|_| true), conflicts_with = "mazes")]
        format: Option<Format>,
        /// Print a JSON object
        #[arg(long)]
        json: bool,
    },
    /// Size, goals and shortest path of maze files, and what is wrong with them
    ///
    /// Errors, which make the exit code 1: a file that cannot be read, cells that contradict each
    /// other, gaps in the outer wall, a goal that cannot be reached. Warnings: posts without a
    /// wall, cells that cannot be reached, unknown walls, hex digits that other mazes fit too, a maze
    /// that another file holds as well.
    Check {
        /// Maze files, and folders, which are searched with their subfolders but for hidden files
        /// and those that end in .md or .json
        #[arg(required = true, value_name = "PATH")]
        paths: Vec<PathBuf>,
        /// Read all files as in this format [default: told by their content]
        #[arg(long, value_parser = format(|_| true))]
        format: Option<Format>,
        /// Print a JSON array
        #[arg(long)]
        json: bool,
    },
    /// Write a maze file in another format
    Convert(ConvertArgs),
    /// Download a public collection of real contest mazes
    #[command(long_about = FETCH)]
    Fetch(FetchArgs),
    /// Make mazes like those of contests, or to train in; the same seed gives the same maze
    Generate(GenerateArgs),
}

#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// The maze file, - for the standard input
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// The file to write, - for the standard output: its ending .txt, .trial, .maz or .num says
    /// the format, unless --to does. A file that is there is replaced, a pipe or device is written to
    #[arg(value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// The format of IN [default: told by its content]
    #[arg(long, value_parser = format(|_| true))]
    pub(crate) format: Option<Format>,
    /// The format of OUT [default: told by its ending, text for the standard output]
    #[arg(long, value_parser = format(Format::is_writable))]
    pub(crate) to: Option<Format>,
    /// Leave out start and goal where the format has no place for them
    #[arg(long)]
    pub(crate) lossy: bool,
}

const FETCH: &str = "\
Download a public collection of real contest mazes: the maze files of micromouseonline.

The collection carries no licence: its mazes are their authors', and are downloaded for your own use.

Fetched again, mazes that have changed there are replaced, and those that are gone there are removed. \
What you have put into the folder or changed stays as it is. The environment variables HTTPS_PROXY, \
HTTP_PROXY and NO_PROXY are heeded.";

#[derive(Debug, Args)]
pub(crate) struct FetchArgs {
    /// The folder for the mazes [default: ~/.mmsim, where they are looked for first]
    #[arg(value_name = "DIR")]
    pub(crate) folder: Option<PathBuf>,
    /// Where the collection comes from: the address of a .tar.gz, .zip or .tar, by https, http or
    /// file, or such a file that is already here
    #[arg(long, value_name = "URL|FILE", default_value = COLLECTION)]
    pub(crate) from: String,
    /// Print a JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// The archive that its host makes of the newest state of the collection.
const COLLECTION: &str =
    "https://github.com/micromouseonline/mazefiles/archive/refs/heads/master.tar.gz";

#[derive(Debug, Args)]
pub(crate) struct GenerateArgs {
    /// Cells from west to east and from south to north
    #[arg(long, value_name = "WxH", default_value_t = MazeSize::CLASSIC, value_parser = parse_size)]
    pub(crate) size: MazeSize,
    /// Which maze of all there are [default: any; it is said which]
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// What kind of maze
    #[arg(long, default_value = Style::Contest.name())]
    pub(crate) style: StyleArg,
    /// How many mazes; the first is that of the seed, the second that of the next seed, and so on
    #[arg(long, value_name = "COUNT", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) count: u32,
    /// The file to write it into, in the format of its ending .trial, .maz or .num, else as text;
    /// if that is a folder or ends like one, or there are several mazes, the folder for files such
    /// as contest-16x16-1.txt [default: print them, with a blank line between]
    #[arg(short, long, value_name = "FILE|DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Replace files that hold something else
    #[arg(long, requires = "output")]
    pub(crate) force: bool,
    /// Print a JSON array
    #[arg(long, conflicts_with = "output")]
    pub(crate) json: bool,
}

/// A style of mazes, as a value of the command line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StyleArg(pub(crate) Style);

impl ValueEnum for StyleArg {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: [StyleArg; 3] =
            [StyleArg(Style::Contest), StyleArg(Style::Perfect), StyleArg(Style::Open)];
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.name()).help(self.0.about()))
    }
}

/// The names of some formats.
fn format(of: fn(Format) -> bool) -> impl TypedValueParser<Value = Format> {
    let names = Format::ALL.into_iter().filter(move |&format| of(format)).map(Format::name);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Format>())
}

//! Arguments of `mmsim compare`.

use std::path::PathBuf;

use clap::Args;
use mmsim_fastrun::Vehicle;
use mmsim_run::SearchSpeed;

use crate::searches::SearchArgs;
use crate::vehicle::{VEHICLES, parse_vehicle};

const AFTER_HELP: &str = "\
Examples:
  mmsim compare                                   compare all strategies in the default mazes
  mmsim compare mazes/ --mouse mine=./my-mouse    compare your own mouse with the strategies
  mmsim compare mazes/ --mouse new=./mouse --mouse \"old=python3 old.py\" --strategies none
  mmsim compare mazes/ --html report.html         write a report with charts and pictures
  mmsim compare harbour my-maze.txt --strategies flood-fill,swing
  mmsim compare mazes/ --vehicle expert           add the times of fast runs in seconds
  mmsim compare mazes/ --csv > searches.csv       write a CSV file, one line per search
  mmsim compare mazes/ --json                     print searches and statistics as JSON

A mouse is a program for the simulator mms, or a client that connects to the address in the
environment variable MMSIM_ENDPOINT; {endpoint} in its arguments stands for the same address. A
mouse runs once in each maze, in parallel on all processors. It has finished if it has reached the
goal and not moved for two seconds. Failures are counted and listed; the other searches continue.

Means and medians cover the mazes in which all mice reached the goal. Differences, from the first
mouse, cover the mazes in which both reached the goal; the middle half lies between the quartiles.

The exit code is 0 if all mazes could be read, regardless of the results.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct CompareArgs {
    /// Maze files, folders to search recursively, and words from the path of a maze [default: all
    /// mazes in ~/.mmsim if there are any, else the bundled mazes]
    pub(crate) mazes: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) search: SearchArgs,
    #[arg(
        long,
        value_name = "NAME|FILE",
        value_parser = parse_vehicle,
        help = format!(
            "Calculate the times of fast runs for a vehicle: {VEHICLES}. Without it, \
             fastest-path-search explores for expert"
        )
    )]
    pub(crate) vehicle: Option<Vehicle>,
    /// Seconds per cell and per quarter turn while a mouse searches
    #[arg(long, value_name = "CELL,TURN", default_value = SearchSpeed::DEFAULT, requires = "vehicle")]
    pub(crate) search_speed: SearchSpeed,
    /// Write a report to FILE: one HTML page with tables, charts and pictures
    #[arg(long, value_name = "FILE")]
    pub(crate) html: Option<PathBuf>,
    /// Write the charts as SVG files to DIR
    #[arg(long, value_name = "DIR")]
    pub(crate) charts: Option<PathBuf>,
    /// Print CSV: a header and one line per search
    #[arg(long, conflicts_with = "json")]
    pub(crate) csv: bool,
    /// Print a JSON array
    #[arg(long)]
    pub(crate) json: bool,
}

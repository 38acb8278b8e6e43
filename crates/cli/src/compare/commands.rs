//! Executes the commands of a mouse that was written for mms.

use std::io::{BufReader, BufWriter, Read, Write};

use mmsim_maze::{Cell, CellSet, Heading, MazeSize};
use mmsim_mms::{Environment, Response, SimulatedMouse};

use super::own_search::{Kind, Over, Progress, SharedProgress, lock};
use crate::mms::child::{Line, read_line};
use crate::mms::invalid_lines::InvalidLine;

/// A mouse that has written this many bytes of invalid lines since its latest command is stopped.
const MAX_INVALID_BYTES: usize = 16 << 20;

/// Executes commands until the output of the mouse ends or the search is over. Output of a mouse that
/// does not write commands is ignored.
pub(super) fn execute_all(
    mut output: BufReader<impl Read>,
    input: impl Write,
    size: MazeSize,
    (start, goals): (Cell, CellSet),
    progress: &SharedProgress,
) {
    let mut mouse = SimulatedMouse::new(size, start, goals);
    let mut replies = BufWriter::new(input);
    let mut invalid_bytes = 0;
    // An error ends the output.
    while let Ok(Some(line)) = read_line(&mut output) {
        let mut progress = lock(progress);
        if progress.is_over {
            return;
        }
        let Ok(command) = InvalidLine::parse(&line, size) else {
            invalid_bytes += length(&line);
            if invalid_bytes > MAX_INVALID_BYTES && progress.kind() != Some(Kind::Client) {
                return progress.end(Over::Flood(too_many(&line)));
            }
            continue;
        };
        invalid_bytes = 0;
        if !progress.accept(Kind::Mms) {
            continue;
        }
        if progress.track.states() == 0 {
            progress.add(mouse.pose(), false);
        }
        let Ok(reply) = mouse.execute(command, &mut *progress) else { return };
        progress.crashes += u32::from(reply == Some(Response::Crash));
        drop(progress);
        if let Some(reply) = reply {
            // A mouse that has closed its stdin may still write commands.
            let _ = writeln!(replies, "{reply}");
        }
        // The mouse may wait for the replies to all commands that it has written.
        if !output.buffer().contains(&b'\n') {
            let _ = replies.flush();
        }
    }
}

const fn length(line: &Line) -> usize {
    match line {
        Line::Whole(line) | Line::TooLong(line) | Line::Unfinished(line) => line.len(),
    }
}

fn too_many(line: &Line) -> String {
    let mebibytes = MAX_INVALID_BYTES >> 20;
    let reason = match InvalidLine::parse(line, MazeSize::CLASSIC) {
        Err(error) => error.to_string(),
        Ok(_) => String::new(),
    };
    format!("wrote {mebibytes} MiB without a valid command; last line: {reason}")
}

impl Environment for Progress {
    /// The search is over.
    type Error = ();

    fn has_wall(&mut self, cell: Cell, heading: Heading) -> Result<bool, ()> {
        Ok(self.track.read_wall(cell, heading))
    }

    fn on_pose_change(&mut self, mouse: &SimulatedMouse) -> Result<(), ()> {
        if self.add(mouse.pose(), false) { Ok(()) } else { Err(()) }
    }

    fn on_restart(&mut self, mouse: &SimulatedMouse) -> Result<(), ()> {
        if self.add(mouse.pose(), true) { Ok(()) } else { Err(()) }
    }
}

//! Executes the commands of a mouse that was written for mms.

use std::io::{BufReader, BufWriter, Read, Write};

use mmsim_maze::{Cell, CellSet, Heading, MazeSize};
use mmsim_mms::{Environment, Response, SimulatedMouse};

use super::own_search::{Kind, Over, Progress, SharedProgress, lock};
use crate::mms::child::{Line, read_line};
use crate::mms::invalid_lines::InvalidLine;

/// A mouse that has written this many bytes of invalid lines since its latest command is stopped.
const MAX_INVALID_BYTES: usize = 4 << 20;

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

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{self, Receiver};
    use std::sync::{Arc, Mutex};

    use mmsim_maze::Maze;

    use super::*;
    use crate::compare::own_search::SearchLimits;

    const MAZE: &str = "o---o---o\n| S   G |\no---o---o\n";

    /// Executes the output of a mouse, and returns the replies and the progress.
    fn execute(output: &[u8], max_states: u32) -> (String, SharedProgress, Receiver<Over>) {
        let maze: Maze = MAZE.parse().unwrap();
        let (sender, over) = mpsc::channel();
        let limits = SearchLimits { time: std::time::Duration::MAX, states: max_states };
        let progress = Arc::new(Mutex::new(Progress::new(&maze, limits, sender)));
        let mut replies = Vec::new();
        let goal = (maze.start().cell, *maze.goals());
        execute_all(BufReader::new(output), &mut replies, maze.size(), goal, &progress);
        (String::from_utf8(replies).unwrap(), progress, over)
    }

    #[test]
    fn commands_are_answered_and_invalid_lines_are_ignored() {
        let output =
            b"hello\nmazeWidth\nsetText 0 0 a\nwallFront\nturnRight\n\nmoveForward\nmoveForward\n";
        let (replies, progress, over) = execute(output, 1000);
        assert_eq!(replies, "2\ntrue\nack\nack\ncrash\n");
        let mut progress = lock(&progress);
        assert_eq!((progress.kind(), progress.crashes), (Some(Kind::Mms), 1));
        let figures = progress.track.figures();
        assert_eq!(
            (figures.steps_to_goal, figures.turns, figures.path_found),
            (Some(1), 1, Some(1))
        );
        assert!(over.try_recv().is_err());
    }

    #[test]
    fn a_search_ends_at_the_limit_of_states() {
        let (replies, progress, over) = execute(&b"turnRight\n".repeat(10), 4);
        assert_eq!(replies, "ack\nack\nack\n", "the first state is the start");
        assert_eq!(lock(&progress).track.states(), 4);
        assert!(matches!(over.try_recv(), Ok(Over::StepLimit)));
    }

    #[test]
    fn a_flood_of_invalid_lines_ends_the_search() {
        let line = b"this line is not a command of mms, but it is rather long\n";
        let flood = line.repeat(MAX_INVALID_BYTES / line.len() + 1);
        let (_, progress, over) = execute(&flood, 1000);
        assert!(lock(&progress).is_over);
        let Ok(Over::Flood(reason)) = over.try_recv() else { panic!("no flood") };
        insta::assert_snapshot!(reason, @r#"wrote 4 MiB without a valid command; last line: unknown command "this line is not a command of mms, but it is rather long""#);
        // A command now and then shows that the mouse is at work.
        let half = &flood[..flood.len() / 2];
        let (replies, progress, _) = execute(&[half, b"\nturnLeft\n", half].concat(), 1000);
        assert_eq!((&*replies, lock(&progress).is_over), ("ack\n", false));
    }
}

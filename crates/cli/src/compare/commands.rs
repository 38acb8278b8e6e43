//! Executes the commands of a mouse that was written for mms.

use std::io::{self, BufReader, BufWriter, Read, Write};

use mmsim_maze::{Cell, CellSet, Heading, MazeSize};
use mmsim_mms::{Environment, Response, SimulatedMouse};

use super::own_search::{EndSignal, MouseKind, Progress, SharedProgress, lock};
use crate::mms::child::{Line, read_line};
use crate::mms::invalid_lines::InvalidLine;

/// A mouse that has written this many bytes since its latest command is stopped.
pub(super) const MAX_INVALID_BYTES: usize = 4 << 20;

/// Executes commands until the output of the mouse ends or the search is over. Output of a mouse that
/// does not write commands is ignored.
pub(super) fn execute_all(
    output: impl Read,
    input: impl Write,
    size: MazeSize,
    (start, goals): (Cell, CellSet),
    progress: &SharedProgress,
) {
    let mut mouse = SimulatedMouse::new(size, start, goals);
    let mut output = BufReader::new(Limited { output, left: MAX_INVALID_BYTES });
    let mut replies = BufWriter::new(input);
    loop {
        // An error ends the output.
        let line = read_line(&mut output).ok().flatten();
        let mut progress = lock(progress);
        let is_client = progress.kind() == Some(MouseKind::Client);
        let is_flood = output.get_ref().left == 0;
        if is_client {
            output.get_mut().left = MAX_INVALID_BYTES;
        }
        let Some(line) = line else {
            match (is_flood, is_client) {
                (false, _) => return,
                (true, true) => continue,
                (true, false) => return progress.end(EndSignal::Flood),
            }
        };
        if progress.is_over {
            return;
        }
        let command = match InvalidLine::parse(&line, size) {
            Ok(command) => command,
            Err(_) if is_client || is_blank(&line) => continue,
            Err(error) => {
                progress.fault = Some(format!("last invalid line: {error}"));
                continue;
            }
        };
        output.get_mut().left = MAX_INVALID_BYTES;
        if !progress.accept(MouseKind::Mms) {
            continue;
        }
        if progress.track.states() == 0 {
            progress.add(mouse.pose(), false);
        }
        let Ok(reply) = mouse.execute(command, &mut *progress) else { return };
        progress.track.crashes += u32::from(reply == Some(Response::Crash));
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

fn is_blank(line: &Line) -> bool {
    matches!(line, Line::Whole(line) if line.trim_ascii().is_empty())
}

/// The output of a mouse, which ends after a number of bytes.
struct Limited<R> {
    output: R,
    /// The number of bytes until the end.
    left: usize,
}

impl<R: Read> Read for Limited<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let max = buffer.len().min(self.left);
        let length = self.output.read(&mut buffer[..max])?;
        self.left -= length;
        Ok(length)
    }
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
    fn execute(output: &[u8], max_states: u32) -> (String, SharedProgress, Receiver<EndSignal>) {
        let maze: Maze = MAZE.parse().unwrap();
        let (sender, over) = mpsc::channel();
        let limits = SearchLimits { time: std::time::Duration::MAX, states: max_states };
        let progress = Arc::new(Mutex::new(Progress::new(&maze, limits, sender)));
        let mut replies = Vec::new();
        let goal = (maze.start().cell, *maze.goals());
        execute_all(output, &mut replies, maze.size(), goal, &progress);
        (String::from_utf8(replies).unwrap(), progress, over)
    }

    #[test]
    fn commands_are_answered_and_invalid_lines_are_ignored() {
        let output =
            b"hello\nmazeWidth\nsetText 0 0 a\nwallFront\nturnRight\n\nmoveForward\nmoveForward\n";
        let (replies, progress, over) = execute(output, 1000);
        assert_eq!(replies, "2\ntrue\nack\nack\ncrash\n");
        let mut progress = lock(&progress);
        assert_eq!((progress.kind(), progress.track.crashes), (Some(MouseKind::Mms), 1));
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
        assert!(matches!(over.try_recv(), Ok(EndSignal::StepLimit)));
    }

    #[test]
    fn a_flood_of_invalid_output_ends_the_search() {
        let line = b"this line is not a command of mms, but it is rather long\n";
        let flood = line.repeat(MAX_INVALID_BYTES / line.len() + 1);
        for output in [&flood[..], &b"x".repeat(2 * MAX_INVALID_BYTES)] {
            let (_, progress, over) = execute(output, 1000);
            assert!(lock(&progress).is_over);
            assert!(matches!(over.try_recv(), Ok(EndSignal::Flood)));
        }
        // A command now and then shows that the mouse is at work.
        let half = &flood[..flood.len() / 2];
        let (replies, progress, _) = execute(&[half, b"\nturnLeft\n", half].concat(), 1000);
        assert_eq!((&*replies, lock(&progress).is_over), ("ack\n", false));
        let (_, progress, _) = execute(b"setColor 9 9 g\n\nturnLeft\n", 1000);
        let fault = lock(&progress).fault.clone().unwrap();
        insta::assert_snapshot!(fault, @r#"last invalid line: expected a cell in a maze of 2x1 cells, found "setColor 9 9 g""#);
    }

    #[test]
    fn a_client_may_print_anything() {
        let maze: Maze = MAZE.parse().unwrap();
        let limits = SearchLimits { time: std::time::Duration::MAX, states: 10 };
        let progress = Arc::new(Mutex::new(Progress::new(&maze, limits, mpsc::channel().0)));
        assert!(lock(&progress).accept(MouseKind::Client));
        let goal = (maze.start().cell, *maze.goals());
        let output = [&b"x".repeat(3 * MAX_INVALID_BYTES)[..], b"\nturnLeft\n"].concat();
        execute_all(&output[..], io::sink(), maze.size(), goal, &progress);
        let progress = lock(&progress);
        assert_eq!((progress.is_over, &progress.fault, progress.track.states()), (false, &None, 0));
    }
}

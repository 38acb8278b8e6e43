//! Runs a robot of the user in another process.

use std::io::{BufReader, PipeWriter, Write};
use std::process::Stdio;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use mmsim_maze::KnownMaze;
use mmsim_mms::excerpt;
use mmsim_trial::{Action, Robot};

use crate::commands::{InvalidLine, Line, read_lines};
use crate::process::{
    CHECK_INTERVAL, LastLine, MouseProcess, Shortage, StartError, exit_text, spawn,
};
use crate::program::Program;

/// The maximum time between the end of a robot's output and its exit.
const EXIT_TIMEOUT: Duration = Duration::from_millis(500);

/// The maximum number of answers that a robot can write ahead.
const MAX_LINES_AHEAD: usize = 64;

/// Returns true once a robot must stop.
pub type StopCheck = Arc<dyn Fn() -> bool + Send + Sync>;

/// A robot that reads lines from its stdin and writes its answers to its stdout.
///
/// The first line describes the maze. Each further line contains the readings of the three sensors,
/// and the robot answers it with a rotation and a movement, or with `reset`.
pub struct RobotProcess {
    state: Result<RunningRobot, String>,
    limit: Duration,
    must_stop: StopCheck,
}

struct RunningRobot {
    process: MouseProcess,
    stdin: PipeWriter,
    lines: Receiver<Line>,
    last_line: LastLine,
}

impl RobotProcess {
    /// Starts a robot and describes the maze to it. A program that cannot be run fails in its first
    /// step, as does a robot whose answer takes longer than `limit`, or that is still running when
    /// `must_stop` returns true. `shows_stderr` copies the stderr of the robot to that of this process.
    ///
    /// # Errors
    /// The system lacks something that the robot needs.
    pub fn start(
        program: &Program,
        unexplored: &KnownMaze,
        limit: Duration,
        must_stop: StopCheck,
        shows_stderr: bool,
    ) -> Result<Self, Shortage> {
        let state = match RunningRobot::start(program, &first_line(unexplored), shows_stderr) {
            Ok(running) => Ok(running),
            Err(StartError::Mouse(reason)) => Err(reason),
            Err(StartError::Shortage(shortage)) => return Err(shortage),
        };
        Ok(Self { state, limit, must_stop })
    }

    fn answer(&mut self, sensors: [u8; 3]) -> Result<Action, String> {
        let running = self.state.as_mut().map_err(|reason| reason.clone())?;
        let [left, front, right] = sensors;
        // A robot that does not read may still have written an answer.
        let _ = writeln!(running.stdin, "{left} {front} {right}");
        let _ = running.stdin.flush();
        let asked = Instant::now();
        loop {
            match running.lines.recv_timeout(CHECK_INTERVAL) {
                Ok(line) => return parse(&line),
                Err(RecvTimeoutError::Disconnected) => return Err(running.end()),
                Err(RecvTimeoutError::Timeout) => {}
            }
            // A child process of a robot that has exited may keep the output open.
            if asked.elapsed() >= EXIT_TIMEOUT && !matches!(running.process.status(), Ok(None)) {
                return Err(running.end());
            }
            if (self.must_stop)() {
                return Err("interrupted".into());
            }
            if asked.elapsed() >= self.limit {
                return Err(format!("no answer within {} s", self.limit.as_secs_f64()));
            }
        }
    }
}

impl Robot for RobotProcess {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        self.answer(sensors).unwrap_or_else(|reason| {
            // Dropping the process kills it.
            self.state = Err(reason);
            Action::Fail
        })
    }

    fn failure(&self) -> Option<String> {
        self.state.as_ref().err().cloned()
    }
}

impl RunningRobot {
    fn start(program: &Program, first_line: &str, shows_stderr: bool) -> Result<Self, StartError> {
        let (mut process, mut stdin, stdout) =
            MouseProcess::start_piped(program, None, Stdio::piped())?;
        let (sender, lines) = mpsc::sync_channel(MAX_LINES_AHEAD);
        spawn("stdout", move || read_lines(BufReader::new(stdout), &sender))?;
        let last_line = LastLine::from_process(&mut process, shows_stderr)?;
        // A robot that has exited is reported when it does not answer.
        let _ = stdin.write_all(first_line.as_bytes());
        Ok(Self { process, stdin, lines, last_line })
    }

    /// Returns how a robot ended whose output has ended.
    fn end(&mut self) -> String {
        let ended = Instant::now();
        loop {
            match self.process.status() {
                Ok(Some(status)) => {
                    self.process.kill_group();
                    let line = self.last_line.get();
                    let line = if line.is_empty() { line } else { format!(": {line}") };
                    return format!("{}{line}", exit_text(status));
                }
                Ok(None) if ended.elapsed() < EXIT_TIMEOUT => {
                    thread::sleep(Duration::from_millis(1));
                }
                Ok(None) => return "closed its stdout".into(),
                Err(error) => return error,
            }
        }
    }
}

/// Returns the line that describes the maze: its width and height, the start, and the goal cells.
fn first_line(unexplored: &KnownMaze) -> String {
    let (size, start) = (unexplored.size(), unexplored.start());
    let goals = unexplored.goals().iter().map(|goal| format!(" {} {}", goal.x, goal.y));
    format!(
        "maze {} {} start {} {} {} goals{}\n",
        size.width(),
        size.height(),
        start.cell.x,
        start.cell.y,
        start.heading.letter(),
        goals.collect::<String>()
    )
}

/// Parses an answer.
fn parse(line: &Line) -> Result<Action, String> {
    let line = match line {
        // The last line may lack its newline.
        Line::Whole(line) | Line::Unfinished(line) => line.trim_ascii(),
        Line::TooLong(start) => return Err(InvalidLine::TooLong(start).to_string()),
    };
    let text = str::from_utf8(line).unwrap_or_default();
    if text.eq_ignore_ascii_case("reset") {
        return Ok(Action::Reset);
    }
    let numbers = text.split_once(char::is_whitespace).and_then(|(rotation, movement)| {
        Some(Action::from_numbers(rotation.parse().ok()?, movement.trim().parse().ok()?))
    });
    numbers.ok_or_else(|| {
        format!("expected a rotation and a movement, or reset, found {}", excerpt(line))
    })
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, CellSet, MazeSize};

    use super::*;

    fn parsed(line: &[u8]) -> Result<String, String> {
        parse(&Line::Whole(line.to_vec())).map(|action| action.to_string())
    }

    #[test]
    fn the_first_line_describes_the_maze() {
        let goals = CellSet::from_iter([Cell::new(1, 1), Cell::new(2, 0)]);
        let map = KnownMaze::new(MazeSize::new(3, 2).unwrap(), Cell::new(0, 0), goals);
        assert_eq!(first_line(&map), "maze 3 2 start 0 0 N goals 2 0 1 1\n");
    }

    #[test]
    fn answers_are_two_numbers_or_reset() {
        for (line, action) in [
            (&b"90 3\n"[..], "(90, 3)"),
            (b" -90\t-2 \r\n", "(-90, -2)"),
            (b"45 100", "(0, 3)"),
            (b"reset\n", "(Reset, Reset)"),
            (b"RESET\r\n", "(Reset, Reset)"),
        ] {
            assert_eq!(parsed(line), Ok(action.into()));
        }
        for line in [
            &b""[..],
            b"90",
            b"90 3 0",
            b"ninety 3",
            b"1e2 3",
            b"\xff 1",
            b"0 99999999999999999999",
        ] {
            let error = parsed(line).unwrap_err();
            assert!(
                error.starts_with("expected a rotation and a movement, or reset, found "),
                "{error}"
            );
        }
        let error = parse(&Line::TooLong(b"lorem".to_vec())).unwrap_err();
        assert!(error.starts_with("expected at most 4096 bytes"), "{error}");
    }
}

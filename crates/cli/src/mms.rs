//! `mmsim mms`: a mouse that was written for the simulator mms searches a maze of ours.

mod args;
mod button;
mod child;
mod ended;
mod simulator;

pub(crate) use args::MmsArgs;

use std::error::Error;
use std::time::Duration;

use button::Button;
use child::{Child, Line, MAX_LINE_BYTES, Next};
use ended::{Ended, How};
use mmsim_client::{Transport, Zmq};
use mmsim_maze::{Cell, Heading, KnownMaze, Pose};
use mmsim_mms::{Command, CommandError, Excerpt, Response, SimulatedMouse};
use simulator::{Simulator, Stop};

use crate::args::wrong_usage;
use crate::hosting;
use crate::interrupt::Interrupt;
use crate::output::{complain, print, print_json, say};
use crate::selection::Collection;
use crate::solve::{ask_goals, endpoint, explain, say_waiting, told_goals};

/// How long it may take until Ctrl-C is noticed while a mouse thinks.
const GLANCE: Duration = Duration::from_millis(50);

/// A line that was begun and has no end after this time, a number of whole glances, gets none.
const LONG: Duration = Duration::from_secs(1);

/// Runs the mouse; gives the exit code.
pub(crate) fn run(args: &MmsArgs) -> Result<i32, Box<dyn Error>> {
    match &args.elsewhere.connect {
        None => in_own_maze(args),
        Some(connect) => in_maze_of(&endpoint(connect), args),
    }
}

fn in_own_maze(args: &MmsArgs) -> Result<i32, Box<dyn Error>> {
    let told = &args.elsewhere.told;
    if told.size.is_some() || !told.goal.is_empty() {
        wrong_usage("mms", "expected --connect with --size and --goal, found none");
    }
    let collection = Collection::at(args.mazes.as_deref())?;
    let selected = collection.select(&args.maze.words.join(" "))?;
    let map = KnownMaze::unexplored(&selected.maze);
    let (server, interrupt) =
        hosting::begin(selected, collection.catalogue, args.port, &args.keep, Some(&args.viewer))?;
    let address = server.address();
    let transport = Zmq::connect(address, None, |waiting| say_waiting(&waiting, false))?;
    let ended = search(args, transport, &map, &interrupt)?;
    if matches!(ended.how, How::Interrupted | How::NotStarted(_)) {
        // There is nothing more to look at.
    } else if args.stays() {
        say(format_args!("still serving at {address}; Ctrl-C ends it"));
        interrupt.wait();
    } else if !args.viewer.no_viewer {
        say("the page has gone with the mouse; --stay keeps it");
    }
    server.stop()?;
    Ok(ended.code())
}

fn in_maze_of(endpoint: &str, args: &MmsArgs) -> Result<i32, Box<dyn Error>> {
    let told = told_goals("mms", &args.elsewhere.told);
    let asks_server = told.is_none();
    let mut transport = Zmq::connect(endpoint, None, |waiting| say_waiting(&waiting, asks_server))?;
    let (map, _) = match told {
        Some((size, goals)) => {
            let start = Pose::new(Cell::new(0, 0), Heading::North);
            (KnownMaze::new(size, start.cell, goals), start)
        }
        None => ask_goals(&mut transport, args.elsewhere.told.size)?,
    };
    // A simulator that is not there yet may be waited for until Ctrl-C.
    transport.exchange(b"ping", &mut Vec::new())?;
    search(args, transport, &map, &Interrupt::catch()?).map(|ended| ended.code())
}

/// Lets the mouse search a maze of which no more is known than this, and tells how that went.
fn search(
    args: &MmsArgs,
    transport: impl Transport,
    map: &KnownMaze,
    interrupt: &Interrupt,
) -> Result<Ended, Box<dyn Error>> {
    let pace = Duration::from_millis(args.pace);
    let mut simulator = Simulator::begin(transport, map.size(), interrupt, pace)?;
    let mut search = Search {
        button: Button::from_stdin(),
        mouse: SimulatedMouse::new(map.size(), map.start(), *map.goals()),
        limit: args.limit,
        lines: 0,
        crashes: 0,
        refused: 0,
    };
    let how = match Child::start(&args.command) {
        Ok(child) => search.run(child, &mut simulator, interrupt).unwrap_or_else(|how| how),
        Err(error) => How::NotStarted(error),
    };
    let Search { mouse, crashes, refused, .. } = search;
    let ended = Ended { mouse, how, crashes, refused };
    match &ended.how {
        How::LostSimulator(error) => complain(format_args!("mmsim: {}", explain(error))),
        How::NotStarted(error) | How::Failed(error) => complain(format_args!("mmsim: {error}")),
        How::ByItself(_) | How::Limit(_) | How::Interrupted => {}
    }
    let was_started = !matches!(ended.how, How::NotStarted(_));
    if was_started {
        say(ended.summary());
    }
    if args.json {
        print_json(&serde_json::to_string(&ended.report())?)?;
    } else if args.score && was_started {
        print(&ended.scores())?;
    }
    Ok(ended)
}

/// A mouse on its way.
struct Search {
    button: Button,
    mouse: SimulatedMouse,
    limit: Option<u32>,
    lines: u64,
    crashes: u64,
    refused: u64,
}

impl Search {
    /// Does what the mouse says until it ends, or until that is stopped.
    fn run<T: Transport>(
        &mut self,
        mut child: Child,
        simulator: &mut Simulator<'_, T>,
        interrupt: &Interrupt,
    ) -> Result<How, How> {
        simulator.tell(&self.mouse)?;
        let mut silence = Duration::ZERO;
        loop {
            if interrupt.wait_for(Duration::ZERO) {
                return Err(How::Interrupted);
            }
            match child.next(GLANCE) {
                Next::Line(line) => {
                    self.answer(&line, &child, simulator)?;
                    silence = Duration::ZERO;
                }
                // What it has started may hold the pipe for longer than itself.
                Next::Silence if child.status().is_ok_and(|status| status.is_some()) => break,
                Next::Silence => {
                    silence += GLANCE;
                    if silence == LONG {
                        self.say_begun(&child.begun());
                    }
                }
                Next::End => break,
            }
        }
        child.end_replies();
        // What it showed last.
        simulator.tell(&self.mouse)?;
        let mut glance = Duration::from_millis(1);
        loop {
            let status = child.status();
            // Ctrl-C may have reached both.
            let patience = if matches!(status, Ok(None)) { glance } else { Duration::ZERO };
            if interrupt.wait_for(patience) {
                return Err(How::Interrupted);
            }
            match status {
                Ok(Some(status)) => return Ok(How::ByItself(status)),
                Ok(None) => glance = GLANCE.min(2 * glance),
                Err(error) => return Err(How::Failed(error.to_string())),
            }
        }
    }

    /// Says of a line that is not at its end yet that the mouse waits for nothing.
    fn say_begun(&self, begun: &[u8]) {
        if !begun.is_empty() {
            let (line, begun) = (self.lines + 1, Excerpt::new(begun));
            complain(format_args!(
                "mms: line {line}: expected the end of the line, found nothing yet after {begun}"
            ));
        }
    }

    fn answer<T: Transport>(
        &mut self,
        line: &Line,
        child: &Child,
        simulator: &mut Simulator<'_, T>,
    ) -> Result<(), How> {
        self.lines += 1;
        if matches!(line, Line::Whole(line) if line.trim_ascii().is_empty()) {
            return Ok(());
        }
        if self.button.was_pressed() {
            self.mouse.press_reset();
        }
        let command = match self.command(line) {
            Ok(command) => command,
            Err(error) => {
                self.refused += 1;
                complain(format_args!("mms: line {}: {error}", self.lines));
                return Ok(());
            }
        };
        let is_movement = matches!(command, Command::Forward { .. } | Command::Turn { .. });
        let reply = self.mouse.execute(command, simulator)?;
        self.crashes += u64::from(reply == Some(Response::Crash));
        if let Some(limit) = self.limit.filter(|_| is_movement)
            && self.mouse.scores().total().cost() > limit.into()
        {
            return Err(How::Limit(limit));
        }
        reply.map_or(Ok(()), |reply| child.reply(reply)).map_err(How::Failed)
    }

    fn command<'l>(&self, line: &'l Line) -> Result<Command<'l>, String> {
        match line {
            Line::Whole(line) => Command::parse(line, self.mouse.map().size())
                .map_err(|error: CommandError| error.to_string()),
            Line::TooLong(start) => Err(format!(
                "expected at most {MAX_LINE_BYTES} bytes, found more, which begin with {}",
                Excerpt::new(start)
            )),
            Line::Unfinished(line) => Err(format!(
                "expected the end of the line, found nothing after {}",
                Excerpt::new(line)
            )),
        }
    }
}

impl From<Stop> for How {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::Interrupted => Self::Interrupted,
            Stop::Failed(error) => Self::LostSimulator(error),
        }
    }
}

//! A trial that can be watched: the robot is a client that tells a simulator where it is.

use std::error::Error;
use std::io::{self, IsTerminal};
use std::time::Duration;

use mmsim_client::{Exchange, RunError, Zmq};
use mmsim_maze::{KnownMaze, Unknown};
use mmsim_trial::{RaceSteps, Trial};

use super::TrialArgs;
use super::results::Results;
use super::tried::{Contender, Tried};
use crate::args::wrong_usage;
use crate::demo::PACE_MS;
use crate::output::say;
use crate::selection::{Collection, Selected};
use crate::solve::say_waiting;
use crate::{Outcome, hosting};

/// Puts one robot on trial in one maze.
pub(crate) fn run(args: &TrialArgs, mazes: Vec<Selected>) -> Outcome {
    let (contenders, paths) = (args.contenders(), mazes.len());
    let [contender] = &contenders[..] else {
        let found = format!("expected one robot with --serve, found {}", contenders.len());
        wrong_usage("trial", &found);
    };
    let Ok([selected]) = <[Selected; 1]>::try_from(mazes) else {
        wrong_usage("trial", &format!("expected one maze with --serve, found {paths}"));
    };
    let watch = &args.watch;
    // A maze that is no file is one of the bundled ones.
    let collection = Collection::at(Some(&*selected.path).filter(|path| path.exists()))?;
    let viewer = (!watch.once).then_some(&watch.viewer);
    let (server, interrupt) =
        hosting::begin(selected.clone(), collection.catalogue, watch.port, &watch.keep, viewer)?;
    let pace = watch.pace.unwrap_or(if io::stdout().is_terminal() { PACE_MS } else { 0 });
    let pause = || interrupt.wait_for(Duration::from_millis(pace));
    let tried = Client::connect(server.address())
        .and_then(|client| client.stand_trial(contender, &selected, pause));
    let mut is_done = true;
    if let Some(tried) = tried? {
        let jobs = [(&selected, contender)];
        let mut results = Results::new(&jobs, args);
        results.add(vec![tried])?;
        is_done = results.finish()?;
        if !watch.once {
            say(format_args!("still serving at {}; Ctrl-C ends it", server.address()));
            interrupt.wait();
        }
    }
    server.stop()?;
    Ok(is_done || !watch.once)
}

/// Why a trial broke off.
enum Stop {
    Interrupted,
    Failed(RunError),
}

/// A client of the simulator that asks it nothing.
struct Client<'a> {
    simulator: Exchange<Zmq<'a>>,
}

impl Client<'_> {
    fn connect(address: &str) -> Result<Self, Box<dyn Error>> {
        let transport = Zmq::connect(address, None, |waiting| say_waiting(&waiting, false))?;
        Ok(Self { simulator: Exchange::new(transport) })
    }

    /// Lets the robot explore and race and tells of each moment. `None` if `pause` between two
    /// steps says that it is enough.
    fn stand_trial(
        mut self,
        contender: &Contender,
        selected: &Selected,
        pause: impl Fn() -> bool,
    ) -> Result<Option<Tried>, Box<dyn Error>> {
        self.simulator.reset()?;
        let tried = contender.stand_watched(&selected.maze, |trial, seen| {
            self.tell_state(trial, seen).map_err(Stop::Failed)?;
            if pause() { Err(Stop::Interrupted) } else { Ok(()) }
        });
        match tried {
            Ok(tried) => Ok(Some(tried)),
            Err(Stop::Interrupted) => Ok(None),
            Err(Stop::Failed(error)) => Err(error.into()),
        }
    }

    /// Where the robot is, what it has seen, and how many steps of a race it may be to the goal.
    fn tell_state(&mut self, trial: &Trial<'_>, seen: &KnownMaze) -> Result<(), RunError> {
        let steps = RaceSteps::flood(seen.walls(Unknown::Open), seen.goals());
        self.simulator.state(trial.pose(), seen, |cell| steps.at(cell).unwrap_or(u16::MAX))
    }
}

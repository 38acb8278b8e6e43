//! Runs a custom strategy against a simulator.
//!
//! Start a simulator with `mmsim`, then run this program, optionally with an endpoint such as
//! `tcp://127.0.0.1:6574`. The strategy also runs in memory and on a real mouse.

use std::error::Error;
use std::ops::ControlFlow;
use std::process::ExitCode;
use std::time::Duration;

use mmsim_client::{Exchange, Timeout, Zmq, search_run};
use mmsim_maze::{Cell, KnownMaze, Pose};
use mmsim_solvers::{Mouse, Move, SearchError, Strategy, open_steps};

/// Goes to the least visited neighbour. If several neighbours qualify, the strategy chooses the
/// neighbour nearest to the goal, ignoring walls.
#[derive(Default)]
struct Explorer {
    visits: [[u16; 32]; 32],
}

impl Strategy for Explorer {
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
        self.visits[usize::from(pose.cell.x)][usize::from(pose.cell.y)] += 1;
        if map.goals().contains(pose.cell) {
            return Ok(Move::Stop);
        }
        let distance = |cell: Cell| {
            map.goals().iter().map(|goal| cell.x.abs_diff(goal.x) + cell.y.abs_diff(goal.y)).min()
        };
        open_steps(map, pose)
            .min_by_key(|&(_, cell)| (self.weight(cell), distance(cell)))
            .map(|(step, _)| Move::Step(step))
            .ok_or(SearchError::BoxedIn { cell: pose.cell })
    }

    /// Returns the number that a viewer shows in a cell.
    fn weight(&self, cell: Cell) -> Option<u16> {
        Some(self.visits[usize::from(cell.x)][usize::from(cell.y)])
    }
}

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Searches the maze and returns true if the goal was reached.
fn run() -> Result<bool, Box<dyn Error>> {
    let variable = std::env::var("MMSIM_ENDPOINT").ok();
    let endpoint = std::env::args().nth(1).or_else(|| variable.clone());
    let endpoint = endpoint.unwrap_or("tcp://127.0.0.1:6574".into());
    // `mmsim run` sets the variable. It holds replies while the mouse is paused.
    let is_run = variable == Some(endpoint.clone());
    let timeout = if is_run { Timeout::Never } else { Timeout::After(Duration::from_secs(5)) };
    let mut transport = Zmq::connect(&endpoint, timeout, |waiting| {
        if !waiting.answered {
            eprintln!("no reply from {} yet", waiting.endpoint);
        }
    })?;

    // Only mmsim describes its maze. For another simulator, use `KnownMaze::new`.
    let info = Exchange::new(&mut transport).info()?;
    let (Some(map), Some(start)) = (info.known_maze(), info.start_pose()) else {
        return Err("expected a maze of 1x1 to 32x32 cells".into());
    };
    let mut mouse = Mouse::new(Explorer::default(), map, start);
    // Called after each state: inspect it here, or sleep to slow the mouse down.
    let observe = |_: &Mouse<Explorer>, _: &_| ControlFlow::Continue(());
    let run = search_run(&mut transport, &mut mouse, 1000, observe)?;

    print!("{}", mouse.map().picture().with_mouse(mouse.pose()));
    let goal = if run.stats.goal_reached() { "goal reached" } else { "goal not reached" };
    println!("{goal} after {} steps", run.stats.steps());
    Ok(run.stats.goal_reached())
}

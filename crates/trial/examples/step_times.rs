//! Measures how long the champion takes per step in complete trials, with noise-free and noisy
//! sensors. For each file or folder, prints the median, the 99th percentile and the maximum of the
//! step times in its mazes.
//!
//! Each trial runs three times, and only the fastest time of each step counts, which reduces the
//! influence of other processes.
//!
//! ```sh
//! cargo run --release -p mmsim-trial --example step_times -- MAZES...
//! ```

use std::error::Error;
use std::path::Path;
use std::time::{Duration, Instant};

use mmsim_formats::Catalogue;
use mmsim_maze::{KnownMaze, Maze};
use mmsim_trial::{
    Action, Champion, Robot, SensorNoise, StoppingRule, WallPrior, run_observed_trial,
};

/// A robot that records the duration of each step.
struct TimedRobot<R> {
    robot: R,
    steps: Vec<Duration>,
}

impl<R: Robot> Robot for TimedRobot<R> {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        let start = Instant::now();
        let action = self.robot.next_move(sensors);
        self.steps.push(start.elapsed());
        action
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("{:>9} {:>9} {:>9} {:>9}  noise, mazes", "steps", "median", "99 %", "maximum");
    for path in std::env::args().skip(1) {
        let catalogue = Catalogue::from_path(Path::new(&path))?;
        let mazes: Vec<Maze> =
            catalogue.entries().iter().map(mmsim_formats::Entry::maze).collect::<Result<_, _>>()?;
        for noise in [0., 0.1] {
            let mut steps: Vec<Duration> =
                mazes.iter().flat_map(|maze| fastest_of_three(maze, noise)).collect();
            steps.sort_unstable();
            let Some(last) = steps.len().checked_sub(1) else { continue };
            let ms = |index: usize| format!("{:.3} ms", steps[index].as_secs_f64() * 1e3);
            let [median, percentile, max] = [last / 2, last * 99 / 100, last].map(ms);
            println!("{:>9} {median} {percentile} {max}  {noise}, {path}", steps.len());
        }
    }
    Ok(())
}

fn fastest_of_three(maze: &Maze, noise: f64) -> Vec<Duration> {
    let run = || {
        let (unexplored, rule) = (KnownMaze::unexplored(maze), StoppingRule::default());
        let robot = Champion::new(unexplored, rule, WallPrior::CONTEST, noise, 0);
        let mut timed = TimedRobot { robot, steps: Vec::new() };
        run_observed_trial(maze, &mut timed, &mut SensorNoise::new(noise, 1), |_, _, _| {});
        timed.steps
    };
    let [first, second, third] = [(); 3].map(|()| run());
    let fastest = |((a, b), c): ((Duration, Duration), Duration)| a.min(b).min(c);
    first.into_iter().zip(second).zip(third).map(fastest).collect()
}

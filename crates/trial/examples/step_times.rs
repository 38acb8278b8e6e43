//! How long the champion takes to answer a step: median, 99th percentile and worst, over whole
//! trials in all mazes of the paths told, with sensors that are right and with sensors that err.
//!
//! Each trial is run three times, and of each step the least time counts: what else runs on the
//! machine then hardly does.
//!
//! ```sh
//! cargo run --release -p mmsim-trial --example step_times -- MAZES...
//! ```

use std::error::Error;
use std::path::Path;
use std::time::{Duration, Instant};

use mmsim_formats::Catalogue;
use mmsim_maze::{KnownMaze, Maze};
use mmsim_trial::{Action, Champion, Habits, Noise, Robot, Rule, try_watched};

/// A robot, and how long it took for each step.
struct Timed<R> {
    robot: R,
    steps: Vec<Duration>,
}

impl<R: Robot> Robot for Timed<R> {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        let begin = Instant::now();
        let action = self.robot.next_move(sensors);
        self.steps.push(begin.elapsed());
        action
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("{:>9} {:>9} {:>9} {:>9}  noise, mazes", "steps", "median", "99 %", "worst");
    for path in std::env::args().skip(1) {
        let catalogue = Catalogue::from_path(Path::new(&path))?;
        let mazes: Vec<Maze> =
            catalogue.entries().iter().map(mmsim_formats::Entry::maze).collect::<Result<_, _>>()?;
        for noise in [0., 0.1] {
            let mut steps: Vec<Duration> =
                mazes.iter().flat_map(|maze| least_of_three(maze, noise)).collect();
            steps.sort_unstable();
            let Some(last) = steps.len().checked_sub(1) else { continue };
            let ms = |index: usize| format!("{:.3} ms", steps[index].as_secs_f64() * 1e3);
            let [median, most, worst] = [last / 2, last * 99 / 100, last].map(ms);
            println!("{:>9} {median} {most} {worst}  {noise}, {path}", steps.len());
        }
    }
    Ok(())
}

fn least_of_three(maze: &Maze, noise: f64) -> Vec<Duration> {
    let run = || {
        let before = KnownMaze::unexplored(maze);
        let robot = Champion::new(before, Rule::default(), Habits::CONTEST, noise, 0);
        let mut timed = Timed { robot, steps: Vec::new() };
        try_watched(maze, &mut timed, &mut Noise::new(noise, 1), |_, _, _| {});
        timed.steps
    };
    let [first, second, third] = [(); 3].map(|()| run());
    let least = |((a, b), c): ((Duration, Duration), Duration)| a.min(b).min(c);
    first.into_iter().zip(second).zip(third).map(least).collect()
}

//! Checks that mmsim reproduces recorded runs of the original two-run trial, and that the robots
//! take the expected numbers of steps.

use std::fs;
use std::thread;

use mmsim_formats::Catalogue;
use mmsim_maze::{Cell, Heading, KnownMaze, Maze, Pose};
use mmsim_tests::{json_lines, shared};
use mmsim_trial::{
    Action, BundledRobot, CountExpansion, KeyPoints, Robot, Score, Settings, SwingAsPublished,
    Trial, TrialOutcome, TrialPhase, Variant, race_optimum, run_trial,
};
use serde::Deserialize;

/// A run that was recorded with the tester of the original two-run trial.
#[derive(Deserialize)]
struct RecordedTrial {
    maze: String,
    steps: Vec<([u8; 3], RecordedAction)>,
    explore_steps: Option<u32>,
    race_steps: Option<u32>,
    score: Option<String>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum RecordedAction {
    Move(i64, i64),
    /// `["Reset", "Reset"]`
    Reset(String, String),
}

impl From<&RecordedAction> for Action {
    fn from(action: &RecordedAction) -> Self {
        match action {
            RecordedAction::Move(rotation, movement) => Self::from_numbers(*rotation, *movement),
            RecordedAction::Reset(first, second) => {
                assert_eq!((first.as_str(), second.as_str()), ("Reset", "Reset"));
                Self::Reset
            }
        }
    }
}

#[test]
fn recorded_runs_are_reproduced() {
    let (Some(transcripts), Some(mazes)) = (shared("transcripts"), shared("mazes/trial")) else {
        return;
    };
    let is_trial = |name: &str| name.starts_with("trial.");
    let files = fs::read_dir(transcripts).unwrap().map(|entry| entry.unwrap());
    let files: Vec<_> =
        files.filter(|file| is_trial(&file.file_name().to_string_lossy())).collect();
    let mut runs = 0;
    for file in files {
        for (number, recorded) in (1..).zip(json_lines::<RecordedTrial>(&file.path())) {
            let run = format!("{}, run {number}", file.path().display());
            let maze = mmsim_formats::read_maze(&mazes.join(&recorded.maze)).unwrap();
            let mut trial = Trial::new(&maze);
            for (step, (readings, action)) in (1..).zip(&recorded.steps) {
                assert_eq!(trial.outcome(), None, "{run}, step {step}");
                assert_eq!(trial.readings(), *readings, "{run}, step {step}");
                trial.act(action.into());
            }
            match (trial.outcome(), recorded.score) {
                (Some(TrialOutcome::Scored(score)), Some(expected)) => {
                    assert_eq!(Some(score.explore_steps), recorded.explore_steps, "{run}");
                    assert_eq!(Some(score.race_steps), recorded.race_steps, "{run}");
                    assert_eq!(score.to_string(), expected, "{run}");
                }
                (ending, score) => {
                    assert_eq!((ending, score), (Some(TrialOutcome::OutOfTime), None), "{run}");
                }
            }
            runs += 1;
        }
    }
    assert!(runs >= 180, "found only {runs} runs");
}

/// The sensor readings, the action, and the pose after the action: x, y and the heading.
type SwingStep = ([u8; 3], RecordedAction, (u8, u8, char));

/// A run of the published swing robot or of a copy with another tour.
#[derive(Deserialize)]
struct RecordedSwing {
    maze: String,
    variant: String,
    key_points: u8,
    goals_run1: Vec<(u8, u8)>,
    steps: Vec<SwingStep>,
    explore: u32,
    race: u32,
}

/// Reads one of the three published mazes, or the altered one.
fn published_maze(name: &str) -> Option<Maze> {
    let folder = if name == "test_maze_created" { "trial-altered" } else { "mazes/trial" };
    Some(mmsim_formats::read_maze(&shared(folder)?.join(name).with_extension("txt")).unwrap())
}

#[test]
fn published_swing_is_reproduced_step_by_step() {
    let Some(transcripts) = shared("transcripts") else { return };
    let runs = json_lines::<RecordedSwing>(&transcripts.join("published-swing.jsonl"));
    assert_eq!(runs.len(), 48);
    for recorded in runs {
        let run = format!("{}, {} {}", recorded.maze, recorded.variant, recorded.key_points);
        let Some(maze) = published_maze(&recorded.maze) else { return };
        let unexplored = KnownMaze::unexplored(&maze);
        let tour: Vec<Cell> = recorded.goals_run1.iter().map(|&(x, y)| Cell::new(x, y)).collect();
        let mut robot: Box<dyn Robot> = if recorded.variant == "count-expansion" {
            Box::new(CountExpansion::new(unexplored))
        } else {
            Box::new(SwingAsPublished::with_tour(&unexplored, &tour))
        };
        let mut trial = Trial::new(&maze);
        for (number, (readings, action, (x, y, heading))) in (1..).zip(&recorded.steps) {
            assert_eq!(trial.readings(), *readings, "{run}, step {number}");
            assert_eq!(robot.next_move(*readings), action.into(), "{run}, step {number}");
            trial.act(action.into());
            let heading = Heading::from_letter(*heading).unwrap();
            let pose = Pose::new(Cell::new(*x, *y), heading);
            assert_eq!(trial.pose(), pose, "{run}, step {number}");
        }
        let score = Score { explore_steps: recorded.explore, race_steps: recorded.race };
        assert_eq!(trial.outcome(), Some(TrialOutcome::Scored(score)), "{run}");
    }
}

#[test]
fn race_optima_match_the_published_optima() {
    let Some(mazes) = shared("mazes/trial") else { return };
    for (name, expected) in [("test_maze_01", 17), ("test_maze_02", 22), ("test_maze_03", 25)] {
        let maze = mmsim_formats::read_maze(&mazes.join(name).with_extension("txt")).unwrap();
        let optimum = race_optimum(maze.walls(), maze.start().cell, maze.goals());
        assert_eq!(optimum, Some(expected), "{name}");
    }
}

/// A robot's exploration and race steps in each of the three published mazes.
type PublishedMazeSteps = [(u32, u32); 3];

fn steps(robot: BundledRobot, settings: &Settings) -> Option<PublishedMazeSteps> {
    let mazes = shared("mazes/trial")?;
    let scored_steps = |number| {
        let maze =
            mmsim_formats::read_maze(&mazes.join(format!("test_maze_0{number}.txt"))).unwrap();
        let mut robot = robot.robot(KnownMaze::unexplored(&maze), settings);
        match run_trial(&maze, &mut robot) {
            TrialOutcome::Scored(score) => (score.explore_steps, score.race_steps),
            outcome => panic!("{outcome:?} in maze {number}"),
        }
    };
    Some([1, 2, 3].map(scored_steps))
}

#[test]
fn swing_is_at_least_as_good_as_the_published_code() {
    let published = [
        (Variant::JustArrive, [(32, 43), (58, 47), (76, 47)], [(33, 24), (68, 31), (66, 31)]),
        (
            Variant::ArriveAndBack,
            [(78, 28), (110, 44), (136, 48)],
            [(66, 17), (108, 26), (114, 31)],
        ),
        (Variant::All, [(187, 17), (235, 33), (293, 36)], [(137, 17), (206, 26), (252, 27)]),
    ];
    for (variant, theirs, expected) in published {
        let settings = Settings { variant, ..Settings::default() };
        let Some(ours) = steps(BundledRobot::Swing, &settings) else { return };
        for (ours, theirs) in ours.into_iter().zip(theirs) {
            let thirtieths = |(explore, race): (u32, u32)| explore + 30 * race;
            assert!(
                thirtieths(ours) <= thirtieths(theirs),
                "{variant}: {ours:?} is worse than {theirs:?}"
            );
        }
        assert_eq!(ours, expected, "{variant} (listed in the README of the crate)");
    }
    let timed = [
        (Variant::JustArrive, [(57, 26), (49, 25), (61, 28)]),
        (Variant::ArriveAndBack, [(84, 17), (89, 25), (104, 28)]),
        (Variant::All, [(144, 17), (183, 22), (225, 25)]),
    ];
    for (variant, expected) in timed {
        let settings = Settings { variant, ..Settings::default() };
        assert_eq!(steps(BundledRobot::SwingTimed, &settings), Some(expected), "{variant}");
    }
    let swing = [
        [(91, 17), (136, 26), (152, 29)],
        [(117, 17), (168, 26), (214, 27)],
        [(122, 17), (189, 26), (218, 27)],
        [(137, 17), (206, 26), (252, 27)],
    ];
    let timed = [
        [(106, 17), (116, 22), (146, 25)],
        [(133, 17), (162, 22), (193, 25)],
        [(132, 17), (166, 22), (199, 25)],
        [(144, 17), (183, 22), (225, 25)],
    ];
    for (robot, corners) in [(BundledRobot::Swing, swing), (BundledRobot::SwingTimed, timed)] {
        for (key_points, expected) in KeyPoints::ALL.iter().copied().zip(corners) {
            let settings = Settings { key_points, ..Settings::default() };
            assert_eq!(steps(robot, &settings), Some(expected), "{robot}, {key_points} key points");
        }
    }
}

/// The scores of the five tours in the three published mazes and the altered one, as the report
/// shows them.
#[test]
fn published_swing_gives_the_figures_of_the_report() {
    let report = [
        (Variant::JustArrive, 3, "32+43=44.067 58+47=48.933 76+47=49.533 46+48=49.533"),
        (Variant::ArriveAndBack, 3, "100+26=29.333 130+44=48.333 157+42=47.233 98+41=44.267"),
        (Variant::All, 1, "137+28=32.567 193+44=50.433 249+32=40.300 170+20=25.667"),
        (Variant::All, 2, "187+17=23.233 232+33=40.733 287+36=45.567 217+19=26.233"),
        (Variant::All, 3, "187+17=23.233 235+33=40.833 293+36=45.767 208+19=25.933"),
    ];
    for (variant, corners, expected) in report {
        let key_points = KeyPoints::ALL[corners];
        let settings = Settings { variant, key_points, ..Settings::default() };
        let mut found = Vec::new();
        for name in ["test_maze_01", "test_maze_02", "test_maze_03", "test_maze_created"] {
            let Some(maze) = published_maze(name) else { return };
            let unexplored = KnownMaze::unexplored(&maze);
            let mut robot = BundledRobot::SwingAsPublished.robot(unexplored, &settings);
            let TrialOutcome::Scored(score) = run_trial(&maze, &mut robot) else {
                panic!("no score in {name}")
            };
            found.push(format!("{}+{}={score}", score.explore_steps, score.race_steps));
        }
        assert_eq!(found.join(" "), expected, "{variant}, {key_points} corners");
    }
}

/// The figures of docs/trial.md for the maze in which the shorter path first leads away from the goal.
#[test]
fn robots_that_stop_at_the_goal_take_the_wrong_turn() {
    let maze = mmsim_formats::parse_maze(mmsim_mazes::WRONG_TURN.as_bytes()).unwrap();
    for (robot, variant, expected) in [
        (BundledRobot::CountExpansion, Variant::All, "45 + 79 = 80.500"),
        (BundledRobot::SwingAsPublished, Variant::JustArrive, "46 + 84 = 85.533"),
        (BundledRobot::SwingAsPublished, Variant::All, "288 + 19 = 28.600"),
        (BundledRobot::Swing, Variant::All, "237 + 19 = 26.900"),
    ] {
        let settings = Settings { variant, ..Settings::default() };
        let mut ready = robot.robot(KnownMaze::unexplored(&maze), &settings);
        let TrialOutcome::Scored(score) = run_trial(&maze, &mut ready) else { panic!("{robot}") };
        let found = format!("{} + {} = {score}", score.explore_steps, score.race_steps);
        assert_eq!(found, expected, "{robot}, {variant}");
    }
}

/// In mazes of another kind, the published program may crash.
#[test]
fn published_swing_crashes_as_often_as_the_published_program() {
    let Some(folder) = shared("mazes/classic") else { return };
    let (mut scores, mut crashed, mut out_of_time) = (Vec::new(), 0, 0);
    for entry in Catalogue::from_path(&folder).unwrap().entries() {
        let maze = entry.maze().unwrap();
        let unexplored = KnownMaze::unexplored(&maze);
        let mut robot = BundledRobot::SwingAsPublished.robot(unexplored, &Settings::default());
        match run_trial(&maze, &mut robot) {
            TrialOutcome::Scored(score) => scores.push(score.value()),
            TrialOutcome::Failed => {
                assert!(robot.failure().is_some_and(|reason| reason.starts_with("no path to (")));
                crashed += 1;
            }
            TrialOutcome::OutOfTime => out_of_time += 1,
            TrialOutcome::GaveUp => panic!("gave up in {}", entry.name()),
        }
    }
    assert_eq!((scores.len(), crashed, out_of_time), (217, 32, 1));
    let mean = scores.iter().sum::<f64>() / 217.;
    assert_eq!(format!("{mean:.3}"), "49.604");
}

#[test]
fn count_expansion_matches_the_published_steps() {
    let Some(found) = steps(BundledRobot::CountExpansion, &Settings::default()) else { return };
    let scores = found.map(|(explore_steps, race_steps)| {
        (explore_steps, race_steps, Score { explore_steps, race_steps }.to_string())
    });
    let published = [(33, 43, "44.100"), (56, 47, "48.867"), (75, 48, "50.500")];
    assert_eq!(scores, published.map(|(explore, race, score)| (explore, race, score.to_owned())));
}

/// Mazes that do not resemble contest mazes.
const UNUSUAL_MAZES: [&str; 9] = [
    "o---o\n|SG |\no---o\n",
    "o---o---o---o\n| S   G   G |\no---o---o---o\n",
    "o---o\n| S |\no   o\n| G |\no---o\n",
    "o---o\n| S |\no   o\n|   |\no   o\n|   |\no   o\n|   |\no   o\n| G |\no---o\n",
    "o---o---o\n|     G |\no   o---o\n|   | S |\no   o   o\n|       |\no---o---o\n",
    "o---o---o---o\n|   | G |   |\no---o---o   o\n| S         |\no---o---o---o\n",
    "o---o\n| G |\no---o\n| S |\no---o\n",
    "o---o---o---o\n| G | S | G |\no---o   o   o\n|           |\no---o---o---o\n",
    "o---o---o---o\n|         G |\no   o---o---o\n| S | G     |\no---o---o---o\n",
];

#[test]
fn every_robot_finishes_in_unusual_mazes() {
    for text in UNUSUAL_MAZES {
        let maze: Maze = text.parse().unwrap();
        let optimum = race_optimum(maze.walls(), maze.start().cell, maze.goals());
        for (robot, settings) in robots() {
            let ending =
                run_trial(&maze, &mut robot.robot(KnownMaze::unexplored(&maze), &settings));
            match (optimum, ending) {
                (Some(optimum), TrialOutcome::Scored(score)) => {
                    assert!(score.race_steps >= optimum.into());
                }
                (None, TrialOutcome::GaveUp) => {}
                (_, outcome) => panic!("{robot} {settings:?}: {outcome:?} in\n{text}"),
            }
        }
    }
}

/// Returns each robot that finishes in any maze, with every combination of [`Variant`] and
/// [`KeyPoints`].
fn robots() -> impl Iterator<Item = (BundledRobot, Settings)> {
    let settings = Variant::ALL.iter().flat_map(|&variant| {
        let settings = move |&key_points| Settings { key_points, variant, ..Settings::default() };
        KeyPoints::ALL.iter().map(settings)
    });
    settings.flat_map(|settings| finishing_robots().map(move |robot| (robot, settings)))
}

/// Returns all robots except those that may run out of time or fail.
fn finishing_robots() -> impl Iterator<Item = BundledRobot> {
    let may_fail = [BundledRobot::Random, BundledRobot::SwingAsPublished];
    BundledRobot::ALL.iter().copied().filter(move |robot| !may_fail.contains(robot))
}

#[test]
fn robots_score_in_solvable_mazes_and_give_up_in_others() {
    for kind in ["classic", "halfsize", "training", "trial"] {
        let Some(folder) = shared(&format!("mazes/{kind}")) else { return };
        // All mazes take minutes in an unoptimised build.
        let sample = if cfg!(debug_assertions) { 12 } else { 1 };
        for entry in Catalogue::from_path(&folder).unwrap().entries().iter().step_by(sample) {
            let maze = entry.maze().unwrap();
            let optimum = race_optimum(maze.walls(), maze.start().cell, maze.goals());
            for robot in finishing_robots() {
                let mut ready = robot.robot(KnownMaze::unexplored(&maze), &Settings::default());
                let ending = run_trial(&maze, &mut ready);
                let name = entry.name();
                match (optimum, ending) {
                    (Some(_), TrialOutcome::Scored(_)) | (None, TrialOutcome::GaveUp) => {}
                    // In a large maze, or on a long winding path, Swing may exceed the step limit.
                    (Some(optimum), TrialOutcome::OutOfTime)
                        if kind == "halfsize" || optimum > 200 => {}
                    (optimum, outcome) => {
                        panic!("{name}: {robot}: {outcome:?}, optimum {optimum:?}")
                    }
                }
            }
        }
    }
}

#[test]
fn champion_beats_the_best_public_robots_on_average() {
    // The scores of three different robots, the best public ones.
    let best = [19.033, 27.667, 28.667];
    let names = ["test_maze_01", "test_maze_02", "test_maze_03"];
    let Some(mazes) = names.map(published_maze).into_iter().collect::<Option<Vec<_>>>() else {
        return;
    };
    let score = |maze: &Maze, seed| {
        let settings = Settings { seed, ..Settings::default() };
        let mut champion = BundledRobot::Champion.robot(KnownMaze::unexplored(maze), &settings);
        match run_trial(maze, &mut champion) {
            TrialOutcome::Scored(score) => score.value(),
            other => panic!("{other:?} with seed {seed}"),
        }
    };
    let first: Vec<f64> = mazes.iter().map(|maze| score(maze, 0)).collect();
    assert!(first.iter().zip(best).all(|(&score, best)| score < best), "{first:?}");
    // Only in the first maze do the scores of many seeds lie around that of the best public robot.
    let few = if cfg!(debug_assertions) { 16 } else { 256 };
    let mean = |(maze, seeds): (&Maze, u32)| {
        let sum = |first| (first..seeds).step_by(2).map(|seed| score(maze, seed.into())).sum();
        // Each half takes a minute in an unoptimised build.
        let (even, odd): (f64, f64) = thread::scope(|scope| {
            let even = scope.spawn(|| sum(0));
            (sum(1), even.join().unwrap())
        });
        (even + odd) / f64::from(seeds)
    };
    let means: Vec<f64> = mazes.iter().zip([256, few, few]).map(mean).collect();
    assert!(means.iter().zip(best).all(|(&mean, best)| mean < best), "{means:?}");
    assert!(means.iter().sum::<f64>() <= 73.2, "{means:?}");
}

/// In the report, the random robot finds the goal in the first run of 3 of its 6 trials. A robot that
/// picks among the open directions finds it in 72 % to 88 % of the trials in the first maze.
#[test]
fn random_finds_the_goal_of_the_first_maze_as_often_as_the_published_robot() {
    let Some(maze) = published_maze("test_maze_01") else { return };
    let finds_goal = |&seed: &u64| {
        let settings = Settings { seed, ..Settings::default() };
        let mut robot = BundledRobot::Random.robot(KnownMaze::unexplored(&maze), &settings);
        let mut trial = Trial::new(&maze);
        while trial.act(robot.next_move(trial.readings())).is_none() {}
        trial.phase() == TrialPhase::Race
    };
    let found = (0..1000).filter(finds_goal).count();
    assert!((720..=880).contains(&found), "{found} of 1000 trials");
}

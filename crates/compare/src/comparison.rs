//! The comparison of searches: rows, the ranking, statistics and an overview.

use std::collections::BTreeMap;

use mmsim_fastrun::{Planners, Vehicle, VehicleParameters};
use mmsim_maze::{Escaped, counted};
use mmsim_report::{Comparison, Measure, MeasureStatistics, Statistics};
use mmsim_run::{Cause, Divergence, Ending, SearchFigures, SearchTimes, Senses};
use serde::Serialize;

use crate::baseline::Changes;
use crate::compared_mouse::ComparedMouse;
use crate::measures::{MEASURES, SearchMeasure};
use crate::named_maze::{NamedMaze, unique_names};
use crate::ranking::Ranking;
use crate::searches::measure_times;

/// The explanation of the ranking.
const CAPTION: &str = "\
Lost: mean time beyond the shortest search of these mice and the fastest run of the maze. In \
brackets: the best rival and its loss.";

/// A search of a mouse in a maze. The field names are JSON keys and CSV column names.
#[derive(Clone, Debug, Serialize)]
pub struct SearchRow {
    /// The maze.
    #[serde(flatten)]
    pub maze: MazeColumns,
    /// The figures of the search.
    #[serde(flatten)]
    pub figures: SearchFigures,
    /// The times with a vehicle, if they have been measured.
    #[serde(flatten)]
    pub times: Option<SearchTimes>,
    /// The cause that the mouse has not reached the goal, if it is known.
    pub cause: Option<Cause>,
    /// Where a repetition differed, if one did.
    pub random: Option<Divergence>,
}

/// The maze of a row. The field names are JSON keys and CSV column names.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct MazeColumns {
    /// The path of the file, or an empty string.
    pub path: String,
    /// The name.
    pub maze: String,
    /// The width in cells.
    pub width: u8,
    /// The height in cells.
    pub height: u8,
}

impl MazeColumns {
    /// Creates the columns of a maze that is called `name` here.
    pub(crate) fn new(maze: &NamedMaze, name: &str) -> Self {
        let (path, size) = (maze.path.display().to_string(), maze.maze.size());
        Self { path, maze: name.into(), width: size.width(), height: size.height() }
    }
}

impl SearchRow {
    /// Creates the row for the search of a mouse in a maze.
    pub fn new(maze: &NamedMaze, figures: SearchFigures) -> Self {
        let SearchFigures { times, cause, random, .. } = figures;
        Self { maze: MazeColumns::new(maze, &maze.name), times, cause, random, figures }
    }
}

/// The comparison of several mice in several mazes.
pub struct SearchComparison {
    /// The values, the ranking and why each mouse loses time, for charts and HTML.
    pub comparison: Comparison,
    /// What the ranking means, the vehicles, and how mice misread walls.
    pub notes: Vec<String>,
    /// A table of how often each mouse succeeded, with a header.
    pub overview: Vec<Vec<String>>,
    /// The statistics of each measure.
    pub statistics: Vec<MeasureStatistics>,
    /// The summary of each mouse.
    pub mice: Vec<MouseSummary>,
}

/// All searches of a mouse. The field names are JSON keys.
#[derive(Debug, Serialize)]
pub struct MouseSummary {
    /// The name of the mouse.
    pub mouse: String,
    /// The command of a mouse of the user.
    pub command: Option<String>,
    /// The rank, and why the mouse loses time.
    #[serde(flatten)]
    pub ranking: Ranking,
    goal_reached: usize,
    /// The number of mazes in which the mouse correctly reported that the goal is unreachable.
    gave_up_rightly: usize,
    /// The number of all other mazes.
    failed: usize,
    /// The number of mazes in which the goal was reached and the shortest path was proven.
    proven: usize,
    /// The number of mazes in which the goal was reached and the path found is as short as the
    /// shortest path in the true maze.
    shortest_path_found: usize,
    /// The number of mazes in which the fast run takes as little time as the fastest run of the true
    /// maze.
    fastest_run_found: usize,
    /// The number of searches with each ending.
    endings: BTreeMap<Ending, usize>,
    /// The statistics of each measure.
    statistics: BTreeMap<&'static str, Statistics>,
    /// What is better and worse than in a saved comparison, if there is one with this mouse.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub changes: Option<Changes>,
    /// The searches, one for each maze.
    pub mazes: Vec<SearchRow>,
}

impl SearchComparison {
    /// Compares the figures of each mouse in each maze, and its times with one vehicle or with the
    /// default vehicle of each maze. The overview of mice that misread walls counts fast runs and crashes.
    pub fn new(
        mice: &[ComparedMouse],
        mazes: &[NamedMaze],
        mut figures: Vec<Vec<SearchFigures>>,
        vehicle: Option<Vehicle>,
        senses: &Senses,
    ) -> Self {
        let planners = Planners::new(vehicle);
        measure_times(&mut figures, mazes, &planners);
        let searches = figures.into_iter().map(|figures| {
            let searches = mazes.iter().zip(figures);
            searches.map(|(maze, figures)| SearchRow::new(maze, figures)).collect()
        });
        let searches: Vec<Vec<SearchRow>> = searches.collect();
        let names = mice.iter().map(|mouse| mouse.name().to_string()).collect();
        let maze_names = unique_names(mazes);
        let columns = mazes.iter().zip(&maze_names);
        let columns: Vec<_> = columns.map(|(maze, name)| MazeColumns::new(maze, name)).collect();
        let mut comparison = Comparison::new("Comparison of mice", names, maze_names)
            .with_failures(|mouse, maze| searches[mouse][maze].figures.failure());
        for SearchMeasure { key, name, unit, verb, value, .. } in MEASURES {
            let measure = Measure::new(key, name, unit).with_verb(verb);
            comparison = comparison.with_measure(measure, |mouse, maze| {
                let figures = &searches[mouse][maze].figures;
                value(figures).filter(|_| figures.goal_reached)
            });
        }
        let statistics = comparison.statistics();
        let names: Vec<&str> = mice.iter().map(ComparedMouse::name).collect();
        let rankings = Ranking::all(&names, &columns, &searches);
        let mice = mice.iter().zip(rankings).zip(searches).enumerate();
        let mice = mice.map(|(index, ((mouse, ranking), searches))| {
            let statistics = MEASURES.iter().zip(&statistics);
            let statistics = statistics.map(|(measure, statistics)| {
                (measure.key, statistics.candidates[index].statistics.clone())
            });
            MouseSummary::new(mouse, ranking, statistics.collect(), searches)
        });
        let mice: Vec<MouseSummary> = mice.collect();
        let misreads = senses.misreadings.probability > 0.0;
        let drives = |vehicle: &&Vehicle| {
            mazes.iter().any(|it| planners.for_size(it.maze.size()).vehicle() == *vehicle)
        };
        let vehicles = planners.vehicles().filter(drives).map(vehicle_note);
        let notes = [CAPTION.into()].into_iter().chain(vehicles);
        let notes = notes.chain(misreads.then(|| senses.to_string()));
        let notes = notes.chain(mice.iter().filter_map(MouseSummary::random)).collect();
        let overview = MouseSummary::rows(&mice, misreads);
        let mut report = Self { comparison, notes, overview, statistics, mice };
        let verdicts = report.ranked().into_iter().map(MouseSummary::verdict);
        report.comparison.notes = report.notes.iter().cloned().chain(verdicts).collect();
        report.comparison.overview = Ranking::rows(&report.ranked());
        report
    }

    /// Returns the mice, best ones first.
    pub fn ranked(&self) -> Vec<&MouseSummary> {
        let mut mice: Vec<_> = self.mice.iter().collect();
        mice.sort_by_key(|mouse| mouse.ranking.rank);
        mice
    }
}

fn vehicle_note(vehicle: &Vehicle) -> String {
    let VehicleParameters { name, search_speed, search_turn_time, .. } = vehicle.parameters();
    format!(
        "Vehicle {}; searches at {search_speed} mm/s and {search_turn_time} s per quarter turn.",
        Escaped(name)
    )
}

impl MouseSummary {
    fn new(
        mouse: &ComparedMouse,
        ranking: Ranking,
        statistics: BTreeMap<&'static str, Statistics>,
        mazes: Vec<SearchRow>,
    ) -> Self {
        let searches = || mazes.iter().map(|search| &search.figures);
        let reached = || searches().filter(|search| search.goal_reached);
        let count =
            |is_so: fn(&SearchFigures) -> bool| reached().filter(|search| is_so(search)).count();
        let ending = |ending| (ending, searches().filter(|search| search.ending == ending).count());
        Self {
            mouse: mouse.name().into(),
            command: mouse.command().map(String::from),
            ranking,
            goal_reached: reached().count(),
            gave_up_rightly: searches().filter(|search| search.is_rightly_given_up).count(),
            failed: searches().filter(|search| search.failure().is_some()).count(),
            proven: count(|search| search.steps_until_proven.is_some()),
            shortest_path_found: count(|search| search.path_found == search.shortest_path),
            fastest_run_found: count(|search| search.times.is_some_and(|it| it.is_optimal())),
            endings: Ending::ALL.into_iter().map(ending).collect(),
            statistics,
            changes: None,
            mazes,
        }
    }

    /// Returns why the mouse loses time, and in which mazes.
    fn verdict(&self) -> String {
        let command = self.command.as_ref().map(|it| format!(" ({it})")).unwrap_or_default();
        let lines = [format!("{}{command}: {}", self.mouse, self.ranking.why())].into_iter();
        lines.chain(self.ranking.mazes(true)).collect::<Vec<_>>().join("; ") + "."
    }

    /// Returns a note on the mazes in which the runs of the mouse differ.
    fn random(&self) -> Option<String> {
        let mut random =
            self.mazes.iter().filter_map(|search| Some((&search.maze.maze, search.random?)));
        let (maze, divergence) = random.next()?;
        let (name, count) = (Escaped(&self.mouse), counted(1 + random.count(), "maze"));
        let maze = Escaped(maze);
        Some(format!("{name} is random in {count}, such as {maze}: {divergence}."))
    }

    /// Returns the overview of all mice, with a header.
    fn rows(mice: &[Self], misreads: bool) -> Vec<Vec<String>> {
        let mut head = vec!["mouse", "mazes", "goal reached", "correctly gave up", "failed"];
        head.extend(["shortest path found", "shortest path proven", "fastest run found"]);
        head.extend(misreads.then_some(["fast runs", "crashes"]).into_iter().flatten());
        let head = head.into_iter().map(String::from).collect();
        [head].into_iter().chain(mice.iter().map(|mouse| mouse.row(misreads))).collect()
    }

    fn row(&self, misreads: bool) -> Vec<String> {
        let Self { goal_reached, gave_up_rightly, ranking: Ranking { reachable, .. }, .. } = self;
        let mazes = self.mazes.len();
        let mut row = vec![self.mouse.clone(), mazes.to_string()];
        row.push(format!("{goal_reached}/{reachable}"));
        row.push(format!("{gave_up_rightly}/{}", mazes - reachable));
        let counts = [self.failed, self.shortest_path_found, self.proven, self.fastest_run_found];
        row.extend(counts.map(|count| count.to_string()));
        if misreads {
            let searches = || self.mazes.iter().map(|search| &search.figures);
            let runs = searches().filter(|search| search.fast_run_steps.is_some()).count();
            let crashes: u32 = searches().filter_map(|search| search.crashes).sum();
            row.extend([runs.to_string(), crashes.to_string()]);
        }
        row
    }
}

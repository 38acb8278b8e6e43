//! The report on a comparison: a table, CSV and JSON.

use std::cell::RefCell;
use std::collections::BTreeMap;

use mmsim_fastrun::{Planner, Vehicle};
use mmsim_maze::Escaped;
use mmsim_report::{Comparison, Distribution, Measure, MeasureStatistics, MousePath, Statistics};
use serde::Serialize;

use super::candidate::Candidate;
use super::figures::{Ending, Figures};
use super::measures::SearchMeasure;
use super::times::{Times, plan};
use crate::fast_run::picture::path as driven_path;
use crate::selection::Selected;

/// The report on one search. The field names are JSON keys and CSV column names.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SearchReport {
    #[serde(flatten)]
    pub(super) maze: MazeColumns,
    #[serde(flatten)]
    figures: Figures,
    #[serde(flatten)]
    times: Option<Times>,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct MazeColumns {
    pub(super) path: String,
    name: String,
    width: u8,
    height: u8,
}

impl SearchReport {
    fn new(selected: &Selected, figures: Figures) -> Self {
        let (path, name) = (selected.path.display().to_string(), selected.name.clone());
        let size = selected.maze.size();
        let maze = MazeColumns { path, name, width: size.width(), height: size.height() };
        Self { maze, times: figures.times, figures }
    }
}

/// The reports on all candidates.
pub(crate) struct Report {
    pub(crate) comparison: Comparison,
    pub(super) measures: Vec<SearchMeasure>,
    pub(super) statistics: Vec<MeasureStatistics>,
    pub(crate) candidates: Vec<CandidateReport>,
}

/// The report on all searches of a candidate. The field names are JSON keys.
#[derive(Debug, Serialize)]
pub(crate) struct CandidateReport {
    /// The name of the candidate.
    pub(super) strategy: String,
    /// The command of a mouse of the user.
    command: Option<String>,
    /// The number of mazes with a reachable goal.
    pub(super) reachable: usize,
    pub(super) goal_reached: usize,
    /// The number of mazes in which the candidate correctly reported that the goal is unreachable.
    pub(super) rightly_given_up: usize,
    /// The number of all other mazes.
    pub(super) failed: usize,
    /// The number of mazes in which the goal was reached and the shortest path was proven.
    pub(super) proven: usize,
    /// The number of mazes in which the goal was reached and the path found is as short as the
    /// shortest path in the true maze.
    pub(super) shortest_path_found: usize,
    /// The number of mazes in which the fast run takes as little time as the fastest run of the true
    /// maze, if a vehicle was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) fastest_run_found: Option<usize>,
    /// The number of searches with each ending.
    endings: BTreeMap<Ending, usize>,
    /// The mean of each measure over the mazes in which all candidates have a value.
    #[serde(flatten)]
    pub(super) means: BTreeMap<&'static str, Option<f64>>,
    /// The mean length of the shortest path in the true maze, over the mazes in which all candidates
    /// reached the goal.
    shortest_path: Option<f64>,
    statistics: BTreeMap<&'static str, Statistics>,
    pub(super) mazes: Vec<SearchReport>,
}

impl Report {
    /// Creates the reports from the figures of each candidate in each maze.
    pub(super) fn new(
        candidates: &[Candidate],
        mazes: &[Selected],
        figures: Vec<Vec<Figures>>,
        measures: Vec<SearchMeasure>,
        note: Option<String>,
    ) -> Self {
        let searches = figures.into_iter().map(|figures| {
            let searches = mazes.iter().zip(figures);
            searches.map(|(maze, figures)| SearchReport::new(maze, figures)).collect()
        });
        let searches: Vec<Vec<SearchReport>> = searches.collect();
        let names = unique_names(mazes);
        let described = candidates.iter().map(|candidate| mmsim_report::Candidate {
            name: candidate.name().into(),
            description: candidate.about().into(),
        });
        let comparison = Comparison::new("Comparison of mice", described.collect(), names)
            .with_failures(|candidate, maze| searches[candidate][maze].figures.failure());
        let comparison = note.into_iter().fold(comparison, Comparison::with_note);
        let comparison = measures.iter().fold(comparison, |comparison, measure| {
            let SearchMeasure { key, name, unit, verb, value, .. } = *measure;
            let measure = Measure::new(key, name, unit).with_verb(verb);
            comparison.with_measure(measure, |candidate, maze| {
                let figures = &searches[candidate][maze].figures;
                value(figures).filter(|_| figures.goal_reached)
            })
        });
        let statistics = comparison.statistics();
        let to_goal = comparison.measures().iter().find(|(one, _)| one.key == "steps_to_goal");
        let solved = to_goal.map(|(_, values)| values.common_mazes());
        let shortest_paths = solved
            .unwrap_or_default()
            .into_iter()
            .filter_map(|maze| searches.first()?[maze].figures.shortest_path.map(f64::from));
        let shortest_path = Distribution::new(shortest_paths.collect()).map(|paths| paths.mean);
        let candidates = candidates.iter().zip(searches).enumerate();
        let candidates = candidates.map(|(index, (candidate, searches))| {
            let statistics = measures.iter().zip(&statistics);
            let statistics = statistics.map(|(measure, statistics)| {
                (measure.key, statistics.candidates[index].statistics.clone())
            });
            CandidateReport::new(candidate, statistics.collect(), shortest_path, searches)
        });
        let candidates: Vec<CandidateReport> = candidates.collect();
        let comparison = comparison.with_overview(CandidateReport::rows(&candidates));
        let comparison = comparison.with_limiting_candidate();
        Self { comparison, measures, statistics, candidates }
    }

    /// Returns the report as an HTML page, with pictures of the searches or, if there is a vehicle, of
    /// the fast runs.
    pub(crate) fn html(&self, mazes: &[Selected], vehicle: Option<&Vehicle>) -> String {
        let planner = vehicle.map(|vehicle| RefCell::new(Planner::new(vehicle.clone())));
        let caption = match vehicle {
            Some(_) => "The lines are the fast runs.",
            None => {
                "The lines are whole searches: the search run and, if the mouse returns to the start, the \
                 return run."
            }
        };
        self.comparison.clone().with_pictures_caption(caption).html(|candidate, maze| {
            let figures = &self.candidates[candidate].mazes[maze].figures;
            let maze = &mazes[maze].maze;
            let Some(planner) = &planner else {
                return Some(MousePath::through_cells(maze, &figures.path));
            };
            let mut planner = planner.borrow_mut();
            let trajectory = plan(&mut planner, maze, &figures.outcome)?;
            let trajectory = trajectory.drive(planner.vehicle()).ok()?;
            Some(MousePath { maze, points: driven_path("", &trajectory).outline() })
        })
    }
}

impl CandidateReport {
    fn new(
        candidate: &Candidate,
        statistics: BTreeMap<&'static str, Statistics>,
        shortest_path: Option<f64>,
        mazes: Vec<SearchReport>,
    ) -> Self {
        let searches = || mazes.iter().map(|search| &search.figures);
        let reached = || searches().filter(|search| search.goal_reached);
        let count = |is_so: fn(&Figures) -> bool| reached().filter(|search| is_so(search)).count();
        let mean = |statistics: &Statistics| Some(statistics.distribution.as_ref()?.mean);
        let ending = |ending| (ending, searches().filter(|search| search.ending == ending).count());
        Self {
            strategy: candidate.name().into(),
            command: candidate.command().map(String::from),
            reachable: searches().filter(|search| search.shortest_path.is_some()).count(),
            goal_reached: reached().count(),
            rightly_given_up: searches().filter(|search| search.is_rightly_given_up).count(),
            failed: searches()
                .filter(|search| !search.goal_reached && !search.is_rightly_given_up)
                .count(),
            proven: count(|search| search.steps_until_proven.is_some()),
            shortest_path_found: count(|search| search.path_found == search.shortest_path),
            fastest_run_found: searches()
                .all(|search| search.times.is_some())
                .then(|| count(|search| search.times.is_some_and(|times| times.is_optimal()))),
            endings: Ending::ALL.into_iter().map(ending).collect(),
            means: statistics.iter().map(|(&key, statistics)| (key, mean(statistics))).collect(),
            shortest_path,
            statistics,
            mazes,
        }
    }

    /// Writes each search as one line of CSV. Writes a header first if nothing has been written
    /// yet. Escapes control characters, so that each search stays on one line.
    pub(crate) fn write_csv<W: std::io::Write>(&self, csv: &mut csv::Writer<W>) -> csv::Result<()> {
        #[derive(Serialize)]
        struct StrategyColumn<'a> {
            strategy: &'a str,
        }
        let strategy = StrategyColumn { strategy: &self.strategy };
        let escaped = |text: &String| Escaped(text).to_string();
        self.mazes.iter().cloned().try_for_each(|SearchReport { mut maze, mut figures, times }| {
            (maze.path, maze.name) = (escaped(&maze.path), escaped(&maze.name));
            figures.error = figures.error.as_ref().map(escaped);
            match times {
                Some(times) => csv.serialize((&strategy, maze, figures, times)),
                None => csv.serialize((&strategy, maze, figures)),
            }
        })
    }
}

/// Returns the names of the mazes, or the path of a maze if another maze has the same name.
pub(crate) fn unique_names(mazes: &[Selected]) -> Vec<String> {
    let name = |Selected { name, path, .. }: &Selected| {
        let is_unique = mazes.iter().filter(|other| other.name == *name).count() == 1;
        if is_unique { name.clone() } else { path.display().to_string() }
    };
    mazes.iter().map(name).collect()
}

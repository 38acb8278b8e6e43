//! Reports on one search and on all of a strategy's searches.

use mmsim_maze::Escaped;
use serde::Serialize;

use super::candidate::Candidate;
use super::figures::Figures;
use crate::selection::Selected;

/// The report on one search. The field names are JSON keys and CSV column names.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SearchReport {
    #[serde(flatten)]
    maze: MazeColumns,
    #[serde(flatten)]
    figures: Figures,
}

#[derive(Clone, Debug, Serialize)]
struct MazeColumns {
    path: String,
    name: String,
    width: u8,
    height: u8,
}

impl SearchReport {
    pub(crate) fn new(selected: &Selected, figures: Figures) -> Self {
        let (path, name) = (selected.path.display().to_string(), selected.name.clone());
        let size = selected.maze.size();
        let maze = MazeColumns { path, name, width: size.width(), height: size.height() };
        Self { maze, figures }
    }
}

/// The report on all of a candidate's searches. The means include only mazes in which the goal was
/// reached. The field names are JSON keys.
#[derive(Debug, Serialize)]
pub(crate) struct CandidateReport {
    /// The name of the candidate.
    strategy: String,
    /// The command of a mouse of the user.
    command: Option<String>,
    /// The number of mazes with a reachable goal.
    reachable: usize,
    goal_reached: usize,
    /// The number of mazes in which the strategy correctly reported that the goal is unreachable.
    rightly_given_up: usize,
    /// The number of mazes in which the goal was reached and the shortest path was proven.
    proven: usize,
    /// The number of mazes in which the goal was reached and the path found is as short as the
    /// shortest path in the true maze.
    shortest_path_found: usize,
    steps_to_goal: Option<f64>,
    /// The mean number of steps until the shortest path was proven. Only the mazes counted in
    /// `proven` contribute to this mean.
    steps_until_proven: Option<f64>,
    steps_in_all: Option<f64>,
    turns: Option<f64>,
    path_found: Option<f64>,
    shortest_path: Option<f64>,
    time_us: Option<f64>,
    mazes: Vec<SearchReport>,
}

impl CandidateReport {
    pub(crate) fn new(candidate: &Candidate, mazes: Vec<SearchReport>) -> Self {
        let searches = || mazes.iter().map(|search| &search.figures);
        let reached = || searches().filter(|search| search.goal_reached);
        let count = |is_so: fn(&Figures) -> bool| reached().filter(|search| is_so(search)).count();
        let mean = |number: fn(&Figures) -> Option<f64>| mean(reached().filter_map(number));
        Self {
            strategy: candidate.name().into(),
            command: candidate.command().map(String::from),
            reachable: searches().filter(|search| search.shortest_path.is_some()).count(),
            goal_reached: reached().count(),
            rightly_given_up: searches().filter(|search| search.is_rightly_given_up).count(),
            proven: count(|search| search.steps_until_proven.is_some()),
            shortest_path_found: count(|search| search.path_found == search.shortest_path),
            steps_to_goal: mean(|search| search.steps_to_goal.map(f64::from)),
            steps_until_proven: mean(|search| search.steps_until_proven.map(f64::from)),
            steps_in_all: mean(|search| Some(search.steps_in_all.into())),
            turns: mean(|search| Some(search.turns.into())),
            path_found: mean(|search| search.path_found.map(f64::from)),
            shortest_path: mean(|search| search.shortest_path.map(f64::from)),
            time_us: mean(|search| search.time_us),
            mazes,
        }
    }

    /// Returns the header row of the table.
    pub(crate) fn head() -> Vec<String> {
        let head = [
            "strategy", "mazes", "reached", "given up", "to goal", "proven", "after", "in all",
            "turns", "path", "shortest", "found", "µs",
        ];
        head.map(String::from).into()
    }

    /// Returns the strategy's row of the table.
    pub(crate) fn row(&self) -> Vec<String> {
        let mean = |mean: Option<f64>| mean.map_or("-".into(), |mean| format!("{mean:.1}"));
        let Self { reachable, goal_reached, rightly_given_up, .. } = self;
        let mazes = self.mazes.len();
        vec![
            self.strategy.clone(),
            mazes.to_string(),
            format!("{goal_reached}/{reachable}"),
            format!("{rightly_given_up}/{}", mazes - reachable),
            mean(self.steps_to_goal),
            self.proven.to_string(),
            mean(self.steps_until_proven),
            mean(self.steps_in_all),
            mean(self.turns),
            mean(self.path_found),
            mean(self.shortest_path),
            self.shortest_path_found.to_string(),
            mean(self.time_us),
        ]
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
        self.mazes.iter().cloned().try_for_each(|SearchReport { mut maze, mut figures }| {
            (maze.path, maze.name) = (escaped(&maze.path), escaped(&maze.name));
            figures.error = figures.error.as_ref().map(escaped);
            csv.serialize((&strategy, maze, figures))
        })
    }
}

/// Returns the mean, or `None` if there are no numbers.
fn mean(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = numbers.fold((0., 0.), |(sum, count), number| (sum + number, count + 1.));
    (count > 0.).then(|| sum / count)
}

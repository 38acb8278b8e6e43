//! The text output: the rules, the tables and the mice without a fast run.

use mmsim_maze::Escaped;

use super::Contest;
use super::attempt::{Attempt, Run};
use super::standings::{Entry, MazeResult, Standing};
use crate::grid::aligned;
use crate::output::{counted, list_reasons};

impl Contest {
    /// Returns the rules, the runs in one maze or the scores in several mazes, and the mice without a
    /// fast run.
    pub(super) fn text(&self) -> String {
        let mut sections = vec![self.head()];
        match &self.mazes[..] {
            [] => {}
            [maze] => sections.push(maze.table()),
            mazes => sections.extend([self.standings_table(), self.scores_table(mazes)]),
        }
        sections.extend(self.standings.iter().filter_map(|standing| self.reasons(&standing.mouse)));
        if !self.skipped.is_empty() {
            let count = counted(self.skipped.len() as u64, "maze");
            let names = Escaped(self.skipped.join(", "));
            sections.push(format!("Skipped {count} with an unreachable goal: {names}\n"));
        }
        sections.join("\n")
    }

    fn head(&self) -> String {
        let Self { rules, time_limit_s, search_speed, .. } = self;
        let runs = match self.max_runs {
            Some(1) => "the search run".into(),
            Some(max) => format!("the best of {max} runs"),
            None => "the best run".into(),
        };
        let share = match self.search_share {
            share if share > 0.0 => format!(" + 1/{:.0} of the time before the run", 1.0 / share),
            _ => String::new(),
        };
        let penalty = match self.touch_penalty_s {
            penalty if penalty > 0.0 => format!(" + {penalty} s after a touch"),
            _ => String::new(),
        };
        let vehicle = Escaped(&self.vehicle);
        format!(
            "Rules {rules}: {runs} within {time_limit_s} s. Score: time of the run{share}{penalty}.\n\
             Vehicle {vehicle}; searches at {search_speed}. Times in seconds.\n"
        )
    }

    fn standings_table(&self) -> String {
        let head = ["", "mouse", "mazes scored", "mazes won", "total score"].map(String::from);
        let row = |standing: &Standing| {
            let Standing { rank, mouse, scored, wins, total_score_s } = standing;
            let total = if *scored > 0 { format!("{total_score_s:.3}") } else { "-".into() };
            let scored = format!("{scored}/{}", self.mazes.len());
            [rank.to_string(), mouse.clone(), scored, wins.to_string(), total]
        };
        aligned(&ranked([head].into_iter().chain(self.standings.iter().map(row)).collect()))
    }

    /// Returns a table with the score of each mouse in each maze.
    fn scores_table(&self, mazes: &[MazeResult]) -> String {
        let mice = || self.standings.iter().map(|standing| &standing.mouse);
        let head: Vec<String> = ["maze".into()].into_iter().chain(mice().cloned()).collect();
        let rows = mazes.iter().map(|maze| {
            let scores = mice()
                .map(|mouse| seconds(maze.entry(mouse).and_then(|entry| entry.attempt.score_s)));
            [maze.name.clone()].into_iter().chain(scores).collect()
        });
        aligned(&[head].into_iter().chain(rows).collect::<Vec<_>>())
    }

    /// Lists the most frequent reasons why a mouse made no fast run.
    fn reasons(&self, mouse: &str) -> Option<String> {
        let mut reasons: Vec<(&str, Vec<&str>)> = Vec::new();
        for maze in &self.mazes {
            let error = maze.entry(mouse).and_then(|entry| entry.attempt.error.as_deref());
            let Some(error) = error else { continue };
            match reasons.iter_mut().find(|(text, _)| *text == error) {
                Some((_, mazes)) => mazes.push(&maze.name),
                None => reasons.push((error, vec![&maze.name])),
            }
        }
        list_reasons(&format!("{mouse} made no fast run"), reasons)
    }
}

impl MazeResult {
    /// Returns a table with the run of each mouse that counts.
    fn table(&self) -> String {
        let head = [
            "",
            &self.name,
            "score",
            "best run",
            "rest to rest",
            "begins at",
            "search run",
            "runs",
            "touched",
        ];
        let row = |Entry { rank, mouse, attempt }: &Entry| {
            let Attempt { score_s, runs, touched, .. } = attempt;
            let best = attempt.best_run();
            let search_run = runs.first().map(|run| run.time_s);
            [
                rank.map_or("-".into(), |rank| rank.to_string()),
                mouse.clone(),
                seconds(*score_s),
                seconds(best.map(|run| run.time_s)),
                seconds(best.and_then(|run: &Run| run.rest_to_rest_s)),
                seconds(best.map(|run| run.start_s)),
                seconds(search_run),
                runs.len().to_string(),
                if *touched { "yes" } else { "no" }.into(),
            ]
        };
        let head = head.map(String::from);
        aligned(&ranked([head].into_iter().chain(self.entries.iter().map(row)).collect()))
    }
}

/// Joins the ranks and the names in the first two columns, which are then left-aligned.
fn ranked<const N: usize>(rows: Vec<[String; N]>) -> Vec<Vec<String>> {
    let width = rows.iter().map(|row| row[0].len()).max().unwrap_or(0);
    let join = |row: [String; N]| {
        let mut cells = row.into_iter();
        let (rank, name) = (cells.next().unwrap_or_default(), cells.next().unwrap_or_default());
        [format!("{rank:>width$} {name}")].into_iter().chain(cells).collect()
    };
    rows.into_iter().map(join).collect()
}

fn seconds(time: Option<f64>) -> String {
    time.map_or("-".into(), |time| format!("{time:.3}"))
}

//! A saved comparison, and what has become better or worse since.

use mmsim_maze::Escaped;
use serde::{Deserialize, Deserializer, Serialize};

use crate::comparison::MouseSummary;

/// Smaller differences in s are none: times are rounded to 0.1 ms.
const MIN_DIFFERENCE_S: f64 = 0.0005;

/// A comparison that was saved as JSON, an array of [`MouseSummary`]. Other keys are ignored.
#[derive(Debug, Deserialize)]
#[serde(transparent)]
pub struct Baseline {
    mice: Vec<SavedMouse>,
}

#[derive(Debug, Deserialize)]
struct SavedMouse {
    mouse: String,
    mazes: Vec<SavedSearch>,
}

#[derive(Debug, Deserialize)]
struct SavedSearch {
    path: String,
    // Without `with`, a missing key would be null.
    #[serde(with = "Nullable")]
    total_time_s: Option<f64>,
    #[serde(with = "Nullable")]
    optimal_time_s: Option<f64>,
}

/// Deserializes a number or null.
struct Nullable;

impl Nullable {
    fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
        Option::deserialize(deserializer)
    }
}

/// What has become better or worse since a comparison was saved. The field names are JSON keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Changes {
    /// The mazes in which the mouse is slower than before, or which it does not solve any more.
    #[serde(rename = "worse_mazes")]
    pub worse: Vec<Change>,
    /// The mazes in which the mouse is faster, or which it did not solve before.
    #[serde(rename = "better_mazes")]
    pub better: Vec<Change>,
    /// The number of mazes with the same result.
    pub equal: usize,
    /// The number of mazes that the saved comparison does not have.
    #[serde(rename = "new_maze_count")]
    pub new_mazes: usize,
    /// The number of saved mazes that were not searched now.
    #[serde(rename = "missing_maze_count")]
    pub missing_mazes: usize,
}

/// The result in a maze now and in the saved comparison. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// The name of the maze.
    pub maze: String,
    /// The time until the end of the fast run in s, or `None` if the mouse did not solve the maze.
    pub total_time_s: Option<f64>,
    /// This time in the saved comparison.
    pub saved_time_s: Option<f64>,
}

impl Baseline {
    /// Returns what has become better or worse for a mouse, or `None` if the saved comparison has no mouse
    /// with its name. The paths of mazes identify them; the changes use `names`, one for each maze.
    ///
    /// # Errors
    /// Returns an error if a maze has another fastest run than before, so that times cannot be compared.
    pub fn changes(
        &self,
        summary: &MouseSummary,
        names: &[String],
    ) -> Result<Option<Changes>, String> {
        let Some(saved) = self.mice.iter().find(|saved| saved.mouse == summary.mouse) else {
            return Ok(None);
        };
        let mut changes = Changes::default();
        for (search, name) in summary.mazes.iter().zip(names) {
            let path = &search.maze.path;
            let same = |saved: &&SavedSearch| is_same_path(&saved.path, path);
            let Some(saved) = saved.mazes.iter().find(same) else {
                changes.new_mazes += 1;
                continue;
            };
            let times = search.times;
            let [now, before] = [times.and_then(|it| it.optimal_time_s), saved.optimal_time_s];
            if (now.unwrap_or(0.0) - before.unwrap_or(0.0)).abs() > MIN_DIFFERENCE_S {
                let path = Escaped(path);
                return Err(format!("{path} has changed, or was saved with another vehicle"));
            }
            changes.add(name, times.and_then(|it| it.total_time_s), saved.total_time_s);
        }
        let is_gone = |saved: &&SavedSearch| {
            !summary.mazes.iter().any(|search| is_same_path(&saved.path, &search.maze.path))
        };
        changes.missing_mazes = saved.mazes.iter().filter(is_gone).count();
        Ok(Some(changes))
    }

    /// Returns true if a saved mouse has this name.
    pub fn has(&self, mouse: &str) -> bool {
        self.mice.iter().any(|saved| saved.mouse == mouse)
    }

    /// Returns the names of the saved mice, separated by commas.
    pub fn names(&self) -> String {
        let names: Vec<&str> = self.mice.iter().map(|saved| &*saved.mouse).collect();
        names.join(", ")
    }
}

/// Returns true for paths of the same file, such as `a/b` and `./a\b`.
fn is_same_path(one: &str, other: &str) -> bool {
    let parts = |path: &str| {
        let parts = path.split(['/', '\\']).filter(|part| !matches!(*part, "" | "."));
        parts.map(String::from).collect::<Vec<_>>()
    };
    parts(one) == parts(other)
}

impl Changes {
    fn add(&mut self, maze: &str, total_time_s: Option<f64>, saved_time_s: Option<f64>) {
        let change = Change { maze: maze.into(), total_time_s, saved_time_s };
        let difference = change.difference();
        if difference > MIN_DIFFERENCE_S {
            self.worse.push(change);
        } else if difference < -MIN_DIFFERENCE_S {
            self.better.push(change);
        } else {
            self.equal += 1;
        }
    }

    /// Returns the mazes that the mouse does not solve any more, or in which it takes longer than the saved
    /// time and this share of it.
    pub fn exceeding(&self, allowed: f64) -> impl Iterator<Item = &Change> {
        self.worse.iter().filter(move |change| match (change.total_time_s, change.saved_time_s) {
            (Some(now), Some(saved)) => now > saved * (1.0 + allowed),
            _ => true,
        })
    }

    /// Returns true if no maze was searched both times.
    pub fn is_empty(&self) -> bool {
        self.worse.is_empty() && self.better.is_empty() && self.equal == 0
    }

    /// Returns the numbers of mazes in words, such as `1 worse, 2 better, 15 equal`.
    pub fn counts(&self) -> String {
        let Self { worse, better, equal, new_mazes, missing_mazes } = self;
        let counts = [(worse.len(), "worse"), (better.len(), "better"), (*equal, "equal")];
        let others = [(*new_mazes, "new"), (*missing_mazes, "missing")];
        let others = others.into_iter().filter(|(count, _)| *count > 0);
        let counts = counts.into_iter().chain(others);
        counts.map(|(count, name)| format!("{count} {name}")).collect::<Vec<_>>().join(", ")
    }
}

impl Change {
    /// Returns the difference of the times in s. Not to solve a maze is infinitely slow.
    fn difference(&self) -> f64 {
        match (self.total_time_s, self.saved_time_s) {
            (None, None) => 0.0,
            (now, saved) => now.unwrap_or(f64::INFINITY) - saved.unwrap_or(f64::INFINITY),
        }
    }

    /// Describes the change, such as `harbour: 41.2 s instead of 40.0 s (+3.0 %)`.
    pub fn text(&self) -> String {
        let maze = Escaped(&self.maze);
        match (self.total_time_s, self.saved_time_s) {
            (Some(now), Some(saved)) => {
                let percent = (now / saved - 1.0) * 100.0;
                format!("{maze}: {now:.3} s instead of {saved:.3} s ({percent:+.1} %)")
            }
            (Some(now), None) => format!("{maze}: solved in {now:.3} s"),
            (None, Some(saved)) => format!("{maze}: not solved, instead of {saved:.3} s"),
            (None, None) => format!("{maze}: not solved"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slower_and_unsolved_mazes_are_worse() {
        let mut changes = Changes::default();
        for (maze, saved, now) in [
            ("slower", Some(40.0), Some(41.2)),
            ("faster", Some(40.0), Some(30.0)),
            ("same", Some(40.0), Some(40.0004)),
            ("lost", Some(40.0), None),
            ("won", None, Some(50.0)),
            ("never", None, None),
        ] {
            changes.add(maze, now, saved);
        }
        let texts =
            |changes: &[Change]| changes.iter().map(Change::text).collect::<Vec<_>>().join("; ");
        assert_eq!(changes.counts(), "2 worse, 2 better, 2 equal");
        let worse = "slower: 41.200 s instead of 40.000 s (+3.0 %); \
                     lost: not solved, instead of 40.000 s";
        assert_eq!(texts(&changes.worse), worse);
        let better = "faster: 30.000 s instead of 40.000 s (-25.0 %); won: solved in 50.000 s";
        assert_eq!(texts(&changes.better), better);
        assert_eq!(changes.exceeding(1.0).count(), 1, "a maze is not solved any more");
        assert_eq!([0.0, 0.029, 0.031].map(|it| changes.exceeding(it).count()), [2, 2, 1]);
    }

    #[test]
    fn paths_are_compared_by_their_parts() {
        for other in ["mazes/a.txt", "./mazes/a.txt", r"mazes\a.txt", "mazes//./a.txt"] {
            assert!(is_same_path("mazes/a.txt", other), "{other}");
        }
        assert!(!is_same_path("mazes/a.txt", "a.txt"));
    }
}

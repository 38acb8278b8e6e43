//! The ranking of mice over many mazes: how much time each mouse loses, where, and why.

use std::fmt;

use mmsim_maze::{Escaped, counted};
use mmsim_report::list_reasons;
use mmsim_run::{SearchFigures, tenth_of_ms};
use serde::Serialize;

use crate::comparison::{MazeColumns, MouseSummary, SearchRow};

/// The maximum number of mazes in which a mouse lost most.
const MAX_WORST: usize = 5;

/// The maximum numbers that a short text names: of the worst mazes, of unsolved mazes for a reason, and
/// of reasons why mazes are unsolved.
const SHORT: [usize; 3] = [3, 4, 2];

/// Smaller losses in s are no reason and are not listed.
const MIN_LOSS_S: f64 = 0.005;

/// The error of a mouse that reached the goal, but has no total time and no other error.
const NO_FAST_RUN: &str = "a wall that the mouse does not know blocks its fast run";

/// The rank of a mouse, and why it loses time. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ranking {
    /// The number of better mice, plus one. A mouse that solved more mazes is better, then one with a
    /// lower mean loss.
    pub rank: usize,
    /// The number of mazes in which the mouse has a total time.
    pub solved: usize,
    /// The number of mazes with a reachable goal.
    pub reachable: usize,
    /// The mean loss over the paired mazes, or `None` if there are none.
    pub mean_loss: Option<Loss>,
    /// The number of mazes that were solved by all mice that solved as many mazes as this one.
    #[serde(rename = "paired_maze_count")]
    pub paired_mazes: usize,
    /// Why the mouse loses, the main reason first. A mouse that loses nothing has no reasons.
    pub reasons: Vec<Reason>,
    /// The number of movements that a wall blocked.
    pub crashes: u32,
    /// The number of solved mazes in which the shortest path was not proven.
    pub not_proven: usize,
    /// The mazes in which the mouse lost most time, at most five.
    pub worst_mazes: Vec<MazeLoss>,
    /// The mazes with a reachable goal in which the mouse has no total time.
    pub unsolved_mazes: Vec<UnsolvedMaze>,
}

/// The time that a mouse loses to the best possible: the shortest search of all mice in the maze,
/// followed by the fastest run of the true maze. The field names are JSON keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Loss {
    /// The sum of both losses, in s.
    pub loss_s: f64,
    /// How much longer the search and the return take than the shortest ones of all mice, in s.
    pub search_loss_s: f64,
    /// How much longer the fast run takes than the fastest run of the true maze, in s.
    pub route_loss_s: f64,
}

/// A reason why a mouse is not the best possible one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// It did not solve each maze.
    NotSolved,
    /// It ran into walls.
    Crashes,
    /// Its searches are longer than the shortest ones.
    SearchTooLong,
    /// Its fast runs are slower than the fastest ones.
    RouteTooSlow,
    /// It did not prove each path to be the shortest.
    NotProven,
}

/// The loss of a mouse in a maze. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MazeLoss {
    /// The maze. Its name is unique among the mazes.
    #[serde(flatten)]
    pub maze: MazeColumns,
    /// The loss.
    #[serde(flatten)]
    pub loss: Loss,
    /// The name of the other mouse that lost least, if another one solved the maze.
    pub rival: Option<String>,
    /// The loss of the rival, in s.
    pub rival_loss_s: Option<f64>,
}

/// A maze that a mouse did not solve. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UnsolvedMaze {
    /// The maze. Its name is unique among the mazes.
    #[serde(flatten)]
    pub maze: MazeColumns,
    /// Why the mouse has no total time.
    pub error: String,
    /// The name of the other mouse that lost least, if another one solved the maze.
    pub rival: Option<String>,
}

impl Ranking {
    /// Ranks mice with these names. Each mouse has a search in each maze.
    pub(crate) fn all(
        mice: &[&str],
        mazes: &[MazeColumns],
        searches: &[Vec<SearchRow>],
    ) -> Vec<Self> {
        let losses = Loss::all(searches);
        let all = (0..mice.len()).map(|mouse| Self::new(mouse, mice, mazes, searches, &losses));
        let mut all: Vec<Self> = all.collect();
        let order = |one: &Self, other: &Self| {
            let loss = |it: &Self| it.mean_loss.map_or(f64::INFINITY, |mean| mean.loss_s);
            other.solved.cmp(&one.solved).then(loss(one).total_cmp(&loss(other)))
        };
        let ranks: Vec<usize> = (all.iter())
            .map(|one| 1 + all.iter().filter(|other| order(other, one).is_lt()).count())
            .collect();
        all.iter_mut().zip(ranks).for_each(|(one, rank)| one.rank = rank);
        all
    }

    /// Creates the ranking of a mouse, without its rank.
    fn new(
        mouse: usize,
        mice: &[&str],
        mazes: &[MazeColumns],
        searches: &[Vec<SearchRow>],
        losses: &[Vec<Option<Loss>>],
    ) -> Self {
        let solved = |losses: &[Option<Loss>]| losses.iter().flatten().count();
        let own = &losses[mouse];
        let equals: Vec<_> = losses.iter().filter(|it| solved(it) == solved(own)).collect();
        let is_paired = |maze: usize| equals.iter().all(|losses| losses[maze].is_some());
        let paired: Vec<Loss> =
            (0..mazes.len()).filter(|&maze| is_paired(maze)).filter_map(|maze| own[maze]).collect();
        let searches = &searches[mouse];
        let figures = || searches.iter().map(|search| &search.figures);
        let is_reachable = |maze: &usize| searches[*maze].figures.shortest_path.is_some();
        let reachable = || (0..mazes.len()).filter(is_reachable);
        let rival = |maze: usize| {
            let others = (0..mice.len()).filter(|&other| other != mouse);
            let rivals =
                others.filter_map(|other| Some((mice[other], losses[other][maze]?.loss_s)));
            let best = rivals.min_by(|(_, one), (_, other)| one.total_cmp(other));
            best.map(|(name, loss)| (name.to_string(), loss))
        };
        let unsolved = reachable().filter(|&maze| own[maze].is_none()).map(|maze| UnsolvedMaze {
            maze: mazes[maze].clone(),
            error: error(&searches[maze].figures),
            rival: rival(maze).map(|(name, _)| name),
        });
        let mut worst: Vec<(usize, Loss)> =
            own.iter().enumerate().filter_map(|(maze, loss)| Some((maze, (*loss)?))).collect();
        worst.retain(|(_, loss)| loss.loss_s >= MIN_LOSS_S);
        worst.sort_by(|(_, one), (_, other)| other.loss_s.total_cmp(&one.loss_s));
        let worst = worst.into_iter().take(MAX_WORST).map(|(maze, loss)| {
            let (rival, rival_loss_s) = rival(maze).unzip();
            MazeLoss { maze: mazes[maze].clone(), loss, rival, rival_loss_s }
        });
        let not_proven = own.iter().zip(figures());
        let not_proven =
            not_proven.filter(|(loss, it)| loss.is_some() && it.steps_until_proven.is_none());
        let ranking = Self {
            rank: 0,
            solved: solved(own),
            reachable: reachable().count(),
            mean_loss: Loss::mean(&paired),
            paired_mazes: paired.len(),
            reasons: Vec::new(),
            crashes: reachable().filter_map(|maze| searches[maze].figures.crashes).sum(),
            not_proven: not_proven.count(),
            worst_mazes: worst.collect(),
            unsolved_mazes: unsolved.collect(),
        };
        Self { reasons: ranking.find_reasons(), ..ranking }
    }

    fn find_reasons(&self) -> Vec<Reason> {
        let Loss { search_loss_s, route_loss_s, .. } = self.mean_loss.unwrap_or_default();
        let mut losses =
            [(Reason::SearchTooLong, search_loss_s), (Reason::RouteTooSlow, route_loss_s)];
        losses.sort_by(|(_, one), (_, other)| other.total_cmp(one));
        let losses = losses.map(|(reason, loss)| (reason, loss >= MIN_LOSS_S));
        let all = [(Reason::NotSolved, !self.unsolved_mazes.is_empty())].into_iter().chain(losses);
        let all = all
            .chain([(Reason::Crashes, self.crashes > 0), (Reason::NotProven, self.not_proven > 0)]);
        all.filter(|(_, applies)| *applies).map(|(reason, _)| reason).collect()
    }

    /// Describes all reasons, in one line.
    pub fn why(&self) -> String {
        let mean = self.mean_loss.unwrap_or_default();
        let describe = |reason: &Reason| match reason {
            Reason::NotSolved => {
                format!("{} not solved", counted(self.unsolved_mazes.len(), "maze"))
            }
            Reason::Crashes => format!("{} blocked", counted(self.crashes, "movement")),
            Reason::SearchTooLong => format!("search {} s too long", seconds(mean.search_loss_s)),
            Reason::RouteTooSlow => format!("route {} s too slow", seconds(mean.route_loss_s)),
            Reason::NotProven => format!("{} not proven", counted(self.not_proven, "path")),
        };
        match &self.reasons[..] {
            [] if self.reachable == 0 => "no maze has a reachable goal".into(),
            [] => "nothing lost".into(),
            reasons => reasons.iter().map(describe).collect::<Vec<_>>().join(", "),
        }
    }

    /// Returns lines that name the mazes in which the mouse lost most time, each with the loss in s and,
    /// in brackets, the best rival, unless it is that of the previous maze, and its loss. Further lines
    /// name the mazes that the mouse did not solve. Names all mazes, or only the most important ones.
    pub fn mazes(&self, names_all: bool) -> Vec<String> {
        let [max_worst, max_names, max_reasons] = if names_all { [usize::MAX; 3] } else { SHORT };
        let mut last = None;
        let worst = self.worst_mazes.iter().take(max_worst).map(
            |MazeLoss { maze, loss, rival, rival_loss_s }| {
                let is_new = last.replace(rival) != Some(rival);
                let name = rival.as_ref().filter(|_| is_new);
                let name = name.map(|name| format!("{} ", Escaped(name))).unwrap_or_default();
                let rival =
                    rival_loss_s.map(|loss| format!(" ({name}{loss:.1})")).unwrap_or_default();
                format!("{} {:.1}{rival}", Escaped(&maze.maze), loss.loss_s)
            },
        );
        let worst: Vec<String> = worst.collect();
        let worst = (!worst.is_empty()).then(|| format!("lost most: {}", worst.join(", ")));
        let unsolved = self.unsolved_mazes.iter().map(|it| (&*it.error, &*it.maze.maze));
        let unsolved = list_reasons(unsolved, max_names, max_reasons, " (see --tables)");
        let unsolved = unsolved.into_iter().map(|line| format!("not solved: {line}"));
        worst.into_iter().chain(unsolved).collect()
    }

    /// Returns a table of ranked mice, with a header.
    pub(crate) fn rows(mice: &[&MouseSummary]) -> Vec<Vec<String>> {
        let width = mice.last().map_or(0, |last| last.ranking.rank.to_string().len());
        let head = ["mouse", "solved", "lost (s)", "search", "route", "main reason"];
        let row = |mouse: &&MouseSummary| {
            let Self { rank, solved, reachable, mean_loss, reasons, .. } = &mouse.ranking;
            let loss = |part: fn(Loss) -> f64| mean_loss.map_or("-".into(), |it| seconds(part(it)));
            vec![
                format!("{rank:>width$} {}", mouse.mouse),
                format!("{solved}/{reachable}"),
                loss(|it| it.loss_s),
                loss(|it| it.search_loss_s),
                loss(|it| it.route_loss_s),
                reasons.first().map_or("-".into(), ToString::to_string),
            ]
        };
        [head.map(String::from).to_vec()].into_iter().chain(mice.iter().map(row)).collect()
    }
}

impl Loss {
    /// Returns the loss of each mouse in each maze that it solved.
    fn all(searches: &[Vec<SearchRow>]) -> Vec<Vec<Option<Self>>> {
        // The time until the fast run, and the loss of the fast run.
        let parts = |search: &SearchRow| {
            let times = search.times?;
            let run = times.fast_run_time_s?;
            let route_loss = if times.is_optimal() { 0.0 } else { run - times.optimal_time_s? };
            Some((times.total_time_s? - run, route_loss))
        };
        let best = |maze: usize| {
            let starts = searches.iter().filter_map(|mouse| Some(parts(&mouse[maze])?.0));
            starts.fold(f64::INFINITY, f64::min)
        };
        let loss = |(maze, search): (usize, &SearchRow)| {
            let (start, route_loss) = parts(search)?;
            Some(Self::new(start - best(maze), route_loss))
        };
        searches.iter().map(|mouse| mouse.iter().enumerate().map(loss).collect()).collect()
    }

    fn new(search_loss_s: f64, route_loss_s: f64) -> Self {
        let [search_loss_s, route_loss_s] = [search_loss_s, route_loss_s].map(tenth_of_ms);
        Self { loss_s: tenth_of_ms(search_loss_s + route_loss_s), search_loss_s, route_loss_s }
    }

    fn mean(losses: &[Self]) -> Option<Self> {
        let count = f64::from(u32::try_from(losses.len()).ok().filter(|&count| count > 0)?);
        let mean = |part: fn(&Self) -> f64| losses.iter().map(part).sum::<f64>() / count;
        Some(Self::new(mean(|it| it.search_loss_s), mean(|it| it.route_loss_s)))
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotSolved => "mazes not solved",
            Self::Crashes => "crashes",
            Self::SearchTooLong => "search too long",
            Self::RouteTooSlow => "route too slow",
            Self::NotProven => "path not proven",
        })
    }
}

/// Returns why a mouse has no total time.
fn error(figures: &SearchFigures) -> String {
    let error = figures.failure().or_else(|| figures.error.clone());
    let no_run = match &figures.outcome.driven {
        Some(_) => "the vehicle cannot drive its fast run",
        None if !figures.is_complete => "its search did not end",
        None => NO_FAST_RUN,
    };
    error.unwrap_or_else(|| no_run.into())
}

fn seconds(time: f64) -> String {
    format!("{time:.2}")
}

#[cfg(test)]
mod tests {
    use mmsim_run::SearchTimes;

    use super::*;

    /// The time until the fast run and the time of the fast run, in s, or `None` without a fast run.
    type Times = Option<(f64, f64)>;

    /// Ranks mice with these times in mazes whose fastest run takes 2 s. The mazes are called "a" to
    /// "c"; the goal of others is unreachable.
    fn rank(mice: &[(&str, &[Times])]) -> Vec<Ranking> {
        let column = |maze: usize| {
            let name = ["a", "b", "c", "closed"][maze].to_string();
            MazeColumns { path: name.clone() + ".txt", maze: name, width: 16, height: 16 }
        };
        let search = |(maze, times): (usize, &Times)| {
            let reached = times.is_some();
            let times = SearchTimes {
                search_time_s: 1.0,
                fast_run_time_s: times.map(|(_, run)| run),
                fast_run_loss_percent: times.map(|(_, run)| (run / 2.0 - 1.0) * 100.0),
                total_time_s: times.map(|(start, run)| start + run),
                known_run_time_s: None,
                optimal_time_s: (maze < 3).then_some(2.0),
            };
            let figures = SearchFigures {
                goal_reached: reached,
                steps_until_proven: reached.then_some(7),
                shortest_path: (maze < 3).then_some(9),
                search_steps: 999,
                times: Some(times),
                ..SearchFigures::default()
            };
            SearchRow { maze: column(maze), figures, times: Some(times), cause: None, random: None }
        };
        let searches: Vec<Vec<SearchRow>> =
            mice.iter().map(|(_, times)| times.iter().enumerate().map(search).collect()).collect();
        let names: Vec<&str> = mice.iter().map(|(name, _)| *name).collect();
        let mazes: Vec<_> = (0..mice[0].1.len()).map(column).collect();
        Ranking::all(&names, &mazes, &searches)
    }

    const ADA: (&str, &[Times]) =
        ("ada", &[Some((10.0, 2.5)), Some((31.0, 2.0)), Some((20.0, 2.0)), None]);
    const BO: (&str, &[Times]) =
        ("bo", &[Some((14.0, 2.0)), Some((30.0, 3.5)), Some((20.0, 2.0)), None]);
    /// A wall follower, which is slower than the others in the only maze that it solves.
    const CY: (&str, &[Times]) = ("cy", &[Some((40.0, 3.0)), None, None, None]);

    fn ranks(rankings: &[Ranking]) -> Vec<usize> {
        rankings.iter().map(|one| one.rank).collect()
    }

    fn loss(loss_s: f64, search_loss_s: f64, route_loss_s: f64) -> Loss {
        Loss { loss_s, search_loss_s, route_loss_s }
    }

    /// The example of docs/compare.md.
    #[test]
    fn the_ranking_is_that_worked_out_by_hand() {
        let rankings = rank(&[BO, CY, ADA]);
        assert_eq!(ranks(&rankings), [2, 3, 1]);
        let [bo, cy, ada] = &rankings[..] else { panic!("three mice") };
        // ada: 0 + 0.5, 1 + 0 and 0 s; bo: 4 + 0, 0 + 1.5 and 0 s.
        assert_eq!(ada.mean_loss, Some(loss(0.5, 0.3333, 0.1667)));
        assert_eq!(bo.mean_loss, Some(loss(1.8333, 1.3333, 0.5)));
        assert_eq!((ada.solved, ada.reachable, ada.paired_mazes), (3, 3, 3));
        assert_eq!((cy.solved, cy.mean_loss, cy.paired_mazes), (1, Some(loss(31.0, 30.0, 1.0)), 1));
        let worst: Vec<_> =
            bo.worst_mazes.iter().map(|it| (&*it.maze.maze, it.loss, it.rival_loss_s)).collect();
        assert_eq!(
            worst,
            [("a", loss(4.0, 4.0, 0.0), Some(0.5)), ("b", loss(1.5, 0.0, 1.5), Some(1.0))]
        );
        assert!(bo.worst_mazes.iter().all(|it| it.rival.as_deref() == Some("ada")));
        let unsolved: Vec<_> =
            (cy.unsolved_mazes.iter()).map(|it| (&*it.maze.maze, it.rival.as_deref())).collect();
        // In c, both others lose nothing; the first one is named.
        assert_eq!(unsolved, [("b", Some("ada")), ("c", Some("bo"))]);
        assert_eq!(ada.reasons, [Reason::SearchTooLong, Reason::RouteTooSlow]);
        assert_eq!(cy.reasons, [Reason::NotSolved, Reason::SearchTooLong, Reason::RouteTooSlow]);
        assert_eq!(bo.why(), "search 1.33 s too long, route 0.50 s too slow");
        assert_eq!(bo.mazes(false), ["lost most: a 4.0 (ada 0.5), b 1.5 (1.0)"]);
        assert_eq!(
            cy.mazes(false),
            ["lost most: a 31.0 (ada 0.5)", "not solved: b, c: goal not reached after 999 steps"]
        );
    }

    #[test]
    fn many_unsolved_mazes_are_named_only_on_demand() {
        let maze = |name: &str| {
            let name = name.to_string();
            MazeColumns { path: String::new(), maze: name, width: 1, height: 1 }
        };
        let reasons = ["stuck", "stuck", "lost", "mad"].into_iter().chain(["stuck"; 6]);
        let unsolved = ('a'..).zip(reasons).map(|(name, reason)| UnsolvedMaze {
            maze: maze(&name.to_string()),
            error: reason.into(),
            rival: None,
        });
        let none = rank(&[("none", &[None])]).remove(0);
        let ranking = Ranking { unsolved_mazes: unsolved.collect(), ..none };
        assert_eq!(
            ranking.mazes(false),
            [
                "not solved: a, b, e, f and 4 more: stuck",
                "not solved: c: lost",
                "not solved: 1 maze for other reasons (see --tables)"
            ]
        );
        assert_eq!(
            ranking.mazes(true),
            [
                "not solved: a, b, e, f, g, h, i, j: stuck",
                "not solved: c: lost",
                "not solved: d: mad"
            ]
        );
    }

    #[test]
    fn a_wall_follower_does_not_change_the_others() {
        let with = rank(&[ADA, BO, CY]);
        assert_eq!(with[..2], rank(&[ADA, BO]));
    }

    #[test]
    fn equal_mice_share_a_rank_and_one_alone_loses_only_on_its_route() {
        let all = rank(&[CY, ("ada", ADA.1), ("eve", ADA.1)]);
        assert_eq!(ranks(&all), [3, 1, 1]);
        let alone = &rank(&[BO])[0];
        assert_eq!(alone.mean_loss, Some(loss(0.5, 0.0, 0.5)));
        assert_eq!((alone.worst_mazes.len(), &alone.worst_mazes[0].rival), (1, &None));
        assert_eq!(rank(&[("none", &[None, None])])[0].mean_loss, None);
    }

    #[test]
    fn mice_with_equally_many_solved_mazes_are_compared_in_the_same_ones() {
        let all = rank(&[
            ("x", &[Some((10.0, 2.0)), Some((10.0, 2.0)), None]),
            ("y", &[None, Some((11.0, 2.0)), Some((90.0, 2.0))]),
            ("z", &[Some((10.0, 2.0)), None, Some((10.0, 2.0))]),
        ]);
        assert!(all.iter().all(|one| one.paired_mazes == 0 && one.mean_loss.is_none()));
        let two = rank(&[
            ("x", &[Some((10.0, 2.0)), Some((10.0, 2.0)), None]),
            ("y", &[None, Some((11.0, 2.0)), Some((90.0, 2.0))]),
        ]);
        assert_eq!(two[1].mean_loss, Some(loss(1.0, 1.0, 0.0)));
        assert_eq!(ranks(&two), [1, 2]);
    }
}

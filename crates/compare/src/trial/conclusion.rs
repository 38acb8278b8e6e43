//! Why the tours of the published report compare differently with a correct A* search.

use mmsim_maze::counted;
use mmsim_trial::{BundledRobot, KeyPoints, Score, Settings, Variant};

use super::result::TrialResult;
use super::robot::{RobotKind, TrialRobot};
use super::tables::TrialTables;

impl TrialTables<'_> {
    /// Compares the tours of the published report, run by both versions of swing. Returns a sentence
    /// that explains the difference if swing is best with fewer key points than as published.
    pub fn conclusion(&self, settings: Settings) -> Option<String> {
        let tours: Vec<Settings> = (Variant::ALL.iter())
            .flat_map(|&variant| {
                let with = move |&key_points| Settings { variant, key_points, ..settings };
                let count = if variant == Variant::All { 3 } else { 1 };
                KeyPoints::ALL.iter().rev().take(count).rev().map(with)
            })
            .collect();
        let scores_of = |robot| -> Vec<Vec<Option<f64>>> {
            let robot_of = |&settings| TrialRobot { kind: RobotKind::Bundled(robot), settings };
            let score = |result: &TrialResult| result.score().map(Score::value);
            let scores = |tour| self.results_of(&robot_of(tour)).iter().map(score).collect();
            tours.iter().map(scores).collect()
        };
        let [swing, published] =
            [BundledRobot::Swing, BundledRobot::SwingAsPublished].map(scores_of);
        let scored_by_all: Vec<usize> = (0..self.mazes.len())
            .filter(|&maze| swing.iter().chain(&published).all(|scores| scores[maze].is_some()))
            .collect();
        // The index of the best tour, and its mean score.
        let best = |tours: &[Vec<Option<f64>>]| {
            let sum = |scores: &Vec<Option<f64>>| -> f64 {
                scored_by_all.iter().filter_map(|&maze| scores[maze]).sum()
            };
            let sums = tours.iter().map(sum).enumerate();
            let (tour, sum) = sums.min_by(|a, b| a.1.total_cmp(&b.1))?;
            let count = u32::try_from(scored_by_all.len()).ok()?;
            Some((tour, sum / f64::from(count)))
        };
        let name = |tour: usize| match tours[tour] {
            Settings { variant: Variant::All, key_points, .. } => {
                counted(key_points.number(), "key point").to_string()
            }
            Settings { variant, .. } => variant.to_string(),
        };
        let ((few, score), (many, published)) = (best(&swing)?, best(&published)?);
        (few < many).then(|| {
        let (few, many) = (name(few), name(many));
        format!(
            "Of the tours in the report, {many} is best as published (mean score {published:.3}). \
             With a correct A*, {few} is best ({score:.3}), because further corners cost more \
             steps than they save.\n"
        )
    })
    }
}

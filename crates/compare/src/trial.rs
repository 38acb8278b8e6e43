//! The two-run trial of several robots in several mazes.

mod result;
mod robot;
mod tables;

pub use self::result::{Means, TrialResult};
pub use self::robot::{
    OwnRobot, RobotKind, RunContext, TrialJob, TrialRobot, TrialStop, run_trials,
};
pub use self::tables::{TableRow, TrialRow, TrialTable, TrialTables};

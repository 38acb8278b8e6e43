//! The motion of a mouse over time, as CSV.

use std::error::Error;

use mmsim_fastrun::{MotionState, Trajectory};

/// The columns, with their units.
const HEAD: [&str; 7] = [
    "time_s",
    "x_mm",
    "y_mm",
    "heading_rad",
    "speed_mm_s",
    "acceleration_mm_s2",
    "angular_velocity_rad_s",
];

/// Formats the states of the mouse at regular times, `interval` s apart, and the last one.
pub(super) fn csv(trajectory: &Trajectory, interval: f64) -> Result<String, Box<dyn Error>> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    csv.write_record(HEAD)?;
    for moment in trajectory.samples(interval) {
        let MotionState { time, x, y, heading, speed, acceleration, angular_velocity, .. } = moment;
        csv.write_record([
            format!("{time:.6}"),
            format!("{x:.3}"),
            format!("{y:.3}"),
            format!("{heading:.6}"),
            format!("{speed:.2}"),
            format!("{acceleration:.1}"),
            format!("{angular_velocity:.4}"),
        ])?;
    }
    Ok(String::from_utf8(csv.into_inner()?)?)
}

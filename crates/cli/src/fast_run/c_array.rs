//! The straights and turns of a run, as an array in C.

use std::fmt::Write as _;
use std::path::Path;

use mmsim_fastrun::{Segment, Shape, Side, StraightLimits, TurnKind, Vehicle, VehicleParameters};
use mmsim_maze::Escaped;

use super::driven::DrivenRun;
use super::report::is_diagonal;
use crate::output::is_standard;

/// The types that all headers share.
const TYPES: &str = "
    FAST_RUN_STOP
};

enum fast_run_side { FAST_RUN_LEFT, FAST_RUN_RIGHT };

struct fast_run_step {
    float straight;         /* distance to the arc of the turn, or to the stop, in mm */
    unsigned char steps;    /* lattice steps on the straight: half a cell each, or half its diagonal */
    unsigned char diagonal; /* 1 if the straight is a diagonal, else 0 */
    float top_speed;        /* greatest speed on the straight, in mm/s */
    enum fast_run_turn turn;
    enum fast_run_side side;
    float arc;              /* length of the arc, in mm */
    float speed;            /* speed on the arc, in mm/s */
};

#endif
";

/// The straight before a turn without one, and that of a mouse that stays in the start cell.
const NO_STRAIGHT: &str = "0.000f, 0, 0, 0.000f";

/// Formats a run as a C header that also compiles as C++. The array and the macros are named after
/// the file, so that a program can include several headers.
pub(super) fn c_array(driven: &DrivenRun, file: &Path) -> String {
    let DrivenRun { maze, vehicle, run, trajectory, .. } = driven;
    let name = array_name(file);
    let macros = name.to_uppercase();
    let title = format!("Run of {} in {}", vehicle.name(), maze.path.display());
    let (title, time) = (comment(&title), trajectory.duration());
    let VehicleParameters { start_offset, stop_offset, .. } = vehicle.parameters();
    let turns: String = TurnKind::ALL.map(|kind| format!("    {},\n", constant(kind))).concat();
    let mut text = format!(
        "/* {title}: {time:.4} s from rest to rest. As text:\n * {run}\n *\n\
         \x20* The first straight begins {start_offset} mm behind the centre of the start cell, and the last\n\
         \x20* one ends {stop_offset} mm past the centre of a goal cell.\n */\n\
         #ifndef FAST_RUN_TYPES\n#define FAST_RUN_TYPES\n\n\
         enum fast_run_turn {{\n{turns}{}\n\
         #ifndef {macros}_H\n#define {macros}_H\n\n\
         #define {macros}_DIRECTION '{}' /* of the mouse at the start */\n{}\n\
         static const struct fast_run_step {name}[] = {{\n",
        TYPES.trim_start_matches('\n'),
        run.direction(),
        limits(vehicle, &macros),
    );
    let mut straight = NO_STRAIGHT.to_string();
    for segment in trajectory.segments() {
        let Segment { shape, entry, length, exit_speed, .. } = segment;
        match *shape {
            Shape::Straight(steps) => {
                let (diagonal, top) = (u8::from(is_diagonal(entry.heading)), segment.top_speed());
                straight = format!("{length:.3}f, {steps}, {diagonal}, {top:.3}f");
            }
            Shape::Turn(kind, side) => {
                let (turn, side) = (constant(kind), side_constant(side));
                // Writing to a string cannot fail.
                let _ = writeln!(
                    text,
                    "    {{ {straight}, {turn}, {side}, {length:.3}f, {exit_speed:.3}f }},"
                );
                straight = NO_STRAIGHT.into();
            }
        }
    }
    text + &format!(
        "    {{ {straight}, FAST_RUN_STOP, FAST_RUN_LEFT, 0.000f, 0.000f }},\n}};\n\n\
         #define {macros}_COUNT (sizeof {name} / sizeof {name}[0])\n\n#endif\n"
    )
}

/// Returns the name of the array in a file: `fast_run_final` in `final.h`, and `fast_run` in
/// `fast-run.h` and on stdout.
fn array_name(file: &Path) -> String {
    let stem =
        file.file_stem().filter(|_| !is_standard(file)).unwrap_or_default().to_string_lossy();
    let is_allowed = |c: char| c.is_ascii_alphanumeric();
    let stem: String =
        stem.to_lowercase().chars().map(|c| if is_allowed(c) { c } else { '_' }).collect();
    match stem.strip_prefix("fast_run").unwrap_or(&stem).trim_matches('_') {
        "" => "fast_run".into(),
        rest => format!("fast_run_{rest}"),
    }
}

/// Defines the limits on straights.
fn limits(vehicle: &Vehicle, macros: &str) -> String {
    let mut text = String::new();
    let VehicleParameters { along, diagonal, .. } = vehicle.parameters();
    let places = [
        ("", "on straights along rows and columns", Some(along)),
        ("DIAGONAL_", "on diagonals", diagonal.as_ref()),
    ];
    for (prefix, place, limits) in places {
        let Some(StraightLimits { acceleration, braking, jerk, .. }) = limits else { continue };
        let mut define = |limit: &str, value: f64, unit: &str| {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "#define {macros}_{prefix}{limit} {value:.1}f /* {place}, in {unit} */"
            );
        };
        define("ACCELERATION", *acceleration, "mm/s^2");
        define("BRAKING", *braking, "mm/s^2");
        if *jerk < f64::INFINITY {
            define("JERK", *jerk, "mm/s^3");
        }
    }
    text
}

/// Returns the constant of a side.
const fn side_constant(side: Side) -> &'static str {
    match side {
        Side::Left => "FAST_RUN_LEFT",
        Side::Right => "FAST_RUN_RIGHT",
    }
}

/// Returns the constant of a turn, such as `FAST_RUN_45IN`.
fn constant(kind: TurnKind) -> String {
    format!("FAST_RUN_{}", kind.name().to_uppercase())
}

/// Makes a text fit into a comment.
fn comment(text: &str) -> String {
    Escaped(text).to_string().replace("*/", "* /").replace("/*", "/ *")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_named_after_their_files() {
        let name = |file: &str| array_name(Path::new(file));
        assert_eq!(name("out/Final run.h"), "fast_run_final_run");
        assert_eq!(name("2-int.h"), "fast_run_2_int");
        assert_eq!(name("fast-run.h"), "fast_run");
        assert_eq!(name("fast_run_1.h"), "fast_run_1");
        assert_eq!((name("-"), name("ü.h")), ("fast_run".into(), "fast_run".into()));
    }

    #[test]
    fn no_text_ends_a_comment() {
        assert_eq!(comment("a*/b/*c\nd*/*/"), "a* /b/ *c\\nd* / * /");
    }
}

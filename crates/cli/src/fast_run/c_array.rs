//! The straights and turns of a run, as an array in C.

use std::fmt::Write as _;

use mmsim_fastrun::{Segment, Shape, Side, TurnKind, Vehicle};
use mmsim_maze::Escaped;

use super::driven::Driven;
use super::text::is_diagonal;

/// The declarations before the array.
const TYPES: &str = "
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
";

/// A straight of the array. The default is the one of a mouse that stays in the start cell.
#[derive(Default)]
struct Straight {
    length: f64,
    steps: u8,
    is_diagonal: bool,
    top_speed: f64,
}

/// Formats a run as C code that also compiles as C++.
pub(super) fn c_array(driven: &Driven) -> String {
    let Driven { maze, vehicle, run, trajectory, .. } = driven;
    let title = format!("Run of {} in {}", vehicle.name(), maze.path.display());
    let (title, time) = (comment(&title), trajectory.duration());
    let names: Vec<String> = TurnKind::ALL.into_iter().map(constant).collect();
    let mut text = format!(
        "/* {title}: {time:.4} s from rest to rest. As text:\n * {run}\n */\n\
         #ifndef FAST_RUN_H\n#define FAST_RUN_H\n\n\
         #define FAST_RUN_DIRECTION '{}' /* of the mouse at the start */\n{}\n\
         enum fast_run_turn {{\n    {},\n    FAST_RUN_STOP\n}};\n\
         {TYPES}\nstatic const struct fast_run_step fast_run[] = {{\n",
        run.direction(),
        limits(vehicle),
        names.join(",\n    "),
    );
    let mut straight = Straight::default();
    for segment in trajectory.segments() {
        let Segment { shape, entry, length, exit_speed, .. } = segment;
        match *shape {
            Shape::Straight(steps) => {
                let (is_diagonal, top_speed) = (is_diagonal(entry.heading), segment.top_speed());
                straight = Straight { length: *length, steps, is_diagonal, top_speed };
            }
            Shape::Turn(kind, side) => {
                let turn = (constant(kind), side, *length, *exit_speed);
                push_step(&mut text, std::mem::take(&mut straight), &turn);
            }
        }
    }
    push_step(&mut text, straight, &("FAST_RUN_STOP".into(), Side::Left, 0.0, 0.0));
    text + "};\n\n#define FAST_RUN_COUNT (sizeof fast_run / sizeof fast_run[0])\n\n#endif\n"
}

/// Defines the accelerations on straights.
fn limits(vehicle: &Vehicle) -> String {
    let define = |name: &str, value: f64, place: &str| {
        format!("#define FAST_RUN_{name} {value:.1}f /* {place}, in mm/s^2 */\n")
    };
    let (along, diagonal) = (vehicle.limits(false), vehicle.limits(true));
    [
        define("ACCELERATION", along.acceleration, "on straights along rows and columns"),
        define("BRAKING", along.braking, "on straights along rows and columns"),
        define("DIAGONAL_ACCELERATION", diagonal.acceleration, "on diagonals"),
        define("DIAGONAL_BRAKING", diagonal.braking, "on diagonals"),
    ]
    .concat()
}

fn push_step(
    text: &mut String,
    Straight { length, steps, is_diagonal, top_speed }: Straight,
    (turn, side, arc, speed): &(String, Side, f64, f64),
) {
    let side = match side {
        Side::Left => "FAST_RUN_LEFT",
        Side::Right => "FAST_RUN_RIGHT",
    };
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "    {{ {length:.3}f, {steps}, {}, {top_speed:.3}f, {turn}, {side}, {arc:.3}f, {speed:.3}f }},",
        u8::from(is_diagonal)
    );
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
    fn no_text_ends_a_comment() {
        assert_eq!(comment("a*/b/*c\nd*/*/"), "a* /b/ *c\\nd* / * /");
    }
}

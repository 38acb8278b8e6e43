//! The straights and turns of a run, as an array in C.

use std::fmt::Write as _;

use mmsim_fastrun::{Segment, Shape, Side, TurnKind};
use mmsim_maze::Escaped;

use super::driven::Driven;

/// The declarations before the array.
const TYPES: &str = "
enum fast_run_side { FAST_RUN_LEFT, FAST_RUN_RIGHT };

struct fast_run_step {
    float straight;      /* distance to the arc of the turn, or to the stop, in mm */
    unsigned char steps; /* lattice steps on the straight: half a cell each, or half its diagonal */
    enum fast_run_turn turn;
    enum fast_run_side side;
    float arc;           /* length of the arc, in mm */
    float speed;         /* speed on the arc, in mm/s */
};
";

/// Formats a run as C code that also compiles as C++.
pub(super) fn c_array(driven: &Driven) -> String {
    let Driven { maze, vehicle, run, trajectory, .. } = driven;
    let title = format!("Run of {} in {}", vehicle.name(), maze.path.display());
    let (title, time) = (comment(&title), trajectory.duration());
    let names: Vec<String> = TurnKind::ALL.into_iter().map(constant).collect();
    let mut text = format!(
        "/* {title}: {time:.4} s from rest to rest. As text:\n * {run}\n */\n\
         #define FAST_RUN_DIRECTION '{}' /* of the mouse at the start */\n\n\
         enum fast_run_turn {{\n    {},\n    FAST_RUN_STOP\n}};\n\
         {TYPES}\nstatic const struct fast_run_step fast_run[] = {{\n",
        run.direction(),
        names.join(",\n    "),
    );
    let mut straight = (0.0, 0);
    for Segment { shape, length, exit_speed, .. } in trajectory.segments() {
        match *shape {
            Shape::Straight(steps) => straight = (*length, steps),
            Shape::Turn(kind, side) => {
                let turn = (constant(kind), side, *length, *exit_speed);
                push_step(&mut text, std::mem::take(&mut straight), &turn);
            }
        }
    }
    push_step(&mut text, straight, &("FAST_RUN_STOP".into(), Side::Left, 0.0, 0.0));
    text + "};\n\n#define FAST_RUN_COUNT (sizeof fast_run / sizeof fast_run[0])\n"
}

fn push_step(
    text: &mut String,
    (straight, steps): (f64, u8),
    (turn, side, arc, speed): &(String, Side, f64, f64),
) {
    let side = match side {
        Side::Left => "FAST_RUN_LEFT",
        Side::Right => "FAST_RUN_RIGHT",
    };
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "    {{ {straight:.3}f, {steps}, {turn}, {side}, {arc:.3}f, {speed:.3}f }},"
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

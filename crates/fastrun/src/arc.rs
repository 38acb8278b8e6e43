//! The arc of a turn: a cubic spiral.

use libm::{cos, sin};

/// Returns the heading after the fraction `q` of the arc, as a fraction of the whole turn.
fn turned(q: f64) -> f64 {
    q * q * (3.0 - 2.0 * q)
}

/// Returns the displacement after the fraction `q` (0 to 1) of an arc that turns by `angle`
/// radians, as fractions of its length: forward and to the side.
///
/// The heading turns by θ(3q² - 2q³), so its curvature begins and ends at zero and is greatest in
/// the middle: 1.5 θ/L.
pub(crate) fn displacement(angle: f64, q: f64) -> (f64, f64) {
    // Gauss-Legendre quadrature with five points on each of eight parts.
    const NODES: [(f64, f64); 5] = [
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683, 0.478_628_670_499_366_47),
        (-0.538_469_310_105_683, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let half = q / 16.0;
    let (mut forward, mut aside) = (0.0, 0.0);
    for part in 0..8 {
        let middle = half * f64::from(2 * part + 1);
        for (node, weight) in NODES {
            let heading = angle * turned(middle + half * node);
            forward += half * weight * cos(heading);
            aside += half * weight * sin(heading);
        }
    }
    (forward, aside)
}

/// Returns the heading in radians after the fraction `q` (0 to 1) of an arc.
pub(crate) fn heading(angle: f64, q: f64) -> f64 {
    angle * turned(q)
}

/// Returns the curvature in the middle of an arc of `length` mm, in 1/mm.
pub(crate) fn greatest_curvature(angle: f64, length: f64) -> f64 {
    1.5 * angle / length
}

/// Returns the curvature in 1/mm, positive to the left for positive angles, after the fraction `q`
/// (0 to 1) of an arc of `length` mm.
pub(crate) fn curvature(angle: f64, length: f64, q: f64) -> f64 {
    6.0 * angle * q * (1.0 - q) / length
}

/// Returns the length of the two tangents of an arc as a fraction of its length: from each end to
/// the corner of the two lines.
pub(crate) fn tangent(angle: f64) -> f64 {
    displacement(angle, 1.0).1 / sin(angle)
}

#[cfg(test)]
mod tests {
    use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    use super::*;

    #[test]
    fn tangents_are_those_of_the_model() {
        let expected = [
            (FRAC_PI_4, 0.521_119_579_931_7),
            (FRAC_PI_2, 0.605_143_688_828_1),
            (3.0 * FRAC_PI_4, 0.902_489_023_162_4),
        ];
        for (angle, r) in expected {
            assert!((tangent(angle) - r).abs() < 1e-12, "{angle}: {}", tangent(angle));
        }
        assert!((displacement(PI, 1.0).1 - 0.486_075_967_227_1).abs() < 1e-12);
    }

    #[test]
    fn displacements_follow_the_heading() {
        let small = 1e-4;
        for angle in [FRAC_PI_4, FRAC_PI_2, PI] {
            assert_eq!(displacement(angle, 0.0), (0.0, 0.0));
            for step in 1..10 {
                let q = f64::from(step) / 10.0;
                let (before, after) =
                    (displacement(angle, q - small), displacement(angle, q + small));
                let (forward, aside) = (after.0 - before.0, after.1 - before.1);
                assert!((forward.hypot(aside) - 2.0 * small).abs() < 1e-9);
                assert!((aside.atan2(forward) - heading(angle, q)).abs() < 1e-6);
            }
        }
    }
}

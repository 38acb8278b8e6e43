//! Colours with a meaning: ramps for weights (heat colours) and speeds, distinct colours for several
//! paths, and the colours that a mouse gives to cells.
//!
//! A colour ramp is a sequence of colours, taken from a polyline in the `OKLab` colour space.
//! Neighbouring colours of the ramp are equally far apart, so equal differences look equal. The
//! lightness changes steadily, so colour-blind users can read the ramp. The range of lightness of
//! heat colours is limited, so that numbers drawn on top of them are legible.

use mmsim_maze::Colour;

use crate::style::colour::{Lch, Rgb, Theme, blend, luminance};

/// The number of colours in the ramp of speeds.
pub(crate) const SPEED_LEVELS: usize = 24;

/// The maximum number of paths in a scene.
pub const MAX_PATHS: usize = 6;

/// The slowest to the fastest colour. Lightness and the difference between blue and yellow grow
/// with the speed, so colour-blind users can read the ramp.
const SPEED_LIGHT: [Lch; 4] =
    [(0.35, 0.19, 268.0), (0.45, 0.22, 305.0), (0.56, 0.22, 5.0), (0.68, 0.165, 55.0)];
const SPEED_DARK: [Lch; 4] =
    [(0.55, 0.17, 270.0), (0.63, 0.19, 320.0), (0.74, 0.15, 25.0), (0.9, 0.15, 95.0)];

/// Returns the colours of speeds, slowest first.
pub(crate) fn speed_ramp(theme: Theme) -> Vec<Rgb> {
    match theme {
        Theme::Light => blend(&SPEED_LIGHT, SPEED_LEVELS),
        Theme::Dark => blend(&SPEED_DARK, SPEED_LEVELS),
    }
}

/// Returns the colours of several paths. They also differ for colour-blind users.
pub(crate) const fn path_colours(theme: Theme) -> [Rgb; MAX_PATHS] {
    match theme {
        Theme::Light => [
            Rgb(37, 99, 235),
            Rgb(217, 95, 2),
            Rgb(171, 2, 130),
            Rgb(70, 148, 144),
            Rgb(72, 5, 152),
            Rgb(97, 51, 15),
        ],
        Theme::Dark => [
            Rgb(88, 156, 255),
            Rgb(255, 150, 60),
            Rgb(175, 245, 200),
            Rgb(150, 60, 255),
            Rgb(165, 75, 75),
            Rgb(30, 120, 180),
        ],
    }
}

/// Returns the faint form of a colour, for the part of a path that the mouse has not driven yet.
pub(crate) fn faint(Rgb(red, green, blue): Rgb, floor: Rgb) -> Rgb {
    let mix = |colour: u8, floor: u8| {
        let sum = 3 * u16::from(colour) + 7 * u16::from(floor);
        u8::try_from(sum / 10).unwrap_or(u8::MAX)
    };
    Rgb(mix(red, floor.0), mix(green, floor.1), mix(blue, floor.2))
}

/// A scale of speeds from 0 to a round number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpeedScale {
    /// The distance between two ticks, in mm/s.
    step: f64,
    /// The number of steps.
    steps: u32,
}

impl SpeedScale {
    /// The maximum number of steps.
    const MAX_STEPS: f64 = 8.0;

    /// Returns the shortest scale that includes a speed in mm/s.
    pub(crate) fn up_to(speed: f64) -> Self {
        let round =
            (0..9).flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10_f64.powi(power)));
        let steps = |step: f64| (speed / step - 1e-9).ceil().max(1.0);
        let step = round.into_iter().find(|&step| steps(step) <= Self::MAX_STEPS).unwrap_or(1e9);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 8")]
        let steps = steps(step).min(Self::MAX_STEPS) as u32;
        Self { step, steps }
    }

    fn end(self) -> f64 {
        self.step * f64::from(self.steps)
    }

    /// Returns the index in the [`speed_ramp`] of the colour of a speed in mm/s.
    pub(crate) fn level(self, speed: f64) -> usize {
        #[expect(clippy::cast_precision_loss, reason = "small")]
        let level = speed / self.end() * SPEED_LEVELS as f64;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        (level.max(0.0) as usize).min(SPEED_LEVELS - 1)
    }

    /// Returns the ticks: the share of the scale, from 0 to 1, and the speed in m/s as text.
    pub(crate) fn ticks(self) -> impl Iterator<Item = (f64, String)> {
        (0..=self.steps).map(move |tick| {
            let metres = (f64::from(tick) * self.step).round() / 1000.0;
            (f64::from(tick) / f64::from(self.steps), metres.to_string())
        })
    }
}

/// The number of colours in a ramp.
pub(crate) const HEAT_LEVELS: usize = 64;

/// Returns the colour ramp of a theme, from the smallest weight to the largest weight.
pub(crate) fn heat_ramp(theme: Theme) -> Vec<Rgb> {
    match theme {
        Theme::Light => blend(&HEAT_LIGHT, HEAT_LEVELS),
        Theme::Dark => blend(&HEAT_DARK, HEAT_LEVELS),
    }
}

/// Returns the index of a weight's colour in the ramp, given the largest weight.
pub(crate) fn heat_step(weight: u16, largest: u16) -> usize {
    let (weight, largest) = (usize::from(weight), usize::from(largest).max(1));
    ((2 * weight * (HEAT_LEVELS - 1) + largest) / (2 * largest)).min(HEAT_LEVELS - 1)
}

const HEAT_LIGHT: [Lch; 5] = [
    (0.955, 0.025, 230.0),
    (0.935, 0.04, 130.0),
    (0.895, 0.085, 85.0),
    (0.825, 0.12, 62.0),
    (0.735, 0.145, 42.0),
];
const HEAT_DARK: [Lch; 4] =
    [(0.27, 0.05, 255.0), (0.345, 0.085, 305.0), (0.42, 0.115, 0.0), (0.51, 0.12, 50.0)];

/// The distance from a coloured area to the edges of its cell, in units. The floor between the area
/// and the walls keeps the walls visible beside any colour.
pub(crate) const INSET: u32 = 2;

/// Returns the colour of a cell as mms shows it.
pub(crate) const fn cell_colour(colour: Colour) -> Rgb {
    match colour {
        Colour::Black => Rgb(0, 0, 0),
        Colour::Blue => Rgb(0, 0, 179),
        Colour::Grey => Rgb(179, 179, 179),
        Colour::Cyan => Rgb(0, 102, 102),
        Colour::Green => Rgb(0, 179, 0),
        Colour::Orange => Rgb(179, 102, 0),
        Colour::Red => Rgb(204, 0, 0),
        Colour::White => Rgb(255, 255, 255),
        Colour::Yellow => Rgb(179, 179, 0),
        Colour::DarkBlue => Rgb(0, 0, 51),
        Colour::DarkCyan => Rgb(0, 51, 51),
        Colour::DarkGrey => Rgb(26, 26, 26),
        Colour::DarkGreen => Rgb(0, 77, 0),
        Colour::DarkOrange => Rgb(51, 26, 0),
        Colour::DarkRed => Rgb(77, 0, 0),
        Colour::DarkViolet => Rgb(51, 0, 51),
        Colour::DarkYellow => Rgb(51, 51, 0),
    }
}

/// Returns the class of labels on a colour: white on dark colours, black on light colours.
pub(crate) fn label_class(colour: Rgb) -> &'static str {
    if is_light(colour) { "on-light" } else { "on-dark" }
}

/// Returns true if black has more contrast than white on a colour.
pub(crate) fn is_light(colour: Rgb) -> bool {
    // The contrast ratio of two colours is the ratio of their luminances plus 0.05.
    (luminance(colour) + 0.05).powi(2) > 0.05 * 1.05
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::style::colour::{contrast, differences, luminance};

    #[test]
    fn speeds_are_visible_and_get_lighter() {
        for theme in [Theme::Light, Theme::Dark] {
            let (ramp, floor) = (speed_ramp(theme), theme.colours().floor);
            assert_eq!(ramp.len(), SPEED_LEVELS);
            for pair in ramp.windows(2) {
                assert!(luminance(pair[1]) > luminance(pair[0]), "{theme:?}: {pair:?}");
            }
            for colour in ramp {
                let contrast = contrast(colour, floor);
                assert!(contrast >= 2.7, "{theme:?}: {colour} {contrast:.2}");
            }
        }
    }

    #[test]
    fn paths_differ_for_colour_blind_users() {
        for theme in [Theme::Light, Theme::Dark] {
            let (colours, floor) = (path_colours(theme), theme.colours().floor);
            for (index, &one) in colours.iter().enumerate() {
                for &other in &colours[index + 1..] {
                    for (vision, difference) in differences(one, other) {
                        assert!(
                            difference > 0.11,
                            "{theme:?} {vision} {one} {other}: {difference:.3}"
                        );
                    }
                }
            }
            for colour in colours {
                assert!(contrast(colour, floor) >= 3.0, "{theme:?} {colour}");
                assert!(luminance(colour) > 0.03, "{theme:?} {colour} is almost black");
                let faint = faint(colour, floor);
                assert!((1.1..3.0).contains(&contrast(faint, floor)), "{theme:?} {faint}");
            }
        }
    }

    #[test]
    fn scales_end_at_round_numbers() {
        for (speed, last, count) in [
            (2500.0, "2.5", 6),
            (1893.0, "2", 5),
            (5000.0, "5", 6),
            (500.0, "0.5", 6),
            (3100.0, "3.5", 8),
            (0.0, "0.001", 2),
        ] {
            let ticks: Vec<_> = SpeedScale::up_to(speed).ticks().collect();
            assert_eq!((ticks[0].1.as_str(), ticks[0].0), ("0", 0.0));
            assert_eq!(
                (ticks[ticks.len() - 1].1.as_str(), ticks.len()),
                (last, count),
                "{ticks:?}"
            );
        }
        let scale = SpeedScale::up_to(2500.0);
        let levels = [-1.0, 0.0, 1250.0, 2499.9, 2500.0, 1e12].map(|speed| scale.level(speed));
        assert_eq!(levels, [0, 0, 12, 23, 23, 23]);
        assert!(SpeedScale::up_to(1e300).ticks().count() <= 9);
    }

    #[test]
    fn lightness_is_monotonic() {
        for theme in [Theme::Light, Theme::Dark] {
            let ramp: Vec<f64> = heat_ramp(theme).into_iter().map(luminance).collect();
            assert_eq!(ramp.len(), HEAT_LEVELS);
            let rises = ramp.windows(2).filter(|pair| pair[1] > pair[0]).count();
            assert_eq!(rises, if theme == Theme::Dark { HEAT_LEVELS - 1 } else { 0 });
        }
    }

    #[test]
    fn neighbouring_colours_differ_but_only_slightly() {
        for theme in [Theme::Light, Theme::Dark] {
            for pair in heat_ramp(theme).windows(2) {
                assert_ne!(pair[0], pair[1]);
                assert!(contrast(pair[0], pair[1]) < 1.1);
            }
        }
    }

    #[test]
    fn the_largest_weight_is_the_warmest() {
        assert_eq!([0, 1, 2].map(|weight| heat_step(weight, 2)), [0, 32, 63]);
        assert_eq!(heat_step(0, 0), 0);
        for largest in 1..=255_u16 {
            for weight in 0..=largest {
                let exact = f64::from(weight) * 63.0 / f64::from(largest);
                #[expect(clippy::cast_precision_loss, reason = "at most 63")]
                let found = heat_step(weight, largest) as f64;
                // Browsers round half up.
                assert!((found - (exact + 0.5).floor()).abs() < 0.1, "{weight} of {largest}");
            }
        }
    }

    #[test]
    fn labels_are_legible_on_every_colour() {
        for colour in Colour::ALL {
            let area = cell_colour(colour);
            let label = if is_light(area) { Rgb(0, 0, 0) } else { Rgb(255, 255, 255) };
            let contrast = contrast(label, area);
            assert!(contrast >= 4.5, "{colour:?}: {contrast:.2}");
        }
    }

    #[test]
    fn cell_colours_are_distinct() {
        let colours: BTreeSet<_> = Colour::ALL.into_iter().map(cell_colour).collect();
        assert_eq!(colours.len(), Colour::ALL.len());
    }
}

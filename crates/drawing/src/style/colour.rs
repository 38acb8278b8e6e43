//! Heat map colours for weights.
//!
//! A colour ramp is a sequence of colours from cool to warm, taken from a polyline in the `OKLab`
//! colour space (<https://bottosson.github.io/posts/oklab/>). Neighbouring colours of the ramp are
//! equally far apart, so equal differences in weight look equal. The lightness decreases steadily
//! (in the dark theme, it increases), so colour-blind users can read the ramp. The range of
//! lightness is limited, so that numbers drawn on top of the colours are legible.

use crate::style::Theme;

/// The number of colours in a ramp.
pub(crate) const STEPS: usize = 64;

/// A colour as red, green and blue, each from 0 to 255.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Rgb(pub(crate) u8, pub(crate) u8, pub(crate) u8);

impl std::fmt::Display for Rgb {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
    }
}

/// Returns the colour ramp of a theme, from the smallest weight to the largest weight.
pub(crate) fn ramp(theme: Theme) -> Vec<Rgb> {
    match theme {
        Theme::Light => blend(&LIGHT, STEPS),
        Theme::Dark => blend(&DARK, STEPS),
    }
}

/// Returns `steps` equally distant colours on the polyline through `corners`.
pub(crate) fn blend(corners: &[Lch], steps: usize) -> Vec<Rgb> {
    let corners: Vec<Lab> = corners.iter().copied().map(lab).collect();
    let lengths: Vec<f64> = corners.windows(2).map(|pair| distance(pair[0], pair[1])).collect();
    let total: f64 = lengths.iter().sum();
    #[expect(clippy::cast_precision_loss, reason = "few steps")]
    let at = |step: usize| total * step as f64 / (steps - 1) as f64;
    (0..steps).map(|step| srgb(along(&corners, &lengths, at(step)))).collect()
}

/// Returns the index of a weight's colour in the ramp, given the largest weight.
pub(crate) fn step(weight: u16, largest: u16) -> usize {
    let (weight, largest) = (usize::from(weight), usize::from(largest).max(1));
    ((2 * weight * (STEPS - 1) + largest) / (2 * largest)).min(STEPS - 1)
}

/// Returns the relative luminance as defined by the Web Content Accessibility Guidelines 2.2.
pub(crate) fn luminance(Rgb(red, green, blue): Rgb) -> f64 {
    let linear = |channel: u8| {
        let share = f64::from(channel) / 255.0;
        if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
    };
    0.2126 * linear(red) + 0.7152 * linear(green) + 0.0722 * linear(blue)
}

/// The lightness, chroma and hue (in degrees) of a colour. The colour ramps are polylines through
/// the colours in `LIGHT` and `DARK`.
pub(crate) type Lch = (f64, f64, f64);
const LIGHT: [Lch; 5] = [
    (0.955, 0.025, 230.0),
    (0.935, 0.04, 130.0),
    (0.895, 0.085, 85.0),
    (0.825, 0.12, 62.0),
    (0.735, 0.145, 42.0),
];
const DARK: [Lch; 4] =
    [(0.27, 0.05, 255.0), (0.345, 0.085, 305.0), (0.42, 0.115, 0.0), (0.51, 0.12, 50.0)];

type Lab = [f64; 3];

fn lab((lightness, chroma, hue): Lch) -> Lab {
    let (sin, cos) = hue.to_radians().sin_cos();
    [lightness, chroma * cos, chroma * sin]
}

fn distance(from: Lab, to: Lab) -> f64 {
    from.iter().zip(to).map(|(from, to)| (to - from).powi(2)).sum::<f64>().sqrt()
}

/// Returns the colour at the distance `way` along the polyline through `corners`.
fn along(corners: &[Lab], lengths: &[f64], mut way: f64) -> Lab {
    let mut leg = 0;
    while leg + 1 < lengths.len() && way > lengths[leg] {
        way -= lengths[leg];
        leg += 1;
    }
    let (from, to, share) = (corners[leg], corners[leg + 1], way / lengths[leg]);
    std::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis]))
}

/// Converts an `OKLab` colour to the nearest sRGB colour.
fn srgb([l, a, b]: Lab) -> Rgb {
    let cube = |a_share: f64, b_share: f64| (l + a_share * a + b_share * b).powi(3);
    let (l, m, s) = (
        cube(0.396_337_777_4, 0.215_803_757_3),
        cube(-0.105_561_345_8, -0.063_854_172_8),
        cube(-0.089_484_177_5, -1.291_485_548),
    );
    let channel = |linear: f64| {
        let curved = if linear <= 0.003_130_8 {
            12.92 * linear
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        {
            (curved * 255.0).round().clamp(0.0, 255.0) as u8
        }
    };
    Rgb(
        channel(4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s),
        channel(-1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s),
        channel(-0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701 * s),
    )
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Returns the contrast ratio, from 1 to 21, as defined by the Web Content Accessibility
    /// Guidelines 2.2.
    pub(crate) fn contrast(one: Rgb, other: Rgb) -> f64 {
        let (one, other) = (luminance(one) + 0.05, luminance(other) + 0.05);
        one.max(other) / one.min(other)
    }

    #[test]
    fn lightness_is_monotonic() {
        for theme in [Theme::Light, Theme::Dark] {
            let ramp: Vec<f64> = ramp(theme).into_iter().map(luminance).collect();
            assert_eq!(ramp.len(), STEPS);
            let rises = ramp.windows(2).filter(|pair| pair[1] > pair[0]).count();
            assert_eq!(rises, if theme == Theme::Dark { STEPS - 1 } else { 0 });
        }
    }

    #[test]
    fn neighbouring_colours_differ_but_only_slightly() {
        for theme in [Theme::Light, Theme::Dark] {
            for pair in ramp(theme).windows(2) {
                assert_ne!(pair[0], pair[1]);
                assert!(contrast(pair[0], pair[1]) < 1.1);
            }
        }
    }

    #[test]
    fn reference_colours_convert_correctly() {
        assert_eq!(srgb([1.0, 0.0, 0.0]), Rgb(255, 255, 255));
        assert_eq!(srgb([0.0, 0.0, 0.0]), Rgb(0, 0, 0));
        // Pure red, from the article that defines OKLab.
        assert_eq!(srgb([0.627_955, 0.224_863, 0.125_846]), Rgb(255, 0, 0));
    }

    #[test]
    fn the_largest_weight_is_the_warmest() {
        assert_eq!([0, 1, 2].map(|weight| step(weight, 2)), [0, 32, 63]);
        assert_eq!(step(0, 0), 0);
        for largest in 1..=255_u16 {
            for weight in 0..=largest {
                let exact = f64::from(weight) * 63.0 / f64::from(largest);
                #[expect(clippy::cast_precision_loss, reason = "at most 63")]
                let found = step(weight, largest) as f64;
                // Browsers round half up.
                assert!((found - (exact + 0.5).floor()).abs() < 0.1, "{weight} of {largest}");
            }
        }
    }
}

//! Themes, and colours in the colour spaces sRGB and `OKLab`
//! (<https://bottosson.github.io/posts/oklab/>).

/// A colour theme.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Theme {
    /// Dark lines on a light background.
    #[default]
    Light,
    /// Light lines on a dark background.
    Dark,
}

/// A colour as red, green and blue, each from 0 to 255.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Rgb(pub(crate) u8, pub(crate) u8, pub(crate) u8);

impl std::fmt::Display for Rgb {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
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

/// Returns the relative luminance as defined by the Web Content Accessibility Guidelines 2.2.
pub(crate) fn luminance(Rgb(red, green, blue): Rgb) -> f64 {
    let linear = |channel: u8| {
        let share = f64::from(channel) / 255.0;
        if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
    };
    0.2126 * linear(red) + 0.7152 * linear(green) + 0.0722 * linear(blue)
}

/// The lightness, chroma and hue (in degrees) of a colour.
pub(crate) type Lch = (f64, f64, f64);
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
pub(crate) use tests::{contrast, differences};

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the contrast ratio, from 1 to 21, as defined by the Web Content Accessibility
    /// Guidelines 2.2.
    pub(crate) fn contrast(one: Rgb, other: Rgb) -> f64 {
        let (one, other) = (luminance(one) + 0.05, luminance(other) + 0.05);
        one.max(other) / one.min(other)
    }

    /// Returns linear light from 0 to 1.
    fn linear(Rgb(red, green, blue): Rgb) -> [f64; 3] {
        [red, green, blue].map(|channel| {
            let share = f64::from(channel) / 255.0;
            if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
        })
    }

    /// Returns the difference of two colours of linear light in the colour space `OKLab`.
    fn difference(one: [f64; 3], other: [f64; 3]) -> f64 {
        let lab = |[r, g, b]: [f64; 3]| {
            let l = (0.412_221 * r + 0.536_333 * g + 0.051_446 * b).max(0.0).cbrt();
            let m = (0.211_903 * r + 0.680_700 * g + 0.107_397 * b).max(0.0).cbrt();
            let s = (0.088_302 * r + 0.281_719 * g + 0.629_979 * b).max(0.0).cbrt();
            [
                0.210_454 * l + 0.793_618 * m - 0.004_072 * s,
                1.977_998 * l - 2.428_592 * m + 0.450_594 * s,
                0.025_904 * l + 0.782_772 * m - 0.808_676 * s,
            ]
        };
        let (one, other) = (lab(one), lab(other));
        one.iter().zip(other).map(|(one, other)| (one - other).powi(2)).sum::<f64>().sqrt()
    }

    /// How people without one kind of cones see linear light, from Machado, Oliveira and Fernandes:
    /// A Physiologically-based Model for Simulation of Color Vision Deficiency (2009).
    const VISIONS: [(&str, [[f64; 3]; 3]); 3] = [
        ("normal", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        (
            "protanopia",
            [
                [0.152_286, 1.052_583, -0.204_868],
                [0.114_503, 0.786_281, 0.099_216],
                [-0.003_882, -0.048_116, 1.051_998],
            ],
        ),
        (
            "deuteranopia",
            [
                [0.367_322, 0.860_646, -0.227_968],
                [0.280_085, 0.672_501, 0.047_413],
                [-0.011_820, 0.042_940, 0.968_881],
            ],
        ),
    ];

    /// Returns the difference of two colours in `OKLab` for each kind of vision.
    pub(crate) fn differences(one: Rgb, other: Rgb) -> [(&'static str, f64); 3] {
        VISIONS.map(|(name, vision)| {
            let [one, other] = [one, other].map(|colour| {
                let light = linear(colour);
                vision.map(|row| row.iter().zip(light).map(|(share, light)| share * light).sum())
            });
            (name, difference(one, other))
        })
    }

    #[test]
    fn reference_colours_convert_correctly() {
        assert_eq!(srgb([1.0, 0.0, 0.0]), Rgb(255, 255, 255));
        assert_eq!(srgb([0.0, 0.0, 0.0]), Rgb(0, 0, 0));
        // Pure red, from the article that defines OKLab.
        assert_eq!(srgb([0.627_955, 0.224_863, 0.125_846]), Rgb(255, 0, 0));
    }
}

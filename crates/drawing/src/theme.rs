//! Themes and style rules.

use std::fmt::Write as _;

use crate::font;
use crate::heat::Rgb;
use crate::passages::AGES;

/// A colour theme.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Theme {
    /// Dark lines on a light background.
    #[default]
    Light,
    /// Light lines on a dark background.
    Dark,
}

/// The colours of a theme, except the heat colours.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Colours {
    pub(crate) floor: Rgb,
    pub(crate) visited: Rgb,
    pub(crate) wall: Rgb,
    /// The colour of walls that are not on the client's map.
    pub(crate) unknown: Rgb,
    pub(crate) mistaken: Rgb,
    /// The colours of the start cell and of its frame.
    pub(crate) start: (Rgb, Rgb),
    /// The colours of the goal cells and of their frame.
    pub(crate) goal: (Rgb, Rgb),
    /// The colours of the oldest and of the newest passages of the trail.
    pub(crate) trail: (Rgb, Rgb),
    pub(crate) number: Rgb,
    pub(crate) mouse: Rgb,
    /// The colour of the mouse's outline.
    pub(crate) rim: Rgb,
    pub(crate) post_opacity: &'static str,
}

const fn rgb(hex: u32) -> Rgb {
    let [_, red, green, blue] = hex.to_be_bytes();
    Rgb(red, green, blue)
}

impl Theme {
    /// Returns the colours of the theme.
    pub(crate) const fn colours(self) -> Colours {
        match self {
            Self::Light => Colours {
                floor: rgb(0x00fd_fdfc),
                visited: rgb(0x00c4_d8f5),
                wall: rgb(0x001b_2430),
                unknown: rgb(0x006c_7686),
                mistaken: rgb(0x00d0_1c50),
                start: (rgb(0x00cb_ebe2), rgb(0x0005_6b5c)),
                goal: (rgb(0x00ec_dcf7), rgb(0x007a_2ba8)),
                trail: (rgb(0x0086_a5e8), rgb(0x0025_63eb)),
                number: rgb(0x002a_3442),
                mouse: rgb(0x001d_4fd7),
                rim: rgb(0x00ff_ffff),
                post_opacity: ".2",
            },
            Self::Dark => Colours {
                floor: rgb(0x0013_1820),
                visited: rgb(0x0024_364f),
                wall: rgb(0x00e8_edf4),
                unknown: rgb(0x007a_8698),
                mistaken: rgb(0x00ff_b02e),
                start: (rgb(0x000d_4039), rgb(0x006f_e3cd)),
                goal: (rgb(0x0043_2560), rgb(0x00d9_a8f7)),
                trail: (rgb(0x003f_6597), rgb(0x0058_a6ff)),
                number: rgb(0x00e2_e8f0),
                mouse: rgb(0x007d_b8ff),
                rim: rgb(0x000b_0f15),
                post_opacity: ".2",
            },
        }
    }
}

impl Colours {
    /// Returns the colours that are drawn without transparency.
    pub(crate) fn areas(&self) -> Vec<Rgb> {
        let Self { floor, visited, wall, unknown, mistaken, number, mouse, rim, .. } = *self;
        let areas = [floor, visited, wall, unknown, mistaken, number, mouse, rim];
        let marks = [self.start.0, self.start.1, self.goal.0, self.goal.1];
        areas.into_iter().chain(marks).chain((0..AGES).map(|age| self.trail(age))).collect()
    }

    /// Returns the colour of the passages of the trail with this age.
    pub(crate) fn trail(&self, age: usize) -> Rgb {
        let (Rgb(old_red, old_green, old_blue), Rgb(red, green, blue)) = self.trail;
        let mix = |old: u8, new: u8| {
            let (old, new, last) = (usize::from(old), usize::from(new), AGES - 1);
            u8::try_from((old * (last - age) + new * age + last / 2) / last).unwrap_or(u8::MAX)
        };
        Rgb(mix(old_red, red), mix(old_green, green), mix(old_blue, blue))
    }
}

/// Returns the style rules shared by both themes. The rules contain no variables or calculations,
/// so that even simple SVG renderers support them.
fn shapes() -> String {
    format!(
        "\
.maze .floor,.maze .cell,.maze .heat{{shape-rendering:crispEdges}}
.maze path{{fill:none;stroke-linecap:round;stroke-linejoin:round}}
.maze .cell{{fill:none}}
.maze .wall{{stroke-width:2;stroke-linecap:square}}
.maze .wall.true{{stroke-width:1.2;stroke-linecap:butt}}
.maze .wall.known{{stroke-width:2;stroke-linecap:square}}
.maze .wall.mistaken{{stroke-linecap:butt;stroke-dasharray:4 3;stroke-dashoffset:-1}}
.maze .mark{{stroke-width:1.4}}
.maze .letter{{stroke-width:.95}}
.maze .passage{{stroke-width:1.6}}
.maze .faint{{stop-opacity:.22}}
.maze .number,.maze .text{{stroke-width:{}}}
.maze .mouse{{stroke-width:1.2;fill-rule:evenodd}}
.maze .mouse.absent,.hide-numbers .numbers,.hide-heat .heats,.hide-trail .trail{{display:none}}
",
        font::STROKE
    )
}

/// Returns the style rules that set the colours of a theme.
fn colours(theme: Theme) -> String {
    let Colours {
        floor, visited, wall, unknown, mistaken, start, goal, number, mouse, rim, ..
    } = theme.colours();
    let post_opacity = theme.colours().post_opacity;
    let mut rules = String::new();
    for (what, style) in [
        ("floor", format!("fill:{floor}")),
        ("cell.visited", format!("fill:{visited}")),
        ("cell.start", format!("fill:{}", start.0)),
        ("cell.goal", format!("fill:{}", goal.0)),
        ("mark.start", format!("stroke:{}", start.1)),
        ("mark.goal", format!("stroke:{}", goal.1)),
        ("badge.start", format!("fill:{}", start.1)),
        ("badge.goal", format!("fill:{}", goal.1)),
        ("letter", format!("stroke:{floor}")),
        ("number", format!("stroke:{number}")),
        ("text", format!("stroke:{number}")),
        ("on-dark", "stroke:#fff".into()),
        ("on-light", "stroke:#000".into()),
        ("wall.true", format!("stroke:{unknown}")),
        ("wall.known", format!("stroke:{wall}")),
        ("wall.mistaken", format!("stroke:{mistaken}")),
        ("posts", format!("fill:{wall};fill-opacity:{post_opacity}")),
        ("mouse", format!("fill:{mouse};stroke:{rim}")),
    ] {
        let _ = writeln!(rules, ".maze .{what}{{{style}}}");
    }
    for age in 0..AGES {
        let trail = theme.colours().trail(age);
        let _ = writeln!(rules, ".maze .ink{age} stop{{stop-color:{trail}}}");
        let _ = writeln!(rules, ".no-labels .age{age}{{stroke:{trail}}}");
    }
    rules
}

/// Returns the stylesheet for a page that contains drawings
/// ([`Scene::page_svg`](crate::Scene::page_svg)). The stylesheet uses the dark theme for users who
/// prefer dark colours, and the light theme otherwise.
///
/// ```
/// let css = mmsim_drawing::stylesheet();
/// assert!(css.contains("@media (prefers-color-scheme:dark){\n.maze .floor{"));
/// ```
pub fn stylesheet() -> String {
    let (light, dark) = (colours(Theme::Light), colours(Theme::Dark));
    format!("{}{light}@media (prefers-color-scheme:dark){{\n{dark}}}\n", shapes())
}

/// Returns the style rules of a standalone file with this theme. If `is_truth_alone` is true, all
/// walls are drawn like known walls, because the scene contains the true maze but no client's map.
pub(crate) fn file_style(theme: Theme, is_truth_alone: bool) -> String {
    let wall = theme.colours().wall;
    let strong =
        format!(".maze .wall.true{{stroke:{wall};stroke-width:2;stroke-linecap:square}}\n");
    let strong = if is_truth_alone { strong } else { String::new() };
    format!("{}{}{strong}", shapes(), colours(theme))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heat::ramp;
    use crate::heat::tests::contrast;

    #[test]
    fn numbers_are_legible_on_every_cell() {
        for theme in [Theme::Light, Theme::Dark] {
            let Colours { floor, visited, start, goal, number, .. } = theme.colours();
            for cell in ramp(theme).into_iter().chain([floor, visited, start.0, goal.0]) {
                let contrast = contrast(number, cell);
                assert!(contrast >= 4.5, "{theme:?}: {contrast:.2} on {cell}");
            }
        }
    }

    #[test]
    fn important_elements_have_contrast() {
        for theme in [Theme::Light, Theme::Dark] {
            let colours = theme.colours();
            let Colours { floor, visited, wall, unknown, mistaken, start, goal, mouse, .. } =
                colours;
            // Heat colours and the colours of mice do not touch walls.
            let newest = colours.trail(AGES - 1);
            for (what, colour, behind) in [
                ("wall", wall, floor),
                ("wall of a visited cell", wall, visited),
                ("unknown wall", unknown, floor),
                ("unknown wall of a visited cell", unknown, visited),
                ("unknown wall of the start", unknown, start.0),
                ("unknown wall of a goal cell", unknown, goal.0),
                ("new trail", newest, floor),
                ("new trail in a visited cell", newest, visited),
                ("mistaken wall", mistaken, floor),
                ("S", start.1, floor),
                ("G", goal.1, floor),
                ("mouse", mouse, visited),
            ] {
                let contrast = contrast(colour, behind);
                assert!(contrast >= 3.0, "{theme:?}: {what} {contrast:.2}");
            }
        }
    }

    #[test]
    fn kinds_of_cells_and_walls_differ() {
        for theme in [Theme::Light, Theme::Dark] {
            let colours = theme.colours();
            let Colours { floor, visited, wall, unknown, .. } = colours;
            for (what, one, other, least) in [
                ("visited cell", visited, floor, 1.4),
                ("unknown wall", unknown, wall, 3.0),
                ("old trail", colours.trail(0), colours.trail(AGES - 1), 1.5),
                ("old trail in a visited cell", colours.trail(0), visited, 1.5),
            ] {
                let contrast = contrast(one, other);
                assert!(contrast >= least, "{theme:?}: {what} {contrast:.2}");
            }
        }
    }

    #[test]
    fn the_dark_rules_differ_only_in_colours() {
        let selectors = |theme| {
            let rules = colours(theme);
            rules
                .lines()
                .map(|rule| rule.split('{').next().unwrap().to_string())
                .collect::<Vec<_>>()
        };
        assert_eq!(selectors(Theme::Light), selectors(Theme::Dark));
        let css = stylesheet();
        assert_eq!(css.matches('{').count(), css.matches('}').count());
        assert!(!css.contains("var(") && !file_style(Theme::Dark, false).contains('@'));
    }
}

//! Themes and style rules.

pub(crate) mod colour;
pub(crate) mod data_colours;

use std::fmt::Write as _;

use crate::shapes::AGES;
use crate::style::colour::{Rgb, Theme};
use crate::text::{STROKE, TEXT_STROKE, decimals};

/// The colours of a theme, except the heat colours.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Colours {
    pub(crate) floor: Rgb,
    pub(crate) visited: Rgb,
    pub(crate) wall: Rgb,
    /// The colour of walls that are not on the client's map.
    pub(crate) unknown: Rgb,
    pub(crate) mistaken: Rgb,
    pub(crate) start: PlaceColours,
    pub(crate) goal: PlaceColours,
    /// The colours of the oldest and of the newest passages of the trail.
    pub(crate) trail: (Rgb, Rgb),
    pub(crate) shortest_route: Rgb,
    pub(crate) planned_route: Rgb,
    pub(crate) number: Rgb,
    pub(crate) text: Rgb,
    pub(crate) mouse: Rgb,
    /// The colour of the mouse's outline.
    pub(crate) rim: Rgb,
}

/// The colours of the start cell or of the goal cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaceColours {
    pub(crate) floor: Rgb,
    pub(crate) visited: Rgb,
    pub(crate) frame: Rgb,
}

const fn place(floor: u32, visited: u32, frame: u32) -> PlaceColours {
    PlaceColours { floor: rgb(floor), visited: rgb(visited), frame: rgb(frame) }
}

/// The widths of walls in units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WallWidths {
    pub(crate) known: f64,
    pub(crate) unknown: f64,
}

/// The limits of the width of a wall: the minimum in units, the minimum in pixels, and the maximum in
/// units, which takes precedence. A line of 2 pixels covers at least one pixel completely, wherever
/// it is.
pub(crate) type WidthLimits = [f64; 3];
pub(crate) const KNOWN_WIDTH: WidthLimits = [2.0, 3.0, 4.5];
pub(crate) const UNKNOWN_WIDTH: WidthLimits = [1.2, 2.0, 3.0];

impl WallWidths {
    /// Returns the widths at a scale in pixels per unit.
    pub(crate) fn at_scale(scale: f64) -> Self {
        let width = |[min, min_px, max]: WidthLimits| (min_px / scale).clamp(min, max);
        Self { known: width(KNOWN_WIDTH), unknown: width(UNKNOWN_WIDTH) }
    }
}

impl Default for WallWidths {
    fn default() -> Self {
        Self { known: KNOWN_WIDTH[0], unknown: UNKNOWN_WIDTH[0] }
    }
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
                mistaken: rgb(0x00cc_0f3f),
                start: place(0x00e6_f8f2, 0x00b0_dcd9, 0x0005_6b5c),
                goal: place(0x00f8_f1fd, 0x00d6_cbf7, 0x007a_2ba8),
                trail: (rgb(0x0086_a5e8), rgb(0x0025_63eb)),
                shortest_route: rgb(0x0000_808c),
                planned_route: rgb(0x00c2_5700),
                number: rgb(0x002a_3442),
                text: rgb(0x006e_1f00),
                mouse: rgb(0x001d_4fd7),
                rim: rgb(0x00ff_ffff),
            },
            Self::Dark => Colours {
                floor: rgb(0x0013_1820),
                visited: rgb(0x0024_364f),
                wall: rgb(0x00e8_edf4),
                unknown: rgb(0x007a_8698),
                mistaken: rgb(0x00ff_b02e),
                start: place(0x0008_2b26, 0x000e_3f46, 0x007f_e8c8),
                goal: place(0x0030_1844, 0x003c_3168, 0x00e3_9bff),
                trail: (rgb(0x003f_6597), rgb(0x0058_a6ff)),
                shortest_route: rgb(0x005c_d6c8),
                planned_route: rgb(0x00ff_9d5c),
                number: rgb(0x00e2_e8f0),
                text: rgb(0x00ff_dfae),
                mouse: rgb(0x007d_b8ff),
                rim: rgb(0x000b_0f15),
            },
        }
    }
}

impl Colours {
    /// Returns the colours that are drawn without transparency.
    pub(crate) fn areas(&self) -> Vec<Rgb> {
        let Self { floor, visited, wall, unknown, mistaken, number, mouse, rim, .. } = *self;
        let route = self.planned_route;
        let areas = [floor, visited, wall, unknown, mistaken, number, mouse, rim, route];
        let marks = [self.start, self.goal]
            .into_iter()
            .flat_map(|place| [place.floor, place.visited, place.frame]);
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
fn shapes(WallWidths { known, unknown }: WallWidths) -> String {
    let [known, unknown] = [known, unknown].map(decimals);
    format!(
        "\
.maze .floor,.maze .cell,.maze .heat{{shape-rendering:crispEdges}}
.maze path{{fill:none;stroke-linecap:round;stroke-linejoin:round}}
.maze .cell{{fill:none}}
.maze .wall{{stroke-width:{known};stroke-linecap:square}}
.maze .wall.true{{stroke-width:{unknown};stroke-linecap:butt}}
.maze .wall.known,.maze .wall.missed{{stroke-width:{known};stroke-linecap:square}}
.maze .wall.mistaken{{stroke-linecap:butt;stroke-dasharray:4 3;stroke-dashoffset:-1}}
.maze .mark{{stroke-width:1.4}}
.maze .letter{{stroke-width:.95}}
.maze .passage{{stroke-width:1.6}}
.maze .shortest-route{{stroke-width:7;stroke-opacity:.3}}
.maze .planned-route{{stroke-width:2;stroke-dasharray:0 7.2 1.4 2.8 1.4 7.2}}
.no-labels .shortest-route,.small-cells .shortest-route{{stroke-width:4.4;stroke-opacity:.55}}
.no-labels .planned-route,.small-cells .planned-route{{stroke-dasharray:3 4}}
.maze .faint{{stop-opacity:.14}}
.maze .number{{stroke-width:{STROKE}}}
.maze .text{{stroke-width:{TEXT_STROKE}}}
.maze .mouse{{stroke-width:1.2;fill-rule:evenodd}}
.maze .mouse.absent,.hide-numbers .numbers,.hide-heat .heats,.hide-trail .trail,.small-cells .numbers,.small-cells .texts{{display:none}}
"
    )
}

/// Returns the style rules that set the colours of a theme.
fn colours(theme: Theme) -> String {
    let Colours {
        floor, visited, wall, unknown, mistaken, start, goal, number, mouse, rim, ..
    } = theme.colours();
    let Colours { text, shortest_route, planned_route, .. } = theme.colours();
    let mut rules = String::new();
    for (what, style) in [
        ("floor", format!("fill:{floor}")),
        ("cell.visited", format!("fill:{visited}")),
        ("cell.start", format!("fill:{}", start.floor)),
        ("cell.start.visited", format!("fill:{}", start.visited)),
        ("cell.goal", format!("fill:{}", goal.floor)),
        ("cell.goal.visited", format!("fill:{}", goal.visited)),
        ("mark.start", format!("stroke:{}", start.frame)),
        ("mark.goal", format!("stroke:{}", goal.frame)),
        ("badge.start", format!("fill:{}", start.frame)),
        ("badge.goal", format!("fill:{}", goal.frame)),
        ("letter", format!("stroke:{floor}")),
        ("shortest-route", format!("stroke:{shortest_route}")),
        ("planned-route", format!("stroke:{planned_route}")),
        ("number", format!("stroke:{number}")),
        ("text", format!("stroke:{text}")),
        ("on-dark", "stroke:#fff".into()),
        ("on-light", "stroke:#000".into()),
        ("wall.true", format!("stroke:{unknown}")),
        ("wall.known", format!("stroke:{wall}")),
        ("wall.missed", format!("stroke:{mistaken}")),
        ("wall.mistaken", format!("stroke:{mistaken}")),
        ("posts", format!("fill:{wall};fill-opacity:.2")),
        ("mouse", format!("fill:{mouse};stroke:{rim}")),
    ] {
        let _ = writeln!(rules, ".maze .{what}{{{style}}}");
    }
    for age in 0..AGES {
        let trail = theme.colours().trail(age);
        let _ = writeln!(rules, ".maze .ink{age} stop{{stop-color:{trail}}}");
        let _ = writeln!(rules, ".no-labels .age{age},.small-cells .age{age}{{stroke:{trail}}}");
    }
    rules
}

/// Returns the stylesheet for a page that contains drawings
/// ([`Scene::page_svg`](crate::Scene::page_svg)). The stylesheet uses the dark theme for users who
/// prefer dark colours, and the light theme otherwise. It also has the colours of driven paths, for
/// scripts that draw them: the classes `speed0` (slowest) to `speed23` set the stroke, and the classes
/// `path0` to `path5` of several paths set the current colour.
///
/// ```
/// let css = mmsim_drawing::stylesheet();
/// assert!(css.contains("@media (prefers-color-scheme:dark){\n.maze .floor{"));
/// ```
pub fn stylesheet() -> String {
    let [light, dark] = [Theme::Light, Theme::Dark].map(|theme| colours(theme) + &paths(theme));
    format!(
        "{}{light}@media (prefers-color-scheme:dark){{\n{dark}}}\n",
        shapes(WallWidths::default())
    )
}

/// Returns the style rules that set the colours of driven paths.
fn paths(theme: Theme) -> String {
    let mut rules = String::new();
    for (level, colour) in data_colours::speed_ramp(theme).into_iter().enumerate() {
        let _ = writeln!(rules, ".maze .speed{level}{{stroke:{colour}}}");
    }
    for (index, colour) in data_colours::path_colours(theme).into_iter().enumerate() {
        let _ = writeln!(rules, ".path{index}{{color:{colour}}}");
    }
    rules
}

/// Returns the style rules of a standalone file with this theme. If `is_truth_alone` is true, all
/// walls are drawn like known walls, because the scene contains the true maze but no client's map.
pub(crate) fn file_style(theme: Theme, widths: WallWidths, is_truth_alone: bool) -> String {
    let (wall, known) = (theme.colours().wall, decimals(widths.known));
    let strong =
        format!(".maze .wall.true{{stroke:{wall};stroke-width:{known};stroke-linecap:square}}\n");
    let strong = if is_truth_alone { strong } else { String::new() };
    format!("{}{}{strong}", shapes(widths), colours(theme))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::style::colour::{contrast, differences};
    use crate::style::data_colours::heat_ramp;

    #[test]
    fn numbers_and_texts_are_legible_on_every_cell() {
        for theme in [Theme::Light, Theme::Dark] {
            let Colours { floor, visited, start, goal, number, text, .. } = theme.colours();
            let cells = [floor, visited, start.floor, start.visited, goal.floor, goal.visited];
            for cell in heat_ramp(theme).into_iter().chain(cells) {
                for label in [number, text] {
                    let contrast = contrast(label, cell);
                    assert!(contrast >= 4.5, "{theme:?}: {label} {contrast:.2} on {cell}");
                }
            }
        }
    }

    #[test]
    fn lines_and_marks_differ_for_colour_blind_users() {
        for theme in [Theme::Light, Theme::Dark] {
            let colours = theme.colours();
            let Colours { wall, unknown, mistaken, start, goal, .. } = colours;
            let (planned, shortest) = (colours.planned_route, colours.shortest_route);
            let trail = colours.trail(AGES - 1);
            for (what, one, other) in [
                ("planned path and shortest path", planned, shortest),
                ("planned path and trail", planned, trail),
                ("shortest path and trail", shortest, trail),
                ("mistaken wall and known wall", mistaken, wall),
                ("mistaken wall and unknown wall", mistaken, unknown),
                ("start and goal", start.frame, goal.frame),
                ("text and weight", colours.text, colours.number),
            ] {
                for (vision, difference) in differences(one, other) {
                    assert!(difference > 0.08, "{theme:?}, {vision}: {what} {difference:.3}");
                }
            }
        }
    }

    #[test]
    fn important_elements_have_contrast() {
        for theme in [Theme::Light, Theme::Dark] {
            let colours = theme.colours();
            let Colours { floor, visited, wall, unknown, mistaken, start, goal, mouse, .. } =
                colours;
            let Colours { planned_route, shortest_route, .. } = colours;
            // Heat colours and the colours of mice do not touch walls.
            let newest = colours.trail(AGES - 1);
            for (what, colour, behind) in [
                ("wall", wall, floor),
                ("wall of a visited cell", wall, visited),
                ("unknown wall", unknown, floor),
                ("unknown wall of a visited cell", unknown, visited),
                ("unknown wall of the start", unknown, start.floor),
                ("unknown wall of the visited start", unknown, start.visited),
                ("unknown wall of a goal cell", unknown, goal.floor),
                ("unknown wall of a visited goal cell", unknown, goal.visited),
                ("new trail", newest, floor),
                ("new trail in a visited cell", newest, visited),
                ("mistaken wall", mistaken, floor),
                ("S", start.frame, floor),
                ("G", goal.frame, floor),
                ("mouse", mouse, visited),
                ("shortest path", shortest_route, floor),
                ("planned path", planned_route, floor),
                ("planned path in a visited cell", planned_route, visited),
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
            let Colours { floor, visited, wall, unknown, start, goal, .. } = colours;
            for (what, one, other, least) in [
                ("visited cell", visited, floor, 1.4),
                ("visited start", start.visited, start.floor, 1.3),
                ("visited goal cell", goal.visited, goal.floor, 1.3),
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
        for theme in [Theme::Light, Theme::Dark] {
            assert!(css.contains(&format!(
                ".maze .speed23{{stroke:{}}}",
                data_colours::speed_ramp(theme)[23]
            )));
            assert!(
                css.contains(&format!(".path0{{color:{}}}", data_colours::path_colours(theme)[0]))
            );
        }
        assert_eq!(css.matches('{').count(), css.matches('}').count());
        assert!(
            !css.contains("var(")
                && !file_style(Theme::Dark, WallWidths::default(), false).contains('@')
        );
    }
}

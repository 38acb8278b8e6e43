//! Pictures of the mazes with the largest differences.

use maud::{Markup, PreEscaped, html};
use mmsim_drawing::{PATH_COLOURS, two_paths};

use super::MousePath;
use crate::comparison::{Comparison, Measure};
use crate::statistics::Values;
use crate::text::{NumberFormat, clean, shortened};

/// The maximum number of mazes in which the other candidate is better.
const MAX_LOSSES: usize = 6;
/// The maximum number of mazes in which the reference is better.
const MAX_WINS: usize = 3;
/// The number of candidates whose pictures are visible. The pictures of others are collapsed.
const OPEN_CANDIDATES: usize = 1;

/// A picture of a maze, and the values of the reference and of the other candidate.
struct Picture<'a> {
    maze: &'a str,
    values: [f64; 2],
    svg: String,
}

/// The pictures for one candidate.
struct Gallery<'a> {
    names: [&'a str; 2],
    losses: Vec<Picture<'a>>,
    wins: Vec<Picture<'a>>,
}

impl Comparison {
    /// Returns pictures of the mazes in which the reference differs most from each other candidate,
    /// or nothing if no paths are available.
    pub(super) fn pictures_section<'p>(
        &self,
        path: impl Fn(usize, usize) -> Option<MousePath<'p>>,
    ) -> Markup {
        let Some((measure, values)) = self.measures().first() else { return html! {} };
        let Some(reference) = values.reference() else { return html! {} };
        let others = (0..self.candidates().len()).filter(|&other| other != reference);
        let galleries = others.map(|other| self.gallery(values, [reference, other], &path));
        let galleries: Vec<Gallery<'_>> =
            galleries.filter(|one| !one.losses.is_empty() || !one.wins.is_empty()).collect();
        html! {
            @if !galleries.is_empty() {
                section class="pictures" {
                    h2 { "Mazes with the largest differences in " (clean(&measure.name)) }
                    p class="quiet" {
                        (clean(&self.pictures_caption))
                        " A ring marks the start of a path, and a disc marks its end."
                    }
                    @for (index, gallery) in galleries.iter().enumerate() {
                        @if index < OPEN_CANDIDATES {
                            h3 { (clean(gallery.names[1])) }
                            (gallery.draw(measure))
                        } @else {
                            details {
                                summary { (clean(gallery.names[1])) }
                                (gallery.draw(measure))
                            }
                        }
                    }
                }
            }
        }
    }

    fn gallery<'p>(
        &self,
        values: &Values,
        [reference, other]: [usize; 2],
        path: impl Fn(usize, usize) -> Option<MousePath<'p>>,
    ) -> Gallery<'_> {
        let picture = |maze: usize| {
            let paths = [path(reference, maze)?, path(other, maze)?];
            Some(Picture {
                maze: self.mazes().get(maze)?,
                values: [values.row(reference)[maze]?, values.row(other)[maze]?],
                svg: two_paths(paths[0].maze, [&paths[0].points, &paths[1].points]),
            })
        };
        let mut differences = values.differences(other, reference);
        differences.sort_by(|(_, one), (_, other)| one.total_cmp(other));
        let losses = differences.iter().take_while(|(_, difference)| *difference < 0.0);
        let wins = differences.iter().rev().take_while(|(_, difference)| *difference > 0.0);
        Gallery {
            names: [reference, other].map(|index| &*self.candidates()[index]),
            losses: losses.filter_map(|&(maze, _)| picture(maze)).take(MAX_LOSSES).collect(),
            wins: wins.filter_map(|&(maze, _)| picture(maze)).take(MAX_WINS).collect(),
        }
    }
}

impl Gallery<'_> {
    fn draw(&self, measure: &Measure) -> Markup {
        let [reference, other] = self.names.map(|name| shortened(name, 40));
        html! {
            p class="legend" {
                @for ((name, colour), class) in
                    [&reference, &other].into_iter().zip(PATH_COLOURS).zip(["swatch", "swatch second"]) {
                    span { span class=(class) style={ "border-color:" (colour) } {} (name) }
                    " "
                }
            }
            @for (winner, pictures) in [(&other, &self.losses), (&reference, &self.wins)] {
                @if !pictures.is_empty() {
                    p { "Largest differences in mazes in which " (winner) " is better:" }
                    div class="mazes" {
                        @for picture in pictures { (picture.draw(measure, [&reference, &other])) }
                    }
                }
            }
        }
    }
}

impl Picture<'_> {
    fn draw(&self, measure: &Measure, [reference, other]: [&str; 2]) -> Markup {
        let format = NumberFormat::for_values(self.values);
        let [one, two] = self.values.map(|number| format.plain(number).replace('-', "−"));
        html! {
            figure {
                (PreEscaped(&self.svg))
                figcaption {
                    (clean(self.maze)) ", " (clean(&measure.heading())) ": "
                    (reference) " " (one) ", " (other) " " (two)
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Maze};

    use super::*;

    fn maze() -> Maze {
        "o---o---o\n|     G |\no   o---o\n| S     |\no---o---o\n".parse().unwrap()
    }

    /// Returns a comparison of candidates whose values are `steps` for each candidate and maze.
    fn comparison(candidates: usize, mazes: usize, steps: fn(usize, usize) -> f64) -> Comparison {
        let names = ["mine", "flood-fill", "left-wall"].map(Into::into)[..candidates].to_vec();
        let mazes = (0..mazes).map(|maze| format!("maze {maze}")).collect();
        let measure = Measure::new("steps", "steps to the goal", "steps");
        Comparison::new("", names, mazes).with_measure(measure, |one, maze| Some(steps(one, maze)))
    }

    fn captions(page: &str) -> Vec<&str> {
        let captions = page.split("<figcaption>").skip(1);
        captions.filter_map(|rest| rest.split("</figcaption>").next()).collect()
    }

    fn path(maze: &Maze) -> MousePath<'_> {
        MousePath::through_cells(maze, &[Cell::new(0, 0), Cell::new(0, 1)])
    }

    #[test]
    fn the_largest_losses_and_wins_are_drawn() {
        let maze = maze();
        // The candidate differs by −10, −9, …, +9.
        let steps = |one, maze| [100.0, 90.0 + crate::charts::count(maze)][one];
        let page =
            comparison(2, 20, steps).pictures_section(|_, _| Some(path(&maze))).into_string();
        let losses = (0..6).map(|maze| {
            format!("maze {maze}, steps to the goal: mine 100, flood-fill {}", 90 + maze)
        });
        let wins = (17..20).rev().map(|maze| {
            format!("maze {maze}, steps to the goal: mine 100, flood-fill {}", 90 + maze)
        });
        assert_eq!(captions(&page), losses.chain(wins).collect::<Vec<_>>());
        assert_eq!(page.matches("<svg").count(), 9);
    }

    #[test]
    fn pictures_without_a_path_or_a_difference_are_omitted() {
        let maze = maze();
        let steps = |one, maze| crate::charts::count(if one == 1 { maze % 3 } else { 1 });
        let comparison = comparison(3, 6, steps);
        let page = comparison.pictures_section(|_, index| (index > 2).then(|| path(&maze)));
        let page = page.into_string();
        let expected = [
            "maze 3, steps to the goal: mine 1, flood-fill 0",
            "maze 5, steps to the goal: mine 1, flood-fill 2",
        ];
        assert_eq!(captions(&page), expected);
        assert!(!page.contains("left-wall"), "equal in all mazes");
        assert_eq!(comparison.pictures_section(|_, _| None).into_string(), "");
    }
}

//! The numbers and texts in the cells of a drawing.

use mmsim_maze::{Cell, MazeSize};

use super::Svg;
use crate::shapes::{cell_area, centre, corner};
use crate::style::data_colours::label_class;
use crate::text::{Label, cell_text, decimals};

impl Svg<'_> {
    pub(super) fn numbers(&mut self) {
        if !self.has(|layers| layers.numbers) {
            return;
        }
        let size = self.scene.size;
        self.put("<g class=\"numbers\">\n");
        for (cell, label) in self.scene.labels() {
            let label = label.filter(|_| self.scene.text(cell).is_none());
            let (class, position) =
                (self.label_class(cell), position(size, cell, label.map_or(1.0, Label::scale)));
            let path = label.map(Label::path).unwrap_or_default();
            self.put_part(cell_area(corner(size, cell)), label.is_some(), format_args!(
                "<path class=\"number{class}\" data-cell=\"{},{}\" transform=\"{position}\" d=\"{path}\"/>\n",
                cell.x, cell.y
            ));
        }
        self.put("</g>\n");
    }

    pub(super) fn texts(&mut self) {
        let size = self.scene.size;
        self.put("<g class=\"texts\">\n");
        for cell in size.cells() {
            let Some(text) = self.scene.text(cell) else { continue };
            let ((path, scale), class) = (cell_text(text), self.label_class(cell));
            let position = position(size, cell, scale);
            self.put_part(cell_area(corner(size, cell)), true, format_args!(
                "<path class=\"text{class}\" data-cell=\"{},{}\" data-text=\"{}\" transform=\"{position}\" d=\"{path}\"/>\n",
                cell.x, cell.y, escape(text)
            ));
        }
        self.put("</g>\n");
    }

    /// Returns the class of the label of a cell, preceded by a space.
    fn label_class(&self, cell: Cell) -> String {
        let colour = self.scene.colour(cell);
        colour.map(|colour| format!(" {}", label_class(colour))).unwrap_or_default()
    }
}

/// Returns the transformation of a label in this cell.
fn position(size: MazeSize, cell: Cell, scale: f64) -> String {
    let ((x, y), scale) = (centre(size, cell), decimals(scale));
    let scale = if scale == "1" { String::new() } else { format!(" scale({scale})") };
    format!("translate({x} {y}){scale}")
}

/// Escapes a text for an attribute of an XML document. Control characters, U+FFFE and U+FFFF are
/// removed, because XML documents cannot contain them.
fn escape(text: &str) -> String {
    let is_allowed = |c: &char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    let text: String = text.chars().filter(is_allowed).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Colour;

    use super::*;
    use crate::scene::{Layers, Scene};
    use crate::style::colour::Theme;
    use crate::style::data_colours::heat_ramp;
    use crate::svg::tests::maze;
    use crate::text::{INFINITY, digits};

    #[test]
    fn all_zero_weights_are_hidden() {
        let maze = maze();
        assert_eq!(
            Scene::from_maze(&maze).with_weights(|_| 0).page_svg(),
            Scene::from_maze(&maze).page_svg()
        );
        let svg = Scene::from_maze(&maze).with_weights(|cell| cell.x).page_svg();
        assert_eq!((svg.matches(r#"fill="none""#).count(), numbers(&svg).len()), (0, 4));
    }

    /// Returns the paths of the numbers in a drawing.
    fn numbers(svg: &str) -> Vec<&str> {
        let lines = svg.lines().filter(|line| line.starts_with(r#"<path class="number"#));
        let paths = lines.map(|line| line.rsplit('"').nth(1).unwrap());
        paths.filter(|path| !path.is_empty()).collect()
    }

    #[test]
    fn the_weight_255_is_infinite_and_has_no_heat_colour() {
        let maze = maze();
        let weight = |cell: Cell| if cell == Cell::new(1, 1) { 255 } else { cell.x + cell.y };
        let svg = Scene::from_maze(&maze).with_weights(weight).page_svg();
        assert_eq!(numbers(&svg), [&digits(0), &digits(1), &digits(1), INFINITY]);
        assert!(svg.contains(r#"data-cell="1,1" x="22" y="2" width="16" height="16" fill="none""#));
        assert_eq!(svg.matches(r#"fill="none""#).count(), 1);
        let warmest = heat_ramp(Theme::Light)[63].to_string();
        assert_eq!(svg.matches(&warmest).count(), 2, "1 is the largest weight");
        let numbered = Scene::from_maze(&maze).with_numbers(|_| Some(255)).page_svg();
        assert_eq!(numbers(&numbered), [&digits(255)[..]; 4]);
    }

    #[test]
    fn texts_replace_numbers_and_follow_the_colour_of_the_cell() {
        let maze = maze();
        let text = |cell: Cell| ["1200", "", "<\"é&\"> 12", ""][usize::from(2 * cell.y + cell.x)];
        let colour = |cell: Cell| {
            [Some(Colour::White), Some(Colour::DarkBlue), None, Some(Colour::Yellow)]
                [usize::from(2 * cell.y + cell.x)]
        };
        let scene = Scene::from_maze(&maze).with_weights(|_| 7);
        let svg = scene.with_texts(text).with_colours(colour).svg();
        let lines = |start: &str| -> Vec<&str> {
            svg.lines().filter(|line| line.starts_with(start)).collect()
        };
        let (first, first_scale) = cell_text("1200");
        assert_eq!(
            lines("<path class=\"text"),
            [
                format!(
                    r#"<path class="text on-light" data-cell="0,0" data-text="1200" transform="translate(10 30) scale({first_scale})" d="{first}"/>"#
                ),
                format!(
                    r#"<path class="text" data-cell="0,1" data-text="&lt;&quot;é&amp;&quot;> 12" transform="translate(10 10) scale(0.6)" d="{}"/>"#,
                    cell_text("<\"é&\"> 12").0
                ),
            ]
        );
        assert_eq!(numbers(&svg), [digits(7), digits(7)]);
        let classes = ["number on-light", "number on-dark", "number", "number on-light"];
        for (line, class) in lines("<path class=\"number").into_iter().zip(classes) {
            assert!(line.contains(&format!("class=\"{class}\"")), "{line}");
        }
        let colours: Vec<_> = lines("<rect class=\"colour\"")
            .into_iter()
            .map(|line| (line.split('"').nth(3).unwrap(), line.rsplit('"').nth(1).unwrap()))
            .collect();
        assert_eq!(colours, [("0,0", "#ffffff"), ("1,0", "#000033"), ("1,1", "#b3b300")]);
    }

    #[test]
    fn weight_0_is_hidden_if_other_cells_have_texts() {
        let maze = maze();
        let text = |cell: Cell| ["0", "12"].get(usize::from(cell.x + 2 * cell.y)).copied();
        let scene = Scene::from_maze(&maze)
            .with_weights(|cell| if cell == Cell::new(1, 0) { 12 } else { 0 })
            .with_texts(|cell| text(cell).unwrap_or_default());
        let svg = scene.page_svg();
        assert_eq!(numbers(&svg), [""; 0], "a number in a cell without a text");
        assert_eq!(svg.matches(r#"fill="none""#).count(), 2, "heat colours of cells without texts");
        let without_texts = scene.with_layers(Layers { texts: false, ..Layers::ALL }).page_svg();
        assert_eq!(numbers(&without_texts), [0, 12, 0, 0].map(digits));
        assert!(!without_texts.contains("data-text"));
    }

    #[test]
    fn characters_that_xml_forbids_are_removed() {
        let text = "a\u{1}\u{7f}\u{85}\u{fffd}\u{fffe}\u{ffff}b";
        let maze = maze();
        let scene = Scene::from_maze(&maze).with_texts(|_| text);
        assert!(scene.svg().contains("data-text=\"a\u{fffd}b\""));
        assert!(scene.png(200).is_ok());
    }

    #[test]
    fn long_numbers_are_scaled_to_fit() {
        let maze = maze();
        let svg = Scene::from_maze(&maze).with_numbers(|_| Some(1023)).page_svg();
        assert_eq!(svg.matches(") scale(0.75)\"").count(), 4);
    }
}

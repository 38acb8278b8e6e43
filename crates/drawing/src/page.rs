//! JSON tables that a web page uses to draw numbers and heat colours.

use mmsim_maze::Colour;

use crate::shapes::{AGES, MIN_FADE, PASSAGE_ARROWS, PASSAGE_LINES};
use crate::style::colour::Theme;
use crate::style::data_colours::{INSET, cell_colour, heat_ramp, is_light};
use crate::style::{KNOWN_WIDTH, UNKNOWN_WIDTH};
use crate::text::{
    ADVANCE, FULL_CHARS, GLYPHS, INFINITY, LINE_CHARS, LINE_OFFSET, MISSING, decimals,
};

/// Returns JSON with the tables that a web page needs to draw the same numbers and heat colours as
/// this crate:
///
/// ```json
/// {"advance": 5, "glyphs": ["", "m…", … 95], "missing": "m…", "infinity": "M…",
///  "text": {"line": 5, "full": 3, "offset": 5.5},
///  "inset": 2, "colours": {"k": "#rrggbb", … 15}, "light_colours": "gwy…",
///  "walls": {"known": [2, 3, 4.5], "unknown": [1.2, 2, 3]},
///  "trail": {"ages": 6, "min_fade": 48, "lines": ["v-20", … 4], "arrows": ["m…", … 4]},
///  "heat": {"light": ["#rrggbb", … 64], "dark": […]}}
/// ```
///
/// The path of a line of text is the concatenation of the paths of its characters, each preceded by
/// `M{x} {y}`. The glyphs are those of the characters from the space to `~`; `missing` is the glyph
/// of other characters. For character i of n, counted from 0, x is (i − n/2) · advance, rounded to
/// two decimals, and y is 0 (see [`digits`](crate::digits)). A text of more than 5 characters is
/// split into two lines: the first 5 characters at y = −5.5 and the rest at y = 5.5. A line of n
/// characters is scaled by 3 / max(n, 3). These constants are the properties `line`, `offset` and
/// `full` of `text`. A coloured area is `inset` units smaller than its cell on each side. A label is
/// black in a cell with one of the `light_colours`, and white in a cell with another colour. The
/// index of the colour for a weight w is round(63 · w / max(1, the largest weight)). The weight 255
/// is drawn as the path `infinity`, has no heat colour and does not count as the largest weight.
///
/// The limits of the width of a wall are the minimum in units, the minimum in pixels, and the
/// maximum in units, which takes precedence.
///
/// A trail is a list of n passages from a cell to a neighbouring cell, oldest first. The age of
/// passage i, counted from 0, is `ages` − 1 − ⌊(n − 1 − i) · `ages` / max(n, `min_fade`)⌋. The path
/// of a passage starts at the centre of a cell and continues with the line of its heading (north,
/// east, south or west). If x and y of that cell are both even or both odd, an arrowhead follows.
///
/// ```
/// assert!(mmsim_drawing::page_json().starts_with(r#"{"advance":5,"glyphs":["","m2.5-3.4v4.4"#));
/// ```
pub fn page_json() -> String {
    let heat = |theme| list(heat_ramp(theme).into_iter().map(|colour| colour.to_string()));
    let light = Colour::ALL.into_iter().filter(|&colour| is_light(cell_colour(colour)));
    let light: String = light.map(Colour::letter).collect();
    let by_letter = |value: &dyn Fn(Colour) -> String| {
        Colour::ALL.map(|colour| format!("\"{}\":\"{}\"", colour.letter(), value(colour))).join(",")
    };
    let colours = by_letter(&|colour| cell_colour(colour).to_string());
    let names = by_letter(&|colour| colour.name().to_string());
    format!(
        r#"{{"advance":{},"glyphs":{},"missing":"{MISSING}","infinity":"{INFINITY}","text":{{"line":{LINE_CHARS},"full":{FULL_CHARS},"offset":{LINE_OFFSET}}},"inset":{INSET},"colours":{{{colours}}},"colour_names":{{{names}}},"light_colours":"{light}","walls":{{"known":{KNOWN_WIDTH:?},"unknown":{UNKNOWN_WIDTH:?}}},"trail":{{"ages":{AGES},"min_fade":{MIN_FADE},"lines":{},"arrows":{}}},"heat":{{"light":{},"dark":{}}}}}"#,
        decimals(ADVANCE),
        list(GLYPHS.map(String::from).into_iter()),
        list(PASSAGE_LINES.map(String::from).into_iter()),
        list(PASSAGE_ARROWS.map(String::from).into_iter()),
        heat(Theme::Light),
        heat(Theme::Dark),
    )
}

/// Formats strings as a JSON array. The strings must not contain characters that need escaping in
/// JSON.
fn list(texts: impl Iterator<Item = String>) -> String {
    format!("[{}]", texts.map(|text| format!("\"{text}\"")).collect::<Vec<_>>().join(","))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_match_the_drawing() {
        let json: serde_json::Value = serde_json::from_str(&page_json()).unwrap();
        let advance = json["advance"].as_f64().unwrap();
        let written: String = [(0, '2'), (1, '5'), (2, '5')]
            .map(|(index, digit): (u8, char)| {
                let glyph = digit as usize - ' ' as usize;
                let x = (f64::from(index) - 1.5) * advance;
                format!("M{x} 0{}", json["glyphs"][glyph].as_str().unwrap())
            })
            .concat();
        assert_eq!(written, crate::digits(255));
        let text = serde_json::json!({ "line": 5, "full": 3, "offset": 5.5 });
        assert_eq!(json["walls"]["known"], serde_json::json!(KNOWN_WIDTH));
        assert_eq!(json["walls"]["unknown"], serde_json::json!(UNKNOWN_WIDTH));
        assert_eq!((&json["text"], &json["inset"]), (&text, &serde_json::json!(2)));
        for colour in Colour::ALL {
            let letter = colour.letter().to_string();
            assert_eq!(json["colours"][&letter], cell_colour(colour).to_string());
            assert_eq!(json["colour_names"][&letter], colour.name());
        }
        for (name, theme) in [("light", Theme::Light), ("dark", Theme::Dark)] {
            let read: Vec<_> = json["heat"][name]
                .as_array()
                .unwrap()
                .iter()
                .map(|colour| colour.as_str().unwrap().to_string())
                .collect();
            let drawn: Vec<_> = heat_ramp(theme).iter().map(ToString::to_string).collect();
            assert_eq!(read, drawn);
        }
    }
}

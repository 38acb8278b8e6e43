//! The colours that a mouse gives to cells. They are those of the simulator mms, in both themes.

use crate::style::colour::{Rgb, luminance};

/// The distance from a coloured area to the edges of its cell, in units. The floor between the area
/// and the walls keeps the walls visible beside any colour.
pub(crate) const INSET: u32 = 2;

/// The colours, each with its letter.
pub(crate) const COLOURS: [(char, Rgb); 15] = [
    ('k', Rgb(0, 0, 0)),
    ('b', Rgb(0, 0, 179)),
    ('a', Rgb(179, 179, 179)),
    ('c', Rgb(0, 102, 102)),
    ('g', Rgb(0, 179, 0)),
    ('o', Rgb(179, 102, 0)),
    ('r', Rgb(204, 0, 0)),
    ('w', Rgb(255, 255, 255)),
    ('y', Rgb(179, 179, 0)),
    ('B', Rgb(0, 0, 51)),
    ('C', Rgb(0, 51, 51)),
    ('A', Rgb(26, 26, 26)),
    ('G', Rgb(0, 77, 0)),
    ('R', Rgb(77, 0, 0)),
    ('Y', Rgb(51, 51, 0)),
];

/// Returns the colour with this letter.
pub(crate) fn colour(letter: char) -> Option<Rgb> {
    COLOURS.into_iter().find(|&(known, _)| known == letter).map(|(_, colour)| colour)
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
    use crate::style::colour::tests::contrast;

    #[test]
    fn labels_are_legible_on_every_colour() {
        for (letter, colour) in COLOURS {
            let label = if is_light(colour) { Rgb(0, 0, 0) } else { Rgb(255, 255, 255) };
            let contrast = contrast(label, colour);
            assert!(contrast >= 4.5, "{letter}: {contrast:.2}");
        }
    }

    #[test]
    fn colours_and_letters_are_distinct() {
        let letters: String = COLOURS.iter().map(|(letter, _)| letter).collect();
        assert_eq!(letters, "kbacgorwyBCAGRY");
        assert_eq!(COLOURS.iter().map(|(_, colour)| colour).collect::<BTreeSet<_>>().len(), 15);
        assert_eq!((colour('w'), colour('x')), (Some(Rgb(255, 255, 255)), None));
    }
}

//! Untrusted text, such as names of candidates and mazes.

use mmsim_maze::Escaped;

/// Replaces characters that would control a terminal or that XML cannot represent.
pub(crate) fn clean(text: &str) -> String {
    Escaped(text).to_string().replace(['\u{fffe}', '\u{ffff}'], "\u{fffd}")
}

/// [Cleans](clean) a text and shortens it to at most `max` characters.
pub(crate) fn shortened(text: &str, max: usize) -> String {
    let text = clean(text);
    match text.char_indices().nth(max) {
        None => text,
        Some(_) => text.chars().take(max - 1).chain(['…']).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_end_with_an_ellipsis() {
        assert_eq!(shortened("b\n\u{ffff}", 24), "b\\n\u{fffd}");
        assert_eq!(shortened("four", 4), "four");
        assert_eq!(shortened("fünfzehn", 4), "fün…");
    }
}

//! Untrusted text, such as names of candidates and mazes.

use mmsim_maze::Escaped;
use unicode_truncate::UnicodeTruncateStr as _;
use unicode_width::UnicodeWidthStr as _;

/// Replaces characters that would control a terminal or that XML cannot represent.
pub(crate) fn clean(text: &str) -> String {
    Escaped(text).to_string().replace(['\u{fffe}', '\u{ffff}'], "\u{fffd}")
}

/// [Cleans](clean) a text and shortens it to at most `max` columns. A wide character, such as `決`,
/// occupies two columns.
pub(crate) fn shortened(text: &str, max: usize) -> String {
    let text = clean(text);
    if text.width() <= max { text } else { text.unicode_truncate(max - 1).0.to_owned() + "…" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_end_with_an_ellipsis() {
        assert_eq!(shortened("b\n\u{ffff}", 24), "b\\n\u{fffd}");
        assert_eq!(shortened("four", 4), "four");
        assert_eq!(shortened("fünfzehn", 4), "fün…");
        assert_eq!(shortened("全日本決勝", 10), "全日本決勝");
        assert_eq!(shortened("全日本決勝", 9), "全日本決…");
        assert_eq!(shortened("全日本決勝", 8), "全日本…", "half of a character does not fit");
        let (accents, family) = ("e\u{301}".repeat(4), "👩\u{200d}👩\u{200d}👧");
        assert_eq!(shortened(&accents, 4), accents);
        assert_eq!(shortened(&accents, 3), "e\u{301}e\u{301}…");
        assert_eq!(shortened(&format!("a{family}{family}"), 4), format!("a{family}…"));
    }
}

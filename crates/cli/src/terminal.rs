//! What a terminal can display.

use anstream::stream::RawStream;
use anstream::{AutoStream, ColorChoice};

/// Returns true if messages on this stream have colours. Follows `NO_COLOR`, `CLICOLOR`,
/// `CLICOLOR_FORCE` and `TERM`, as the messages about arguments do.
pub(crate) fn has_colours(stream: &impl RawStream) -> bool {
    AutoStream::choice(stream) != ColorChoice::Never && interprets_escape_codes()
}

/// Returns true if this stream is a terminal on which a program can replace its output.
pub(crate) fn can_redraw(stream: &impl RawStream) -> bool {
    stream.is_terminal() && anstyle_query::term_supports_color() && interprets_escape_codes()
}

/// Consoles of Windows interpret escape codes only if a program asks for it.
fn interprets_escape_codes() -> bool {
    anstyle_query::windows::enable_ansi_colors() != Some(false)
}

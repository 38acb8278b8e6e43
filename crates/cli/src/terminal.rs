//! What a terminal can display, and progress bars on it.

use std::io;
use std::time::Duration;

use anstream::stream::RawStream;
use anstream::{AutoStream, ColorChoice};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};
use terminal_size::{Width, terminal_size_of};

use crate::output::is_quiet;

/// Returns true if messages on this stream have colours. Follows `NO_COLOR`, `CLICOLOR`,
/// `CLICOLOR_FORCE` and `TERM`, as the messages about arguments do.
pub(crate) fn has_colours(stream: &impl RawStream) -> bool {
    let is_shown = !stream.is_terminal() || interprets_escape_codes();
    AutoStream::choice(stream) != ColorChoice::Never && is_shown
}

/// Returns true if this stream is a terminal on which a program can replace its output.
pub(crate) fn can_redraw(stream: &impl RawStream) -> bool {
    stream.is_terminal() && anstyle_query::term_supports_color() && interprets_escape_codes()
}

/// Returns the number of columns of the terminal on stdout, or 80 without a terminal.
pub(crate) fn columns() -> usize {
    terminal_size_of(io::stdout()).map_or(80, |(Width(columns), _)| columns.into())
}

/// Consoles of Windows interpret escape codes only if a program asks for it.
fn interprets_escape_codes() -> bool {
    anstyle_query::windows::enable_ansi_colors() != Some(false)
}

/// The time between two updates of a bar on which nothing else happens.
const TICK: Duration = Duration::from_millis(100);

/// Shows a progress bar on stderr until it is dropped, if stderr is a terminal and `--quiet` is not
/// set. `text` is the template of the text beside the bar. Work of unknown length has only a text.
pub(crate) fn progress_bar(length: Option<u64>, text: &str) -> ProgressBar {
    let is_shown = can_redraw(&io::stderr()) && !is_quiet();
    let target = if is_shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = if length.is_some() { "{wide_bar} " } else { "" };
    let style = ProgressStyle::with_template(&format!("{bar}{text}"));
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("█░");
    let progress = ProgressBar::with_draw_target(length, target)
        .with_style(style)
        .with_finish(ProgressFinish::AndClear);
    if is_shown {
        progress.enable_steady_tick(TICK);
    }
    progress
}

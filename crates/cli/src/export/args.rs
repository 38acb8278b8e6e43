//! Arguments of `mmsim export`.

use std::path::PathBuf;

use clap::Args;
use mmsim_fastrun::Vehicle;

use crate::args::ReadingArgs;
use crate::vehicle::parse_vehicle;

#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// Recording file; if the file is truncated, the intact part is exported
    pub(crate) file: PathBuf,
    /// File to write: .html, or - for stdout. An existing file is replaced
    #[arg(short, long, value_name = "FILE", value_parser = parse_page)]
    pub(crate) output: PathBuf,
    /// Add the vehicle in FILE (TOML) to those whose fast runs the page plays; may be repeated
    #[arg(long, value_name = "FILE", value_parser = parse_vehicle)]
    pub(crate) vehicle: Vec<Vehicle>,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
}

fn parse_page(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match &extension[..] {
        "html" | "htm" => Ok(path),
        "" if text == "-" => Ok(path),
        "" => Err("expected a file ending in .html".into()),
        other => Err(format!("expected a file ending in .html, found .{other}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_html_files_are_written() {
        for path in ["a/b.HTML", "run.htm", "-"] {
            assert_eq!(parse_page(path), Ok(path.into()));
        }
        let error = "expected a file ending in .html, found .mcap".to_string();
        assert_eq!(parse_page("run.mcap"), Err(error));
        assert!(parse_page("html").is_err() && parse_page("").is_err());
    }
}

//! Arguments of `mmsim render`.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, TypedValueParser};
use mmsim_drawing::{Theme, WIDTH_PX};

use crate::args::{ReadingArgs, one_of};

#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    /// Recording, maze file, or words from the path of a maze
    #[arg(required = true, value_name = "MAZE|RECORDING")]
    pub(crate) source: Vec<String>,
    /// File to write: .svg or .png, or .gif to animate a recording. An existing file is replaced
    #[arg(short, long, value_name = "FILE", value_parser = parse_picture)]
    pub(crate) output: Picture,
    /// File or folder to search for the maze [default: ~/.mmsim if it has mazes, else the
    /// bundled mazes]
    #[arg(long, value_name = "PATH")]
    pub(crate) mazes: Option<PathBuf>,
    /// Draw state N of a recording; a .gif ends with state N [default: the last state]
    #[arg(long, value_name = "N")]
    pub(crate) at: Option<usize>,
    /// Label each cell of a maze with its distance to the goal in steps
    #[arg(long)]
    pub(crate) distances: bool,
    /// Colour the cells: in a maze by the distance to the goal, in a recording by the mouse's
    /// weights
    #[arg(long)]
    pub(crate) heat: bool,
    /// Omit the mouse's weights in a recording
    #[arg(long)]
    pub(crate) no_numbers: bool,
    /// Omit the mouse's trail in a recording
    #[arg(long)]
    pub(crate) no_trail: bool,
    /// Omit the texts that the mouse displays in a recording
    #[arg(long)]
    pub(crate) no_texts: bool,
    /// Omit the colours that the mouse displays in a recording
    #[arg(long)]
    pub(crate) no_colours: bool,
    /// Colour theme
    #[arg(long, default_value = "light", value_parser = themes())]
    pub(crate) theme: Theme,
    /// Width of a .png or .gif in pixels [default: chosen so that the longer side is 640 pixels]
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(width_range()))]
    pub(crate) width: Option<u32>,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
}

/// The path and the format of the picture to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Picture {
    pub(crate) path: PathBuf,
    pub(crate) format: PictureFormat,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureFormat {
    Svg,
    Png,
    Gif,
}

pub(crate) fn themes() -> impl TypedValueParser<Value = Theme> {
    one_of([Theme::Light, Theme::Dark], |theme| match theme {
        Theme::Light => PossibleValue::new("light").help("Dark on light"),
        Theme::Dark => PossibleValue::new("dark").help("Light on dark"),
    })
}

pub(crate) fn width_range() -> RangeInclusive<i64> {
    i64::from(*WIDTH_PX.start())..=i64::from(*WIDTH_PX.end())
}

pub(crate) fn parse_picture(text: &str) -> Result<Picture, String> {
    let path = PathBuf::from(text);
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let format = match &extension[..] {
        "svg" => PictureFormat::Svg,
        "png" => PictureFormat::Png,
        "gif" => PictureFormat::Gif,
        "" => return Err("expected a file ending in .svg, .png or .gif".into()),
        other => {
            return Err(format!("expected a file ending in .svg, .png or .gif, found .{other}"));
        }
    };
    Ok(Picture { path, format })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extension_selects_the_format() {
        let format = |text| parse_picture(text).map(|picture| picture.format);
        assert_eq!(format("a/b.SVG"), Ok(PictureFormat::Svg));
        assert_eq!(format(".x.png"), Ok(PictureFormat::Png));
        assert_eq!(format("run.gif"), Ok(PictureFormat::Gif));
        let error = "expected a file ending in .svg, .png or .gif, found .jpeg".to_string();
        assert_eq!(format("run.jpeg"), Err(error));
        assert!(format("svg").is_err() && format("").is_err());
    }
}

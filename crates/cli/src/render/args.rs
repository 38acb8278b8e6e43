//! The command line of `mmsim render`.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use mmsim_drawing::WIDTH_PX;

use crate::args::ReadingArgs;

#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    /// A recording, a maze file, or words of the path of a maze
    #[arg(required = true, value_name = "MAZE|RECORDING")]
    pub(crate) source: Vec<String>,
    /// The file to draw into, which is replaced if there is one: a .svg, a .png, or of a recording a
    /// .gif that shows the search
    #[arg(short, long, value_name = "FILE", value_parser = parse_picture)]
    pub(crate) output: Picture,
    /// Where to look for the maze [default: ~/.mmsim where that exists, else the bundled mazes]
    #[arg(long, value_name = "PATH")]
    pub(crate) mazes: Option<PathBuf>,
    /// Draw the state with this number of a recording; a .gif ends with it [default: the last one]
    #[arg(long, value_name = "N")]
    pub(crate) at: Option<usize>,
    /// Write the distance to the goal into each cell of a maze, in steps
    #[arg(long)]
    pub(crate) distances: bool,
    /// Colour the cells of a recording by the mouse's weights, those of a maze by distance
    #[arg(long)]
    pub(crate) heat: bool,
    /// Leave out the weights of a recording
    #[arg(long)]
    pub(crate) no_numbers: bool,
    /// Leave out the way that the mouse of a recording took
    #[arg(long)]
    pub(crate) no_trail: bool,
    /// The colours
    #[arg(long, default_value = "light")]
    pub(crate) theme: ThemeArg,
    /// How many pixels a .png or .gif is wide [default: 640 on its longer side]
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(width_range()))]
    pub(crate) width: Option<u32>,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
}

/// Where a picture goes, and what it shall be.
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

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum ThemeArg {
    /// Dark on light
    Light,
    /// Light on dark
    Dark,
}

fn width_range() -> RangeInclusive<i64> {
    i64::from(*WIDTH_PX.start())..=i64::from(*WIDTH_PX.end())
}

fn parse_picture(text: &str) -> Result<Picture, String> {
    let path = PathBuf::from(text);
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let format = match &extension[..] {
        "svg" => PictureFormat::Svg,
        "png" => PictureFormat::Png,
        "gif" => PictureFormat::Gif,
        "" => return Err("expected a file that ends in .svg, .png or .gif".into()),
        other => return Err(format!("expected .svg, .png or .gif at the end, found .{other}")),
    };
    Ok(Picture { path, format })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_says_what_a_picture_is() {
        let format = |text| parse_picture(text).map(|picture| picture.format);
        assert_eq!(format("a/b.SVG"), Ok(PictureFormat::Svg));
        assert_eq!(format(".x.png"), Ok(PictureFormat::Png));
        assert_eq!(format("run.gif"), Ok(PictureFormat::Gif));
        let error = "expected .svg, .png or .gif at the end, found .jpeg".to_string();
        assert_eq!(format("run.jpeg"), Err(error));
        assert!(format("svg").is_err() && format("").is_err());
    }
}

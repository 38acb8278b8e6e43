//! The pictures that commands write to files.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::builder::{PossibleValue, TypedValueParser};
use mmsim_drawing::{PictureError, Scene, Theme, WIDTH_PX};

use crate::args::{extension, one_of, wrong_extension};

/// The default length of the longer side of a picture, in pixels.
pub(crate) const SIDE_PX: u32 = 640;

/// The path and the format of the picture to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PictureFile {
    pub(crate) path: PathBuf,
    pub(crate) format: PictureFormat,
}

impl PictureFile {
    /// Returns an error if an SVG has a width.
    pub(crate) fn check_width(&self, width_px: Option<u32>) -> Result<(), String> {
        match width_px.filter(|_| self.format == PictureFormat::Svg) {
            Some(_) => Err("--width needs a .png or .gif file: an .svg fits any width".into()),
            None => Ok(()),
        }
    }
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

pub(crate) fn parse_picture(text: &str) -> Result<PictureFile, String> {
    let path = PathBuf::from(text);
    let format = match &extension(&path)[..] {
        "svg" => PictureFormat::Svg,
        "png" => PictureFormat::Png,
        "gif" => PictureFormat::Gif,
        other => return Err(wrong_extension(".svg, .png or .gif", other)),
    };
    Ok(PictureFile { path, format })
}

/// Draws a scene as SVG or, in any other format, as a still PNG. By default, the longer side of a PNG
/// has [`SIDE_PX`] pixels.
pub(crate) fn draw_still(
    scene: &Scene<'_>,
    format: PictureFormat,
    width_px: Option<u32>,
) -> Result<Vec<u8>, PictureError> {
    match format {
        PictureFormat::Svg => Ok(scene.svg().into_bytes()),
        PictureFormat::Png | PictureFormat::Gif => {
            scene.png(width_px.unwrap_or_else(|| scene.width_within(SIDE_PX)))
        }
    }
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

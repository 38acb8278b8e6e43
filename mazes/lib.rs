//! Nineteen micromouse mazes as text.
//!
//! Each maze is a constant, so a program contains only the mazes that it uses. Except for the mazes
//! of the two-run trial, `Maze` in `mmsim-maze` parses them without `std`:
//!
//! ```
//! let maze: mmsim_maze::Maze = mmsim_mazes::HARBOUR.parse()?;
//! assert_eq!(maze.size().to_string(), "16x16");
//! # Ok::<(), mmsim_maze::ParseMazeError>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]

/// Embeds files of this folder as constants, and lists them.
macro_rules! mazes {
    ($($name:ident = $file:literal,)+) => {
        $(
            #[doc = concat!("The content of `", $file, "`.\n\n```text\n", include_str!($file), "```")]
            pub const $name: &str = include_str!($file);
        )+

        /// The name and the content of each maze file, sorted by name.
        ///
        /// ```
        /// assert_eq!(mmsim_mazes::FILES[0], ("01-harbour.txt", mmsim_mazes::HARBOUR));
        /// ```
        pub const FILES: &[(&str, &str)] = &[$(($file, $name)),+];
    };
}

mazes! {
    HARBOUR = "01-harbour.txt",
    MARKET_TOWN = "02-market-town.txt",
    OLD_STAIRS = "03-old-stairs.txt",
    GALLERIES = "04-galleries.txt",
    HEDGEROW = "05-hedgerow.txt",
    MIRAGE = "06-mirage.txt",
    LIGHTHOUSE = "07-lighthouse.txt",
    WINDING_RIVER = "08-winding-river.txt",
    LEFT_BANK = "09-left-bank.txt",
    TWO_ROADS = "10-two-roads.txt",
    BACK_GATE = "11-back-gate.txt",
    OLD_QUARTER = "half-size-old-quarter.txt",
    LONG_MEADOW = "oblong-long-meadow.txt",
    FIRST_STEPS = "training-first-steps.txt",
    ORCHARD = "trial-12-orchard.txt",
    WRONG_TURN = "trial-12-wrong-turn.txt",
    TERRACES = "trial-14-terraces.txt",
    CITADEL = "trial-16-citadel.txt",
    CLOSED_GARDEN = "unreachable-closed-garden.txt",
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::fs;
    use std::vec::Vec;

    use super::FILES;

    #[test]
    fn all_maze_files_in_the_folder_are_listed() {
        let folder = fs::read_dir(env!("CARGO_MANIFEST_DIR")).unwrap();
        let paths = folder.map(|entry| entry.unwrap().path());
        let mut paths: Vec<_> =
            paths.filter(|path| path.extension() == Some("txt".as_ref())).collect();
        paths.sort_unstable();
        let names = paths.iter().map(|path| path.file_name().unwrap());
        assert!(names.eq(FILES.iter().map(|(name, _)| *name)));
    }
}

/// Compiles and runs the example in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;

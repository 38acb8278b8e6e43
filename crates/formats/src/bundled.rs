//! The bundled mazes, which are part of the library.

use crate::catalogue::Catalogue;

/// Embeds files from the `mazes` folder as `(file name, content)` pairs.
macro_rules! mazes {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../mazes/", $name)))),+]
    };
}

const MAZES: &[(&str, &str)] = mazes![
    "01-harbour.txt",
    "02-market-town.txt",
    "03-old-stairs.txt",
    "04-galleries.txt",
    "05-hedgerow.txt",
    "06-mirage.txt",
    "07-lighthouse.txt",
    "08-winding-river.txt",
    "09-left-bank.txt",
    "10-two-roads.txt",
    "11-back-gate.txt",
    "half-size-old-quarter.txt",
    "oblong-long-meadow.txt",
    "training-first-steps.txt",
    "trial-12-orchard.txt",
    "trial-12-wrong-turn.txt",
    "trial-14-terraces.txt",
    "trial-16-citadel.txt",
    "unreachable-closed-garden.txt",
];

/// Returns the names and contents of the files of the bundled mazes.
///
/// ```
/// let (name, content) = mmsim_formats::bundled_files()[0];
/// assert_eq!(name, "01-harbour.txt");
/// assert!(content.starts_with("o---o"));
/// ```
pub const fn bundled_files() -> &'static [(&'static str, &'static str)] {
    MAZES
}

impl Catalogue {
    /// Lists the bundled mazes.
    pub fn bundled() -> Self {
        Self::from_texts(MAZES)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn every_maze_in_the_folder_is_bundled() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("mazes");
        let files = Catalogue::from_path(&folder).unwrap();
        let names = |catalogue: &Catalogue| {
            catalogue.entries().iter().map(crate::Entry::name).collect::<Vec<_>>()
        };
        assert_eq!(names(&Catalogue::bundled()), names(&files));
    }
}

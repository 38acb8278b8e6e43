//! The labels in the cells.

use crate::digits::digits;

/// The weight that a client assigns to a cell without a path to the goal. A client also sends 255
/// for weights above 255, because a weight is sent as one byte.
pub(crate) const NO_PATH: u8 = u8::MAX;

/// The path of the sign ∞, centred on (0, 0).
pub(crate) const INFINITY: &str = "M0 0c1-1.5 1.8-2.1 2.8-2.1 1.1 0 2 .9 2 2.1s-.9 2.1-2 2.1c-1 0-1.8-.6-2.8-2.1s-1.8-2.1-2.8-2.1c-1.1 0-2 .9-2 2.1s.9 2.1 2 2.1c1 0 1.8-.6 2.8-2.1z";

/// Returns the SVG path of a weight: its [`digits`], or the sign ∞ for 255.
///
/// ```
/// assert_eq!(mmsim_drawing::weight(254), mmsim_drawing::digits(254));
/// assert!(mmsim_drawing::weight(255).starts_with("M0 0c"));
/// ```
pub fn weight(weight: u8) -> String {
    Label::from_weight(weight).path()
}

/// The label in a cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Label {
    Number(u16),
    /// The sign ∞.
    NoPath,
}

impl Label {
    pub(crate) fn from_weight(weight: u8) -> Self {
        if weight == NO_PATH { Self::NoPath } else { Self::Number(weight.into()) }
    }

    /// Returns the number on which the heat colour depends.
    pub(crate) const fn number(&self) -> Option<u16> {
        match self {
            Self::Number(number) => Some(*number),
            Self::NoPath => None,
        }
    }

    /// Returns the path of the label, centred on (0, 0).
    pub(crate) fn path(&self) -> String {
        match self {
            Self::Number(number) => digits(*number),
            Self::NoPath => INFINITY.into(),
        }
    }

    /// Returns the factor by which the path is scaled to fit into a cell.
    pub(crate) const fn scale(&self) -> f64 {
        match self {
            Self::Number(1000..) => 0.75,
            _ => 1.0,
        }
    }
}

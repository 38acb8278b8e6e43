//! Errors in the text of a vehicle, with the lines at fault.

use alloc::boxed::Box;
use alloc::format;
use alloc::string::{String, ToString as _};

use toml::de::{DeTable, DeValue};

use super::MAX_NAME;
use crate::vehicle::{Vehicle, VehicleError};

/// The error for a text that does not describe a possible vehicle.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}{fault}", line.map_or(String::new(), |line| format!("line {line}: ")))]
pub struct VehicleFileError {
    /// The number of the line, beginning with 1, or `None` if the fault is in no particular line.
    pub line: Option<usize>,
    /// What is wrong.
    pub fault: VehicleFileFault,
}

/// A fault in a text that should describe a vehicle.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VehicleFileFault {
    /// The text is not TOML, or has a key or a value of an unexpected kind.
    #[error("{0}")]
    Toml(String),
    /// The name is empty or too long.
    #[error("name: expected 1 to {MAX_NAME} characters, found {}", match found {
        0 => "only spaces".into(),
        _ => found.to_string(),
    })]
    Name {
        /// The number of characters, without spaces at both ends.
        found: usize,
    },
    /// No preset has the name of the base.
    #[error("base: expected one of {}, found {found:?}", Vehicle::PRESETS.join(", "))]
    UnknownBase {
        /// The name.
        found: String,
    },
    /// A parameter has no value.
    #[error("{key} is missing ({})", match base {
        Some(base) => format!("set it; base {base:?} has no value for it"),
        None => format!("set it, or set base to one of {}", Vehicle::PRESETS.join(", ")),
    })]
    Missing {
        /// The parameter, such as `along.top_speed`.
        key: String,
        /// The base, which has no value for the parameter.
        base: Option<String>,
    },
    /// The mouse is impossible.
    #[error("{0}")]
    Vehicle(VehicleError),
    /// The mouse is impossible, because of a value of its base.
    #[error("{error}; {key} is the value of base {base:?}")]
    Inherited {
        /// What is impossible.
        error: Box<VehicleError>,
        /// The parameter with the value of the base, such as `turns.l90.length`.
        key: String,
        /// The name of the base.
        base: String,
    },
}

impl VehicleFileFault {
    /// Adds the number of the line with the key at fault. If the key is missing, adds the line of
    /// the key with which the value of the base is in conflict, or else the line of the table.
    pub(super) fn in_text(self, text: &str, base: Option<String>) -> VehicleFileError {
        let key = match &self {
            Self::Toml(_) => return VehicleFileError { line: None, fault: self },
            Self::Name { .. } => "name".into(),
            Self::UnknownBase { .. } => "base".into(),
            Self::Missing { key, .. } => key.into(),
            Self::Vehicle(error) => error.key(),
            Self::Inherited { error, .. } => error.key(),
        };
        let (line, is_given) = find(text, &key);
        if let Self::Missing { key, .. } = self {
            return VehicleFileError { line, fault: Self::Missing { key, base } };
        }
        let (Self::Vehicle(error), Some(base)) = (&self, base) else {
            return VehicleFileError { line, fault: self };
        };
        let other = error.other_key();
        let given = |key: &str| Some(find(text, key)).filter(|(_, is_given)| *is_given);
        let (line, inherited) = match (is_given, &other) {
            (true, Some(other)) if given(other).is_none() => (line, Some(other.clone())),
            (true, _) => (line, None),
            (false, _) => {
                let mut others = other.as_deref().into_iter().chain(OTHER_KEYS);
                (others.find_map(given).map_or(line, |(line, _)| line), Some(key))
            }
        };
        let fault = match inherited {
            Some(key) if self.is_conflict() => {
                Self::Inherited { error: Box::new(error.clone()), key: key.into(), base }
            }
            _ => self,
        };
        VehicleFileError { line, fault }
    }

    /// Returns true if a value is impossible only together with another one.
    const fn is_conflict(&self) -> bool {
        !matches!(self, Self::Vehicle(VehicleError::NoSmallTurn | VehicleError::NoDiagonal { .. }))
    }
}

/// Keys with which a value of the base can be in conflict.
const OTHER_KEYS: [&str; 3] = ["cell", "start_offset", "stop_offset"];

/// Returns the number of the line with a key, and true. If there is no such key, returns the line of
/// its table, if there is one, and false. An acceleration also sets a braking.
fn find(text: &str, key: &str) -> (Option<usize>, bool) {
    let Ok(root) = DeTable::parse(text) else { return (None, false) };
    let (mut table, mut line) = (Some(root.get_ref()), None);
    for part in key.split('.') {
        let value = |part| table.and_then(|table| table.get_key_value(part));
        let value = value(part).or_else(|| value("acceleration").filter(|_| part == "braking"));
        let Some((name, value)) = value else { return (line, false) };
        line = Some(line_number(text, name.span().start));
        table = DeValue::as_table(value.get_ref());
    }
    (line, true)
}

/// Replaces the types of Rust in a message of the TOML parser by those of TOML.
pub(super) fn in_terms_of_toml(message: &str) -> String {
    const VALUE: &str = "expected a number, false, or a text in quotes";
    const TERMS: [(&str, &str); 7] = [
        ("\n", ", "),
        ("expected f64", "expected a number"),
        (" as i128", ""),
        ("type: sequence", "type: array"),
        ("expected a map", "expected a table"),
        ("invalid boolean, expected `false`", VALUE),
        ("string values must be quoted, expected literal string", VALUE),
    ];
    let replace = |text: String, (rust, toml)| text.replace(rust, toml);
    TERMS.into_iter().fold(message.into(), replace)
}

pub(super) fn line_number(text: &str, at: usize) -> usize {
    text.get(..at).unwrap_or(text).matches('\n').count() + 1
}

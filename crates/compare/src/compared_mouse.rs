//! The mice to compare.

use std::ffi::OsString;
use std::str::FromStr;

use mmsim_maze::needs_escape;
use mmsim_mouse::Program;
use mmsim_protocol::MAX_NAME_BYTES;
use mmsim_solvers::BundledStrategy;

/// What a mouse of the user looks like as text.
const EXPECTED: &str = "expected NAME=COMMAND such as \"mine=python3 mouse.py\"";

/// A bundled strategy or a mouse of the user.
#[derive(Clone, Debug)]
pub enum ComparedMouse {
    /// A bundled strategy.
    Bundled(BundledStrategy),
    /// A mouse of the user.
    Own(NamedMouse),
}

/// A mouse that runs in another process.
#[derive(Clone, Debug)]
pub struct NamedMouse {
    /// The name.
    pub name: String,
    /// The command line as the user has written it.
    pub command: String,
    /// The program.
    pub program: Program,
}

impl ComparedMouse {
    /// Returns the name of the strategy, or the name that the user has given.
    pub fn name(&self) -> &str {
        match self {
            Self::Bundled(strategy) => strategy.name(),
            Self::Own(mouse) => &mouse.name,
        }
    }

    /// Returns true for a mouse of the user.
    pub const fn is_own(&self) -> bool {
        matches!(self, Self::Own(_))
    }

    /// Returns the command line of a mouse of the user.
    pub fn command(&self) -> Option<&str> {
        match self {
            Self::Bundled(_) => None,
            Self::Own(mouse) => Some(&mouse.command),
        }
    }
}

impl NamedMouse {
    /// Creates a mouse from its name and its command line. The words of the command may be quoted as in
    /// a shell.
    ///
    /// # Errors
    /// Returns what is wrong with the name or the command.
    pub fn new(name: &str, command: &str) -> Result<Self, String> {
        if name.is_empty() || name.len() > MAX_NAME_BYTES {
            return Err(format!("expected a NAME of 1 to {MAX_NAME_BYTES} bytes"));
        }
        if name.chars().any(needs_escape) {
            return Err("expected a NAME without control characters".into());
        }
        // On Windows, a backslash separates folders.
        let posix = if cfg!(windows) { command.replace('\\', r"\\") } else { command.into() };
        let words = shlex::split(&posix).ok_or("expected a closing quotation mark")?;
        if words.is_empty() {
            return Err(format!("{EXPECTED}; the command is empty"));
        }
        let words: Vec<_> = words.into_iter().map(OsString::from).collect();
        Ok(Self { name: name.into(), command: command.into(), program: Program::new(&words) })
    }
}

impl FromStr for NamedMouse {
    type Err = String;

    /// Parses `NAME=COMMAND`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, command) = text.split_once('=').ok_or(EXPECTED)?;
        Self::new(name.trim(), command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_words_of_a_command_may_be_quoted() {
        let mouse: NamedMouse = "my mouse=python3 'a b.py' --x=1 \"c d\"".parse().unwrap();
        assert_eq!(mouse.name, "my mouse");
        assert_eq!(mouse.command, "python3 'a b.py' --x=1 \"c d\"");
        let command = mouse.program.command();
        assert_eq!(command.get_program(), "python3");
        assert!(command.get_args().eq(["a b.py", "--x=1", "c d"]));
        for (text, error) in [
            ("python3", "expected NAME=COMMAND"),
            ("=python3", "expected a NAME of 1 to 100 bytes"),
            ("a\nb=python3", "without control characters"),
            ("mine=", "the command is empty"),
            ("mine= ", "the command is empty"),
            ("mine='python3", "expected a closing quotation mark"),
        ] {
            let found = text.parse::<NamedMouse>().unwrap_err();
            assert!(found.contains(error), "{text}: {found}");
        }
    }
}

//! Validates the paths in an archive.

/// The maximum length of a path in bytes. Every system supports paths of this length.
const MAX_PATH_BYTES: usize = 200;

/// The names that Windows reserves for devices, in addition to numbered ports such as `COM1`.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];

/// Returns the path with `/` as separator, or `None` if the path is not valid on every system.
///
/// # Errors
/// Returns an error if the path leads outside the target folder on any system.
pub(super) fn inside(path: &[u8]) -> Result<Option<String>, &'static str> {
    if path.starts_with(b"/") || path.starts_with(b"\\") {
        return Err("has an absolute path");
    }
    if let [drive, b':', ..] = path
        && drive.is_ascii_alphabetic()
    {
        return Err("has a path with a drive letter");
    }
    // Windows has two separators.
    if path.split(|byte| b"/\\".contains(byte)).any(|name| name == b"..") {
        return Err("has a path with \"..\"");
    }
    let text = str::from_utf8(path).ok().filter(|text| text.len() <= MAX_PATH_BYTES);
    let names = text.unwrap_or_default().split('/').filter(|name| !name.is_empty() && *name != ".");
    let names: Vec<&str> = names.collect();
    let is_portable = !names.is_empty() && names.iter().all(|name| is_portable_name(name));
    Ok(is_portable.then(|| names.join("/")))
}

fn is_portable_name(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or_default().trim_end().to_lowercase();
    let is_port =
        |port: &str| stem.strip_prefix(port).is_some_and(|number| number.chars().count() == 1);
    let is_device = DEVICES.contains(&&stem[..]) || is_port("com") || is_port("lpt");
    let is_reserved = name.chars().any(|sign| sign.is_control() || "\\:*?\"<>|".contains(sign));
    !is_device && !is_reserved && !name.ends_with(['.', ' '])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inside_paths_are_kept() {
        for (path, kept) in [
            ("a.txt", "a.txt"),
            (
                "./mazes-master/classic//Other(uk2000)__2000 é.txt",
                "mazes-master/classic/Other(uk2000)__2000 é.txt",
            ),
            ("folder/", "folder"),
            (".hidden/..a/b..txt", ".hidden/..a/b..txt"),
            ("command.txt", "command.txt"),
            ("company/lpt", "company/lpt"),
        ] {
            assert_eq!(inside(path.as_bytes()), Ok(Some(kept.to_string())));
        }
    }

    #[test]
    fn outside_paths_are_refused() {
        for path in [
            "/etc/passwd",
            "//server/share",
            "..",
            "../a",
            "a/../../b",
            "a/..",
            "C:\\a",
            "C:a",
            "c:/a",
            "\\a",
            "a\\..\\b",
            "?/../a",
        ] {
            assert!(inside(path.as_bytes()).is_err(), "{path:?}");
        }
        assert!(inside(b"\xff/../a").is_err());
        assert!(inside(&[b"../", &[b'a'; MAX_PATH_BYTES][..]].concat()).is_err());
    }

    #[test]
    fn unportable_paths_return_none() {
        for path in [
            "",
            "./",
            "a\\b",
            "12:30.txt",
            "a.txt:stream",
            "a\"b.txt",
            "b?.txt",
            "nul",
            "a/CON.txt",
            "com1",
            "Lpt9.maz",
            "aux .txt",
            "a./b",
            "a /b",
            "... ",
            "a\0b",
            "a\nb",
            "a\u{7f}",
        ] {
            assert_eq!(inside(path.as_bytes()), Ok(None), "{path:?}");
        }
        assert_eq!(inside(b"\x81.txt"), Ok(None));
        let long = |names| inside("é/".repeat(names).as_bytes()).unwrap();
        assert!(long(66).is_some());
        assert_eq!(long(67), None);
    }
}

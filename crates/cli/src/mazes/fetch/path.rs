//! Paths that an archive or a list may ask for.

/// The longest path in bytes, which every system of today can have below a folder of its own.
const MAX_PATH_BYTES: usize = 200;

/// What Windows takes for a device wherever it is and whatever it ends in, besides COM1 and LPT1 and
/// so on.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];

/// This path with `/` between, if every system takes it for a path inside of where it starts; else
/// what was expected and what was found.
pub(super) fn inside(path: &[u8]) -> Result<String, (String, String)> {
    let refused = |expected: &str, found: &str| Err((expected.to_string(), found.to_string()));
    let Ok(text) = str::from_utf8(path) else {
        return refused("a name in UTF-8", "other bytes");
    };
    if text.len() > MAX_PATH_BYTES {
        let expected = format!("a path of at most {MAX_PATH_BYTES} bytes");
        return Err((expected, text.len().to_string()));
    }
    if text.starts_with('/') {
        return refused("a path inside of the archive", "an absolute one");
    }
    if let Some(sign) = text.chars().find(|&c| c.is_control() || "\\:*?\"<>|".contains(c)) {
        return Err(("a name that every system can have".into(), format!("{sign:?} in it")));
    }
    let names: Vec<&str> =
        text.split('/').filter(|name| !name.is_empty() && *name != ".").collect();
    for name in &names {
        if *name == ".." {
            return refused("a path inside of the archive", "\"..\"");
        }
        let stem = name.split('.').next().unwrap_or_default().trim_end().to_lowercase();
        let is_port =
            |port: &str| stem.strip_prefix(port).is_some_and(|number| number.chars().count() == 1);
        if DEVICES.contains(&&stem[..]) || is_port("com") || is_port("lpt") {
            return Err(("a name that every system can have".into(), format!("{name:?}")));
        }
        if name.ends_with(['.', ' ']) {
            return refused("a name that every system can have", "a dot or a blank at its end");
        }
    }
    Ok(names.join("/"))
}

/// A name as messages show it: in quotes, not too long.
pub(super) fn shown(name: &[u8]) -> String {
    const LONGEST: usize = 80;
    let name = String::from_utf8_lossy(name);
    match name.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{:?}…", &name[..end]),
        None => format!("{name:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_inside_are_kept() {
        for (path, kept) in [
            ("a.txt", "a.txt"),
            (
                "./mazes-master/classic//Other(uk2000)__2000 é.txt",
                "mazes-master/classic/Other(uk2000)__2000 é.txt",
            ),
            ("folder/", "folder"),
            ("./", ""),
            (".hidden/..a/b..txt", ".hidden/..a/b..txt"),
            ("command.txt", "command.txt"),
            ("company/lpt", "company/lpt"),
        ] {
            assert_eq!(inside(path.as_bytes()), Ok(kept.to_string()));
        }
    }

    #[test]
    fn paths_that_lead_out_are_refused() {
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
            "a.txt:stream",
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
            assert!(inside(path.as_bytes()).is_err(), "{path:?}");
        }
        assert!(inside(b"\xff").is_err());
        assert!(inside("é/".repeat(66).as_bytes()).is_ok());
        assert!(inside("é/".repeat(67).as_bytes()).is_err());
    }
}

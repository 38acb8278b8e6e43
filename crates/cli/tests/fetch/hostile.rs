//! Malicious archives and broken downloads.

use tar::EntryType;

use crate::archives::{Zipped, gz, tar, tar_entry, tar_gz, tar_gz_bomb, tar_of, zip, zip_of};
use crate::server::{answer, serve, serve_content};
use crate::{MAZE, fetch_fails, home_with_mazes};

/// Returns the reason in the error message for an archive that cannot be fetched.
fn refusal(archive: &[u8]) -> String {
    let home = home_with_mazes();
    home.write("archive", archive);
    let error = fetch_fails(&home, "archive");
    let error = error.strip_prefix("mmsim: cannot fetch archive: ").unwrap_or(&error);
    error.strip_suffix("; nothing was changed\n").unwrap_or(error).to_string()
}

/// Returns the reason why an archive that contains an entry with the given name is refused. Asserts
/// that it is the same for .tar.gz and .zip.
fn refusal_of_name(name: &[u8]) -> String {
    let good = tar_entry(b"good.txt", EntryType::Regular, MAZE.as_bytes());
    let bad = tar_of(name, EntryType::Regular, MAZE.as_bytes());
    let in_tar = refusal(&gz(&[good, bad].concat()));
    let [good, bad] = [b"good.txt", name].map(|name| Zipped::new(name, MAZE.as_bytes()));
    assert_eq!(refusal(&zip_of(&[good, bad])), in_tar);
    in_tar
}

#[test]
fn outside_paths_are_refused() {
    insta::assert_snapshot!(refusal_of_name(b"../evil.txt"), @r#"entry "../evil.txt" has a path with "..""#);
    insta::assert_snapshot!(refusal_of_name(b"top/../../evil.txt"), @r#"entry "top/../../evil.txt" has a path with "..""#);
    insta::assert_snapshot!(refusal_of_name(b"/evil.txt"), @r#"entry "/evil.txt" has an absolute path"#);
    insta::assert_snapshot!(refusal_of_name(b"C:evil.txt"), @r#"entry "C:evil.txt" has a path with a drive letter"#);
    insta::assert_snapshot!(refusal_of_name(b"C:/evil.txt"), @r#"entry "C:/evil.txt" has a path with a drive letter"#);
    insta::assert_snapshot!(refusal_of_name(b"\xff/../evil.txt"), @r#"entry "\xff/../evil.txt" has a path with "..""#);
    for name in [b"C:\\evil.txt", &b"..\\evil.txt"[..], b"a\\..\\evil.txt", b"\\evil.txt"] {
        let file = tar_of(name, EntryType::Regular, MAZE.as_bytes());
        let in_tar = refusal(&gz(&file));
        assert!(in_tar.contains("path"), "{in_tar}");
        let in_zip = refusal(&zip_of(&[Zipped::new(name, MAZE.as_bytes())]));
        assert_eq!(in_zip, in_tar.replace("\\\\", "/"));
    }
    let home = home_with_mazes();
    let absolute = home.path().join("evil.txt").display().to_string().replace('\\', "/");
    home.write("archive", zip(&[("good.txt", MAZE), (&absolute, MAZE)]));
    fetch_fails(&home, "archive");
}

#[test]
fn outside_folders_are_refused() {
    insta::assert_snapshot!(refusal(&tar_of(b"../evil/", EntryType::Directory, b"")), @r#"entry "../evil/" has a path with "..""#);
    insta::assert_snapshot!(refusal(&zip(&[("../evil/", "")])), @r#"entry "../evil/" has a path with "..""#);
}

#[test]
fn links_and_devices_are_refused() {
    let with_kind = |kind| {
        let good = tar_entry(b"good.txt", EntryType::Regular, MAZE.as_bytes());
        refusal(&gz(&[good, tar_of(b"bad.txt", kind, b"")].concat()))
    };
    insta::assert_snapshot!(with_kind(EntryType::Symlink), @r#"entry "bad.txt" is a symbolic link"#);
    insta::assert_snapshot!(with_kind(EntryType::Link), @r#"entry "bad.txt" is a hard link"#);
    insta::assert_snapshot!(with_kind(EntryType::Char), @r#"entry "bad.txt" is neither a file nor a folder"#);
    insta::assert_snapshot!(with_kind(EntryType::Block), @r#"entry "bad.txt" is neither a file nor a folder"#);
    insta::assert_snapshot!(with_kind(EntryType::Fifo), @r#"entry "bad.txt" is neither a file nor a folder"#);
    insta::assert_snapshot!(with_kind(EntryType::new(b'V')), @r#"entry "bad.txt" is neither a file nor a folder"#);
    let with_mode =
        |mode| refusal(&zip_of(&[Zipped { mode, ..Zipped::new(b"bad.txt", b"/etc/passwd") }]));
    insta::assert_snapshot!(with_mode(0o120_777), @r#"entry "bad.txt" is a symbolic link"#);
    // Some tools mark links only in the mode, regardless of the name and the originating system.
    for (name, system) in [(&b"bad.txt"[..], 0), (b"bad/", 3), (b"bad/", 0), (b"bad.txt", 10)] {
        let link = Zipped { mode: 0o120_777, system, ..Zipped::new(name, b"/etc/passwd") };
        let refusal = refusal(&zip_of(&[Zipped::new(b"a.txt", MAZE.as_bytes()), link]));
        assert!(refusal.ends_with("is a symbolic link"), "{refusal}");
    }
    insta::assert_snapshot!(with_mode(0o020_644), @r#"entry "bad.txt" is neither a file nor a folder"#);
}

#[test]
fn large_content_is_refused() {
    let large = MAZE.to_string() + &" ".repeat(1 << 20);
    insta::assert_snapshot!(refusal(&tar_gz(&[("large.txt", &large)])), @r#"entry "large.txt" is larger than 1048576 bytes"#);
    insta::assert_snapshot!(refusal(&zip(&[("large.txt", &large)])), @r#"entry "large.txt" is larger than 1048576 bytes"#);
    let names: Vec<String> = (0..33).map(|number| format!("{number}.txt")).collect();
    let content = " ".repeat(1 << 20);
    let many: Vec<_> = names.iter().map(|name| (&name[..], &content[..])).collect();
    insta::assert_snapshot!(refusal(&tar_gz(&many)), @"content is larger than 32 MiB");
    insta::assert_snapshot!(refusal(&zip(&many)), @"content is larger than 32 MiB");
    insta::assert_snapshot!(refusal(&vec![0x1f; (32 << 20) + 1]), @"mmsim: cannot read archive: larger than 32 MiB");
}

#[test]
fn too_many_entries_are_refused() {
    let names: Vec<String> = (0..20_001).map(|number| format!("{number}.txt")).collect();
    let many: Vec<_> = names.iter().map(|name| (&name[..], "")).collect();
    insta::assert_snapshot!(refusal(&tar_gz(&many)), @"more than 20000 entries");
    insta::assert_snapshot!(refusal(&zip(&many)), @"more than 20000 entries");
}

#[test]
fn bombs_of_10_gib_are_refused() {
    insta::assert_snapshot!(refusal(&tar_gz_bomb(EntryType::Regular)), @"content is larger than 32 MiB");
    // The metadata of an entry, such as a long name, would be kept in memory.
    insta::assert_snapshot!(refusal(&tar_gz_bomb(EntryType::GNULongName)), @"content is larger than 32 MiB");
    insta::assert_snapshot!(refusal(&tar_gz_bomb(EntryType::XHeader)), @"content is larger than 32 MiB");
    insta::assert_snapshot!(refusal(&tar_gz_bomb(EntryType::XGlobalHeader)), @"content is larger than 32 MiB");
    insta::assert_snapshot!(refusal(&tar_gz_bomb(EntryType::GNUSparse)), @"content is larger than 32 MiB");
    insta::assert_snapshot!(refusal(&zip_of(&[Zipped::bomb()])), @r#"entry "bomb.txt" is damaged: Invalid size: expected 100, got 128"#);
}

#[test]
fn wrong_headers_are_refused() {
    let file = || Zipped::new(b"liar.txt", MAZE.as_bytes());
    let less = Zipped { bytes: 5, ..file() };
    insta::assert_snapshot!(refusal(&zip_of(&[less])), @r#"entry "liar.txt" is damaged: Invalid size: expected 5, got 30"#);
    insta::assert_snapshot!(refusal(&zip_of(&[Zipped { checksum: 1, ..file() }])), @r#"entry "liar.txt" is damaged: Invalid checksum: expected 0x00000001, got 0xed69a67b"#);
    insta::assert_snapshot!(refusal(&zip_of(&[Zipped { method: 14, ..file() }])), @r#"entry "liar.txt" is compressed with a method other than deflate"#);
    insta::assert_snapshot!(refusal(&zip_of(&[Zipped { data: vec![7; 9], ..file() }])), @r#"entry "liar.txt" is damaged: corrupt deflate stream"#);
}

#[test]
fn other_files_and_archives_without_mazes_are_refused() {
    insta::assert_snapshot!(refusal(b""), @"expected a .tar.gz, .zip or .tar archive, found an empty file");
    insta::assert_snapshot!(refusal(b"<!DOCTYPE html><p>Please log in"), @r#"expected a .tar.gz, .zip or .tar archive, found "<!DOCTYPE html><p>Please log in""#);
    insta::assert_snapshot!(refusal(MAZE.as_bytes()), @r#"expected a .tar.gz, .zip or .tar archive, found "o---o---o\n| S   G |\no---o---o\n""#);
    insta::assert_snapshot!(refusal(&tar_gz(&[("top/readme.txt", "no maze"), (".a.txt", MAZE)])), @"no mazes found in 2 files");
    insta::assert_snapshot!(refusal(&zip(&[])), @"no mazes found in 0 files");
    insta::assert_snapshot!(refusal(&gz(b"no tar")), @"damaged archive: failed to read entire block");
}

#[test]
fn truncated_archives_are_refused() {
    let contents = [("a.txt", MAZE), ("b.txt", MAZE)];
    // The last block of a tar archive consists of redundant zeros.
    for (whole, spare) in [(tar_gz(&contents), 0), (zip(&contents), 0), (tar(&contents), 512)] {
        let home = home_with_mazes();
        for end in (1..whole.len() - spare).step_by(whole.len() / 12) {
            home.write("archive", &whole[..end]);
            let error = fetch_fails(&home, "archive");
            assert!(
                error.starts_with("mmsim: cannot fetch archive: "),
                "{end} of {}: {error}",
                whole.len()
            );
        }
    }
}

#[test]
fn failed_downloads_change_nothing() {
    let home = home_with_mazes();
    let archive = tar_gz(&[("a.txt", MAZE)]);
    let fails = |answer: Vec<u8>| {
        let address = format!("http://{}/mazes.tar.gz", serve(answer));
        fetch_fails(&home, &address).replace(&address, "ADDRESS")
    };
    insta::assert_snapshot!(fails(answer("200 OK", archive.len() + 1, &archive)), @"mmsim: cannot download ADDRESS: Peer disconnected (try again, or save it with a browser and run `mmsim mazes fetch --from FILE`)");
    insta::assert_snapshot!(fails(answer("200 OK", archive.len(), &archive[..50])), @"mmsim: cannot download ADDRESS: Peer disconnected (try again, or save it with a browser and run `mmsim mazes fetch --from FILE`)");
    insta::assert_snapshot!(fails(answer("404 Not Found", 4, b"none")), @"mmsim: cannot download ADDRESS: http status: 404 (try again, or save it with a browser and run `mmsim mazes fetch --from FILE`)");
    insta::assert_snapshot!(fails(answer("500 Internal Server Error", 4, b"none")), @"mmsim: cannot download ADDRESS: http status: 500 (try again, or save it with a browser and run `mmsim mazes fetch --from FILE`)");
    insta::assert_snapshot!(fails(answer("200 OK", 1 << 40, b"")), @"mmsim: cannot download ADDRESS: larger than 32 MiB (try again, or save it with a browser and run `mmsim mazes fetch --from FILE`)");
    insta::assert_snapshot!(fails(vec![]), @"mmsim: cannot download ADDRESS: Peer disconnected (try again, or save it with a browser and run `mmsim mazes fetch --from FILE`)");
    insta::assert_snapshot!(fails(b"HTTP/1.0 200 OK\r\n\r\n".iter().chain(&archive[..60]).copied().collect()), @"mmsim: cannot fetch ADDRESS: damaged archive: incomplete deflate stream; nothing was changed");
    insta::assert_snapshot!(fails(b"hello".repeat(100)), @"mmsim: cannot download ADDRESS: protocol: http parse fail: invalid HTTP version (try again, or save it with a browser and run `mmsim mazes fetch --from FILE`)");
    insta::assert_snapshot!(fails(b"HTTP/1.1 302 Found\r\nLocation: file:///etc/passwd\r\n\r\n".to_vec()), @"mmsim: cannot download ADDRESS: too many redirects (try again, or save it with a browser and run `mmsim mazes fetch --from FILE`)");
    let page = serve_content(b"<html>Please log in</html>");
    let error = fetch_fails(&home, &format!("http://{page}/"));
    assert!(error.contains("expected a .tar.gz, .zip or .tar archive, found \"<html>"), "{error}");
    let error = fetch_fails(&home, "missing.zip");
    assert!(error.starts_with("mmsim: cannot read missing.zip: "), "{error}");
    assert!(
        fetch_fails(&home, "ftp://host/a.zip").starts_with("mmsim: cannot read ftp://host/a.zip: ")
    );
    assert!(fetch_fails(&home, "https://").starts_with("mmsim: cannot download https://: "));
}

/// If the system has no certificates, mmsim uses built-in certificates. The server in this test
/// does not support TLS, so the TLS handshake fails.
#[cfg(all(unix, not(target_os = "macos")))]
#[test]
fn systems_without_certificates_are_supported() {
    let home = home_with_mazes();
    let none = home.write("none.pem", "");
    let address = format!("https://{}/a.zip", serve(b"no TLS".repeat(100)));
    let mut command = home.command(&["mazes", "fetch", "mazes", "--from", &address]);
    command.env("SSL_CERT_FILE", none).env_remove("SSL_CERT_DIR");
    let error = String::from_utf8(mmsim_tests::output(&mut command).stderr).unwrap();
    assert!(error.contains(": received corrupt message"), "{error}");
}

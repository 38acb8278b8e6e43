//! Archives that are out to do harm, and downloads that break.

use tar::EntryType;

use crate::archives::{Zipped, gz, tar, tar_entry, tar_gz, tar_gz_bomb, tar_of, zip, zip_of};
use crate::server::{answer, serve, serve_content};
use crate::{MAZE, fetch_in_vain, home_with_mazes};

/// What is said of an archive after its name.
fn refusal(archive: &[u8]) -> String {
    let home = home_with_mazes();
    home.write("archive", archive);
    let error = fetch_in_vain(&home, "archive");
    let error = error.strip_prefix("mmsim: archive: ").unwrap_or(&error);
    error.strip_suffix("; nothing was changed\n").unwrap_or(error).to_string()
}

/// What is said of an entry beside a good one, the same in a .tar.gz and in a .zip.
fn refusal_of_name(name: &[u8]) -> String {
    let good = tar_entry(b"good.txt", EntryType::Regular, MAZE.as_bytes());
    let bad = tar_of(name, EntryType::Regular, MAZE.as_bytes());
    let in_tar = refusal(&gz(&[good, bad].concat()));
    let [good, bad] = [b"good.txt", name].map(|name| Zipped::new(name, MAZE.as_bytes()));
    assert_eq!(refusal(&zip_of(&[good, bad])), in_tar);
    in_tar
}

#[test]
fn paths_that_lead_out_are_refused() {
    insta::assert_snapshot!(refusal_of_name(b"../evil.txt"), @r#"its entry "../evil.txt": expected a path inside of the archive, found one with "..""#);
    insta::assert_snapshot!(refusal_of_name(b"top/../../evil.txt"), @r#"its entry "top/../../evil.txt": expected a path inside of the archive, found one with "..""#);
    insta::assert_snapshot!(refusal_of_name(b"/evil.txt"), @r#"its entry "/evil.txt": expected a path inside of the archive, found an absolute one"#);
    insta::assert_snapshot!(refusal_of_name(b"C:evil.txt"), @r#"its entry "C:evil.txt": expected a path inside of the archive, found one with a drive"#);
    insta::assert_snapshot!(refusal_of_name(b"C:/evil.txt"), @r#"its entry "C:/evil.txt": expected a path inside of the archive, found one with a drive"#);
    insta::assert_snapshot!(refusal_of_name(b"\xff/../evil.txt"), @r#"its entry "�/../evil.txt": expected a path inside of the archive, found one with "..""#);
    for name in [b"C:\\evil.txt", &b"..\\evil.txt"[..], b"a\\..\\evil.txt", b"\\evil.txt"] {
        let file = tar_of(name, EntryType::Regular, MAZE.as_bytes());
        let in_tar = refusal(&gz(&file));
        assert!(in_tar.contains("expected a path inside of the archive"), "{in_tar}");
        let in_zip = refusal(&zip_of(&[Zipped::new(name, MAZE.as_bytes())]));
        assert_eq!(in_zip, in_tar.replace("\\\\", "/"));
    }
    let home = home_with_mazes();
    let absolute = home.path().join("evil.txt").display().to_string().replace('\\', "/");
    home.write("archive", zip(&[("good.txt", MAZE), (&absolute, MAZE)]));
    fetch_in_vain(&home, "archive");
}

#[test]
fn folders_that_lead_out_are_refused() {
    insta::assert_snapshot!(refusal(&tar_of(b"../evil/", EntryType::Directory, b"")), @r#"its entry "../evil/": expected a path inside of the archive, found one with "..""#);
    insta::assert_snapshot!(refusal(&zip(&[("../evil/", "")])), @r#"its entry "../evil/": expected a path inside of the archive, found one with "..""#);
}

#[test]
fn links_and_devices_are_refused() {
    let of_kind = |kind| {
        let good = tar_entry(b"good.txt", EntryType::Regular, MAZE.as_bytes());
        refusal(&gz(&[good, tar_of(b"bad.txt", kind, b"")].concat()))
    };
    insta::assert_snapshot!(of_kind(EntryType::Symlink), @r#"its entry "bad.txt": expected a file or a folder, found a symbolic link"#);
    insta::assert_snapshot!(of_kind(EntryType::Link), @r#"its entry "bad.txt": expected a file or a folder, found a hard link"#);
    insta::assert_snapshot!(of_kind(EntryType::Char), @r#"its entry "bad.txt": expected a file or a folder, found a device"#);
    insta::assert_snapshot!(of_kind(EntryType::Block), @r#"its entry "bad.txt": expected a file or a folder, found a device"#);
    insta::assert_snapshot!(of_kind(EntryType::Fifo), @r#"its entry "bad.txt": expected a file or a folder, found a pipe"#);
    insta::assert_snapshot!(of_kind(EntryType::new(b'V')), @r#"its entry "bad.txt": expected a file or a folder, found something else"#);
    let of_mode =
        |mode| refusal(&zip_of(&[Zipped { mode, ..Zipped::new(b"bad.txt", b"/etc/passwd") }]));
    insta::assert_snapshot!(of_mode(0o120_777), @r#"its entry "bad.txt": expected a file or a folder, found a symbolic link"#);
    // Some tools make such a link whatever its name ends in, and whoever is said to have made it.
    for (name, system) in [(&b"bad.txt"[..], 0), (b"bad/", 3), (b"bad/", 0), (b"bad.txt", 10)] {
        let link = Zipped { mode: 0o120_777, system, ..Zipped::new(name, b"/etc/passwd") };
        let refusal = refusal(&zip_of(&[Zipped::new(b"a.txt", MAZE.as_bytes()), link]));
        assert!(refusal.ends_with("found a symbolic link"), "{refusal}");
    }
    insta::assert_snapshot!(of_mode(0o020_644), @r#"its entry "bad.txt": expected a file or a folder, found a device or a pipe"#);
}

#[test]
fn what_is_too_large_is_refused() {
    let large = MAZE.to_string() + &" ".repeat(1 << 20);
    insta::assert_snapshot!(refusal(&tar_gz(&[("large.txt", &large)])), @r#"its entry "large.txt": expected at most 1048576 bytes, found 1048606"#);
    insta::assert_snapshot!(refusal(&zip(&[("large.txt", &large)])), @r#"its entry "large.txt": expected at most 1048576 bytes, found 1048606"#);
    let names: Vec<String> = (0..33).map(|number| format!("{number}.txt")).collect();
    let content = " ".repeat(1 << 20);
    let many: Vec<_> = names.iter().map(|name| (&name[..], &content[..])).collect();
    insta::assert_snapshot!(refusal(&tar_gz(&many)), @"expected at most 32 MiB in all, found more");
    insta::assert_snapshot!(refusal(&zip(&many)), @"expected at most 32 MiB in all, found more");
    insta::assert_snapshot!(refusal(&vec![0x1f; (32 << 20) + 1]), @"cannot be read: expected at most 32 MiB, found 33554433 bytes");
}

#[test]
fn too_many_entries_are_refused() {
    let names: Vec<String> = (0..20_001).map(|number| format!("{number}.txt")).collect();
    let many: Vec<_> = names.iter().map(|name| (&name[..], "")).collect();
    insta::assert_snapshot!(refusal(&tar_gz(&many)), @"expected at most 20000 entries, found more");
    insta::assert_snapshot!(refusal(&zip(&many)), @"expected at most 20000 entries, found more");
}

#[test]
fn bombs_of_10_gib_are_refused() {
    insta::assert_snapshot!(refusal(&tar_gz_bomb(EntryType::Regular)), @r#"its entry "bomb.txt": expected at most 1048576 bytes, found 10737418240"#);
    // What comes before an entry, with its long name and the like, would be kept in memory.
    insta::assert_snapshot!(refusal(&tar_gz_bomb(EntryType::GNULongName)), @"expected at most 32 MiB in all, found more");
    insta::assert_snapshot!(refusal(&tar_gz_bomb(EntryType::XHeader)), @"expected at most 32 MiB in all, found more");
    insta::assert_snapshot!(refusal(&tar_gz_bomb(EntryType::XGlobalHeader)), @"expected at most 32 MiB in all, found more");
    insta::assert_snapshot!(refusal(&tar_gz_bomb(EntryType::GNUSparse)), @"expected at most 32 MiB in all, found more");
    insta::assert_snapshot!(refusal(&zip_of(&[Zipped::bomb()])), @r#"its entry "bomb.txt": expected its whole content, found Invalid size: expected 100, got 128"#);
}

#[test]
fn headers_that_lie_are_refused() {
    let file = || Zipped::new(b"liar.txt", MAZE.as_bytes());
    let less = Zipped { bytes: 5, ..file() };
    insta::assert_snapshot!(refusal(&zip_of(&[less])), @r#"its entry "liar.txt": expected its whole content, found Invalid size: expected 5, got 30"#);
    insta::assert_snapshot!(refusal(&zip_of(&[Zipped { checksum: 1, ..file() }])), @r#"its entry "liar.txt": expected its whole content, found Invalid checksum: expected 0x00000001, got 0xed69a67b"#);
    insta::assert_snapshot!(refusal(&zip_of(&[Zipped { method: 14, ..file() }])), @r#"its entry "liar.txt": expected a file or a folder, found a file packed by another method than deflate"#);
    insta::assert_snapshot!(refusal(&zip_of(&[Zipped { data: vec![7; 9], ..file() }])), @r#"its entry "liar.txt": expected its whole content, found corrupt deflate stream"#);
}

#[test]
fn what_is_no_archive_or_has_no_maze_is_refused() {
    insta::assert_snapshot!(refusal(b""), @"expected a .tar.gz, .zip or .tar archive, found an empty file");
    insta::assert_snapshot!(refusal(b"<!DOCTYPE html><p>Please log in"), @r#"expected a .tar.gz, .zip or .tar archive, found "<!DOCTYPE html><p>Please log in""#);
    insta::assert_snapshot!(refusal(MAZE.as_bytes()), @r#"expected a .tar.gz, .zip or .tar archive, found "o---o---o\n| S   G |\no---o---o\n""#);
    insta::assert_snapshot!(refusal(&tar_gz(&[("top/readme.txt", "no maze"), (".a.txt", MAZE)])), @"expected an archive with mazes, found none in 2 files");
    insta::assert_snapshot!(refusal(&zip(&[])), @"expected an archive with mazes, found none in 0 files");
    insta::assert_snapshot!(refusal(&gz(b"no tar")), @"expected a whole archive, found a broken one: failed to read entire block");
}

/// Wherever an archive is cut off, it is refused.
#[test]
fn cut_off_archives_are_refused() {
    let contents = [("a.txt", MAZE), ("b.txt", MAZE)];
    // The last block of a tar is one more of zeros, which nobody misses.
    for (whole, spare) in [(tar_gz(&contents), 0), (zip(&contents), 0), (tar(&contents), 512)] {
        let home = home_with_mazes();
        for end in (1..whole.len() - spare).step_by(whole.len() / 12) {
            home.write("archive", &whole[..end]);
            let error = fetch_in_vain(&home, "archive");
            assert!(error.contains("archive: expected a"), "{end} of {}: {error}", whole.len());
        }
    }
}

#[test]
fn downloads_that_break_change_nothing() {
    let home = home_with_mazes();
    let archive = tar_gz(&[("a.txt", MAZE)]);
    let fails = |answer: Vec<u8>| {
        let address = format!("http://{}/mazes.tar.gz", serve(answer));
        fetch_in_vain(&home, &address).replace(&address, "ADDRESS")
    };
    insta::assert_snapshot!(fails(answer("200 OK", archive.len() + 1, &archive)), @"mmsim: ADDRESS: cannot be downloaded: Peer disconnected; try again, or save it with a browser and take that file: `mmsim mazes fetch --from FILE`");
    insta::assert_snapshot!(fails(answer("200 OK", archive.len(), &archive[..50])), @"mmsim: ADDRESS: cannot be downloaded: Peer disconnected; try again, or save it with a browser and take that file: `mmsim mazes fetch --from FILE`");
    insta::assert_snapshot!(fails(answer("404 Not Found", 4, b"none")), @"mmsim: ADDRESS: cannot be downloaded: http status: 404; try again, or save it with a browser and take that file: `mmsim mazes fetch --from FILE`");
    insta::assert_snapshot!(fails(answer("500 Internal Server Error", 4, b"none")), @"mmsim: ADDRESS: cannot be downloaded: http status: 500; try again, or save it with a browser and take that file: `mmsim mazes fetch --from FILE`");
    insta::assert_snapshot!(fails(answer("200 OK", 1 << 40, b"")), @"mmsim: ADDRESS: cannot be downloaded: expected at most 32 MiB, found 1099511627776 bytes; try again, or save it with a browser and take that file: `mmsim mazes fetch --from FILE`");
    insta::assert_snapshot!(fails(vec![]), @"mmsim: ADDRESS: cannot be downloaded: Peer disconnected; try again, or save it with a browser and take that file: `mmsim mazes fetch --from FILE`");
    insta::assert_snapshot!(fails(b"HTTP/1.0 200 OK\r\n\r\n".iter().chain(&archive[..60]).copied().collect()), @"mmsim: ADDRESS: expected a whole archive, found a broken one: incomplete deflate stream; nothing was changed");
    insta::assert_snapshot!(fails(b"hello".repeat(100)), @"mmsim: ADDRESS: cannot be downloaded: protocol: http parse fail: invalid HTTP version; try again, or save it with a browser and take that file: `mmsim mazes fetch --from FILE`");
    insta::assert_snapshot!(fails(b"HTTP/1.1 302 Found\r\nLocation: file:///etc/passwd\r\n\r\n".to_vec()), @"mmsim: ADDRESS: cannot be downloaded: too many redirects; try again, or save it with a browser and take that file: `mmsim mazes fetch --from FILE`");
    let page = serve_content(b"<html>Please log in</html>");
    let error = fetch_in_vain(&home, &format!("http://{page}/"));
    assert!(error.contains("expected a .tar.gz, .zip or .tar archive, found \"<html>"), "{error}");
    let error = fetch_in_vain(&home, "missing.zip");
    assert!(error.starts_with("mmsim: missing.zip: cannot be read: "), "{error}");
    assert!(fetch_in_vain(&home, "ftp://host/a.zip").starts_with("mmsim: ftp://host/a.zip: "));
    assert!(
        fetch_in_vain(&home, "https://").starts_with("mmsim: https://: cannot be downloaded: ")
    );
}

/// Then those who are known to mmsim itself are trusted; what answers here is none of them.
#[cfg(all(unix, not(target_os = "macos")))]
#[test]
fn a_system_without_certificates_is_no_obstacle() {
    let home = home_with_mazes();
    let none = home.write("none.pem", "");
    let address = format!("https://{}/a.zip", serve(b"no TLS".repeat(100)));
    let mut command = home.command(&["mazes", "fetch", "mazes", "--from", &address]);
    command.env("SSL_CERT_FILE", none).env_remove("SSL_CERT_DIR");
    let error = String::from_utf8(mmsim_tests::output(&mut command).stderr).unwrap();
    assert!(error.contains("cannot be downloaded: received corrupt message"), "{error}");
}

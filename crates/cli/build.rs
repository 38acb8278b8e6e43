//! Passes the version that `mmsim --version` prints to the compiler.

use std::env;
use std::fs;
use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let commit = packaged_commit().or_else(checked_out_commit);
    let commit = commit.as_deref().unwrap_or("unknown commit");
    let variable = |name| env::var(name).expect("cargo sets this variable");
    let (version, target) = (variable("CARGO_PKG_VERSION"), variable("TARGET"));
    let library = if env::var_os("CARGO_FEATURE_LIBZMQ").is_some() { ", libzmq" } else { "" };
    println!("cargo:rustc-env=MMSIM_LONG_VERSION={version} ({commit}, {target}{library})");
}

/// Returns the abbreviated hash of the commit that this package was made from. Returns `None` if
/// this is not an unpacked package.
fn packaged_commit() -> Option<String> {
    const INFO: &str = ".cargo_vcs_info.json";
    let info = fs::read_to_string(INFO).ok()?;
    println!("cargo:rerun-if-changed={INFO}");
    let (_, hash) = info.split_once("\"sha1\": \"")?;
    hash.get(..9).map(String::from)
}

/// Returns the abbreviated hash and the date of the commit that is checked out. Returns `None`
/// without git, and if this folder belongs to another repository.
fn checked_out_commit() -> Option<String> {
    if git(&["rev-parse", "--show-prefix"])? != "crates/cli/" {
        return None;
    }
    // Git appends to the log each time another commit is checked out or a commit is added. Without a
    // log, at least the file of the branch changes.
    let branch = git(&["symbolic-ref", "-q", "HEAD"]);
    for file in ["HEAD", "logs/HEAD"].into_iter().chain(branch.as_deref()) {
        let path = git(&["rev-parse", "--git-path", file])?;
        // Cargo would run this script each time if the file did not exist.
        if Path::new(&path).exists() {
            println!("cargo:rerun-if-changed={path}");
        }
    }
    git(&["log", "-1", "--abbrev=9", "--format=%h %cs"])
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

"""Builds wheels with maturin, and adds the `mmsim` command to them. Builds source distributions.

MMSIM_BINARY is the path of a finished binary, or MMSIM_PROFILE is the cargo profile with which the
command is built (by default `release`).
"""
import io
import json
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

import maturin

FOLDER = Path(__file__).resolve().parent
ROOT = FOLDER.parent.parent
SCRIPTS = FOLDER / "micromouse_sim.data" / "scripts"
# maturin needs the folder even if it writes only the metadata.
SCRIPTS.mkdir(parents=True, exist_ok=True)

# In a source distribution, the backend is started in the root folder.
os.chdir(FOLDER)

get_requires_for_build_wheel = maturin.get_requires_for_build_wheel
get_requires_for_build_editable = maturin.get_requires_for_build_editable
prepare_metadata_for_build_wheel = maturin.prepare_metadata_for_build_wheel
prepare_metadata_for_build_editable = maturin.prepare_metadata_for_build_editable


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    add_command()
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    add_command()
    return maturin.build_editable(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory, config_settings=None):
    """Packs all files of the checkout: the wheel contains the command, and Cargo needs all members
    of the workspace."""
    with tempfile.TemporaryDirectory() as folder:
        stem = maturin.prepare_metadata_for_build_wheel(folder)[: -len(".dist-info")]
        metadata = Path(folder, f"{stem}.dist-info", "METADATA").read_bytes()
    project = Path("pyproject.toml").read_text().replace('["."]', '["crates/python"]')
    commit = {"git": {"sha1": git("rev-parse", "HEAD").strip()}}
    added = {
        "PKG-INFO": metadata,
        "pyproject.toml": project.encode(),
        # `mmsim --version` prints the commit.
        "crates/cli/.cargo_vcs_info.json": json.dumps(commit).encode(),
    }
    name = f"{stem}.tar.gz"
    with tarfile.open(Path(sdist_directory, name), "w:gz") as sdist:
        for path in git("ls-files", "-z").split("\0")[:-1]:
            sdist.add(ROOT / path, f"{stem}/{path}")
        for path, content in added.items():
            file = tarfile.TarInfo(f"{stem}/{path}")
            file.size = len(content)
            sdist.addfile(file, io.BytesIO(content))
    return name


def git(*arguments):
    """Runs git in the root folder and returns its stdout."""
    command = ["git", *arguments]
    return subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, check=True, text=True).stdout


def add_command():
    """Copies the `mmsim` command to the folder from which maturin packs it."""
    binary = Path(os.environ.get("MMSIM_BINARY") or build_command())
    if not binary.is_file():
        sys.exit(f"MMSIM_BINARY: no such file: {binary}")
    # A binary for Windows may be packed on Linux, so the name comes from the binary.
    shutil.rmtree(SCRIPTS, ignore_errors=True)
    SCRIPTS.mkdir(parents=True)
    shutil.copy(binary, SCRIPTS / f"mmsim{binary.suffix}")


def build_command():
    """Builds the `mmsim` command and returns the path of the binary."""
    profile = os.environ.get("MMSIM_PROFILE") or "release"
    cargo = os.environ.get("CARGO") or "cargo"
    command = [cargo, "build", "--package=mmsim", "--bin=mmsim", f"--profile={profile}"]
    command += ["--locked", "--message-format=json-render-diagnostics"]
    build = subprocess.run(command, cwd=FOLDER, stdout=subprocess.PIPE, check=True)
    messages = map(json.loads, build.stdout.splitlines())
    return next(filter(None, (message.get("executable") for message in messages)))

"""Build backend: maturin, after cargo has built the command line and the model's library, which the wheel has as its data."""

import os
import shutil
import subprocess
from pathlib import Path

import maturin

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
BUILT = HERE / "poropunch" / "built"

get_requires_for_build_wheel = maturin.get_requires_for_build_wheel
get_requires_for_build_editable = maturin.get_requires_for_build_editable
prepare_metadata_for_build_wheel = maturin.prepare_metadata_for_build_wheel
prepare_metadata_for_build_editable = maturin.prepare_metadata_for_build_editable


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    bundle(BUILT)
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    bundle(BUILT)
    return maturin.build_editable(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory, config_settings=None):
    raise RuntimeError("poropunch has no source distribution: its wheel is built in the repository, `pip wheel ./runner/python`")


def bundle(built: Path) -> None:
    """Puts program, library and FMU into `built`."""
    if shutil.which("cargo") is None:
        raise RuntimeError("building poropunch needs Rust: https://www.rust-lang.org/tools/install")
    # The extension module is named, too, so that its features hold and maturin finds all but the module itself compiled.
    packages = ["--package=runner", "--package=poropunch-python"]
    subprocess.run(["cargo", "build", "--release", *packages, "--bin=runner"], cwd=ROOT, check=True)
    release = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
    shutil.rmtree(built, ignore_errors=True)
    built.mkdir(parents=True)
    shutil.copy(release / "deps" / "libporopunch_fmi.so", built)
    shutil.copy(release / "runner", built)
    # A sixth of the size is names of functions. Every C compiler, which cargo needs, comes with `strip`.
    if strip := shutil.which("strip"):
        subprocess.run([strip, built / "runner"], check=True)
    subprocess.run([built / "runner", "package", "--out", built / "poropunch.fmu"], check=True, stdout=subprocess.DEVNULL)

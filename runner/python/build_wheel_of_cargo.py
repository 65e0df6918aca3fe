"""Build backend: maturin, after cargo has built the command line and the model's library, which the wheel has as its data.

With POROPUNCH_MANYLINUX=1 in the environment the wheel is for every Linux on x86-64 with a glibc from 2.17 on (manylinux2014): zig
links it. Otherwise it is for machines like this one.
"""

import os
import shutil
import subprocess
from pathlib import Path

import maturin

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
BUILT = HERE / "poropunch" / "built"

#: Oldest glibc of manylinux2014, and what such a wheel is built for.
GLIBC = "2.17"
TARGET = "x86_64-unknown-linux-gnu"
MANYLINUX = os.environ.get("POROPUNCH_MANYLINUX", "") not in ("", "0")

get_requires_for_build_editable = maturin.get_requires_for_build_editable
prepare_metadata_for_build_wheel = maturin.prepare_metadata_for_build_wheel
prepare_metadata_for_build_editable = maturin.prepare_metadata_for_build_editable


def get_requires_for_build_wheel(config_settings=None):
    needed = maturin.get_requires_for_build_wheel(config_settings)
    # The versions of cdylib/build-all.
    return [*needed, "ziglang==0.17.1", "cargo-zigbuild==0.24.0"] if MANYLINUX else needed


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    if MANYLINUX:
        # As in cdylib/build-all: what panics say names the sources, not where they lie on this machine.
        cargo_home = os.environ.get("CARGO_HOME", Path.home() / ".cargo")
        os.environ["RUSTFLAGS"] = f"--remap-path-prefix={ROOT}=/poropunch --remap-path-prefix={cargo_home}=/cargo"
        os.environ["MATURIN_PEP517_ARGS"] = f"--target {TARGET} --zig --compatibility manylinux2014"
    bundle(BUILT, MANYLINUX)
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    bundle(BUILT, manylinux=False)
    return maturin.build_editable(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory, config_settings=None):
    raise RuntimeError("poropunch has no source distribution: its wheel is built in the repository, `pip wheel ./runner/python`")


def bundle(built: Path, manylinux: bool) -> None:
    """Puts program, library and FMU into `built`."""
    if shutil.which("cargo") is None:
        raise RuntimeError("building poropunch needs Rust: https://www.rust-lang.org/tools/install")
    # The extension module is named, too, so that its features hold and maturin finds all but the module itself compiled.
    packages = ["--package=runner", "--package=poropunch-python"]
    build = ["zigbuild", f"--target={TARGET}.{GLIBC}"] if manylinux else ["build"]
    subprocess.run(["cargo", *build, "--release", *packages, "--bin=runner"], cwd=ROOT, check=True)
    release = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / (TARGET if manylinux else "") / "release"
    shutil.rmtree(built, ignore_errors=True)
    built.mkdir(parents=True)
    shutil.copy(release / "deps" / "libporopunch_fmi.so", built)
    shutil.copy(release / "runner", built)
    # A sixth of the size is names of functions. Every C compiler, which cargo needs, comes with `strip`.
    if strip := shutil.which("strip"):
        subprocess.run([strip, built / "runner"], check=True)
    subprocess.run([built / "runner", "package", "--out", built / "poropunch.fmu"], check=True, stdout=subprocess.DEVNULL)

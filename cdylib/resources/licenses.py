#!/usr/bin/env python3
"""Writes licenses.txt beside it: the licences of all crates that are linked into the FMU's library.

Run it after a change of dependencies: python3 cdylib/resources/licenses.py
"""

import json
import pathlib
import subprocess

HERE = pathlib.Path(__file__).parent
#: What cdylib/build-all builds for; other systems link other crates.
TARGETS = ["x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu", "x86_64-pc-windows-gnullvm", "x86_64-apple-darwin", "aarch64-apple-darwin"]


def cargo(*arguments):
    return subprocess.run(["cargo", *arguments], cwd=HERE, check=True, capture_output=True, text=True).stdout


def linked():
    """Names and versions; procedural macros run at build time and are not linked."""
    of_package = ["tree", "-p", "poropunch-cdylib", "-e", "normal,no-proc-macro", "--prefix", "none", "--format", "{p}"]
    trees = "\n".join(cargo(*of_package, "--target", target) for target in TARGETS)
    crates = {tuple(line.split()[:2]) for line in trees.splitlines() if line.strip()}
    return sorted((name, version[1:]) for name, version in crates if not name.startswith("poropunch"))


def texts(package):
    """The licence texts of a crate; of several to choose from, MIT where it is one."""
    folder = pathlib.Path(package["manifest_path"]).parent
    files = sorted(f for f in folder.iterdir() if f.is_file() and f.name.upper().startswith(("LICENSE", "LICENCE", "COPYING", "NOTICE")))
    chosen = [f for f in files if "MIT" in f.name.upper()] if " OR " in package["license"] or "/" in package["license"] else []
    return [f.read_text(errors="replace").strip() for f in chosen or files]


def main():
    packages = {(p["name"], p["version"]): p for p in json.loads(cargo("metadata", "--format-version", "1"))["packages"]}
    crates = linked()
    lines = ["Crates linked into this library, with their licences; the texts follow, each once. Rust's standard library is",
             "licensed under MIT OR Apache-2.0, LLVM's compiler-rt and libunwind under Apache-2.0 WITH LLVM-exception; the library for",
             "Windows has parts of MinGW-w64, whose licence is the last."]
    lines += ["", *(f"{name} {version}: {packages[name, version]['license']}" for name, version in crates)]
    by_text = {}
    for crate in crates:
        for text in texts(packages[crate]) or [f"(no text in the package) {packages[crate]['license']}: {', '.join(packages[crate]['authors'])}"]:
            by_text.setdefault(" ".join(text.split()), (text, []))[1].append(f"{crate[0]} {crate[1]}")
    for text, names in by_text.values():
        lines += ["", "-" * 80, ", ".join(names), "", text]
    # Zig's copy, lib/libc/mingw/COPYING.
    lines += ["", "-" * 80, "MinGW-w64", "", (HERE / "mingw-w64.txt").read_text().strip()]
    (HERE / "licenses.txt").write_text("\n".join(lines) + "\n")


main()

#!/usr/bin/env python3
"""What the constants that decide an answer move: every case is diagnosed with each of them halved and doubled.

    tests/thresholds/study.py OUT CASE...      CASE: a folder with P1.csv and P2.csv

Answers are kept in OUT, runs in OUT/cache, so that it goes on where it was stopped. Prints a table for runner/src/diagnosis/README.md.
"""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
RUNNER = os.environ.get("RUNNER", str(HERE.parents[1] / "target/release/runner"))
SOURCE = HERE.parents[1] / "runner/src/diagnosis/thresholds.rs"


def constants():
    """Names and values, from where they stand."""
    defaults = SOURCE.read_text().split("fn default()")[1].split("impl Thresholds")[0]
    return [(name, float(value)) for name, value in re.findall(r"(\w+): ([0-9.e-]+),", defaults)]


def answer(out, case, change):
    """Kind and effects, confidence, part of the gap that goes."""
    folder = out / f"{case.parent.name}.{case.name}" / (change or "as it is").replace("=", "_")
    file = folder / "diagnosis.json"
    if not file.exists():
        command = [RUNNER, "diagnose", case / "P1.csv", case / "P2.csv", "--mesh", "coarse", "--quick", "--out", folder]
        command += ["--cache", out / "cache", *(["--threshold", change] if change else [])]
        subprocess.run([*map(str, command), "--progress", "none"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    found = json.loads(file.read_text())
    verdict, shrinkage = found["verdict"], (found["shrinkage"] or {}).get("value")
    said = verdict["kind"] + (": " + ", ".join(verdict["effects"]) if verdict["effects"] else "")
    return said, verdict["confidence"], shrinkage


def main():
    out, cases = Path(sys.argv[1]), [Path(case).resolve() for case in sys.argv[2:]]
    base = {case: answer(out, case, "") for case in cases}
    print("| constant | value | halved | doubled |\n|---|---|---|---|")
    for name, value in constants():
        cells = []
        for factor in (0.5, 2.0):
            changed = min(value * factor, 0.999) if value < 1 else value * factor
            told, widest = [], 0.0
            for case in cases:
                said, confidence, shrinkage = answer(out, case, f"{name}={changed:g}")
                before, sure, part = base[case]
                if said != before:
                    told.append(f"{case.name}: {said} (was {before})")
                elif (shrinkage is None) != (part is None):
                    told.append(f"{case.name}: part removed {'not ' if shrinkage is None else ''}told")
                widest = max(widest, abs(confidence - sure))
            cells.append("; ".join(told or ["no answer"]) + f"; confidence by up to {widest:.2f}")
        print(f"| `{name}` | {value:g} | {cells[0]} | {cells[1]} |", flush=True)


main()

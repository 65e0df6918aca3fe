"""Writes reference.csv, what the default run of the FMU gives in FMPy (SI units): the archive holds it for importers to check
themselves with. A test says when it is stale.

    target/release/runner package --out poropunch.fmu && .venv/bin/python cdylib/resources/reference.py poropunch.fmu
"""

import sys
from pathlib import Path

from fmpy import simulate_fmu

OUTPUTS = ["punch_displacement", "force", "force_solid", "force_fluid"]

table = simulate_fmu(sys.argv[1], output=OUTPUTS)
lines = [",".join(["time", *OUTPUTS])] + [",".join(f"{float(value):.9g}" for value in row) for row in table]
Path(__file__).with_suffix(".csv").write_text("\n".join(lines) + "\n", encoding="utf-8")

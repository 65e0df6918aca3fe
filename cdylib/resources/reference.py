"""Writes reference.csv, what the default run of the FMU gives in FMPy (SI units): the archive holds it for importers to check
themselves with. A test says when it is stale.

    target/release/runner package --out poropunch.fmu && .venv/bin/python cdylib/resources/reference.py poropunch.fmu
"""

import sys
from pathlib import Path

from fmpy import read_model_description, simulate_fmu

OUTPUTS = ["punch_displacement", "force", "force_solid", "force_fluid"]

# FMPy itself would take longer steps, to have no more than a thousand rows.
step = float(read_model_description(sys.argv[1]).defaultExperiment.stepSize)
table = simulate_fmu(sys.argv[1], output=OUTPUTS, output_interval=step)
# The table's own columns are in the description's order.
columns = ["time", *OUTPUTS]
lines = [",".join(columns)] + [",".join(f"{float(row[name]):.9g}" for name in columns) for row in table]
Path(__file__).with_suffix(".csv").write_text("\n".join(lines) + "\n", encoding="utf-8")

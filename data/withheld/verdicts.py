"""Table of the verdicts from the reports: python3 data/withheld/verdicts.py"""

import csv
import json
import pathlib

here = pathlib.Path(__file__).parent
with open(here / "verdicts.csv", "w", newline="") as file:
    table = csv.writer(file, lineterminator="\n")
    table.writerow(
        ["case", "verdict", "effects", "confidence", "shrinkage", "shrinkage_lower", "shrinkage_upper", "of"]
    )
    for report in sorted((here / "reports").glob("*.json")):
        found = json.loads(report.read_text())
        verdict, shrinkage = found["verdict"], found["shrinkage"] or {}
        value, interval = shrinkage.get("value"), shrinkage.get("interval")
        shown = [f"{x:.2f}" for x in ([value] + interval if value is not None and interval else [])]
        row = [report.stem, verdict["kind"], "; ".join(verdict["effects"]), f"{verdict['confidence']:.2f}"]
        table.writerow(row + (shown or ["undefined", "", ""]) + [shrinkage.get("of", "")])

"""A made population of two groups, and whether a study finds it again.

    make.py make OUT [SPECIMENS]    simulates the specimens, writes OUT/specimens.csv, their measurements and OUT/truth.json
    make.py check OUT               compares OUT/study/gathered/population.json with what was drawn

One cycle of P2 at `coarse`, white noise of 0.02 mN. Every specimen has its own moduli and times, log-normal about Table 1's; the
moduli of the second group are 1.35 times larger.
"""

import csv
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
RUNNER = os.environ.get("RUNNER") or shutil.which("poropunch") or str(ROOT / "target/release/runner")
MOTION = ROOT / "data/measurement/table1-one-cycle/P2.csv"
NOISE_MN = 0.02
RATIO = 1.35
GROUPS = ["young", "old"]
# Table 1: G = mu alpha / 2 (Pa), tau = eta / G (s).
ALPHA = {"G_inf": -2.16, "G_1": -13.5, "G_2": -2.97}
MEAN = {"G_inf": 217 * 2.16 / 2, "G_1": 418 * 13.5 / 2, "G_2": 161 * 2.97 / 2}
ETA = {"tau_1": 50.6, "tau_2": 4680.0}
MEAN |= {"tau_1": ETA["tau_1"] / MEAN["G_1"], "tau_2": ETA["tau_2"] / MEAN["G_2"]}
# Standard deviation of ln(value) between specimens.
SPREAD = {"G_inf": 0.2, "G_1": 0.2, "G_2": 0.2, "tau_1": 0.1, "tau_2": 0.1}


def draw(count):
    rng = np.random.default_rng(20261123)
    for k in range(count):
        group = GROUPS[k % 2]
        ratio = RATIO if group == "old" else 1.0
        yield group, {
            name: mean * np.exp(SPREAD[name] * rng.standard_normal()) * (ratio if name[0] == "G" else 1.0)
            for name, mean in MEAN.items()
        }


def make(out, count):
    out.mkdir(parents=True)
    specimens = list(draw(count))
    rows = []
    for _, v in specimens:
        mu = {name: 2 * v[name] / alpha for name, alpha in ALPHA.items()}
        rows.append([mu["G_inf"], mu["G_1"], mu["G_2"], v["tau_1"] * v["G_1"], v["tau_2"] * v["G_2"]])
    names = ["equilibrium.mu [Pa]", "branch[1].mu [Pa]", "branch[2].mu [Pa]"]
    names += ["branch[1].eta [Pa s]", "branch[2].eta [Pa s]"]
    with open(out / "sets.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow([f"material.{name}" for name in names])
        writer.writerows(rows)
    command = [RUNNER, "batch", str(out / "sets.csv"), "--protocol", str(MOTION), "--mesh", "coarse", "--out", str(out / "runs")]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    rng = np.random.default_rng(7)
    table = [["specimen", "files", "group"]]
    for k, (group, _) in enumerate(specimens):
        with open(out / "runs" / f"{k + 1:04}.csv") as file:
            lines = csv.DictReader(line for line in file if not line.startswith("#"))
            curve = [[float(line[c]) for c in ("time_s", "displacement_mm", "force_mN")] for line in lines]
        with open(out / f"s{k + 1:04}.csv", "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["time_s", "displacement_mm", "force_mN"])
            writer.writerows([t, d, f"{f + NOISE_MN * rng.standard_normal():.5f}"] for t, d, f in curve)
        table.append([f"s{k + 1:04}", f"s{k + 1:04}.csv", group])
    with open(out / "specimens.csv", "w", newline="") as file:
        csv.writer(file).writerows(table)
    (out / "truth.json").write_text(json.dumps([{"group": group, **values} for group, values in specimens]))


def check(out):
    truth = json.loads((out / "truth.json").read_text())
    report = json.loads((out / "study/gathered/population.json").read_text())
    found = {value["symbol"]: value for value in report["values"]}
    held = []

    def compare(what, put_in, interval):
        inside = interval["lower"] <= put_in <= interval["upper"]
        held.append(inside)
        numbers = [f"{interval[key]:.4g}" for key in ("value", "lower", "upper")]
        print(f"{what:22} {put_in:10.4g}   {numbers[0]:>8} [{numbers[1]}, {numbers[2]}]{'' if inside else '   OUTSIDE'}")

    print(f"{report['done']} of {report['units']} specimens   put in   found [95 %]")
    for symbol in MEAN:
        if symbol not in found:
            print(f"{symbol:22} not determined by most specimens")
            held.append(False)
            continue
        value = found[symbol]
        unit = 1e-3 if value["unit"] == "ms" else 1.0
        for group in value["groups"]:
            put_in = MEAN[symbol] * (RATIO if group["group"] == "old" and symbol[0] == "G" else 1.0)
            compare(f"{symbol}, {group['group']}", put_in / unit, group["mean"])
        compare(f"{symbol}, spread", SPREAD[symbol], value["spread"])
        compare(f"{symbol}, old / young", RATIO if symbol[0] == "G" else 1.0, value["differences"][0]["ratio"])
    print(f"{sum(held)} of {len(held)} inside")
    drawn = {s: np.std([np.log(t[s]) for t in truth if t["group"] == "young"], ddof=1) for s in MEAN}
    print("drawn spread of the first group:", {s: round(float(d), 3) for s, d in drawn.items()})


if __name__ == "__main__":
    folder = Path(sys.argv[2])
    if sys.argv[1] == "make":
        make(folder, int(sys.argv[3]) if len(sys.argv) > 3 else 300)
    else:
        check(folder)

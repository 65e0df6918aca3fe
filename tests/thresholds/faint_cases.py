"""Sixty cases of one cycle with a faint effect each, for `next_experiments`: P1 and P2 by poropunch at `standard`, with noise.

    .venv/bin/python tests/thresholds/faint_cases.py OUT MOTIONS     MOTIONS: a folder with P1.csv and P2.csv, whose motions are used (data/practice/lag)

OUT/truth.txt says what was put in.
"""

import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
RUNNER = os.environ.get("RUNNER", str(ROOT / "target/release/runner"))
VARIED = ["equilibrium.mu", "branch[1].mu", "branch[2].mu", "branch[1].eta", "branch[2].eta", "permeability"]
UNITS = {".mu": "Pa", ".eta": "Pa*s", "permeability": "m^2", ".delay": "s", "sample_radius": "m", "sample_height": "m"}
KINDS = ["drift"] * 16 + ["ageing"] * 16 + ["slow"] * 10 + ["delayed"] * 8 + ["size"] * 6 + ["immediate"] * 4


def start_values():
    reals = ((v.get("name"), v.find("Real")) for v in ElementTree.parse(ROOT / "modelDescription.xml").iter("ScalarVariable"))
    return {name: float(real.get("start")) for name, real in reals if real is not None and real.get("start")}


def settings(kind, rng):
    """The FMU's parameters of an effect; drifts are added to the force."""
    if kind == "slow":
        mu = -40 * rng.uniform(1, 4)
        return {"material.branch[3].mu": mu, "material.branch[3].eta": abs(mu) * 300 * rng.uniform(0.5, 2)}
    if kind in ("delayed", "immediate"):
        found = {"effect.softening.loss": rng.uniform(0.2, 0.5), "effect.softening.strain": rng.uniform(0.1, 0.4)}
        return {**found, "effect.softening.delay": rng.uniform(10, 40)} if kind == "delayed" else found
    if kind == "size":
        length = 0.01 * np.exp(rng.choice([-0.5, 0.8]) * rng.uniform(0.6, 1.2))
        return {"geometry.sample_radius": length, "geometry.sample_height": length}
    return {}


def force(motion, values, out):
    """mN at the times of a motion."""
    unit = lambda name: next((u for end, u in UNITS.items() if name.endswith(end)), "")
    given = [x for name, value in values.items() for x in ("--set", f"{name}={float(value)!r}{unit(name)}")]
    command = [RUNNER, "simulate", motion, "--out", out / "run", "--mesh", "standard", "--progress", "none", *given]
    subprocess.run([str(x) for x in command], check=True, capture_output=True)
    lines = [line for line in (out / "run.csv").read_text().splitlines() if not line.startswith("#")]
    column = next(i for i, name in enumerate(lines[0].split(",")) if name.startswith("force"))
    for end in (".csv", ".svg"):
        (out / f"run{end}").unlink(missing_ok=True)
    return np.array([float(line.split(",")[column]) for line in lines[1:]])


def main(out, motions):
    rng, start = np.random.default_rng(20261129), start_values()
    out.mkdir(parents=True)
    points = {}
    for test in ("P1", "P2"):
        lines = [line for line in (motions / f"{test}.csv").read_text().splitlines() if not line.startswith("#")][1:]
        points[test] = np.array([[float(x) for x in line.split(",")[:2]] for line in lines])
        rows = "".join(f"{t:.4f},{d:.4f}\n" for t, d in points[test])
        (out / f"{test}.csv").write_text("time_s,displacement_mm\n" + rows)
    for kind in KINDS:
        values = {f"material.{k}": start[f"material.{k}"] * 2 ** rng.uniform(-1, 1) for k in VARIED}
        values |= settings(kind, rng)
        size = rng.uniform(0.04, 0.12) * rng.choice([-1, 1])
        time_s, white = rng.uniform(100, 500), rng.uniform(0.05, 0.15)
        count, is_same, scatter = int(rng.integers(4, 9)), rng.random() < 0.5, rng.uniform(0.06, 0.15)
        heights = np.exp(scatter * rng.normal(size=count))
        folder = out / f"{rng.integers(2**32):08x}"
        folder.mkdir()
        for test, motion in points.items():
            f = force(out / f"{test}.csv", values, out)
            grown = 1 - np.exp(-motion[:, 0] / time_s)
            grown /= grown[-1]
            if not is_same:
                heights = np.exp(scatter * rng.normal(size=count))
            # Two for a drift: the cases in the docs were drawn so.
            drawn = [rng.normal(size=(len(f), count)) for _ in range(2 if kind == "drift" else 1)]
            f = f * (1 + 2 * size * grown) if kind == "ageing" else f
            f = f + size * f.max() * grown if kind == "drift" else f
            drift = size * f.max() * grown if kind == "drift" else np.zeros(len(f))
            specimens = np.outer(f - drift, heights) + drift[:, None] + white * f.max() / 11 * drawn[-1]
            head = "# synthetic\ntime_s,displacement_mm,force_mN," + ",".join(f"s{k + 1:02d}" for k in range(count)) + "\n"
            row = lambda i: ",".join(f"{x:.4f}" for x in (*motion[i], specimens[i].mean(), *specimens[i])) + "\n"
            (folder / f"{test}.csv").write_text(head + "".join(map(row, range(len(f)))))
        with (out / "truth.txt").open("a") as truth:
            truth.write(f"{folder.name} {kind} {size:.3f} {time_s:.0f}\n")


main(Path(sys.argv[1]), Path(sys.argv[2]))

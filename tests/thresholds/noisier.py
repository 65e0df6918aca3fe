"""The tests of a case with more white noise, for `next_experiments`: what was told apart may look the same then.

    .venv/bin/python tests/thresholds/noisier.py FACTOR OUT FOLDER ...     FOLDER: P1.csv and P2.csv with specimens; OUT/<its name> has FACTOR times their noise
"""

import sys
from pathlib import Path

import numpy as np


def noisier(path, factor, rng):
    """Lines of a file whose specimens, and their mean, have `factor` times the white noise."""
    lines = path.read_text().splitlines()
    comments, (header, *rows) = [x for x in lines if x.startswith("#")], [x for x in lines if not x.startswith("#")]
    values = np.array([[float(x) for x in row.split(",")] for row in rows])
    force, specimens = values[:, 2:3], values[:, 3:]
    # Second differences of neighbours have six times the variance of white noise; their median knows nothing of kinks.
    size = np.median(np.abs(np.diff(specimens, 2, axis=0)), axis=0) / (0.6745 * np.sqrt(6.0))
    added = np.sqrt(factor**2 - 1.0) * size * rng.standard_normal(specimens.shape)
    values[:, 2:3], values[:, 3:] = force + added.mean(axis=1, keepdims=True), specimens + added
    return comments + [header] + [",".join(f"{x:.4f}" for x in row) for row in values]


def main(factor, out, folders):
    rng = np.random.default_rng(20261129)
    for folder in map(Path, folders):
        (out / folder.name).mkdir(parents=True)
        for test in ("P1.csv", "P2.csv"):
            (out / folder.name / test).write_text("\n".join(noisier(folder / test, factor, rng)) + "\n")


main(float(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:])

"""Measurements: files as they are, tables and arrays as files of the project's format."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

import numpy as np

if TYPE_CHECKING:
    import pandas

    from ._simulation import Array

    #: A path; a table with the columns time_s, displacement_mm, force_mN (or others that the reader understands); an array of shape
    #: (n, 3) or three of shape (n,): time (s), displacement (mm), force (mN).
    Measurement = Union[str, os.PathLike[str], pandas.DataFrame, Array, tuple[Array, Array, Array]]
    #: One, several, or several by name.
    Measurements = Union[Measurement, list[Measurement], Mapping[str, Measurement]]

_HEADER = "time_s,displacement_mm,force_mN"


def words(measurements: Measurements, folder: Path) -> list[str]:
    """What the command line reads; tables and arrays are written to `folder`.

    >>> words(["P1.csv", Path("runs") / "P2.csv"], Path())
    ['P1.csv', 'runs/P2.csv']
    >>> words({"P2": "runs/P2_*.csv"}, Path())
    ['P2=runs/P2_*.csv']
    """
    if isinstance(measurements, Mapping):
        return [_word(one, folder, name) for name, one in measurements.items()]
    if not isinstance(measurements, list):
        return [_word(measurements, folder, "measurement", is_named=False)]
    if len(measurements) == 1:
        return words(measurements[0], folder)
    names = (f"measurement{number}" for number in range(1, len(measurements) + 1))
    return [_word(one, folder, name, is_named=False) for one, name in zip(measurements, names)]


def _word(one: Any, folder: Path, name: str, is_named: bool = True) -> str:
    if isinstance(one, (str, os.PathLike)):
        path = os.fspath(one)
        return f"{name}={path}" if is_named else path
    file = folder / f"{name}.csv"
    if file.exists() or Path(name).name != name:
        raise ValueError(f"measurements: `{name}` cannot be the name of a test; give another one")
    if hasattr(one, "to_csv"):
        one.to_csv(file, index=False)
        return str(file)
    try:
        rows = np.column_stack(one) if isinstance(one, tuple) else np.asarray(one, dtype=float)
    except (TypeError, ValueError) as error:
        raise ValueError(f"measurements: `{name}` is neither path, table nor arrays of equal length: {error}") from error
    if rows.ndim != 2 or rows.shape[1] != 3:
        shape = f"measurements: `{name}` has the shape {rows.shape}"
        raise ValueError(f"{shape}; give (n, 3): time (s), displacement (mm), force (mN)")
    np.savetxt(file, rows, fmt="%.17g", delimiter=",", header=_HEADER, comments="")
    return str(file)


def options(values: Mapping[str, Any], folder: Path) -> Iterable[str]:
    """Options that hold measurements, written as those."""
    for name, value in values.items():
        if value is not None and (not isinstance(value, (list, Mapping)) or len(value) > 0):
            yield f"--{name}"
            yield from words(value, folder)

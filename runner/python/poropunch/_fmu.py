"""The FMU."""

from pathlib import Path

from ._place import FMU


def fmu_path() -> Path:
    """Path of the FMU (FMI 2.0 co-simulation), for FMPy and every other importer.

    >>> fmu_path().name
    'poropunch.fmu'
    """
    return Path(FMU)

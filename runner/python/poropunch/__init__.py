"""Nonlinear poro-viscoelastic indentation: simulate it, identify its parameters, diagnose what the best fit misses.

>>> import poropunch
>>> time_s, displacement_mm = poropunch.protocol("P2", points=40)
>>> run = poropunch.simulate(time_s, displacement_mm, {"mesh.preset": "coarse"})
>>> print(f"{run.force_mn.max():.1f} mN")
12.0 mN

SI units inside; the names of what crosses a boundary tell other units (`force_mn`, `time_s`). Displacement and force are positive
into the sample.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._commands import Diagnosis, Identification, Inspection, diagnose, identify, inspect
    from ._fmu import fmu_path
    from ._program import PoropunchWarning
    from ._simulation import Parameter, Simulation, parameters, protocol, simulate

    __version__: str

__all__ = [
    "Diagnosis",
    "Identification",
    "Inspection",
    "Parameter",
    "PoropunchWarning",
    "Simulation",
    "diagnose",
    "fmu_path",
    "identify",
    "inspect",
    "parameters",
    "protocol",
    "simulate",
]

_MODULES = {
    "_commands": ["Diagnosis", "Identification", "Inspection", "diagnose", "identify", "inspect"],
    "_fmu": ["fmu_path"],
    "_program": ["PoropunchWarning"],
    "_simulation": ["Parameter", "Simulation", "parameters", "protocol", "simulate"],
}


def __getattr__(name: str) -> Any:
    # Loaded when first used: the command `poropunch` is in this package, too, and shall start at once.
    if name == "__version__":
        from importlib.metadata import version

        return version("poropunch")
    for module, names in _MODULES.items():
        if name in names:
            return getattr(importlib.import_module(f".{module}", __name__), name)
    raise AttributeError(f"module 'poropunch' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])

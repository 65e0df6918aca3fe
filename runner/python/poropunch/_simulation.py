"""One run of the model, in this process."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _native
from ._place import LIBRARY

if TYPE_CHECKING:
    import pandas

Array = npt.NDArray[np.float64]

_PREFIX = "sensitivity.force."


@dataclass(frozen=True)
class Parameter:
    """A parameter of the model."""

    name: str
    """Its name, the same in the FMU, on the command line and in files."""
    unit: Optional[str]
    """SI unit; None unless it is a real number."""
    start: float
    """Value unless another one is given (SI; the number of an item counts from 1)."""
    min: Optional[float]
    """Smallest admissible value (SI)."""
    max: Optional[float]
    """Largest admissible value (SI)."""
    items: list[str] = field(default_factory=list)
    """What there is to choose from, where it is a choice."""
    description: str = ""
    """What it is."""


@lru_cache(maxsize=1)
def parameters() -> dict[str, Parameter]:
    """Every parameter of the model by its name.

    >>> p = parameters()["material.permeability"]
    >>> p.start, p.unit
    (2.3e-15, 'm^2')
    """
    return {row[0]: Parameter(*row) for row in _native.parameters()}


@dataclass(frozen=True)
class Simulation:
    """A force curve. All arrays are of shape (n,), n the number of times."""

    time_s: Array
    """Times (s)."""
    displacement_mm: Array
    """Displacement of the punch as it was simulated, positive into the sample (mm)."""
    force_mn: Array
    """What the load cell reads (mN)."""
    force_solid_mn: Array
    """Solid part of the force on the specimen (mN)."""
    force_fluid_mn: Array
    """Fluid part: integral of the pore pressure over the contact (mN)."""
    force_sensitivities_mn: dict[str, Array]
    """Derivative of the force by each parameter that was asked for (mN per SI unit of the parameter)."""
    outputs: dict[str, Array]
    """Outputs named by `record` (SI units)."""

    def jacobian_mn(self) -> Array:
        """Derivatives as a matrix of shape (n, k), a column for each of the k `sensitivities` (mN per SI unit)."""
        columns = list(self.force_sensitivities_mn.values())
        return np.column_stack(columns) if columns else np.empty((len(self.time_s), 0))

    def to_frame(self) -> pandas.DataFrame:
        """The curve as a pandas table that `identify` reads as it is: one row per time, units in the names."""
        import pandas

        names = ["time_s", "displacement_mm", "force_mN", "force_solid_mN", "force_fluid_mN"]
        arrays = [self.time_s, self.displacement_mm, self.force_mn, self.force_solid_mn, self.force_fluid_mn]
        return pandas.DataFrame(dict(zip(names, arrays)))


def protocol(name: str, cycles: Optional[int] = None, points: int = 300) -> tuple[Array, Array]:
    """Times (s) and displacements (mm) of the paper's protocols, each of shape (n,).

    `name` is "P1" or "P2"; `cycles` the number of complete cycles, or None for the first one to the end of the hold; `points` about
    how many times are wanted: the corners are among them, and rests are sampled ever wider apart.

    Raises ValueError for other names or numbers.

    >>> time_s, displacement_mm = protocol("P2", points=40)
    >>> float(displacement_mm[0]), float(displacement_mm.max())
    (-0.1, 1.0)
    """
    time_s, displacement_mm = _native.protocol(name, cycles, points)
    return time_s, displacement_mm


def simulate(
    time_s: npt.ArrayLike,
    displacement_mm: npt.ArrayLike,
    parameters: Optional[Mapping[str, Union[float, bool, str]]] = None,
    *,
    sensitivities: Sequence[str] = (),
    record: Sequence[str] = (),
    mesh: Optional[str] = None,
    exact_motion: bool = False,
) -> Simulation:
    """Force of the punch that follows a motion.

    - `time_s`, `displacement_mm`: samples of the motion, shapes (n,); times increase, the displacement is positive into the sample, 0
      at its undeformed surface, and not positive at the first time.
    - `parameters`: values by the FMI names (`poropunch.parameters()` has all): numbers in SI units, or texts with a unit.
    - `sensitivities`: names of material parameters by which the force is differentiated, exactly.
    - `record`: further outputs, e.g. "stored_energy", in SI units.
    - `mesh`: "coarse", "standard" or "fine", in the place of the parameter mesh.preset.
    - `exact_motion`: whether the punch goes straight from sample to sample. By default it goes along the few straight pieces that the
      samples are within their own noise, as on the command line: that costs less, and noise is no motion.

    Runs in this process and lets other threads run meanwhile: a thread pool uses all cores. Ctrl-C stops it.

    Raises ValueError for values, names or samples that cannot be used, RuntimeError where the model cannot make a step.

    >>> time_s, displacement_mm = protocol("P2", points=40)
    >>> softer = {"mesh.preset": "coarse", "material.permeability": "1e-8 mm^2", "geometry.sample_height": 12e-3}
    >>> run = simulate(time_s, displacement_mm, softer, sensitivities=["material.equilibrium.mu"])
    >>> run.force_mn.shape == time_s.shape
    True
    >>> bool(run.force_sensitivities_mn["material.equilibrium.mu"][-1] < 0)  # mu is negative: nearer to 0 is softer
    True
    >>> simulate(time_s, displacement_mm, {"material.permeabilty": 1e-14})
    Traceback (most recent call last):
        ...
    ValueError: the FMU has no parameter `material.permeabilty`; did you mean material.permeability...
    """
    times, displacements = _samples("time_s", time_s), _samples("displacement_mm", displacement_mm)
    given: dict[str, Any] = dict(parameters or {})
    if mesh is not None:
        given["mesh.preset"] = mesh
    wanted = [_PREFIX + name for name in sensitivities]
    parts = ["force_solid", "force_fluid"]
    found = _native.simulate(LIBRARY, times, displacements, given, [*parts, *record, *wanted], exact_motion)
    return Simulation(
        time_s=times,
        displacement_mm=1e3 * found["displacement"],
        force_mn=1e3 * found["force"],
        force_solid_mn=1e3 * found["force_solid"],
        force_fluid_mn=1e3 * found["force_fluid"],
        force_sensitivities_mn={name: 1e3 * found[_PREFIX + name] for name in sensitivities},
        outputs={name: found[name] for name in record},
    )


def _samples(name: str, values: npt.ArrayLike) -> Array:
    samples = np.array(values, dtype=np.float64)
    if samples.ndim != 1:
        raise ValueError(f"{name} has the shape {samples.shape}: give one dimension, (n,)")
    return samples

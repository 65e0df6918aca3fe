"""The commands of the program, with their results as Python has them."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional, Union

from . import _data, _page, _program
from .results import diagnosis, identification, inspection
from .results._read import read

if TYPE_CHECKING:
    import os

    import pandas

    from ._data import Measurements
    from ._program import Progress

    Folder = Union[None, str, os.PathLike[str]]


@dataclass(frozen=True)
class _Answer:
    """What a command answered. In a notebook it shows the page."""

    report: Any
    """Everything, as in the file that it writes."""
    said: list[str] = field(repr=False)
    """What the program said meanwhile."""
    page: str = field(repr=False)
    """The page of the report: it needs no other file."""

    def _repr_html_(self) -> str:
        return _page.framed(self.page)


@dataclass(frozen=True)
class Identification(_Answer):
    """Identified parameters and what they are worth. In a notebook it shows the page of the report."""

    report: identification.FitReport
    """Everything, as in result.json."""

    @property
    def converged(self) -> bool:
        """Whether the fit ended because nothing better is near."""
        return self.report.fit.stop not in ("evaluation_budget", "stop_requested", "too_many_failures")

    @property
    def parameters(self) -> pandas.DataFrame:
        """The fitted parameters: one row for each, indexed by its symbol (`G_inf`, `K0`), values in the unit that the row names."""
        return _table(self.report.parameters, "symbol")

    @property
    def derived(self) -> pandas.DataFrame:
        """Quantities that follow from the parameters, such as moduli and relaxation times, indexed by their symbols."""
        return _table(self.report.derived, "symbol")

    @property
    def curves(self) -> pandas.DataFrame:
        """Measured and computed curves, one row per test and time; columns as in curves.csv."""
        import pandas

        names = {"spread_mN": "spread_mn", "sigma_mN": "sigma_mn", "measured_mN": "measured_mn", "model_mN": "model_mn",
                 "model_solid_mN": "model_solid_mn", "model_fluid_mN": "model_fluid_mn"}  # fmt: skip
        one = [
            pandas.DataFrame(
                {"measurement": m.name, "role": m.role, "time_s": m.time_s, "displacement_mm": m.displacement_mm}
                | {name: getattr(m, of) for name, of in names.items()}
            )
            for m in self.report.measurements
        ]
        return pandas.concat(one, ignore_index=True)

    def __str__(self) -> str:
        verdict = self.report.verdict
        return "\n".join([verdict.headline, *verdict.determined, *verdict.undetermined])


@dataclass(frozen=True)
class Diagnosis(_Answer):
    """Why the best fit misses the data. In a notebook it shows the page."""

    report: diagnosis.Diagnosis
    """Everything, as in diagnosis.json."""

    @property
    def effects(self) -> pandas.DataFrame:
        """The effects as screening sees them, indexed by their names, largest evidence first."""
        return _table(self.report.effects, "name")

    @property
    def models(self) -> pandas.DataFrame:
        """The models that were refitted, largest evidence first."""
        return _table(self.report.models)

    @property
    def curves(self) -> pandas.DataFrame:
        """Measured and computed curves, before and after, one row per test and time (s, mN)."""
        import pandas

        names = {"measured_mN": "measured_mn", "before_mN": "before_mn", "after_mN": "after_mn", "sigma_mN": "sigma_mn"}
        one = [
            pandas.DataFrame({"test": c.name, "time_s": c.time_s} | {name: getattr(c, of) for name, of in names.items()})
            for c in self.report.curves
        ]
        return pandas.concat(one, ignore_index=True)

    def __str__(self) -> str:
        return self.report.verdict.text


@dataclass(frozen=True)
class Inspection(_Answer):
    """What measurements say without a model. In a notebook it shows the page."""

    report: inspection.Inspection
    """Everything, as in inspection.json."""

    @property
    def cycles(self) -> pandas.DataFrame:
        """One row for each test and cycle: peaks, relaxation, times, rates; units in the names."""
        import pandas

        return pandas.json_normalize([{"test": t.name} | asdict(c) for t in self.report.tests for c in t.cycles], sep="_")

    def __str__(self) -> str:
        return "\n".join(self.said)


def identify(
    measurements: Measurements,
    *,
    validate: Optional[Measurements] = None,
    out: Folder = None,
    progress: Progress = None,
    **options: Any,
) -> Identification:
    """Material parameters from measurements.

    - `measurements`: what is fitted; `validate`: what is only predicted. Paths as on the command line; pandas tables with columns like
      time_s, displacement_mm, force_mN (force_std_mN and specimens, too); arrays of shape (n, 3); several in a list, or by name in a
      dict. Displacement and force are positive into the sample, displacement 0 at its surface.
    - `out`: directory for the page, the tables and the cache of runs; without it nothing is kept but what is returned.
    - `progress`: True for a line on standard error, or a function that is called with each event (a dict).
    - All options of `poropunch identify --help` by their names with `_` for `-`: `mesh="coarse"`, `starts=4`, `zero="contact"`,
      `profile=["G_1", "tau_2"]`, `posterior=True`, `parameters="set.ssv"`, `resume=True` with `out`. Those of the form NAME=VALUE are
      dicts, `set={"geometry.punch_radius": "2 mm"}`, as are `fix`, `start`, `bounds`: numbers are SI, texts have units, bounds are pairs
      of numbers or texts like "100:1e5Pa.s".

    Ctrl-C (in a notebook: stop) ends it; with `out`, `resume=True` goes on from there.

    Raises ValueError where options or data are refused, RuntimeError where the fit fails. Warns (`PoropunchWarning`) of what may spoil
    the result, also where it did not converge.

    >>> import poropunch
    >>> sample = {"geometry.punch_radius": "2 mm", "geometry.sample_radius": "10 mm", "geometry.sample_height": "10 mm"}
    >>> time_s, displacement_mm = poropunch.protocol("P2", points=120)
    >>> table = poropunch.simulate(time_s, displacement_mm, sample, mesh="coarse").to_frame()
    >>> found = poropunch.identify({"made up": table}, mesh="coarse", set=sample, noise="none")
    >>> found.converged
    True
    >>> round(float(found.derived.value["G_inf"]), -1)  # Pa; 234 went in
    230.0
    """
    report, said, page = _run("identify", measurements, out, progress, {"validate": validate}, options, "report.html")
    found = Identification(read(identification.FitReport, report), said, page)
    if not found.converged:
        warnings.warn(f"the fit did not converge: {found.report.fit.stop_text}", _program.PoropunchWarning, stacklevel=2)
    return found


def diagnose(
    measurements: Measurements,
    *,
    out: Folder = None,
    progress: Progress = None,
    **options: Any,
) -> Diagnosis:
    """Which unmodelled effect explains what the best fit misses.

    Arguments, warnings and errors as `identify`; other options as `poropunch diagnose --help` tells, e.g. `quick=True`,
    `mesh="coarse"`. Give all tests and cycles you have.
    """
    report, said, page = _run("diagnose", measurements, out, progress, {}, options, "diagnosis.html")
    return Diagnosis(read(diagnosis.Diagnosis, report), said, page)


def inspect(measurements: Measurements, *, out: Folder = None, **options: Any) -> Inspection:
    """What measurements say without a model: cycles, peaks, relaxation, contact, noise.

    Arguments, warnings and errors as `identify`; other options as `poropunch inspect --help` tells.

    >>> import numpy as np, poropunch
    >>> time_s = np.linspace(0, 60, 601)
    >>> displacement_mm = np.minimum(time_s - 5, 1)
    >>> force_mn = 10 * np.maximum(displacement_mm, 0) * np.exp(-np.maximum(time_s - 6, 0) / 100)
    >>> seen = poropunch.inspect((time_s, displacement_mm, force_mn))
    >>> cycle = seen.report.tests[0].cycles[0]
    >>> round(cycle.peak_mn.median, 1), round(cycle.depth_mm, 1)
    (10.0, 1.0)
    """
    report, said, page = _run("inspect", measurements, out, None, {}, options, "inspection.html")
    return Inspection(read(inspection.Inspection, report), said, page)


def _run(
    command: str,
    measurements: Measurements,
    out: Folder,
    progress: Progress,
    others: Mapping[str, Any],
    options: Mapping[str, Any],
    page: str,
) -> tuple[Any, list[str], str]:
    """What a command prints and says, and its page."""
    with tempfile.TemporaryDirectory(prefix="poropunch-") as folder:
        data = Path(folder) / "data"
        data.mkdir()
        place = Path(folder) / command if out is None else Path(out)
        words = [*_data.words(measurements, data), *_data.options(others, data), f"--out={place}", *_program.words(options)]
        report, said = _program.run(command, words, progress)
        return report, said, (place / page).read_text(encoding="utf-8")


def _table(rows: list[Any], index: Optional[str] = None) -> pandas.DataFrame:
    import pandas

    table = pandas.DataFrame([asdict(row) for row in rows])
    return table.set_index(index) if index and len(table) else table

"""Dataclasses of what `poropunch identify` finds. Written by `generate.py` from `runner/schemas`: do not edit."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, Optional

from .shared import Assumption


#: End of the admissible range at which a value sits.
BoundSide = Literal[
    'lower',  # The lower bound of the value.
    'upper',  # The upper bound of the value.
]


#: How well a value is known.
Determination = Literal[
    'determined',  # To a quarter or better.
    'loose',  # Between a quarter and a factor of three.
    'undetermined',  # Not even to a factor of three.
    'unresolved',  # Its interval holds for this division into branches only, which the data do not tell from others.
]


#: What kind of ignorance a finding states.
FindingKind = Literal[
    'invisible',  # One parameter that changes nothing in the data, by a factor of ten or more.
    'loose',  # One parameter that is known only roughly.
    'trade_off',  # Several parameters that the data know only in combination.
]


#: How a sample was made.
Method = Literal[
    'importance',  # Draws around the optimum, weighed by the density.
    'nuts',  # The No-U-Turn sampler.
]


#: What a measurement was used for.
Role = Literal[
    'fit',  # The parameters were fitted to it.
    'validation',  # The model only predicts it.
]


#: Why the iteration ended.
StopReason = Literal[
    'gradient',  # The scaled gradient is small: a stationary point.
    'chi_square_change',  # chi^2 no longer changes, and the quadratic model is trustworthy.
    'step',  # The step is small against the parameters.
    'chi_square_change_and_step',  # chi^2 and the step are both small.
    'evaluation_budget',  # The allowed number of evaluations is used up.
    'stop_requested',  # The user asked to stop.
    'too_many_failures',  # Too many evaluations in a row failed.
]


@dataclass(frozen=True)
class Correlation:
    """Correlation matrix, in the order of the parameters."""

    matrix: list[list[float]]
    """The matrix, by rows."""
    symbols: list[str]
    """Symbols of the rows and columns."""


@dataclass(frozen=True)
class DerivedRow:
    """A quantity computed from the parameters."""

    determination: Determination
    """How well it is known."""
    formula: str
    """Formula in symbols."""
    half_width: float
    """Half-width in ln(value)."""
    lower: float
    """Lower end of the 95 % interval."""
    name: str
    """Full name."""
    symbol: str
    """Symbol, plain text."""
    unit: str
    """Unit."""
    upper: float
    """Upper end of the 95 % interval."""
    value: float
    """Value."""


@dataclass(frozen=True)
class Finding:
    """One thing that the data do not determine."""

    decade_change: float
    """Change of the residuals by moving a factor of ten along the direction, rms in units of the noise."""
    direction: list[float]
    """Direction in log parameters, largest component 1, in the order of `parameters`."""
    half_width: float
    """Largest half-width of the 95 % interval in ln(value) among those that are not determined by themselves."""
    kind: FindingKind
    """Its kind."""
    parameters: list[str]
    """Names of the parameters."""
    text: str
    """The finding in words."""
    correlation: Optional[float] = None
    """Correlation, for a pair."""
    known_combination: Optional[str] = None
    """Name of the derived quantity, known well, that the group enters through."""


@dataclass(frozen=True)
class FitReport:
    """Everything that is known about a fit."""

    command: str
    """The command that made it."""
    correlation: Correlation
    """Correlation of each pair of free parameters."""
    created: str
    """When it was made, RFC 3339."""
    derived: list[DerivedRow]
    """Quantities computed from the parameters."""
    findings: list[Finding]
    """What the data do not determine."""
    fit: FitSummary
    """How the fit went."""
    fixed: list[FixedRow]
    """Fixed and tied parameters."""
    iterations: list[IterationRow]
    """chi^2 after each iteration of the best start."""
    measurements: list[MeasurementResult]
    """Measurements with their fitted or predicted curves."""
    model: str
    """Name and identification of the model."""
    parameters: list[ParameterRow]
    """Free parameters."""
    ratios: list[Ratio]
    """Peak ratios between measurements."""
    runs: RunStatistics
    """What it cost."""
    schema: str
    """[`SCHEMA`]."""
    settings: list[Setting]
    """Settings of model and fit that are worth keeping, name and value."""
    singular_values: list[float]
    """Singular values of the log-parameter Jacobian in units of the noise."""
    starts: list[StartRecord]
    """The fate of each start."""
    title: str
    """Heading."""
    verdict: Verdict
    """The result in words."""
    assumptions: list[Assumption] = field(default_factory=list)
    """What the result rests on: every parameter that was not fitted, given or assumed."""
    gains: list[GainRow] = field(default_factory=list)
    """How much better values are known from everything than from the first loading and hold of each test; empty where nothing else was fitted."""
    nuisances: list[NuisanceRow] = field(default_factory=list)
    """Contact points and load cells' zeros that were fitted with the parameters."""
    posterior: Optional[PosteriorReport] = None
    """A sample of the posterior, where it was asked for."""
    profiles: list[ProfileRow] = field(default_factory=list)
    """Profiles of the likelihood; their intervals stand in the tables."""


@dataclass(frozen=True)
class FitSummary:
    """How the fit went."""

    chi_square: float
    """Sum of squared residuals."""
    common_errors: list[str]
    """Names of errors common to all points that the intervals account for."""
    correlation_time: float
    """Integrated autocorrelation time of the residuals (points)."""
    degrees_of_freedom: int
    """Residuals minus free parameters."""
    evaluations: int
    """Residual evaluations of the best start."""
    iterations: int
    """Accepted steps of the best start."""
    noise_known: bool
    """Residuals are in units of their known standard deviation."""
    points: int
    """Number of residuals."""
    reduced_chi_square: float
    """The rest of chi^2 per degree of freedom."""
    stop: StopReason
    """Why it ended."""
    stop_text: str
    """The same in words."""
    shared_chi_square: Optional[float] = None
    """Part of it that errors account for which many points share, such as the heights of the specimens."""


@dataclass(frozen=True)
class FixedRow:
    """A parameter that was not fitted."""

    how: str
    """`fixed`, or the expression it is tied by."""
    name: str
    """Full name."""
    symbol: str
    """Symbol, plain text."""
    unit: str
    """Unit."""
    value: float
    """Value."""


@dataclass(frozen=True)
class GainRow:
    """How well a value is known: half-widths of its 95 % interval in ln(value)."""

    all: float
    """From everything that was fitted."""
    first_hold: float
    """From the first loading and hold of each test."""
    symbol: str
    """Symbol, plain text."""


@dataclass(frozen=True)
class IterationRow:
    """chi^2 after an iteration."""

    chi_square: float
    """Sum of squared residuals."""
    iteration: int
    """Its number; 0 is the start."""
    optimality: float
    """Bound-scaled gradient."""
    step_norm: float
    """Length of the step."""
    values: list[float]
    """Parameter values in their units, in the order of `parameters`."""


@dataclass(frozen=True)
class MeasurementResult:
    """A measurement with the model's curve. All series have the length of `time_s`."""

    chi_square: float
    """Sum of squared differences over sigma, or over mN (Eq. 16) if sigma is unknown."""
    chi_square_per_point: float
    """chi^2 per point."""
    displacement_mm: list[float]
    """Depth, positive into the sample (mm)."""
    end_mn: Pair
    """Force at the end (mN)."""
    file: str
    """File it came from."""
    measured_mn: list[float]
    """Measured force (mN)."""
    model_mn: list[float]
    """Model's force (mN)."""
    name: str
    """Short name, e.g. `P2`."""
    peak_mn: Pair
    """Peak force (mN)."""
    relaxation_percent: Pair
    """Relaxation, (peak - end) / peak (%)."""
    rms_mn: float
    """Root mean square of the difference (mN)."""
    role: Role
    """What it was used for."""
    sigma_mn: list[float]
    """Standard deviation of each measured point (mN); empty if unknown."""
    synthetic: bool
    """Whether the data are synthetic."""
    time_s: list[float]
    """Times (s)."""
    model_fluid_mn: Optional[list[float]] = None
    """Its fluid part (mN)."""
    model_solid_mn: Optional[list[float]] = None
    """Its solid part (mN)."""
    provenance: Optional[str] = None
    """Where the data come from, if the file says so; data that are synthetic say it here."""
    specimens: list[SpecimenCurve] = field(default_factory=list)
    """Force of each specimen (mN), where the file has them."""
    spread_mn: Optional[list[float]] = None
    """Spread between specimens (standard deviation) (mN)."""


@dataclass(frozen=True)
class NuisanceRow:
    """What a test does not say itself and no law of the material is: where its surface is, what its load cell reads without load."""

    lower: float
    """Lower end of the 95 % interval."""
    name: str
    """What, of which test."""
    unit: str
    """Unit of all values in this row."""
    upper: float
    """Upper end of the 95 % interval."""
    value: float
    """How much higher the surface lies, or the load cell reads, than was read from the file (and told there)."""


@dataclass(frozen=True)
class Pair:
    """A measured number and the model's."""

    measured: float
    """From the data."""
    model: float
    """From the model."""


@dataclass(frozen=True)
class ParameterRow:
    """A free parameter."""

    common_share: float
    """Share of the variance that comes from errors common to all points."""
    determination: Determination
    """How well it is known."""
    half_width: float
    """Half-width of the 95 % interval in ln(value)."""
    lower: float
    """Lower end of the 95 % interval."""
    lower_bound: float
    """Lower bound."""
    name: str
    """Full name."""
    open: tuple[bool, bool]
    """The interval is open below or above: it ends at the bound, not where the data end it."""
    start: float
    """Start value."""
    symbol: str
    """Symbol, plain text."""
    unit: str
    """Unit of all values in this row."""
    upper: float
    """Upper end of the 95 % interval."""
    upper_bound: float
    """Upper bound."""
    value: float
    """Fitted value."""
    at_bound: Optional[BoundSide] = None
    """Bound at which it sits."""
    profiled: Optional[bool] = None
    """The interval is that of a profile of the likelihood."""


@dataclass(frozen=True)
class PosteriorReport:
    """What is known of all values together: draws from the posterior, in the units that stand beside them."""

    divergent: int
    """Trajectories of NUTS that failed."""
    draws: list[list[float]]
    """Draws of equal weight, a value for each of `values`."""
    effective_draws: float
    """Independent draws that these are worth."""
    method: Method
    """How the draws were made."""
    summary: str
    """The same in words."""
    values: list[PosteriorRow]
    """The values."""
    pareto_k_hat: Optional[float] = None
    """Shape of the tail of the importance weights; absent where too few draws had a weight."""


@dataclass(frozen=True)
class PosteriorRow:
    """One value's share of the posterior."""

    lower: float
    """2.5 % quantile."""
    median: float
    """Median."""
    name: str
    """Full name."""
    symbol: str
    """Short symbol."""
    unit: str
    """Unit."""
    upper: float
    """97.5 % quantile."""


@dataclass(frozen=True)
class ProfileRow:
    """How chi^2 rises when a value is given and everything else is fitted."""

    asked: bool
    """Whether the user asked for it; otherwise the linearised interval was open or curved."""
    lower: float
    """Lower end of the 95 % interval."""
    name: str
    """Full name."""
    open: tuple[bool, bool]
    """The interval is open below or above: chi^2 does not rise enough before the bound."""
    points: list[tuple[float, float]]
    """Value and rise of chi^2."""
    symbol: str
    """Symbol, plain text."""
    threshold: float
    """Rise at the ends of the interval."""
    unit: str
    """Unit of all values in this row."""
    upper: float
    """Upper end of the 95 % interval."""
    value: float
    """Fitted value."""


@dataclass(frozen=True)
class Ratio:
    """Ratio of two measurements' peak forces."""

    name: str
    """What, e.g. `peak P2 / peak P1`."""
    value: Pair
    """Its values."""


@dataclass(frozen=True)
class RunStatistics:
    """What the fit cost."""

    cache_hits: int
    """Simulations found in the cache instead."""
    cancelled: int
    """Simulations cancelled because they were no longer needed."""
    failed: int
    """Simulations that failed."""
    failures: list[str]
    """Reasons of failures, without repetition."""
    mean_in_flight: float
    """Mean number of simulations under way while a Jacobian was formed."""
    runs: int
    """Simulations made."""
    wall_time_s: float
    """Wall time (s)."""


@dataclass(frozen=True)
class Setting:
    """A setting worth keeping."""

    name: str
    """Name."""
    value: str
    """Value with unit."""


@dataclass(frozen=True)
class SpecimenCurve:
    """A specimen's curve."""

    force_mn: list[float]
    """Force (mN) at the times of the measurement."""
    name: str
    """Its name."""


@dataclass(frozen=True)
class StartRecord:
    """What became of one start: the material of a waterfall plot."""

    evaluations: int
    """Residual evaluations made."""
    failed: int
    """Evaluations that failed, Jacobians included."""
    index: int
    """0 is the user's start."""
    iterations: int
    """Iterations made."""
    start: list[float]
    """The start, in the optimiser's variables."""
    chi_square: Optional[float] = None
    """chi^2 at the end, if it was refined."""
    chi_square_start: Optional[float] = None
    """chi^2 there, if the model could be evaluated."""
    end: Optional[list[float]] = None
    """Where it ended."""
    failure: Optional[str] = None
    """Why it could not be started."""
    stop: Optional[StopReason] = None
    """Why it ended."""


@dataclass(frozen=True)
class Verdict:
    """The result in words."""

    determined: list[str]
    """What the data determine."""
    headline: str
    """One sentence."""
    undetermined: list[str]
    """What they do not."""
    warnings: list[str]
    """What the reader must know before using the numbers."""

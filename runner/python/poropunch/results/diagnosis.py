"""Dataclasses of what `poropunch diagnose` finds. Written by `generate.py` from `runner/schemas`: do not edit."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, Optional

from .shared import Assumption


#: Kind of answer.
Kind = Literal[
    'no gap',  # The model and the data agree within the noise.
    'effect',  # One effect explains the gap.
    'group',  # One of several effects that cannot be told apart explains it.
    'pair',  # Two effects together explain it.
    'none of these',  # No effect of the catalogue explains it.
]


#: What the punch is doing.
Phase = Literal[
    'approach',  # Above the surface, before a loading.
    'ramp',  # Moving into the sample.
    'hold-early',  # Resting in the sample: the first hundredth of the hold, and less.
    'hold-middle',  # Resting in the sample: from a hundredth to a tenth of the hold.
    'hold-late',  # Resting in the sample: from a tenth of the hold to its end.
    'unload',  # Moving out of the sample, up to its undeformed surface.
    'recovery',  # Above the surface, after an unloading.
]


#: Where an effect acts.
Place = Literal[
    'specimen',  # The material, or the body made of it.
    'contact',  # Between punch or support and specimen.
    'machine',  # Frame and drive.
    'sensor',  # Load cell and its electronics.
    'numerics',  # Mesh, time steps, read-out of the simulation.
    'declared',  # Nobody said: an effect that the user declared.
]


#: Which magnitudes an effect can have.
Sign = Literal[
    'positive',  # 0 or more.
    'either',  # Of both signs.
    'switch',  # On (1) or off (0), nothing between.
]


#: With what the gap goes.
Course = dict[str, Any]


@dataclass(frozen=True)
class CurvePair:
    """One test's curves."""

    before_mn: list[float]
    """Plain model (mN)."""
    measured_mn: list[float]
    """Measured (mN)."""
    name: str
    """Test."""
    sigma_mn: list[float]
    """Standard deviation of the measured curve, simulation error included (mN)."""
    time_s: list[float]
    """Times (s)."""
    after_mn: Optional[list[float]] = None
    """Model with the effect of the verdict (mN), where there is one."""
    specimens_mn: list[list[float]] = field(default_factory=list)
    """Each specimen's curve (mN), where the file has them."""


@dataclass(frozen=True)
class Diagnosis:
    """All of it."""

    baseline: ModelSummary
    """Fit of the plain model."""
    command: str
    """Command that was given."""
    curves: list[CurvePair]
    """Measured and computed curves."""
    effects: list[EffectSummary]
    """Effects as screening sees them, largest evidence first."""
    held_out: list[HeldOut]
    """Prediction of data that were not fitted."""
    location: Location
    """Where it misses."""
    models: list[ModelSummary]
    """Models that were refitted, and their competitors, largest evidence first."""
    next: list[str]
    """What reveals the surviving candidates."""
    not_testable: list[NotTestable]
    """Effects that these data cannot show, and why."""
    overlap: list[list[float]]
    """Cosines between the signatures of `effects`, in their order."""
    parity: list[Parity]
    """Relations that need no fit."""
    quick: bool
    """Whether only the leaders were refitted."""
    schema: str
    """[`SCHEMA`]."""
    seconds: float
    """Wall time (s)."""
    simple_rules: list[SimpleRule]
    """What simpler methods would answer, for comparison."""
    something_else_evidence: float
    """Twice the log evidence of a smooth error outside the catalogue against no gap."""
    tests: list[TestSummary]
    """Tests, and what was left out of them."""
    verdict: Verdict
    """Answer."""
    warnings: list[str]
    """Warnings."""
    assumptions: list[Assumption] = field(default_factory=list)
    """What it rests on: the parameters that were not fitted."""
    leftover: Optional[Leftover] = None
    """What a gap looks like that no effect explains."""
    proposals: list[Proposal] = field(default_factory=list)
    """Tests that would tell the members of a group apart, the best first."""
    shrinkage: Optional[ShrinkageSummary] = None
    """How much of the gap goes."""


@dataclass(frozen=True)
class EffectSummary:
    """One effect in screening."""

    absorbed: float
    """Share that a refit of the parameters hides."""
    evidence: float
    """Twice the log evidence, linear."""
    family: str
    """Name of the effect in the catalogue that it is a variant of."""
    group: list[str]
    """Names of the effects that look the same."""
    magnitude: float
    """Expected magnitude (plausible scales)."""
    magnitude_sigma: float
    """Its standard deviation (plausible scales)."""
    name: str
    """Name."""
    place: Place
    """Where it acts."""
    power: float
    """Score that the plausible scale would give."""
    predicted_gain: float
    """Decrease of chi^2 that is expected of a refit."""
    probability: float
    """Family-wise probability under noise."""
    scale: float
    """Size of magnitude 1, where it has a unit."""
    score: float
    """Score."""
    sign: Sign
    """Its magnitudes."""
    testable: bool
    """Whether these data would show it."""
    title: str
    """In words."""
    unit: str
    """Unit of the scale."""
    actual_gain: Optional[float] = None
    """Decrease of chi^2 in the refit, where one was made."""


@dataclass(frozen=True)
class HeldOut:
    """A prediction."""

    informative: bool
    """Whether the fitted part determines the effects."""
    parts: list[PartGap]
    """Gap before and after, per phase and total."""
    score: float
    """Twice the gain in log predictive density by the effects."""
    split: str
    """What was predicted from what."""
    chosen: list[str] = field(default_factory=list)
    """Effects that the fitted part alone would have chosen; the prediction is with them."""


@dataclass(frozen=True)
class Leftover:
    """A description of what is left."""

    course: Course
    """With what it goes."""
    part: float
    """Part of the gap (chi^2 beyond what noise gives) that this description takes."""
    specimens: list[str]
    """Specimens that differ from the others far more than these among themselves."""
    off_contact: Optional[bool] = None
    """Whether it is there off contact, too: then it is the machine's or the sensor's. None where too little was measured there to tell."""
    test: Optional[str] = None
    """Test that it is seen in; none: in all alike."""


@dataclass(frozen=True)
class Location:
    """Where the plain model misses."""

    probability: float
    """Family-wise probability of the largest score, effects included, under noise."""
    spots: list[SpotSummary]
    """Phases and time scales."""
    threshold: float
    """Score that the largest of all passes by noise alone in 1 of 20 cases."""


@dataclass(frozen=True)
class ModelSummary:
    """A fitted model."""

    adequacy: float
    """Family-wise probability that noise leaves such a residual."""
    chi_square: float
    """chi^2, prior included."""
    effects: list[str]
    """Effects in it; none for the plain model."""
    evidence: float
    """Twice the log evidence against the plain model."""
    gain: float
    """Decrease of chi^2 against the plain model."""
    magnitudes: list[tuple[float, float]]
    """Magnitude of each effect (plausible scales) and its standard deviation."""
    parameters: list[tuple[str, float, str]]
    """Material parameters (display units): name, value, unit."""
    points: int
    """Points."""
    probability: float
    """Posterior probability among all competitors."""
    rms_mn: float
    """Root mean square residual (mN)."""


@dataclass(frozen=True)
class NotTestable:
    """An effect that these data cannot show."""

    name: str
    """Name."""
    reason: str
    """Why."""


@dataclass(frozen=True)
class Parity:
    """One relation."""

    of: str
    """Test, tests and cycle."""
    relation: str
    """What is compared."""
    shows: str
    """What a deviation would mean."""
    unit: str
    """Unit."""
    value: float
    """Value."""
    expected: Optional[float] = None
    """Value without the effect that it would show."""
    sigma: Optional[float] = None
    """Its standard uncertainty, where known."""


@dataclass(frozen=True)
class PartGap:
    """Gap in some part."""

    after_mn: float
    """With it (mN)."""
    before_mn: float
    """Without the effect (mN)."""
    part: str
    """`total` or the phase."""
    interval: Optional[tuple[float, float]] = None
    """90 % interval."""
    shrinkage: Optional[float] = None
    """`1 - after / before`; undefined where the plain model has no significant gap."""


@dataclass(frozen=True)
class Proposal:
    """A test that is proposed."""

    what: str
    """What to do."""
    evidence: Optional[float] = None
    """Fall of chi^2 that tells the explanations apart; none where the test tells the machine's from the specimen's by itself."""


@dataclass(frozen=True)
class ShrinkageSummary:
    """How much of the gap goes, in total."""

    after_mn: float
    """Gap after (mN)."""
    before_mn: float
    """Gap before (mN)."""
    of: str
    """Of which data."""
    points: list[int]
    """Predicted points among those of all tests, one test after the other."""
    predicted_after_mn: list[float]
    """And with it (mN)."""
    predicted_before_mn: list[float]
    """Predictions at these points without the effect (mN)."""
    chosen: list[str] = field(default_factory=list)
    """Effects that the rest of the data alone would have chosen; the prediction is with them."""
    interval: Optional[tuple[float, float]] = None
    """90 % interval."""
    value: Optional[float] = None
    """`1 - after / before`; undefined where the plain model has no significant gap."""


@dataclass(frozen=True)
class SimpleRule:
    """What a simple rule would answer."""

    rule: str
    """Rule."""
    effect: Optional[str] = None
    """Effect of the catalogue; none for no gap."""


@dataclass(frozen=True)
class SpotSummary:
    """One place."""

    mean_mn: float
    """Mean of measured minus model (mN)."""
    pattern: str
    """`level`, `tilt`, or the relaxation time."""
    probability: float
    """Family-wise probability under noise."""
    rms_mn: float
    """Root mean square of measured minus model (mN)."""
    score: float
    """Score, standard normal under noise."""
    test: str
    """Test."""
    cycle: Optional[int] = None
    """Cycle, counted from 1; none for a time scale of all holds."""
    phase: Optional[Phase] = None
    """Phase."""
    time_s: Optional[float] = None
    """Relaxation time (s)."""


@dataclass(frozen=True)
class TestSummary:
    """One test."""

    cycles: int
    """Cycles used."""
    name: str
    """Its name."""
    points: int
    """Points used."""
    same_specimens: bool
    """Whether the specimens are those of the other tests."""
    specimens: int
    """Specimens."""
    white_mn: float
    """White noise of the curve, median over its points (mN)."""
    height_scatter: Optional[float] = None
    """Relative scatter of the specimens' heights (-)."""
    left_out: Optional[str] = None
    """What was left out."""
    slow_noise: Optional[tuple[float, float]] = None
    """Slow noise of the load cell (mN) and its time (s)."""
    specimen_white_mn: Optional[float] = None
    """White noise of a specimen's sample (mN)."""


@dataclass(frozen=True)
class Verdict:
    """The answer."""

    confidence: float
    """Probability that the answer is right."""
    effects: list[str]
    """Names of the effects: one, the group, or the pair and then what would do as well in the place of its second; the most probable first."""
    kind: Kind
    """Kind of answer."""
    text: str
    """In plain words."""
    gap_percent: Optional[float] = None
    """Largest mean difference between data and plain model over half a decade of the time since any kink of the motion, as part of its test's largest force (%)."""
    is_immaterial: Optional[bool] = None
    """Whether there is a significant gap, but a smaller one, and no effect that is sure to predict better."""
    matters_percent: Optional[float] = None
    """What is smaller does not matter (%)."""

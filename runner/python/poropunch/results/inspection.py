"""Dataclasses of what `poropunch inspect` reads. Written by `generate.py` from `runner/schemas`: do not edit."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, Optional


#: Where noise was told from.
NoiseSource = Literal[
    'off-contact',  # Punch in the air.
    'holds',  # Late part of the holds, from sample to sample.
]


@dataclass(frozen=True)
class ContactInspection:
    """First touch."""

    threshold_mm: Quartiles
    """Displacement at which the force passes the threshold above that off contact (mm)."""
    threshold_sigma_mm: float
    """Standard uncertainty of that for one specimen: noise over slope, sampling (mm)."""
    onset_mm: Optional[Quartiles] = None
    """Displacement at which the force begins, extrapolated (mm)."""
    onset_sigma_mm: Optional[float] = None
    """Standard uncertainty of that for one specimen (mm)."""


@dataclass(frozen=True)
class CycleInspection:
    """One cycle. Quartiles are over the specimens."""

    depth_mm: float
    """Displacement of the hold (mm)."""
    end_s: float
    """End (s)."""
    force_after: list[ForceAfter]
    """Force at some times after the end of the ramp, as far as the hold lasts."""
    hold_end_mn: Quartiles
    """Force at the end of the hold (mN)."""
    hold_end_s: float
    """The punch leaves its rest (s)."""
    hold_s: float
    """Length of the hold (s)."""
    number: int
    """Counted from 1."""
    peak_mn: Quartiles
    """Largest force (mN)."""
    peak_over_first: Quartiles
    """Peak over the peak of cycle 1 of the same specimen (-)."""
    ramp_end_s: float
    """The punch comes to rest in the sample (s)."""
    ramp_start_s: float
    """The punch passes the undeformed surface (s)."""
    rate_mm_per_s: Estimate
    """Rate of the loading (mm/s)."""
    relaxation_percent: Quartiles
    """(peak - force at the end of the hold) / peak (%)."""
    start_s: float
    """Beginning (s)."""
    contact: Optional[ContactInspection] = None
    """First touch; none where no specimen's force passes the threshold."""
    drift_mn: Optional[Estimate] = None
    """Change of the force off contact over the cycle, specimen by specimen (mN)."""
    off_contact_after_mn: Optional[Estimate] = None
    """Mean force after withdrawal (mN)."""
    off_contact_before_mn: Optional[Estimate] = None
    """Mean force before first touch (mN)."""
    retraction: Optional[Retraction] = None
    """Smallest force after the hold."""
    surface_s: Optional[float] = None
    """The punch passes the undeformed surface outwards (s)."""
    unload_rate_mm_per_s: Optional[float] = None
    """Rate of the unloading (mm/s), positive."""
    withdrawn_s: Optional[float] = None
    """The punch comes to rest outside (s)."""


@dataclass(frozen=True)
class Estimate:
    """A value and its standard uncertainty, in the same unit."""

    sigma: float
    """Standard deviation of the value."""
    value: float
    """Best value."""


@dataclass(frozen=True)
class ForceAfter:
    """Force some time after the end of the ramp."""

    after_s: float
    """Time after the end of the ramp (s)."""
    force_mn: Quartiles
    """Force (mN)."""


@dataclass(frozen=True)
class Inspection:
    """All that was read from some measurements."""

    command: str
    """Command that was given."""
    contact_threshold_mn: float
    """Force that means contact (mN)."""
    ratios: list[Ratio]
    """Tests against the slowest of them, cycle by cycle."""
    schema: str
    """[`SCHEMA`]."""
    tests: list[TestInspection]
    """One for each test."""
    water: Optional[WaterContent] = None
    """Water content and volume fraction of solid, if they were asked for."""


@dataclass(frozen=True)
class NoiseInspection:
    """Noise of the force."""

    outliers: int
    """Samples left out."""
    samples: int
    """Samples that tell it."""
    specimen_factors: list[float]
    """Factor of each specimen (-)."""
    white_from: NoiseSource
    """Where the white part was told."""
    correlated_below_mn: Optional[float] = None
    """The correlated part is below this, with 95 % confidence (mN)."""
    correlated_mn: Optional[Estimate] = None
    """Correlated part off contact (mN); none where none is seen."""
    correlation_time_s: Optional[Estimate] = None
    """Correlation time of that part (s)."""
    height_of_median: Optional[float] = None
    """What that leaves unknown of the median curve's height, relative (-)."""
    specimen_log_deviation: Optional[Estimate] = None
    """Standard deviation of the logarithm of a factor common to a specimen's whole curve (-)."""
    white_mn: Optional[Estimate] = None
    """White part of one specimen's samples (mN)."""


@dataclass(frozen=True)
class OddSpecimen:
    """A specimen that is none of its kind."""

    left_out: bool
    """Whether `identify` and `diagnose` leave it out: that of another shape."""
    name: str
    """Its name."""
    why: str
    """What is odd about it."""


@dataclass(frozen=True)
class Quartiles:
    """Median and quartiles of the specimens; all three the same for a single one."""

    count: int
    """Number of values."""
    median: float
    """Median."""
    q25: float
    """Lower quartile."""
    q75: float
    """Upper quartile."""


@dataclass(frozen=True)
class Ratio:
    """A faster test against the slowest, in one cycle."""

    cycle: int
    """Cycle."""
    hold_end: RatioValue
    """Ratio of the median forces at the end of the hold (-): an amplitude, of any fading memory."""
    peak: RatioValue
    """Ratio of the median peaks (-)."""
    rate: float
    """Ratio of the rates (-)."""
    rate_effect: RatioValue
    """Ratio of peaks over that of hold ends (-): what is left for the rate."""
    reference: str
    """Name of the slowest test."""
    test: str
    """Name of the faster test."""


@dataclass(frozen=True)
class RatioValue:
    """A ratio; its uncertainty is known where both tests have specimens."""

    value: float
    """Ratio (-)."""
    sigma: Optional[float] = None
    """Standard uncertainty from the scatter of specimens (-)."""


@dataclass(frozen=True)
class Retraction:
    """Force while the punch is pulled off."""

    adhesion: bool
    """Whether the median minimum is below that: the sample holds the punch."""
    minimum_mn: Quartiles
    """Smallest force (mN)."""
    noise_alone_mn: float
    """What noise alone would not fall below in 99 of 100 cycles (mN)."""


@dataclass(frozen=True)
class TestInspection:
    """One test."""

    comments: list[str]
    """Comment lines of the file."""
    cycles: list[CycleInspection]
    """The cycles."""
    displacement_noise_mm: float
    """Standard deviation of a displacement sample's noise (mm)."""
    file: str
    """File, or directory of the specimens' files."""
    name: str
    """Its name."""
    noise: NoiseInspection
    """The noise."""
    notes: list[str]
    """What was read leniently or needs attention."""
    odd_specimens: list[OddSpecimen]
    """Specimens that differ from all others in shape or height."""
    points: int
    """Number of points."""
    shifts_s: list[Estimate]
    """What was added to each specimen's clock (s)."""
    specimens: list[str]
    """Names of the specimens; empty where the file holds one curve."""
    synthetic: bool
    """Whether the file says that it was not measured."""


@dataclass(frozen=True)
class WaterContent:
    """Water and solid of a sample."""

    n0s: Estimate
    """Volume fraction of solid `material.n0s` (-)."""
    solid_density: float
    """Density of the solid (kg/m^3)."""
    specimens: int
    """Specimens that were weighed."""
    uncertainty_known: bool
    """Whether an uncertainty was given or could be told from several specimens."""
    water_density: float
    """Density of water (kg/m^3)."""
    water_fraction: Estimate
    """Mass fraction of water, (m_wet - m_dry) / m_wet (-)."""

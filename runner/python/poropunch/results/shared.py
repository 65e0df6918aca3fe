"""Dataclasses of what several results have alike. Written by `generate.py` from `runner/schemas`: do not edit."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, Optional


@dataclass(frozen=True)
class Assumption:
    """A parameter that was not fitted."""

    given: bool
    """Whether the user gave it; otherwise it is the default."""
    meaning: str
    """What it is."""
    name: str
    """Its name."""
    unit: str
    """Unit, empty where there is none."""
    value: str
    """Its value in `unit`; an item's name or true or false where it is no number."""

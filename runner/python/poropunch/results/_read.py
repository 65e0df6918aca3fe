"""JSON into dataclasses."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any, TypeVar, Union, cast, get_args, get_origin, get_type_hints

T = TypeVar("T")

_hints = functools.lru_cache(maxsize=None)(get_type_hints)


def read(kind: type[T], value: Any) -> T:
    """`value`, as JSON has it, as a `kind`; fields of a later version are left out.

    >>> from poropunch.results.inspection import Estimate
    >>> read(Estimate, {"value": 1.5, "sigma": 0.1})
    Estimate(sigma=0.1, value=1.5)
    """
    return cast(T, _read(kind, value))


def _read(kind: Any, value: Any) -> Any:
    origin, parts = get_origin(kind), get_args(kind)
    if value is None:
        return None
    if origin is Union:
        return _read(parts[0], value)
    if origin is list:
        return [_read(parts[0], item) for item in value]
    if origin is tuple:
        return tuple(map(_read, parts, value))
    if isinstance(kind, type) and dataclasses.is_dataclass(kind):
        hints = _hints(kind)
        return kind(**{name: _read(hints[name], part) for name, part in value.items() if name in hints})
    return value

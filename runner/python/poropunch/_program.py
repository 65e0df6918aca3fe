"""Runs the packaged program and reads what it says."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Optional, Union

from ._place import PROGRAM

#: What is told of each event of a run, as `--progress json` prints it: {"event": "iteration", "chi_square": ...}.
Progress = Union[None, bool, Callable[[dict[str, Any]], None]]

#: The program's exit codes (`poropunch --help`).
_DONE, _USAGE, _NOT_CONVERGED, _REFUSED, _STOPPED = 0, 2, 3, 4, 130

#: How long a program that was asked to stop may take to keep what is done (s).
_LAST_WORDS = 60.0


class PoropunchWarning(UserWarning):
    """What may spoil a result."""


def run(command: str, words: list[str], progress: Progress) -> tuple[Any, list[str]]:
    """The JSON that a command prints, and the texts that it says meanwhile.

    Raises ValueError where the command line or the data are refused, RuntimeError where the command fails, KeyboardInterrupt where it
    was stopped: what was done until then is kept in its directory.
    """
    line = [PROGRAM, command, "--json", "--progress", "json", *words]
    tell = _bar if progress is True else progress or None
    with tempfile.TemporaryFile() as result:
        # A session of its own: Ctrl-C on the terminal comes once, from here.
        with subprocess.Popen(
            line, stdin=subprocess.DEVNULL, stdout=result, stderr=subprocess.PIPE, encoding="utf-8",
            start_new_session=True,
        ) as process:  # fmt: skip
            try:
                said, errors = _listen(process, tell)
                code = process.wait()
            except BaseException:
                _stop(process)
                raise
            finally:
                if tell is _bar:
                    print("\r\033[K", end="", file=sys.stderr, flush=True)
        if code == _STOPPED:
            raise KeyboardInterrupt(f"`poropunch {command}` was stopped")
        if code not in (_DONE, _NOT_CONVERGED):
            why = "\n".join(errors) or f"`poropunch {command}` ended with the code {code}"
            raise (ValueError if code in (_USAGE, _REFUSED) else RuntimeError)(why)
        result.seek(0)
        return json.load(result), said


def _listen(process: subprocess.Popen[str], tell: Optional[Callable[[dict[str, Any]], None]]) -> tuple[list[str], list[str]]:
    said: list[str] = []
    errors: list[str] = []
    assert process.stderr is not None
    for line in process.stderr:
        try:
            event = json.loads(line)
        except ValueError:
            # What refuses a command line speaks before it knows that JSON is wanted.
            errors.append(line.rstrip("\n").removeprefix("error: "))
            continue
        kind, text = event.get("event"), event.get("text", "")
        if kind == "error":
            errors.append(text)
        elif kind == "warning" or text.startswith("warning: "):
            warnings.warn(text.removeprefix("warning: "), PoropunchWarning, stacklevel=5)
        elif kind in ("text", "note"):
            said.append(text)
        if tell is not None:
            tell(event)
    return said, [line for line in errors if line]


def _stop(process: subprocess.Popen[str]) -> None:
    """Asks it to stop and to keep what is done; ends it where it does not, or where the user insists."""
    try:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=_LAST_WORDS)
    except BaseException:
        process.kill()
        process.wait()


def _bar(event: dict[str, Any]) -> None:
    """One line on standard error that is written again and again, in a terminal and in a notebook."""
    seconds = event.get("seconds")
    if seconds is None:
        return
    text = event.get("text")
    if event["event"] == "iteration":
        text = f"start {event['start']}/{event['starts']}, iteration {event['iteration']}: chi^2 = {event['chi_square']:.4g}"
    elif "done" in event:
        text = f"{event['done']}/{event['total']} runs"
    print(f"\r\033[K{text}, {seconds:.0f} s", end="", file=sys.stderr, flush=True)


def words(options: Mapping[str, Any]) -> list[str]:
    """Options of the command line from keyword arguments.

    >>> words({"starts": 4, "quick": True, "resume": False, "set": {"geometry.punch_radius": "1 mm"}, "profile": ["G_1", "tau_2"]})
    ['--starts=4', '--quick', '--set=geometry.punch_radius=1 mm', '--profile=G_1', '--profile=tau_2']
    """
    line = []
    for name, value in options.items():
        flag = "--" + name.replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            line.append(flag)
        elif isinstance(value, Mapping):
            line += [f"{flag}={key}={_quantity(key, of)}" for key, of in value.items()]
        elif isinstance(value, (list, tuple)):
            line += [f"{flag}={item}" for item in value]
        else:
            line.append(f"{flag}={value}")
    return line


def _quantity(name: str, value: Any) -> str:
    """A value as the command line reads it: numbers are SI and get their unit, a pair of them is a range."""
    if isinstance(value, (str, Path)):
        return str(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    from ._simulation import parameters

    known = parameters().get(name)
    unit = (known.unit if known else None) or ""
    unit = "" if unit == "1" else unit
    if isinstance(value, (list, tuple)):
        lower, upper = value
        return f"{lower!r}:{upper!r}{unit}"
    return f"{value!r}{unit}" if isinstance(value, int) else f"{float(value)!r}{unit}"

"""What arguments may be, said before they go anywhere."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from tisserand import _native


def whole_number(name: str, value: Any, least: int = 0) -> int:
    """A whole number of any type, from `least` on."""
    expected = f"expected a whole number from {least} on"
    try:
        number = operator.index(value)
    except TypeError:
        raise _native.InputError(f"{name}: is {value!r}, {expected}") from None
    if isinstance(value, bool) or not least <= number < 2**53:
        raise _native.InputError(f"{name}: is {value!r}, {expected}")
    return number


def optional_whole_number(name: str, value: Any, least: int = 0) -> int | None:
    """The same, or nothing."""
    return None if value is None else whole_number(name, value, least)


def positive(name: str, value: Any, unit: str = "") -> float:
    """A finite number above zero."""
    of = f" of {unit}" if unit else ""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise _native.InputError(f"{name}: is {value!r}, expected a positive number{of}") from None
    if not 0 < number < math.inf:
        raise _native.InputError(f"{name}: is {value!r}, expected a positive number{of}")
    return number


def share(name: str, value: Any) -> float:
    """A number between 0 and 1."""
    if not positive(name, value) < 1:
        raise _native.InputError(f"{name}: is {value!r}, expected a number between 0 and 1")
    return float(value)


def function(name: str, value: Callable[..., object] | None) -> None:
    """A function, or nothing."""
    if value is not None and not callable(value):
        raise _native.InputError(f"{name}: is {value!r}, expected a function")


def names(name: str, value: Iterable[str], example: str) -> list[str]:
    """Several names; one text alone would be a list of its letters."""
    if isinstance(value, str):
        raise _native.InputError(f"{name}: is the text {value!r}, expected a list such as {example}")
    found = list(value)
    for one in found:
        if not isinstance(one, str):
            raise _native.InputError(f"{name}: has {one!r}, expected names")
    return found


def one_of(name: str, value: Any, known: Sequence[str]) -> str:
    """One of several names."""
    if value not in known:
        raise _native.InputError(f"{name}: is {value!r}, expected one of {', '.join(known)}")
    return str(value)


def units_of(units: Sequence[str] | Mapping[str, str]) -> dict[str, str]:
    """Length, mass and time, as a file has them."""
    expected = 'expected length, mass and time, such as ("mm", "t", "s")'
    if isinstance(units, Mapping):
        given = dict(units)
    elif isinstance(units, str) or len(list(units)) != 3:
        raise _native.InputError(f"units: are {units!r}, {expected}")
    else:
        given = dict(zip(("length", "mass", "time"), units, strict=True))
    if set(given) != {"length", "mass", "time"}:
        raise _native.InputError(f"units: are {units!r}, {expected}")
    return given

"""Many reductions of one part, compared with the unreduced part."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from tisserand import _checks, _native
from tisserand.reduction import _enrichment, _json, _means, _part, _threads

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class Study:
    """What each reduction costs, and how far it is off. Made by :func:`study`."""

    rows: list[dict[str, Any]]
    """One for each reduction and form: `variant`, `modes`, `unknowns`, `reduction_seconds`, `file_bytes`, and relative `errors` by measure."""
    text: str
    """Table and verdict, as the program `reduce study` prints them."""

    def __str__(self) -> str:
        return self.text

    def to_pandas(self) -> pandas.DataFrame:
        """Rows as a table, with the largest of each kind of errors in a column of its own.

        Returns
        -------
        pandas.DataFrame
            A row for each of :attr:`rows`. Errors are relative; `reduction_seconds` is in seconds, `file_bytes` in bytes. `further_columns` has the
            sources of further columns, joined by `+`, or nothing.
        """
        import pandas

        left_out = ("errors", "curves", "enrichment")
        return pandas.DataFrame(
            {key: value for key, value in row.items() if key not in left_out}
            | {"further_columns": "+".join(row["enrichment"]) or None}
            | {measure: _largest(error) for measure, error in row["errors"].items()}
            for row in self.rows
        )


FORMS = ("strong", "static", "weak", "free")


def study(
    K: Any,
    M: Any,
    points: ArrayLike,
    interfaces: Mapping[str, Any] | Sequence[Mapping[str, Any]],
    *,
    modes: Sequence[int] | None = None,
    forms: Sequence[str] = ("strong", "static", "weak", "free"),
    interface_modes: Sequence[int] = (),
    enrich: Sequence[Sequence[str]] | None = None,
    band: tuple[float, float] | None = None,
    band_points: int = 400,
    loss_factor: float = 0.02,
    tolerance: float = 1e-3,
    output: str | PathLike[str] | None = None,
    dofs: Sequence[Any] | None = None,
    cells: Mapping[str, ArrayLike] | Sequence[tuple[str, ArrayLike]] | None = None,
    loads: Mapping[str, ArrayLike] | None = None,
    boundary: Any = None,
    component_masses: Mapping[str, Any] | None = None,
    units: Sequence[str] | Mapping[str, str] = ("m", "kg", "s"),
    name: str = "part",
    damping: float | Sequence[float] | Mapping[str, Any] | None = None,
    memory: str | int | None = None,
    threads: int | None = None,
) -> Study:
    """Reduce a part in many ways and compare each with the unreduced part.

    Parameters
    ----------
    K, M, points, interfaces, dofs, cells, loads, boundary, component_masses, units, name, damping, memory, threads
        As in :func:`reduce`.
    modes
        Numbers of modes; 5, 10, 20 and 40 by default, as far as the part has them.
    forms
        Forms in which the superelement is used: `"strong"`, `"static"`, `"weak"` and `"free"`, all by default.
    interface_modes
        Numbers of interface modes, beside all of them.
    enrich
        Sets of further columns, beside none, such as `("spin", "loads")`. They need the form `"strong"`; with it `("krylov",)` is the default.
    band
        Frequencies in Hz, from and to; up to half the highest mode by default.
    band_points
        Points of the band, 2 to 100000, 400 by default; resonances are added.
    loss_factor
        Structural loss factor of the responses compared, 0.02 by default.
    tolerance
        Relative error for which the best row is named, 1e-3 by default.
    output
        Folder for the page `report.html`, its pictures and tables; it is made, or must be empty. By default none is kept.

    Returns
    -------
    Study
        Rows with costs and errors, and the verdict. Ctrl-C is heard at the end only.
    """
    if band is not None:
        ends = [_checks.positive("band", end, "Hz") for end in band]
        if len(ends) != 2 or ends[0] >= ends[1]:
            raise _native.InputError(f"band: is {tuple(band)}, expected two frequencies in Hz, the lower one first")
    if not 2 <= _checks.whole_number("band_points", band_points) <= 100_000:
        raise _native.InputError(f"band_points: is {band_points}, expected 2 to 100000")
    part = _part(K, M, points, interfaces, dofs, cells, loads, units, name, damping, boundary, component_masses)
    if enrich is None:
        enrich = (("krylov",),) if "strong" in forms else ()
    request = {
        "modes": None if modes is None else [_checks.whole_number("modes", number, 1) for number in modes],
        "variants": [_checks.one_of("forms", form, FORMS) for form in _checks.names("forms", forms, '["strong"]')],
        "interface_modes": [_checks.whole_number("interface_modes", number, 1) for number in interface_modes],
        "enrich": [_enrichment("enrich", sources) for sources in enrich],
        "band": band,
        "points": band_points,
        "loss_factor": _checks.positive("loss_factor", loss_factor),
    }
    with tempfile.TemporaryDirectory(prefix="tisserand-") as temporary:
        folder = temporary if output is None else fspath(_empty(Path(output)))
        means = _means(memory, "auto", None, {})
        made = json.loads(_native.study(part, _json(request), means, _checks.positive("tolerance", tolerance), folder, _threads(threads)))
    return Study(made["rows"], made["text"])


def _largest(error: Any) -> float | None:
    """The largest of several errors; that over a band where it is one."""
    if isinstance(error, list):
        return max((largest for largest in map(_largest, error) if largest is not None), default=None)
    if isinstance(error, dict):
        found: float = error["largest"] if "largest" in error else error["error"]
        return found
    return None if error is None else float(error)


def _empty(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.iterdir()):
        raise _native.InputError(f"output: {folder} has files in it; name a new folder")
    return folder

"""Results of runs, read when they are asked for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tisserand import _native

if TYPE_CHECKING:
    import matplotlib.axes
    import pandas
    import xarray


@dataclass(frozen=True)
class Channel:
    """A quantity recorded at every step, as one number or several. :attr:`Results.channels` and :meth:`Results.channel` give it."""

    path: str
    """Where it is in the file, such as `outputs/tip` or `reactions/axle`."""
    description: str
    """A sentence that says what it is."""
    columns: list[str]
    """Names of its numbers, such as `x`; an empty text where the channel's own name says everything."""
    units: list[str]
    """Units of its numbers, one for each column; `1` is no unit."""

    @property
    def name(self) -> str:
        """The path without `outputs/`: for an output its name in the scene."""
        return self.path.removeprefix("outputs/")


class Results:
    """A file of results, open. Histories are read when they are asked for.

    Made by :func:`simulate`, or of a file. `results["tip"]` is a history, `"tip" in results` says whether it is there, and a loop over the results
    gives the names of all channels.

    Parameters
    ----------
    path
        The file (`docs/results.md`).
    """

    def __init__(self, path: str | PathLike[str]) -> None:
        self._file = _native.Results(path)
        self.path = path
        self._channels = {channel[0]: Channel(*channel) for channel in self._file.channels()}

    @property
    def units(self) -> tuple[str, str, str]:
        """Names of the scene's units of length, mass and time."""
        return self._file.units

    @property
    def is_complete(self) -> bool:
        """Whether the run reached its end."""
        return self._file.is_complete

    @property
    def stopped(self) -> str | None:
        """Why it didn't; `None` where it did."""
        return self._file.stopped

    @property
    def channels(self) -> list[Channel]:
        """All that was recorded."""
        return list(self._channels.values())

    @property
    def time(self) -> NDArray[np.float64]:
        """Times of the recorded steps, (steps), read-only, in the scene's unit of time."""
        return self._file.time()

    @property
    def events(self) -> list[tuple[float, str]]:
        """Time (the scene's unit) and text of what was worth telling."""
        return self._file.events()

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """History of a channel by its path, or of an output by its name: (steps), or (steps, columns) where it has several.

        Parameters
        ----------
        name
            Name of an output, or the path of a channel, such as `reactions/JOINT`; its last part is enough where no other channel ends so.

        Returns
        -------
        ndarray
            Its values at the times of :attr:`time`, read-only, in the units that :meth:`channel` says.

        Raises
        ------
        InputError
            There is no such channel; the text has the nearest name.
        """
        channel = self.channel(name)
        history = self._file.history(channel.path)
        return history[:, 0] if len(channel.columns) == 1 else history

    def __contains__(self, name: object) -> bool:
        return name in self._channels or f"outputs/{name}" in self._channels

    def __iter__(self) -> Iterator[str]:
        return (channel.name for channel in self._channels.values())

    def __len__(self) -> int:
        return len(self._channels)

    def keys(self) -> list[str]:
        """Names of all channels.

        Returns
        -------
        list of str
            Names of outputs, and the paths of all other channels, such as `reactions/JOINT`.
        """
        return list(self)

    def channel(self, name: str) -> Channel:
        """A channel by its path, or an output by its name.

        Parameters
        ----------
        name
            Name of an output, or the path of a channel, such as `reactions/JOINT`; its last part is enough where no other channel ends so.

        Returns
        -------
        Channel
            Its path, description, columns and units.

        Raises
        ------
        InputError
            There is no such channel; the text has the nearest name.
        """
        found = self._channels.get(f"outputs/{name}") or self._channels.get(name)
        if found is None and isinstance(name, str):
            ends = [channel for path, channel in self._channels.items() if path.endswith(f"/{name}")]
            found = ends[0] if len(ends) == 1 else None
        if found is None:
            # The reader's own words, with the nearest name.
            self._file.history(name)
            raise _native.InputError(f"{name!r} is no channel")
        return found

    def modes(self) -> dict[str, tuple[str, NDArray[np.float64]]]:
        """Of an analysis of modes: unit and values of frequencies and damping, by name.

        Returns
        -------
        dict
            Unit and values, (n_m), of `frequency` (cycles by time, `Hz` where the time is in s), `damping_ratio` (a part of the critical one) and
            `growth` (1/time, where a mode goes with exp(s t) the real part of s). Empty for other analyses.
        """
        return {name: (unit, np.array(values)) for name, unit, values in self._file.modes()}

    def to_xarray(self) -> xarray.Dataset:
        """All histories, with their units, descriptions and the names of their columns. Needs xarray.

        Returns
        -------
        xarray.Dataset
            A variable for each channel, by its name, with the axis `time`, and `NAME.component` where it has several columns. Each has `units` and
            `description` among its attributes.
        """
        import xarray

        time = self.time
        arrays: dict[str, Any] = {}
        for channel in self.channels:
            about = {"description": channel.description, "units": ", ".join(dict.fromkeys(channel.units))}
            if len(channel.columns) == 1:
                arrays[channel.name] = xarray.DataArray(self[channel.path], {"time": time}, ("time",), attrs=about)
                continue
            axis = f"{channel.name}.component"
            places = {"time": time, axis: channel.columns}
            arrays[channel.name] = xarray.DataArray(self[channel.path], places, ("time", axis), attrs=about)
        dataset = xarray.Dataset(arrays)
        dataset["time"].attrs["units"] = self.units[2]
        return dataset

    def to_pandas(self) -> pandas.DataFrame:
        """All histories, a column for each number. Needs pandas.

        Returns
        -------
        pandas.DataFrame
            A row for each recorded step, with the time as index. Columns are called as their channels, or `NAME.COLUMN`, such as `tip.x`. Numbers are
            in the units that :attr:`channels` say.
        """
        import pandas

        columns: dict[str, NDArray[np.float64]] = {}
        for channel in self.channels:
            history = self._file.history(channel.path)
            for at, name in enumerate(channel.columns):
                columns[f"{channel.name}.{name}" if name else channel.name] = history[:, at]
        return pandas.DataFrame(columns, index=pandas.Index(self.time, name=f"time [{self.units[2]}]"))

    def plot(self, *names: str, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
        """Histories over time; all outputs where none is named. Needs matplotlib.

        Parameters
        ----------
        *names
            Names of outputs, or paths of channels, such as `reactions/JOINT`.
        ax
            Axes to draw into; those of a new figure by default.

        Returns
        -------
        matplotlib.axes.Axes
            The axes, with a curve for each column and its unit in the legend.
        """
        import matplotlib.pyplot as plt

        if ax is None:
            ax = plt.figure().subplots()
        wanted = names or [channel.path for channel in self.channels if channel.path.startswith("outputs/")]
        units = set()
        for name in wanted:
            channel = self.channel(name)
            history = self._file.history(channel.path)
            for at, (column, unit) in enumerate(zip(channel.columns, channel.units, strict=True)):
                label = f"{channel.name}.{column}" if column else channel.name
                ax.plot(self.time, history[:, at], label=f"{label} [{unit}]")
                units.add(unit)
        ax.set_xlabel(f"time [{self.units[2]}]")
        if len(units) == 1:
            ax.set_ylabel(f"[{units.pop()}]")
        ax.legend()
        ax.grid(visible=True)
        return ax

    def __repr__(self) -> str:
        ended = "complete" if self.is_complete else f"stopped: {self.stopped}"
        return f"<Results {self.path}: {len(self.time)} steps, {len(self._channels)} channels, {ended}>"

"""Recordings in memory: from arrays, files, pandas frames."""

from __future__ import annotations

import os
import re
from typing import Any, Mapping, Optional

import numpy as np

from . import _veridyn

_SIGNALS = {"q": "q", "dq": "dq", "ddq": "ddq", "tau": "tau", "i": "current"}


_TIME_COLUMNS = ("t", "time", "timestamp", "seconds", "__time")  # [s], as in CSV files


def _RangeIndex() -> Any:
    import pandas

    return pandas.RangeIndex


def _signals_of_frame(frame: Any) -> dict:
    """Columns t (or time), q1..qn, dq1.., ddq1.., tau1.., i1.. of a pandas frame; else the index is time."""
    columns: dict = {}
    for name in frame.columns:
        match = re.fullmatch(r"(q|dq|ddq|tau|i)([1-9][0-9]*)", str(name))
        if match:
            columns.setdefault(match.group(1), {})[int(match.group(2))] = name
    if "q" not in columns:
        found = ", ".join(str(name) for name in frame.columns)
        raise _veridyn.InvalidInput(
            f"Recording: the frame has the columns {found}; expected t, q1 to qn, and dq1.., "
            "ddq1.., tau1.., i1.. where they are known."
        )
    joints = len(columns["q"])
    out = {}
    for signal, own in columns.items():
        if sorted(own) != list(range(1, joints + 1)):
            raise _veridyn.InvalidInput(
                f"Recording: the frame has the columns {', '.join(map(str, own.values()))}, "
                f"expected {signal}1 to {signal}{joints}."
            )
        ordered = [own[k] for k in range(1, joints + 1)]
        out[_SIGNALS[signal]] = frame[ordered].to_numpy(dtype=float, na_value=np.nan)
    named = [name for name in _TIME_COLUMNS if name in frame.columns]
    if named:
        out["time"] = frame[named[0]].to_numpy(dtype=float)
    else:
        index = frame.index
        seconds = index.total_seconds() if hasattr(index, "total_seconds") else index
        if getattr(index, "dtype", None) is not None and index.dtype.kind == "M":
            seconds = (index - index[0]).total_seconds()
        elif isinstance(index, _RangeIndex()):
            raise _veridyn.InvalidInput(
                "Recording: the frame has no time, only row numbers; expected a column t (or "
                f"{', '.join(_TIME_COLUMNS[1:])}) in seconds, or an index of seconds or dates."
            )
        out["time"] = np.asarray(seconds, dtype=float)
    return out


class Recording(_veridyn.NativeRecording):
    """Signals of one arm against time.

    Recording(time, q, dq=None, ddq=None, tau=None, current=None, source="")
        from arrays: time (N) [s] that rises; the others (N, n), in rad, m, N m, N, A; NaN is a gap.
    Recording(path, **options)
        from a file, as read_recording(path, **options).
    Recording(frame)
        from a pandas frame with the columns t (or time), q1..qn, dq1.., ddq1.., tau1.., i1..;
        without a column of time its index is the time (seconds, timedelta or datetime).

    Raises InvalidInput where sizes do not fit or time does not rise.
    """

    _facts: dict = {}

    def __init__(
        self,
        time: Any,
        q: Optional[Any] = None,
        dq: Optional[Any] = None,
        ddq: Optional[Any] = None,
        tau: Optional[Any] = None,
        current: Optional[Any] = None,
        source: str = "",
        **options: Any,
    ) -> None:
        if q is None and isinstance(time, _veridyn.NativeRecording):
            super().__init__(time)
            return
        if q is None and isinstance(time, (str, os.PathLike)):
            native, facts = _veridyn.read_recording(os.fspath(time), options)
            super().__init__(native)
            self._facts = facts
            return
        if options:
            raise TypeError(f"Recording() has no argument '{next(iter(options))}' beside arrays.")
        if q is None and (hasattr(time, "columns") or isinstance(time, Mapping)):
            given = _signals_of_frame(time) if hasattr(time, "columns") else dict(time)
            for name in ("dq", "ddq", "tau", "current"):
                given.setdefault(name, None)
            super().__init__(source=source, **given)
            return
        if q is None:
            raise TypeError("Recording() needs time and q, a path, or a pandas frame.")
        super().__init__(time, q, dq, ddq, tau, current, source)

    @property
    def facts(self) -> dict:
        """What reading the file brought up, empty for arrays.

        format; joints (names, in the order of the columns); matched (the robot's joints to recorded
        names); topics; remarks; start (s since 1970 of time 0, or 0).
        """
        return self._facts

    def to_pandas(self) -> Any:
        """A pandas frame with the columns t, q1..qn, dq1.., ddq1.., tau1.., i1..."""
        import pandas

        data = {"t": self.time}
        for short, name in _SIGNALS.items():
            values = getattr(self, name)
            if values is not None:
                data.update({f"{short}{k + 1}": values[:, k] for k in range(values.shape[1])})
        return pandas.DataFrame(data)

    def part(self, first: int, end: int) -> Recording:
        """Rows `first` to `end`, the last one excluded."""

        def cut(signal: Any) -> Any:
            return None if signal is None else signal[first:end]

        return Recording(
            cut(self.time),
            cut(self.q),
            dq=cut(self.dq),
            ddq=cut(self.ddq),
            tau=cut(self.tau),
            current=cut(self.current),
            source=self.source,
        )

    def __len__(self) -> int:
        return self.rows

    def __repr__(self) -> str:
        has = [name for name in ("dq", "ddq", "tau", "current") if getattr(self, name) is not None]
        name = f"'{self.source}', " if self.source else ""
        return (
            f"<veridyn.Recording {name}{self.rows} rows, {self.joints} joints, "
            f"{self.time[-1] - self.time[0]:.4g} s, q {' '.join(has)}>"
        )

    def __reduce__(self) -> Any:
        arrays = (self.time, self.q, self.dq, self.ddq, self.tau, self.current)
        return Recording, (*arrays, self.source)

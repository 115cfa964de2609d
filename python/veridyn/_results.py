"""Results: dictionaries with the keys of `--json`, which also show themselves as text and pages."""

from __future__ import annotations

import html
import json
import os
from typing import Any, Optional

from . import _veridyn
from ._recording import Recording


def _in_a_frame(page: str, height: int) -> str:
    """A page within a notebook: a frame of its own, so that neither's styles reach the other."""
    return (
        f'<iframe srcdoc="{html.escape(page, quote=True)}" sandbox="allow-scripts" '
        f'style="width: 100%; height: {height}px; border: 1px solid #ccc"></iframe>'
    )


class _Stored:
    """What of a result survives a pickle: its text, its page, its model."""

    def __init__(self, report: str, page: str, model: Any) -> None:
        self._report, self._page, self.model = report, page, model

    def report(self) -> str:
        return self._report

    def page(self, call: str = "") -> str:
        return self._page

    def save(self, path: Any, command: str) -> None:
        if self.model is None:
            raise _veridyn.InvalidInput(f"{path}: there is no model to save.")
        self.model.save(os.fspath(path))


def _restored(kind: Any, keys: dict, stored: _Stored, call: str) -> Any:
    result = kind.__new__(kind)
    dict.__init__(result, keys)
    result._native, result._call = stored, call
    return result


class Result(dict):
    """A dictionary with the keys of the command's `--json`, and `report()` as text.

    In a notebook it shows as the page that the command's `--report` writes, or as its text.
    """

    def __init__(self, native: Any, call: str = "") -> None:
        super().__init__(json.loads(native.json()))
        self._native = native
        self._call = call

    def report(self) -> str:
        """The result as plain text, as the command prints it."""
        return self._native.report()

    def page(self) -> str:
        """The result as one HTML page that needs neither a network nor other files."""
        if not hasattr(self._native, "page"):
            return f"<pre>{html.escape(self.report())}</pre>"
        return self._native.page(self._call)

    def save_page(self, path: Any) -> None:
        """Writes page() to a file."""
        with open(os.fspath(path), "w", encoding="utf-8") as file:
            file.write(self.page())

    def __repr__(self) -> str:
        return self.report()

    def _repr_html_(self) -> str:
        page = self.page()
        return _in_a_frame(page, 700) if page.lstrip().lower().startswith("<!doctype") else page

    def __reduce__(self) -> Any:
        stored = _Stored(self.report(), self.page(), getattr(self, "model", None))
        return _restored, (type(self), dict(self), stored, self._call)


class _WithModel(Result):
    @property
    def model(self) -> Optional[_veridyn.Model]:
        """The arm with the values found; None where the data cannot answer, see self["reason"]."""
        return self._native.model

    def save(self, path: Any) -> None:
        """Writes the model as YAML, with date, version and the hashes of what it was made from.

        Raises InvalidInput where there is none.
        """
        self._native.save(os.fspath(path), self["command"])


def _axes(rows: int, title: str) -> Any:
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(rows, 1, sharex=True, squeeze=False, figsize=(9, 1.8 * rows))
    figure.suptitle(title)
    return figure, axes[:, 0]


class Identification(_WithModel):
    """What identify() found, or what evaluate() measured."""

    @property
    def verdict(self) -> str:
        """Which joints are good, which are not, and what to do next."""
        return self["verdict"]["sentence"]

    @property
    def error_percent(self) -> list:
        """Relative error of each joint in percent, on held-out recordings where there are any."""
        return [joint["error_percent"] for joint in self["verdict"]["joints"]]

    def plot(self, recording: int = 0) -> Any:
        """Measured and modelled torques of one recording as a matplotlib figure; held-out ones first."""
        series = self._native.series(recording)
        figure, axes = _axes(len(series["joints"]), series["source"])
        for axis, name, measured, modelled in zip(
            axes, series["joints"], series["measured"], series["modelled"]
        ):
            axis.plot(series["time"], measured, label="measured")
            axis.plot(series["time"], modelled, label="model")
            axis.set_ylabel(name)
        axes[0].legend(loc="upper right")
        axes[-1].set_xlabel("time [s]")
        return figure


class Diagnosis(_WithModel):
    """What diagnose() found; `model` is the arm with the findings."""

    @property
    def findings(self) -> list:
        """The findings, the most important first; empty where nothing was found."""
        return self["findings"]


class Payload(Result):
    """What find_payload() found."""

    @property
    def found(self) -> bool:
        """True if there surely is a load."""
        return self._native.found


class Comparison(Result):
    """What differs between two models."""


class Quality(Result):
    """What recordings alone show."""

    def __init__(self, text: str, report: str) -> None:
        dict.__init__(self, json.loads(text))
        self._text = report

    def report(self) -> str:
        return self._text

    def page(self) -> str:
        return f"<pre>{html.escape(self._text)}</pre>"


class Excitation(Result):
    """A motion that tells the parameters apart."""

    @property
    def motion(self) -> Recording:
        """time (N), q, dq, ddq (N, n) from rest to rest."""
        return Recording(self._native.motion)

    def plot(self) -> Any:
        """Positions against time as a matplotlib figure."""
        motion = self.motion
        figure, axes = _axes(motion.joints, f"{self['robot']}: {self['criterion']}")
        for axis, joint, q in zip(axes, self["joints"], motion.q.T):
            axis.plot(motion.time, q)
            axis.set_ylabel(f"{joint['name']} [{joint['unit']}]")
        axes[-1].set_xlabel("time [s]")
        return figure

    def save(self, path: Any) -> None:
        """Writes the motion as CSV: t, q, dq, ddq."""
        self.motion.write(path)


class Simulation(Result):
    """A simulated arm's recording."""

    @property
    def recording(self) -> Recording:
        """What its sensors say: time, q, dq, tau."""
        return Recording(self._native.recording)

    @property
    def actual(self) -> Recording:
        """What the arm really did, without noise, delay and gains."""
        return Recording(self._native.actual)

    @property
    def truth(self) -> _veridyn.Model:
        """The arm with the hidden effects in it."""
        return self._native.truth

    def report(self) -> str:
        hidden = ", ".join(e["effect"] for e in self.get("hidden", [])) or "none"
        return f"Simulated {self.truth.name}: {self.recording!r}; hidden effects: {hidden}"

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
        return dict, (dict(self),)


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


class Identification(_WithModel):
    """What identify() found, or what evaluate() measured."""


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

"""Results: dictionaries with the keys of `--json`, which also show themselves as text and pages."""

from __future__ import annotations

import html
import json
import os
from typing import Any, Optional

import numpy as np

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
    from matplotlib import pyplot  # only here: veridyn itself does not need it

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

    def plot(self) -> Any:
        """Held-out error of every joint before and after, and what each finding explains, as a figure."""
        from matplotlib import pyplot

        joints = [one["coordinate"] for one in self["verdict"]]
        before, after = ([100.0 * e for e in self[k]["test"]["relative_error"]] for k in ("baseline", "extended"))
        figure, (errors, shares) = pyplot.subplots(1, 2, figsize=(11, 1.2 + 0.45 * max(len(joints), len(self.findings), 3)))
        rows = range(len(joints))
        errors.barh([r - 0.2 for r in rows], before, 0.38, label="model", color="#b0b8c4")
        errors.barh([r + 0.2 for r in rows], after, 0.38, label="with the findings", color="#2f6db3")
        floors = [None if one["floor"] is None else 100.0 * one["floor"] for one in self["verdict"]]
        known = [(floor, row) for floor, row in zip(floors, rows) if floor is not None]
        errors.plot([k[0] for k in known], [k[1] for k in known], "k|", markersize=14, label="floor")
        errors.set_yticks(list(rows))
        errors.set_yticklabels(joints)
        errors.set_xlabel("held-out error [% of the torque]")
        errors.legend(loc="best")
        found = self.findings
        shares.barh(range(len(found)), [100.0 * (f["explains"] or 0.0) for f in found],
                    color=["#2f6db3" if f["main"] else "#b0b8c4" for f in found])
        shares.set_yticks(range(len(found)))
        shares.set_yticklabels([f["cause"] for f in found])
        shares.set_xlabel("explains [% of the removable error]")
        for axis in (errors, shares):
            axis.invert_yaxis()
        figure.suptitle(self["robot"])
        figure.tight_layout()
        return figure


class Payload(Result):
    """What find_payload() found."""

    @property
    def found(self) -> bool:
        """True if there surely is a load."""
        return self._native.found


def plot_friction(model: _veridyn.Model, joint: Any, axis: Any = None) -> Any:
    """Friction of one joint against its speed, as the model has it, as a matplotlib figure.

    joint : its name, or its number from 1
    axis : matplotlib axes to draw into
    """
    names = [c["name"] for c in model.coordinates]
    if joint not in names and joint not in range(1, len(names) + 1):
        raise _veridyn.InvalidInput(f"plot_friction: found the joint {joint!r}, expected one of: {', '.join(names)}.")
    index = names.index(joint) if joint in names else int(joint) - 1
    limits = model.coordinates[index]
    fastest = limits["velocity"] if np.isfinite(limits["velocity"]) else 2.0
    # Closer together about zero, where friction changes most.
    speed = fastest * np.linspace(-1.0, 1.0, 401) ** 3
    dq = np.zeros((len(speed), len(names)))
    dq[:, index] = speed
    zero = np.zeros_like(dq)
    effects = [
        _veridyn.joint_torques(model, zero, v, zero, None, 4)[:, index]
        - _veridyn.inverse_dynamics(model, zero, v, zero)[:, index]
        for v in (dq, zero)
    ]
    if axis is None:
        from matplotlib import pyplot

        axis = pyplot.subplots(figsize=(6, 3.6))[1]
    axis.plot(speed, effects[0] - effects[1][0])
    axis.axhline(0.0, color="0.8", linewidth=0.8)
    axis.set_xlabel(f"{names[index]} [{limits['unit']}/s]")
    axis.set_ylabel(f"friction [{limits['effort_unit']}]")
    return axis.figure


class Calibration(_WithModel):
    """What calibrate_links(), calibrate_axis(), calibrate_rcm() or calibrate_handeye() found."""


class Fleet(_WithModel):
    """What the arms of a type share, and which of them stands out."""


class Stability(Result):
    """Eigenvalues and margins of a loop."""

    @property
    def stable(self) -> bool:
        return bool(self["stable"])


class Kinematics(Result):
    """Poses, joints and conditioning; arrays over the rows."""

    def _column(self, key: str) -> np.ndarray:
        return np.array([row[key] for row in self["rows"]])

    @property
    def q(self) -> np.ndarray:
        """Joints (N, n)."""
        return self._column("q")

    @property
    def position(self) -> np.ndarray:
        """Of the frame in the world (N, 3) [m]."""
        return self._column("position")

    @property
    def quaternion(self) -> np.ndarray:
        """Of the frame in the world (N, 4): w, x, y, z."""
        return self._column("quaternion")

    @property
    def jacobian(self) -> np.ndarray:
        """(N, 6, n), linear rows first, in the world."""
        return self._column("jacobian")


class Friction(_WithModel):
    """Friction of every joint: curve, steady speeds, breakaways and verdicts."""

    def plot(self) -> Any:
        """Friction against speed: curve with its 95 % band, and what steady speeds measured."""
        from matplotlib import pyplot

        joints = self["joints"]
        figure, axes = pyplot.subplots(1, len(joints), squeeze=False, figsize=(4.2 * len(joints), 3.6))
        for axis, joint in zip(axes[0], joints):
            curve = joint["curve"]
            band = np.array(curve["interval"], dtype=float).reshape(-1, 2)
            axis.fill_between(curve["velocity"], band[:, 0], band[:, 1], alpha=0.25)
            axis.plot(curve["velocity"], curve["torque"])
            speeds = joint["speeds"]
            axis.plot([s["velocity"] for s in speeds], [s["torque"] for s in speeds], "k.", label="steady speeds")
            axis.set_title(joint["coordinate"])
            axis.set_xlabel(f"speed [{joint['velocity_unit']}]")
            axis.set_ylabel(f"friction [{joint['unit']}]")
        figure.suptitle(self["robot"])
        figure.tight_layout()
        return figure


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

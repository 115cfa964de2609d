"""What several tests need: a robot with values, a motion, a recording of it."""

import os
import pathlib

import numpy as np
import pytest

import veridyn

SOURCE = pathlib.Path(__file__).resolve().parents[2]


def real_data():
    """Folder of real recordings, or None."""
    folder = pathlib.Path(os.environ.get("VERIDYN_REAL_DATA", SOURCE.parent / "shared" / "data"))
    return folder if folder.is_dir() else None


@pytest.fixture(scope="session")
def arm():
    return veridyn.read_model("psm-3dof").with_plausible_values(3)


@pytest.fixture(scope="session")
def motion():
    """A quick Fourier motion within the PSM's limits, with exact derivatives."""
    time = np.arange(0.0, 20.0, 0.005)
    rng = np.random.default_rng(5)
    centre, size = np.array([0.0, 0.0, 0.12]), np.array([0.6, 0.4, 0.05])
    q = np.zeros((time.size, 3))
    dq, ddq = np.zeros_like(q), np.zeros_like(q)
    for k in range(1, 7):
        for joint in range(3):
            w = 2.0 * np.pi * (0.11 * k + 0.043 * joint + 0.017 * k * joint)
            a, phase = size[joint] / k / 2.0, rng.uniform(0.0, 2.0 * np.pi)
            q[:, joint] += a * np.sin(w * time + phase)
            dq[:, joint] += a * w * np.cos(w * time + phase)
            ddq[:, joint] -= a * w * w * np.sin(w * time + phase)
    return veridyn.Recording(time, q + centre, dq=dq, ddq=ddq, source="motion")


@pytest.fixture(scope="session")
def recording(arm, motion):
    return veridyn.simulate(arm, motion, noise="low", seed=2).recording

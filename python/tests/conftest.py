"""What several tests need: a robot with values, a motion, a recording of it."""

import json
import os
import pathlib
import struct

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


def write_mcap(path, names, recording, start=1_700_000_000):
    """Joint states as JSON in MCAP, without chunks: the smallest file that its specification allows."""

    def text(words):
        return struct.pack("<I", len(words)) + words.encode()

    with open(path, "wb") as out:

        def record(code, content):
            out.write(struct.pack("<BQ", code, len(content)) + content)

        out.write(b"\x89MCAP0\r\n")
        record(1, text("") + text("a test"))
        record(3, struct.pack("<H", 1) + text("sensor_msgs/JointState") + text("jsonschema") + text("{}"))
        record(4, struct.pack("<HH", 1, 1) + text("/joint_states") + text("json") + struct.pack("<I", 0))
        for k, t in enumerate(recording.time):
            stamp = start * 10**9 + round(t * 1e9)
            message = {
                "header": {"stamp": {"sec": stamp // 10**9, "nsec": stamp % 10**9}},
                "name": names,
                "position": recording.q[k].tolist(),
                "velocity": recording.dq[k].tolist(),
                "effort": recording.tau[k].tolist(),
            }
            record(5, struct.pack("<HIQQ", 1, k, stamp + 1_500_000, stamp) + json.dumps(message).encode())
        record(15, struct.pack("<I", 0))
        record(2, struct.pack("<QQI", 0, 0, 0))
        out.write(b"\x89MCAP0\r\n")

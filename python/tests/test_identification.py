"""The calls agree with each other, with the truth and with the tool."""

import json
import os
import re
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import veridyn
from conftest import SOURCE, real_data, write_mcap

TOOL = os.environ.get("VERIDYN_TOOL", "")


def bare(arm):
    """The robot without values, as it comes."""
    return veridyn.read_model("psm-3dof")


@pytest.fixture(scope="session")
def identified(arm, recording):
    return veridyn.identify(bare(arm), recording, test=recording)


def test_identify_finds_the_truth(arm, motion, identified):
    assert identified["status"] == "done" and identified["feasible"]
    assert max(identified["test"]["relative_error"]) < 0.05
    q, dq, ddq = motion.q, motion.dq, motion.ddq
    true = veridyn.joint_torques(arm, q, dq, ddq)
    found = veridyn.joint_torques(identified.model, q, dq, ddq)
    error = np.linalg.norm(found - true, axis=0) / np.linalg.norm(true, axis=0)
    assert error.max() < 0.02


def test_memory_and_files_give_the_same_answer(tmp_path, arm, recording, identified):
    path = tmp_path / "recording.csv"
    recording.write(path)
    from_file = veridyn.identify(bare(arm), path, test=str(path))
    for role in ("train", "test"):
        np.testing.assert_allclose(
            from_file[role]["relative_error"], identified[role]["relative_error"], rtol=1e-6
        )
    if not TOOL:
        pytest.skip("no tool to compare with")
    out = tmp_path / "tool.json"
    subprocess.run(
        [TOOL, "identify", "psm-3dof", "--train", path, "--test", path, "--json", out, "--quiet"],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    of_tool = json.loads(out.read_text())
    assert set(of_tool) == set(from_file)
    assert of_tool["test"]["relative_error"] == from_file["test"]["relative_error"]


def test_the_same_name_twice_is_two_recordings(arm, recording):
    half = recording.rows // 2
    parts = [
        veridyn.Recording(
            recording.time[rows], recording.q[rows], dq=recording.dq[rows], tau=recording.tau[rows]
        )
        for rows in (slice(0, half), slice(half, None))
    ]
    found = veridyn.identify(bare(arm), parts[0], test=parts)
    names = [r["source"] for r in found["test"]["recordings"]]
    assert len(set(names)) == 2
    errors = [r["relative_error"] for r in found["test"]["recordings"]]
    assert errors[0] != errors[1]


def test_results_show_themselves(identified, tmp_path):
    assert json.loads(json.dumps(identified))["command"] == "identify"
    page = identified._repr_html_()
    assert page.startswith("<iframe") and "Content-Security-Policy" in page
    assert "physically possible" in repr(identified)
    identified.save(tmp_path / "model.yaml")
    again = veridyn.read_model(tmp_path / "model.yaml")
    np.testing.assert_allclose(again.phi, identified.model.phi, rtol=1e-12)


def test_what_the_data_cannot_answer_is_a_status(arm, recording):
    q = np.array(recording.q)
    dq = np.array(recording.dq)
    q[:, 2], dq[:, 2] = 0.1, 0.0
    still = veridyn.Recording(recording.time, q, dq=dq, tau=recording.tau)
    found = veridyn.identify(bare(arm), still)
    assert found["status"] == "rank-deficient" and "insertion" in found["reason"]
    assert found.model is None
    with pytest.raises(veridyn.InvalidInput, match="no model to save"):
        found.save("nowhere.yaml")


def test_evaluate_fits_nothing(arm, recording):
    seen = veridyn.evaluate(arm, recording)
    assert max(seen["train"]["relative_error"]) < 0.05
    heavier = arm.with_parameters(np.nan_to_num(arm.parameters) * 1.1)
    assert min(veridyn.evaluate(heavier, recording)["train"]["relative_error"]) > 0.05


def test_a_load_is_found_and_compared(arm, motion, recording):
    frame = arm.bodies[-1]
    loaded = veridyn.simulate(arm, motion, effects=[f"payload:{frame}:mass=0.5"], seed=4)
    assert loaded["hidden"][0]["effect"] == "payload"
    found = veridyn.find_payload(arm, loaded, link=frame)
    assert found.found and not veridyn.find_payload(arm, recording, link=frame).found
    difference = veridyn.compare(arm, loaded.truth)
    assert difference["verdict"] == "cannot-tell"  # neither file has statistics


def test_diagnose_names_what_was_hidden(arm, motion):
    effects = ["stribeck_friction:yaw:level=0.6,velocity=0.05"]
    train = [veridyn.simulate(arm, motion, effects=effects, seed=s).recording for s in (1, 2)]
    test = veridyn.simulate(arm, motion, effects=effects, seed=3).recording
    found = veridyn.diagnose(
        bare(arm), train, test, effects=["stribeck_friction", "quadratic_drag"], max_effects=3
    )
    assert [(f["effect"], f["joint"]) for f in found.findings] == [("stribeck_friction", 1)]
    assert "stribeck_friction" in [e["effect"] for e in found.model.effects]
    assert "<iframe" in found._repr_html_()
    elsewhere = veridyn.diagnose(bare(arm), train, test, effects=["stribeck_friction:pitch"])
    assert all(f["effect"] != "stribeck_friction" or f["joint"] == 2 for f in elsewhere.findings)
    with pytest.raises(veridyn.InvalidInput, match="did you mean 'stribeck_friction'"):
        veridyn.diagnose(bare(arm), train, test, effects=["stribek_friction:pitch"])


def test_a_fit_is_validated_and_explained(arm, motion, tmp_path):
    train, test = (
        veridyn.simulate(arm, motion, effects=["joint_spring:pitch:stiffness=3"], noise="low", seed=seed).recording
        for seed in (1, 2)
    )
    fit = veridyn.identify(bare(arm), train)
    scores = veridyn.validate(fit, test)
    assert [score.joint for score in scores] == [1, 2, 3]
    assert "pitch" in repr(scores[1])
    why = veridyn.diagnose(fit, test, effects=["joint_spring"])
    assert why.findings[0]["effect"] == "joint_spring"
    veridyn.save(why, tmp_path / "why.yaml")
    saved = veridyn.read_model(tmp_path / "why.yaml")
    assert [e["effect"] for e in saved.effects] == [e["effect"] for e in why.model.effects]
    with pytest.raises(TypeError):
        veridyn.diagnose(fit, train, test)


def test_wrong_arguments_are_refused(arm, recording):
    with pytest.raises(TypeError, match="did you mean 'filter_cutoff'"):
        veridyn.identify(arm, recording, filter_cutof=3.0)
    with pytest.raises(veridyn.InvalidInput, match="expected one of: ols, wls, feasible"):
        veridyn.identify(arm, recording, method="best")
    with pytest.raises(TypeError, match="expected a path"):
        veridyn.identify(arm, 3)
    with pytest.raises(veridyn.InvalidInput, match="did you mean 'stribeck_friction'"):
        veridyn.diagnose(arm, recording, recording, effects=["stribek_friction"])
    with pytest.raises(veridyn.InvalidInput, match="found no robot of this name"):
        veridyn.read_model("no-such-robot")


def test_progress_is_reported_and_may_raise(arm, recording):
    seen = []
    veridyn.identify(bare(arm), recording, progress=lambda what, share: seen.append((what, share)))
    assert len(seen) > 2 and seen[-1][1] == 1.0

    def refuse(what, share):
        raise RuntimeError("enough of " + what)

    with pytest.raises(RuntimeError, match="enough of"):
        veridyn.identify(bare(arm), recording, progress=refuse)


def test_other_threads_run_meanwhile(arm, recording):
    ticks = []
    stop = threading.Event()

    def tick():
        while not stop.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.002)

    thread = threading.Thread(target=tick)
    thread.start()
    before = len(ticks)
    veridyn.identify(bare(arm), [recording, recording], test=recording)
    stop.set()
    thread.join()
    assert len(ticks) - before > 3


def test_ctrl_c_interrupts(arm, tmp_path):
    script = tmp_path / "long.py"
    script.write_text(
        "import os, signal, threading, veridyn\n"
        "threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
        "try:\n"
        "    veridyn.excite('kuka-lwr4', starts=2000, iterations=100000)\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted')\n"
    )
    done = subprocess.run(
        ["/usr/bin/env", "python3", script] if not os.environ.get("VERIDYN_PYTHON")
        else [os.environ["VERIDYN_PYTHON"], script],
        capture_output=True, text=True, timeout=120,
    )
    assert done.stdout.strip() == "interrupted", done.stderr


@pytest.mark.skipif(real_data() is None, reason="no real recordings here")
def test_a_real_arm():
    folder = real_data() / "psm1-thesis"
    train = [veridyn.read_recording(folder / f"fourier-{k}.csv") for k in (1, 2)]
    found = veridyn.identify("psm-3dof", train, test=folder / "fourier-3.csv", filter_cutoff=3.5)
    assert found["feasible"]
    assert max(found["test"]["relative_error"]) < 0.25


def test_the_example_names_a_spring_from_bags(tmp_path, arm, motion):
    paths = []
    for seed in (1, 2):
        spring = ["joint_spring:pitch:stiffness=3"]
        made = veridyn.simulate(arm, motion, effects=spring, noise="low", seed=seed).recording
        paths.append(str(tmp_path / f"{seed}.mcap"))
        write_mcap(paths[-1], ["outer_yaw", "outer_pitch", "outer_insertion"], made)
    example = SOURCE / "examples" / "from_a_bag.py"
    said = subprocess.run(
        [sys.executable, example, "psm-3dof", *paths], capture_output=True, text=True, check=True
    )
    assert re.match(r"Joint 2 \(pitch\): a spring of (2\.[5-9]|3\.[0-5]) N m/rad\.", said.stdout)
    bad = subprocess.run(
        [sys.executable, example, "mtm", *paths], capture_output=True, text=True, check=False
    )
    assert bad.returncode == 1 and len(bad.stderr.splitlines()) == 1

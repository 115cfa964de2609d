"""A URDF without friction, as makers publish them: the same answers as from the command."""

import os
import pathlib
import pickle
import shutil
import subprocess

import numpy as np
import pytest

import veridyn

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "examples" / "own_robot"
URDF = str(FOLDER / "labarm.urdf")


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("own_robot")
    paths = []
    for seed in (1, 2):
        motion = veridyn.excite(
            URDF, starts=1, iterations=60, seed=seed, frequency=0.1 + 0.01 * seed
        ).motion
        recording = veridyn.simulate(
            str(FOLDER / "true-arm.yaml"), motion, noise="low", seed=seed
        ).recording
        paths.append(str(folder / f"rec-{seed}.csv"))
        recording.to_pandas().to_csv(paths[-1], index=False, float_format="%.17g")
    return paths


@pytest.fixture(scope="module")
def identified(recordings):
    return veridyn.identify(URDF, recordings[0], test=recordings[1])


def test_friction_is_identified_with_it_and_said(identified):
    assert max(identified["test"]["relative_error"]) < 0.06
    assert any("has no friction" in remark for remark in identified["remarks"])
    assert identified.error_percent == [100.0 * e for e in identified["test"]["relative_error"]]
    assert identified.verdict == identified["verdict"]["sentence"]
    assert str(identified).startswith(identified.verdict)


def test_the_command_gives_the_same_model_to_the_last_bit(recordings, identified, tmp_path):
    tool = pathlib.Path(veridyn.__file__).resolve().parents[2] / "bin" / "veridyn"
    found = str(tool) if tool.exists() else shutil.which("veridyn")
    if not found:
        pytest.skip("the tool is not built")
    out = tmp_path / "command.yaml"
    subprocess.run(
        [found, "identify", URDF, "--train", recordings[0], "--test", recordings[1],
         "--model-out", str(out), "--quiet"],
        check=True, stdout=subprocess.DEVNULL,
    )
    by_command = veridyn.read_model(str(out))
    assert by_command.parameter_names == identified.model.parameter_names
    assert np.array_equal(by_command.parameters, identified.model.parameters)


def test_the_noise_of_an_identification_is_what_a_motion_is_predicted_with(identified):
    quick = {"starts": 1, "iterations": 20, "duration": 16}
    usual = veridyn.excite(URDF, **quick)["prediction"]
    learned = veridyn.excite(URDF, noise_of=identified, **quick)["prediction"]
    assert learned["median_relative_std"] < 0.2 * usual["median_relative_std"]
    with pytest.raises(veridyn.InvalidInput, match="noise_of"):
        veridyn.excite(URDF, noise_of=veridyn.read_model(URDF), **quick)


def test_friction_can_be_left_out(recordings):
    bare = veridyn.identify(URDF, recordings[0], friction="file")
    assert bare.model.effects == []
    assert max(bare["train"]["relative_error"]) > 0.2


def test_results_survive_a_pickle(identified, tmp_path):
    back = pickle.loads(pickle.dumps(identified))
    assert type(back) is veridyn.Identification and back == identified
    assert back.report() == identified.report() and back.page() == identified.page()
    assert np.array_equal(back.model.parameters, identified.model.parameters)


def test_a_frame_with_time_is_read_as_csv_is(recordings):
    frame = veridyn.read_recording(recordings[0]).to_pandas()
    named = frame.rename(columns={"t": "time"})
    assert np.array_equal(veridyn.Recording(named).time, frame["t"].to_numpy())
    with pytest.raises(veridyn.InvalidInput, match="no time, only row numbers"):
        veridyn.Recording(frame.drop(columns="t"))


def test_watch_yields_what_changed(recordings, identified):
    motion = veridyn.Recording(recordings[1])
    load = veridyn.simulate(
        str(FOLDER / "true-arm.yaml"), motion, noise="low", seed=5, effects="payload:tool0:mass=0.5"
    ).recording
    quiet = veridyn.Recording(recordings[1])
    rows = load.time > 12.0
    tau = np.where(rows[:, None], load.tau[: quiet.rows], quiet.tau)
    changed = veridyn.Recording(quiet.time, quiet.q, dq=quiet.dq, tau=tau)
    events = list(veridyn.watch(identified.model, changed))
    assert events and any(event["time"] > 12.0 for event in events)


def test_plot_draws_every_joint(identified):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    assert len(identified.plot().axes) == 4

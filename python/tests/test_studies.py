"""calibrate, fleet, friction, stability and kinematics from Python, and figures."""

import json
import os
import pathlib
import pickle
import subprocess

import numpy as np
import pytest

import veridyn

TOOL = os.environ.get("VERIDYN_TOOL", "veridyn")
SOURCE = pathlib.Path(__file__).resolve().parents[2]


def told_by_the_tool(folder, *words):
    out = folder / "told.json"
    subprocess.run([TOOL, *map(str, words), "--json", str(out), "--quiet"], check=True, capture_output=True)
    return json.loads(out.read_text())


def without_clock(keys):
    return {k: v for k, v in keys.items() if k not in ("seconds", "settings")}


def test_kinematics_are_those_of_the_model_and_of_the_command(arm, tmp_path):
    q = np.array([[0.3, -0.2, 0.1], [0.0, 0.4, 0.2]])
    there = veridyn.kinematics("psm-3dof", forward=q, frame="tool")
    for k in range(2):
        pose = arm.frame_pose(q[k], "tool")
        assert np.allclose(there.position[k], pose[:3, 3])
        assert np.allclose(there.jacobian[k], arm.frame_jacobian(q[k], "tool"))
    back = veridyn.kinematics("psm-3dof", inverse=there.position, frame="tool")
    assert back["not_reached"] == 0
    assert np.allclose(back.position, there.position, atol=1e-6)
    assert without_clock(veridyn.kinematics("psm-3dof", workspace=20)) == without_clock(
        told_by_the_tool(tmp_path, "kinematics", "psm-3dof", "--workspace", 20)
    )
    assert pickle.loads(pickle.dumps(there)).q.shape == (2, 3)
    assert there.page().lstrip().lower().startswith("<!doctype")
    with pytest.raises(veridyn.InvalidInput, match="found 2 joints"):
        veridyn.kinematics("psm-3dof", forward=[0.0, 0.0])
    with pytest.raises(TypeError, match="workspce"):
        veridyn.kinematics("psm-3dof", workspce=3)


def test_links_are_calibrated(tmp_path):
    rng = np.random.default_rng(4)
    model = veridyn.read_model("planar-2r")
    longer = tmp_path / "longer.yaml"
    longer.write_text(model.to_yaml())
    true = veridyn.read_model(longer)
    q = rng.uniform(-1.2, 1.2, (60, 2))
    frame = true.frames[-1]
    rows = []
    for k, one in enumerate(q):
        pose = true.frame_pose(one, frame)
        x, y, z = pose[:3, 3] + np.array([0.0, 0.0, 0.0])
        rows.append([0.1 * k, *one, x, y, z])
    poses = tmp_path / "poses.csv"
    np.savetxt(poses, rows, delimiter=",", header="t,q1,q2,x,y,z", comments="", fmt="%.9f")
    found = veridyn.calibrate_links("planar-2r", poses, frame=frame, base="known", tool="known")
    assert without_clock(found) == without_clock(
        told_by_the_tool(tmp_path, "calibrate", "links", "planar-2r", poses, "--frame", frame, "--base", "known", "--tool", "known")
    )
    assert found.model is not None
    assert pickle.loads(pickle.dumps(found)).model.name == found.model.name
    with pytest.raises(TypeError, match="basis"):
        veridyn.calibrate_links("planar-2r", poses, basis="free")
    with pytest.raises(veridyn.InvalidInput):
        veridyn.calibrate_rcm(tmp_path / "none.csv")


def test_a_fleet_is_that_of_the_command(arm, motion, tmp_path):
    arms = {}
    for k in range(3):
        path = tmp_path / f"{k}.csv"
        veridyn.simulate(arm, motion, noise="low", seed=k).recording.write(path)
        arms[f"arm{k}"] = path
    found = veridyn.fleet("psm-3dof", arms)
    (tmp_path / "list.csv").write_text("".join(f"{name},{path}\n" for name, path in arms.items()))
    told = told_by_the_tool(tmp_path, "fleet", "psm-3dof", tmp_path / "list.csv")
    assert without_clock(found) == without_clock(told)
    assert found.model.phi is not None
    found.save(tmp_path / "fleet.yaml")
    assert np.allclose(veridyn.read_model(tmp_path / "fleet.yaml").parameters, found.model.parameters)


def test_stability_is_that_of_the_command(tmp_path):
    scenario = SOURCE / "examples" / "cooperate" / "two-arms-spring.yaml"
    found = veridyn.stability(scenario, bounds=3)
    assert without_clock(found) == without_clock(told_by_the_tool(tmp_path, "stability", scenario, "--bounds", 3))
    assert isinstance(found.stable, bool)
    with pytest.raises(veridyn.InvalidInput, match="expected two"):
        veridyn.stability(scenario, map=("a=1:2:3",))


def test_friction_and_figures(arm, motion, recording, tmp_path):
    pyplot = pytest.importorskip("matplotlib.pyplot", reason="python3-matplotlib is not installed")
    pyplot.switch_backend("Agg")
    other = veridyn.simulate(arm, motion, noise="low", seed=9).recording
    study = veridyn.friction("psm-3dof", recording, other)
    figure = study.plot()
    assert [axis.get_title() for axis in figure.axes] == [joint["coordinate"] for joint in study["joints"]]
    assert study.model is not None
    # The model's curve is the friction that the arm was simulated with.
    drawn = study.model.plot_friction("yaw").axes[0].lines[0]
    true = arm.plot_friction(1).axes[0].lines[0]
    speed = np.abs(true.get_xdata())
    fast = (speed > 0.1) & (speed < 0.8)
    assert np.allclose(drawn.get_ydata()[fast], true.get_ydata()[fast], rtol=0.1)
    with pytest.raises(veridyn.InvalidInput, match="yaw, pitch, insertion"):
        arm.plot_friction("elbow")
    found = veridyn.diagnose("psm-3dof", recording, other, effects=["stribeck_friction"], max_effects=1)
    errors, shares = found.plot().axes
    assert [tick.get_text() for tick in errors.get_yticklabels()] == ["yaw", "pitch", "insertion"]
    assert len(shares.patches) == len(found.findings)
    assert veridyn.identify("psm-3dof", recording, test=other).plot().axes
    pyplot.close("all")

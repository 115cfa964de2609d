"""Recordings from arrays, files and frames are one and the same thing."""

import datetime
import pathlib
import pickle

import numpy as np
import pytest

import veridyn

pandas = pytest.importorskip("pandas")


def test_arrays_come_back_without_copies(recording):
    q = recording.q
    assert q.shape == (recording.rows, recording.joints)
    assert not q.flags.writeable and not q.flags.owndata
    assert recording.current is None
    assert np.shares_memory(recording.q, q)
    kept = veridyn.Recording(recording.time, q, tau=recording.tau).q
    np.testing.assert_array_equal(kept, q)  # its recording lives as long as the view


def test_files_and_frames_hold_the_same(tmp_path, recording):
    path = tmp_path / "rows.csv"
    recording.write(path)
    from_file = veridyn.read_recording(path)
    frame = pandas.read_csv(path)
    from_frame = veridyn.Recording(frame)
    for name in ("time", "q", "dq", "tau"):
        np.testing.assert_array_equal(getattr(from_file, name), getattr(from_frame, name))
        np.testing.assert_allclose(getattr(from_file, name), getattr(recording, name), rtol=1e-9)
    timed = frame.drop(columns="t").set_index(pandas.to_timedelta(frame["t"], unit="s"))
    np.testing.assert_allclose(veridyn.Recording(timed).time, recording.time, atol=2e-9)
    start = datetime.datetime(2026, 1, 1)
    dated = timed.set_index(start + timed.index)
    np.testing.assert_allclose(veridyn.Recording(dated).time, recording.time, atol=2e-9)


def test_frames_with_gaps_and_missing_columns(recording):
    frame = recording.to_pandas()
    frame.loc[10:20, "tau2"] = np.nan
    assert np.isnan(veridyn.Recording(frame).tau[15, 1])
    with pytest.raises(veridyn.InvalidInput, match="expected dq1 to dq3"):
        veridyn.Recording(frame.drop(columns="dq2"))
    with pytest.raises(veridyn.InvalidInput, match="expected t, q1 to qn"):
        veridyn.Recording(frame[["t", "tau1"]])


def test_bad_arrays_are_said(recording):
    q = recording.q
    with pytest.raises(veridyn.InvalidInput, match="numbers that rise"):
        veridyn.Recording(recording.time[::-1], q)
    with pytest.raises(veridyn.InvalidInput, match=r"tau is \(5, 3\)"):
        veridyn.Recording(recording.time, q, tau=q[:5])
    with pytest.raises(TypeError, match="needs time and q"):
        veridyn.Recording(recording.time)


def test_a_missing_file_is_invalid_input(tmp_path):
    with pytest.raises(veridyn.InvalidInput, match="no-such.csv"):
        veridyn.read_recording(tmp_path / "no-such.csv")
    with pytest.raises(TypeError, match="did you mean 'columns'"):
        veridyn.read_recording(tmp_path / "no-such.csv", column=["q"])


def test_recordings_and_models_travel(arm, recording):
    there = pickle.loads(pickle.dumps(recording))
    np.testing.assert_array_equal(there.tau, recording.tau)
    assert pickle.loads(pickle.dumps(arm)).to_yaml() == arm.to_yaml()


def test_quality_of_a_recording_in_memory(recording):
    quality = veridyn.check(recording)
    assert "rate" in str(dict(quality)) and "200" in quality.report()


SAMPLES = pathlib.Path(__file__).resolve().parents[2] / "tests" / "recordings" / "samples"
WRIST = {"wrist_1": 0.0, "wrist_2": 0.0, "wrist_3": 0.0}


@pytest.fixture(scope="module")
def truth():
    return pandas.read_csv(SAMPLES / "truth.csv", float_precision="round_trip")


@pytest.mark.parametrize("file", ["ros1_lz4.bag", "mcap_cdr_zstd.mcap", "rb2_humble_split"])
def test_bags_in_the_order_of_the_robot(file, truth):
    read = veridyn.read_recording(SAMPLES / file, robot="ur10e", fix=WRIST)
    for k, joint in enumerate(["shoulder_pan", "shoulder_lift", "elbow"]):
        np.testing.assert_array_equal(read.q[:, k], truth[f"pos.{joint}_joint"])
        np.testing.assert_array_equal(read.tau[:, k], truth[f"eff.{joint}_joint"])
        assert read.facts["matched"][joint] == f"{joint}_joint"
    assert read.facts["start"] == 1700000000.0
    assert [t["name"] for t in read.facts["topics"] if t["used"]] == ["/joint_states"]


def test_topics_names_and_units_as_the_command_takes_them(truth):
    bag = SAMPLES / "ros1_none.bag"
    turned = veridyn.read_recording(
        bag, topic="/joint_states", units={"q": "deg", "tau2": "-Nm"}, map={"tau1": "tau3", "tau3": "tau1"}
    )
    np.testing.assert_allclose(np.degrees(turned.q[:, 0]), truth["pos.elbow_joint"], rtol=1e-15)
    np.testing.assert_array_equal(turned.tau[:, 0], truth["eff.shoulder_pan_joint"])
    np.testing.assert_array_equal(turned.tau[:, 1], -truth["eff.shoulder_lift_joint"])
    same = veridyn.Recording(bag, units="q=deg,tau2=-Nm", map="tau1=tau3,tau3=tau1")
    np.testing.assert_array_equal(same.tau, turned.tau)
    with pytest.raises(veridyn.InvalidInput, match="/note"):
        veridyn.read_recording(bag, topic=["/note"])
    with pytest.raises(veridyn.InvalidInput, match="furlong"):
        veridyn.read_recording(bag, units={"q": "furlong"})
    with pytest.raises(veridyn.InvalidInput, match="expected NAME=VALUE"):
        veridyn.read_recording(bag, map="tau1")
    with pytest.raises(veridyn.InvalidInput, match="fix without robot"):
        veridyn.read_recording(bag, fix=WRIST)


def test_columns_and_rate_of_a_bare_table(tmp_path):
    path = tmp_path / "bare.csv"
    path.write_text("0.1,0.2,1\n0.2,0.3,2\n0.3,0.4,3\n")
    read = veridyn.read_recording(path, columns=["q", "dq", "tau"], rate=50.0, rows=(1, None))
    np.testing.assert_array_equal(read.q[:, 0], [0.2, 0.3])
    np.testing.assert_array_equal(read.tau[:, 0], [2, 3])
    np.testing.assert_allclose(read.time, [0.02, 0.04], rtol=1e-14)


def test_wrong_signs_are_told_of_arrays_and_files_alike(tmp_path, arm, recording):
    tau = recording.tau.copy()
    tau[:, 1] *= -1.0
    wrong = veridyn.Recording(recording.time, recording.q, dq=recording.dq, tau=tau)
    path = tmp_path / "wrong.csv"
    wrong.write(path)
    for given in (wrong, path):
        found = veridyn.check(given, robot=arm)["data_quality"]
        signs = [f["joint"] for f in found if f["finding"] == "torque_sign"]
        assert signs == [2]
    mended = veridyn.check(path, robot=arm, units={"tau2": "-Nm"})["data_quality"]
    assert not [f for f in mended if f["finding"] == "torque_sign"]


def test_identify_takes_what_reading_takes(tmp_path, arm, recording):
    frame = recording.to_pandas()
    frame["q1"] = np.degrees(frame["q1"])
    frame["tau3"] = -frame["tau3"]
    path = tmp_path / "odd.csv"
    frame.to_csv(path, index=False)
    plain = veridyn.identify("psm-3dof", recording, method="wls")
    odd = veridyn.identify("psm-3dof", path, method="wls", units={"q1": "deg", "tau3": "-N"})
    np.testing.assert_allclose(
        odd["train"]["relative_error"], plain["train"]["relative_error"], rtol=1e-6
    )

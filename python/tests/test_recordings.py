"""Recordings from arrays, files and frames are one and the same thing."""

import datetime
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

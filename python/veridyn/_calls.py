"""What the commands of the tool do, as functions. Options have the commands' names."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Callable, Iterator, List, Mapping, Optional, Sequence, TypeVar, Union

import numpy as np

from . import _veridyn
from ._options import (
    AxisOptions,
    CaptureOptions,
    DiagnosisOptions,
    ExcitationOptions,
    FitOptions,
    FleetOptions,
    HandEyeOptions,
    KinematicsOptions,
    LinksOptions,
    PreprocessingOptions,
    RecordingOptions,
    SimulationOptions,
    StabilityOptions,
    WatchOptions,
)
from ._recording import Recording
from ._results import (
    Calibration,
    Comparison,
    Diagnosis,
    Excitation,
    Fleet,
    Friction,
    Identification,
    Kinematics,
    Payload,
    Quality,
    Simulation,
    Stability,
)

if TYPE_CHECKING:
    from typing_extensions import Unpack

_PREPROCESSING = """
    filter_cutoff : float, Hz, zero-phase low-pass (5); 0: none
    filter_order : int, of one of its two passes (6)
    filtering : "matched" (torque and regressor columns alike) or "signals"
    velocity : "recorded" or "derived"
    stale_rows : "filled" or "kept": rows that a late publisher wrote twice
    resample : float, Hz, of the uniform grid; 0: one over the median time step
    drop_start, drop_end : float, s, left out at the ends of each recording (1.2, 0.5)
    min_speed : float, rad/s or m/s; a joint's slower rows are left out of the fit
    decimation : int; one filtered sample in so many is kept; 0: as the cut-off allows
    rows : (first, end) of the rows to use; end may be None
    columns, rate : signals and rate [Hz] of CSV files without a header or without time
{signals}
    fix : {joint: position} [rad], [m] of joints that are not recorded: the arm without them
    drive_gains : list, N m/A of every joint, for recordings of motor currents
    threads : int; 0: one per core
    progress : callable(what, share), called now and then
"""

_SIGNALS = """
    topic : name, or a list of names, of the topics with the joints, where a bag has several
    map : where a signal is found, {"tau1": "/arm/effort/0"}, {"tau": "/arm/effort"}, {"t": "stamp"},
        or under which name a joint is recorded, {"yaw": "outer_yaw"}
    units : units that are not SI, {"q": "deg", "t": "ms"}; {"tau": "A"}: efforts are motor
        currents; {"tau2": "-Nm"}: the other sign
"""

_FIT = """
    method : "feasible" (every body physically possible), "wls" or "ols"
    weights : "range" or "residual": how joints are weighted
    condition : "pseudo-inertia" or "principal-moments"
    signs : "physical" or "any", of friction, inertia and stiffness
    friction : "auto", "plain" or "file": plain identifies viscous and Coulomb friction, an offset
        and, where it can be told, the rotor inertia of every joint; auto does so for a maker's
        file (URDF) without friction
    prior : Model or its file, to stay close to
    known_mass : "KG@FRAME" or "KG@FRAME=REC,REC", or a list, to find drive gains with
    test_rows : (first, end) of the held-out recordings
"""


_Function = TypeVar("_Function", bound=Callable[..., Any])


def _documented(function: _Function) -> _Function:
    function.__doc__ = (function.__doc__ or "").replace("{fit}", _FIT.strip("\n")).replace(
        "{preprocessing}", _PREPROCESSING.strip("\n")
    ).replace("{signals}", _SIGNALS.strip("\n"))
    return function


def read_model(robot: Any, *, constants: Optional[Mapping[str, float]] = None) -> _veridyn.Model:
    """Reads a robot, or a MODEL (a robot with identified values).

    robot : path of a YAML, JSON, URDF, MJCF or SDF file, or the bare name of a robot that comes with veridyn
    constants : values that replace constants of the file

    Raises InvalidInput: "file:line:column: found ..., expected ...".
    """
    return _veridyn.read_model(os.fspath(robot), dict(constants or {}))


@_documented
def read_recording(path: Any, **options: Unpack[RecordingOptions]) -> Recording:
    """Reads a whole recording into memory: CSV, ROS bags, MCAP, .npz, .mat, HDF5.

    robot : Model, or the name of its file: its joints are looked for by name, in its order
    fix : {joint: position} [rad], [m] of joints of the robot that are not recorded
{signals}
    columns : list of signals, e.g. ["q", "dq", "tau"], of a CSV file without a header
    rate : float, Hz, of a file without time
    rows : (first, end) of the rows to keep; end may be None

    `.facts` of the result has format, joints, matched, topics, remarks.
    Raises InvalidInput with file, line and column.
    """
    return Recording(os.fspath(path), **options)


def read_recordings(model: Any, paths: Sequence[Any], **options: Unpack[RecordingOptions]) -> List[Recording]:
    """Recordings of an arm in memory, each file read once; joints are found by their names.

    model : Model, or the name of its file;  paths : list of files;  options : as read_recording()
    """
    options["robot"] = model
    return [read_recording(path, **options) for path in paths]


@_documented
def check(recordings: Any, **options: Unpack[RecordingOptions]) -> Quality:
    """Quality of recordings: rate, stale rows, gaps, jumps, saturation, units.

    With `robot` also whether they fit it: wrong signs of torque, swapped joints, degrees, currents.
    The keys are those of `veridyn check --json`. Options as read_recording().
    """
    return Quality(*_veridyn.check_json(recordings, options))


@_documented
def identify(
    model: Any, train: Any = None, test: Any = None, *, factors: Any = None, **options: Unpack[FitOptions]
) -> Identification:
    """Identifies an arm from training recordings and validates it on test recordings.

    model : Model, or the name of its file
    train, test : path, Recording, pandas frame, or a list of them
    factors : bytes that compress() or merge() returned, or a list of them; recordings in `train`
        are added to them
{fit}
{preprocessing}

    Returns a dictionary with the keys of `veridyn identify --json`; `.model` is the arm with the
    values found, None where the data cannot answer (self["status"], self["reason"]).
    Raises InvalidInput where a recording is bad or does not fit the arm.
    """
    if factors is None and train is None:
        raise TypeError("identify() needs train or factors.")
    if factors is None:
        native = _veridyn.identify(model, train, test, options)
    else:
        several = [factors] if isinstance(factors, (bytes, bytearray)) else list(factors)
        native = _veridyn.identify_factors(model, several, train, test, options)
    return Identification(native, "veridyn.identify(...)")


@_documented
def compress(model: Any, recordings: Any, **options: Unpack[PreprocessingOptions]) -> bytes:
    """Recordings as square-root factors: all that identify() needs of them, and not one sample.

    model : Model, or the name of its file; recordings : as identify()
{preprocessing}

    Returns bytes (about 250 kB for a recording of the PSM, of any length), that travel between machines.
    Use the same options on all of them.
    """
    return _veridyn.compress(model, recordings, options)


def merge(factors: Sequence[bytes]) -> bytes:
    """The factors of several compress() in one, in this order, for identify(factors=...).

    Raises InvalidInput where they are of two arms, were prepared differently, or are damaged.
    """
    return _veridyn.merge(list(factors))


@_documented
def evaluate(model: Any, train: Any, test: Any = None, **options: Unpack[FitOptions]) -> Identification:
    """What a model with values predicts of recordings; nothing is fitted.

    Arguments and result as identify():
{preprocessing}
    """
    return Identification(_veridyn.evaluate(model, train, test, options), "veridyn.evaluate(...)")


def validate(identification: Identification, recordings: Any) -> List[_veridyn.JointScore]:
    """Errors of an identified model on recordings that took no part in its fit, one score a joint."""
    return _veridyn.validate(identification._native, recordings)


def save(result: Any, path: Any) -> None:
    """Writes the model of an Identification or a Diagnosis, or a Model, as YAML."""
    result.save(path)


@_documented
def diagnose(model: Any, train: Any, test: Any = None, **options: Unpack[DiagnosisOptions]) -> Diagnosis:
    """Names the physical causes that the recordings accept beyond the robot's own model.

    diagnose(model, train, test): an arm without values is identified first; of a MODEL the findings
    say what changed since. diagnose(identification, test): what that fit leaves unexplained, on its
    recordings and with its preparation of them; nothing is read again.

    effects : list of names to ask about, "EFFECT" or "EFFECT:PLACE"; all where it is not given
    max_effects : int, findings at most (20)
    values : "facts" (what changed since?) or "prior" (identified first, as a URDF is)
{fit}
{preprocessing}

    Returns a dictionary with the keys of `veridyn diagnose --json`; `.model` has the findings in it.
    """
    if isinstance(model, Identification):
        if test is not None:
            raise TypeError("diagnose() of an identification takes test recordings alone.")
        native = _veridyn.diagnose_fit(model._native, train, options)
    else:
        native = _veridyn.diagnose(model, train, test, options)
    return Diagnosis(native, "veridyn.diagnose(...)")


@_documented
def find_payload(
    model: Any, recordings: Any, *, link: Optional[str] = None, **options: Unpack[FitOptions]
) -> Payload:
    """Mass, centre and inertia of an added load, for every link that might carry it.

    model : a MODEL with values
    recordings : with the load, all of them
    link : name of a frame: only this link
{preprocessing}
    """
    return Payload(_veridyn.find_payload(model, recordings, link or "", options))


def watch(
    model: Any, rows: Any, *, learn_from: Any = None, block: int = 200, **options: Unpack[WatchOptions]
) -> Iterator[dict[str, Any]]:
    """Follows an arm against its MODEL and yields what changed as soon as it is sure.

    model : a MODEL with values
    rows : a Recording, a path or a pandas frame, or an iterable of them as they come in
    learn_from : quiet recordings of the same arm, to learn its noise from beforehand
    block : rows that are looked at together
    learn : float, s, of the quiet beginning in which noise is learned (4)
    false_alarms : alarms per hour that a quiet arm may give (1)
    links : names of frames that may take up a load

    Yields dictionaries with the keys of `veridyn watch --json-lines`: event, time, since, cause,
    value, sentence.
    """
    native = _veridyn.watch(model, options)

    def whole(given: Any) -> Any:
        return given if isinstance(given, _veridyn.NativeRecording) else Recording(given)

    single = isinstance(rows, (str, os.PathLike, _veridyn.NativeRecording)) or hasattr(rows, "columns")
    quiet = [] if learn_from is None else learn_from
    for one in quiet if isinstance(quiet, (list, tuple)) else [quiet]:
        native.learn(whole(one))
    for piece in [rows] if single else rows:
        recording = whole(piece)
        for first in range(0, recording.rows, block):
            for line in native.add(recording.part(first, first + block)):
                yield json.loads(line)
    for line in native.finish():
        yield json.loads(line)


def compare(before: Any, after: Any, *, significance: float = 0.05) -> Comparison:
    """What differs between two models of one arm, with statistics.

    before, after : Model, or the name of its file
    significance : probability that two models of an unchanged arm are said to differ
    """
    return Comparison(_veridyn.compare(before, after, significance))


def excite(robot: Any, **options: Unpack[ExcitationOptions]) -> Excitation:
    """A motion that starts and stops at rest and tells the parameters apart.

    frequency : float, Hz, of the slowest wave (0.13);  harmonics : int (5)
    duration : float, s (30);  rate : float, Hz (200);  slow_passes : int (0)
    criterion : "d-optimal", "condition" (the thesis's), "a-optimal" or "discriminate"
    friction : "auto", "plain" or "file", as identify()
    between : ("EFFECT:JOINT", "EFFECT:JOINT"), the two causes to tell apart
    essential, starts, iterations, limit_share, seed, threads : as the options of `veridyn excite`
    model : the arm with values, whose efforts limit the torques
    noise_of : an Identification or its MODEL, whose residual is the noise of predicted deviations
    collisions : bool (True): links whose shapes are known keep apart; of a URDF file they are
    shapes : URDF file whose collision shapes the links have;  link_radius : float, m, of capsules
        along the lines from joint to joint
    floor : float, m, height that links stay above;  clearance : float, m (0.01)
    keep_out : boxes (x, x, y, y, z, z) [m] of the world that links stay out of
    progress : callable(what, share)

    Ctrl-C raises KeyboardInterrupt. `.motion` is the Recording to play.
    """
    return Excitation(_veridyn.excite(robot, options), "veridyn.excite(...)")


def simulate(robot: Any, motion: Any, **options: Unpack[SimulationOptions]) -> Simulation:
    """A recording of an arm along a motion, with hidden effects.

    motion : Excitation, Recording, path or pandas frame with q (and dq, ddq where known)
    effects : list of "NAME:JOINT[:KEY=VALUE,...]", as `veridyn simulate --effect`
    noise : preset of sensors, "none", "low" (default), "dvrk", "ur", ...
    controller : "none" (the arm makes the motion exactly) or "pid" (forward dynamics)
    engine : "veridyn" or "mujoco", with a controller
    sample_rate : float, Hz;  seed, arm_seed : int

    `.recording` is what the sensors say, `.truth` the arm with the effects.
    """
    return Simulation(_veridyn.simulate(robot, motion, options))


_CAPTURE = """
    unit : "m" or "mm", for motion-capture files that do not say so;  rate : float, Hz, likewise
    body : name of the body whose pose counts, of a file with several
"""


def calibrate_links(model: Any, poses: Any, **options: Unpack[LinksOptions]) -> Calibration:
    """Constants of a robot file from poses of one frame and the joints' readings.

    poses : file with t, q1..qn, x, y, z, qw, qx, qy, qz; orientation may miss
    frame : the frame that was tracked (the last one)
    base, tool : "auto", "known" or "free": the base in the poses' frame, the body on the frame
{capture}
    threads : int

    `.model` is the robot with the constants found.
    """
    return Calibration(_veridyn.calibrate_links(model, os.fspath(poses), options), "veridyn.calibrate_links(...)")


def calibrate_axis(markers: Any, **options: Unpack[AxisOptions]) -> Calibration:
    """Axes of rotation between bodies, and the links between them, from markers.

    markers : file with t, BODY/MARKER/x, BODY/MARKER/y, BODY/MARKER/z, ...
    between : pairs of bodies; all that turn about one axis where it is not given
    frames : int, used at most (1500)
{capture}
    threads : int
    """
    return Calibration(_veridyn.calibrate_axis(os.fspath(markers), options), "veridyn.calibrate_axis(...)")


def calibrate_rcm(poses: Any, **options: Unpack[CaptureOptions]) -> Calibration:
    """The remote centre that a body turns about, by pivot calibration.

    poses : file with t, x, y, z, qw, qx, qy, qz of one rigid body, or its markers
{capture}
    """
    return Calibration(_veridyn.calibrate_rcm(os.fspath(poses), options), "veridyn.calibrate_rcm(...)")


def calibrate_handeye(a: Any, b: Any, **options: Unpack[HandEyeOptions]) -> Calibration:
    """The pose between two arms, or between an arm and a camera.

    a, b : files with t, x, y, z, qw, qx, qy, qz; rows in pairs
    form : "common-poses", "common-points", "hand-eye", "eye-in-hand" or "two-bases"; the one with
        the fewest unknowns that fits where it is not given
{capture}
    """
    return Calibration(_veridyn.calibrate_handeye(os.fspath(a), os.fspath(b), options), "veridyn.calibrate_handeye(...)")


for _function in (calibrate_links, calibrate_axis, calibrate_rcm, calibrate_handeye):
    _function.__doc__ = (_function.__doc__ or "").replace("{capture}", _CAPTURE.strip("\n"))


@_documented
def fleet(model: Any, arms: Any, **options: Unpack[FleetOptions]) -> Fleet:
    """One model for many arms of one type: what they share, and which stands out.

    arms : {name: file or list of files}, or the path of a list with lines ARM,FILE; recordings, or
        factor files of `veridyn identify --factor-out`
    significance : chance of naming an arm of a fleet without an odd one (0.01)
{preprocessing}
    """
    return Fleet(_veridyn.fleet(model, arms, options), "veridyn.fleet(...)")


@_documented
def friction(model: Any, recordings: Any, test: Any = None, **options: Unpack[FitOptions]) -> Friction:
    """Friction of every joint that moves: against speed, at breakaway, and of which kind.

    model : Model, or the name of its file
    recordings, test : as identify(); without test the last recording, or the last third of one,
        judges the kinds
{preprocessing}
    """
    return Friction(_veridyn.friction(model, recordings, test, options), "veridyn.friction(...)")


def stability(scenario: Any, **options: Unpack[StabilityOptions]) -> Stability:
    """Whether a cooperation loop is stable: eigenvalues, margins, maps.

    scenario : YAML of a scenario; or a MODEL: its impedance against a wall
    set : {parameter: value} to change first
    map : ("NAME=FROM:TO:COUNT", "NAME=FROM:TO:COUNT");  locus : one of them
    recommend : float, degrees of phase margin that recommended gains have at least
    bounds : int, samples over all parameters in their intervals
    frame, pose : of a MODEL: what touches the wall, and its joints at rest
    threads : int
    """
    return Stability(_veridyn.stability(os.fspath(scenario), options), "veridyn.stability(...)")


def kinematics(robot: Any, **options: Unpack[KinematicsOptions]) -> Kinematics:
    """Poses, joints, Jacobians and conditioning of an arm.

    forward : joints (n) or (N, n), of which poses are wanted
    inverse : poses (3), (7), (N, 3) or (N, 7): x, y, z [m] and perhaps qw, qx, qy, qz
    workspace : int, postures over the ranges, where neither is given (1000)
    frame : the frame that counts (tip, tool, or the last)
    start : joints at which inverse kinematics begins
    """
    return Kinematics(_veridyn.kinematics(robot, options), "veridyn.kinematics(...)")


_Array = Union[np.ndarray, Sequence[float], Sequence[Sequence[float]]]


def inverse_dynamics(model: _veridyn.Model, q: _Array, dq: _Array, ddq: _Array) -> np.ndarray:
    """Joint torques of the rigid bodies: tau = M(q) ddq + C(q, dq) dq + g(q).

    q, dq, ddq : (n) of one state or (N, n) of many [rad, rad/s, rad/s^2], metres where prismatic.
        Row-major and column-major float64 arrays are read where they are.
    Returns tau (n) or (N, n) [N m], [N], in the layout of q. Friction and other effects are not in
    it, see joint_torques().
    Raises InvalidInput where sizes do not fit or a body has no values.
    """
    return _veridyn.inverse_dynamics(model, q, dq, ddq)


def regressor(model: _veridyn.Model, q: _Array, dq: _Array, ddq: _Array) -> np.ndarray:
    """The torques as a linear map of the bodies' parameters: tau = Y @ model.phi.

    q, dq, ddq : (n) or (N, n), as inverse_dynamics().
    Returns Y (n, 10 b) or (N, n, 10 b); columns 10 k .. 10 k + 9 belong to body k of model.bodies:
    m, m c (3), L (xx, xy, yy, xz, yz, zz about the frame's origin).
    """
    return _veridyn.regressor(model, q, dq, ddq)


def joint_torques(
    model: _veridyn.Model,
    q: _Array,
    dq: _Array,
    ddq: _Array,
    time: Optional[_Array] = None,
    *,
    substeps: int = 4,
) -> np.ndarray:
    """The whole torque of the motors: rigid bodies and every effect of the model.

    q, dq, ddq : (n) or (N, n), as inverse_dynamics()
    time : (N) [s], rising, for effects with a memory, which start fresh at the first row and see
        `substeps` states per row; without it they go from row to row
    Returns tau (n) or (N, n) [N m], [N].
    """
    return _veridyn.joint_torques(model, q, dq, ddq, time, substeps)


def mass_matrix(model: _veridyn.Model, q: _Array) -> np.ndarray:
    """M(q), (n, n), of the rigid bodies, for q (n)."""
    return _veridyn.mass_matrix(model, q)


def coriolis_matrix(model: _veridyn.Model, q: _Array, dq: _Array) -> np.ndarray:
    """C(q, dq), (n, n), for which dM/dt - 2 C is skew symmetric."""
    return _veridyn.coriolis_matrix(model, q, dq)


def robot_names() -> List[str]:
    """Bare names that read_model() knows."""
    return _veridyn.robot_names()


def effect_names() -> List[str]:
    """Names of effects that diagnose() can ask about."""
    return _veridyn.effect_names()

"""Dynamic models of real robot arms: identified, diagnosed, put to work.

>>> import veridyn
>>> arm = veridyn.read_model("psm-3dof")
>>> train = veridyn.read_recordings(arm, ["one.csv", "two.csv"])
>>> test = veridyn.read_recordings(arm, ["three.csv"])
>>> fit = veridyn.identify(arm, train)       # fit["train"]: the keys of `veridyn identify --json`
>>> veridyn.validate(fit, test)              # the error of every joint
>>> why = veridyn.diagnose(fit, test)        # a page in a notebook; nothing is read or fitted twice
>>> veridyn.save(why, "identified.yaml")
>>> controller = veridyn.JointController(why.model, kp=400, kd=40)

Units everywhere: rad, m, kg, N, N m, s. Arrays over time are (N, n): N rows, n joints. Recordings
are paths, Recording objects, pandas frames, or lists of these. Long calls release the interpreter
lock and end on Ctrl-C.
"""

import os as _os

_robots = _os.path.join(_os.path.dirname(__file__), "robots")
if _os.path.isdir(_robots):
    _os.environ.setdefault("VERIDYN_ROBOTS", _robots)

from ._veridyn import (  # noqa: E402
    ArmState,
    ComputedTorque,
    Engine,
    FrictionCompensation,
    GravityCompensation,
    Impedance,
    InvalidInput,
    JointController,
    JointScore,
    Model,
    ModelErrorObserver,
    MomentumObserver,
    Plant,
    TipController,
    __version__,
)
from ._calls import (  # noqa: E402
    calibrate_axis,
    calibrate_handeye,
    calibrate_links,
    calibrate_rcm,
    check,
    compare,
    compress,
    coriolis_matrix,
    diagnose,
    effect_names,
    evaluate,
    excite,
    find_payload,
    fleet,
    friction,
    identify,
    inverse_dynamics,
    joint_torques,
    kinematics,
    mass_matrix,
    merge,
    read_model,
    read_recording,
    read_recordings,
    regressor,
    robot_names,
    save,
    simulate,
    stability,
    validate,
    watch,
)
from ._recording import Recording  # noqa: E402
from ._results import (  # noqa: E402
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
    Result,
    Simulation,
    Stability,
    plot_friction,
)

setattr(Model, "plot_friction", plot_friction)

__all__ = [
    "ArmState",
    "Calibration",
    "Comparison",
    "ComputedTorque",
    "Diagnosis",
    "Engine",
    "Excitation",
    "Fleet",
    "Friction",
    "FrictionCompensation",
    "GravityCompensation",
    "Identification",
    "Impedance",
    "InvalidInput",
    "JointController",
    "JointScore",
    "Kinematics",
    "Model",
    "ModelErrorObserver",
    "MomentumObserver",
    "Payload",
    "Plant",
    "Quality",
    "Recording",
    "Result",
    "Simulation",
    "Stability",
    "TipController",
    "__version__",
    "calibrate_axis",
    "calibrate_handeye",
    "calibrate_links",
    "calibrate_rcm",
    "check",
    "compare",
    "compress",
    "coriolis_matrix",
    "diagnose",
    "effect_names",
    "evaluate",
    "excite",
    "find_payload",
    "fleet",
    "friction",
    "identify",
    "inverse_dynamics",
    "joint_torques",
    "kinematics",
    "mass_matrix",
    "merge",
    "read_model",
    "read_recording",
    "read_recordings",
    "regressor",
    "robot_names",
    "save",
    "simulate",
    "stability",
    "validate",
    "watch",
]

"""Dynamic models of real robot arms: identified, diagnosed, put to work.

>>> import veridyn
>>> arm = veridyn.read_model("psm-3dof")
>>> result = veridyn.identify(arm, ["one.csv", "two.csv"], test="three.csv")
>>> result["test"]["relative_error"]         # the keys of `veridyn identify --json`
>>> result.model.save("identified.yaml")
>>> veridyn.diagnose(arm, ["one.csv", "two.csv"], test="three.csv")   # a page in a notebook

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
    Model,
    ModelErrorObserver,
    MomentumObserver,
    __version__,
)
from ._calls import (  # noqa: E402
    check,
    compare,
    compress,
    coriolis_matrix,
    diagnose,
    effect_names,
    evaluate,
    excite,
    find_payload,
    identify,
    inverse_dynamics,
    joint_torques,
    mass_matrix,
    merge,
    read_model,
    read_recording,
    regressor,
    robot_names,
    simulate,
    watch,
)
from ._recording import Recording  # noqa: E402
from ._results import (  # noqa: E402
    Comparison,
    Diagnosis,
    Excitation,
    Identification,
    Payload,
    Quality,
    Result,
    Simulation,
)

__all__ = [
    "ArmState",
    "Comparison",
    "ComputedTorque",
    "Diagnosis",
    "Engine",
    "Excitation",
    "FrictionCompensation",
    "GravityCompensation",
    "Identification",
    "Impedance",
    "InvalidInput",
    "Model",
    "ModelErrorObserver",
    "MomentumObserver",
    "Payload",
    "Quality",
    "Recording",
    "Result",
    "Simulation",
    "__version__",
    "check",
    "compare",
    "compress",
    "coriolis_matrix",
    "diagnose",
    "effect_names",
    "evaluate",
    "excite",
    "find_payload",
    "identify",
    "inverse_dynamics",
    "joint_torques",
    "mass_matrix",
    "merge",
    "read_model",
    "read_recording",
    "regressor",
    "robot_names",
    "simulate",
    "watch",
]

"""Names and types of the options of every call, for editors and type checkers."""

from __future__ import annotations

from typing import Any, Callable, List, Mapping, Optional, Sequence, Tuple, TypedDict, Union

try:
    from typing import Literal
except ImportError:  # Python 3.7
    from typing_extensions import Literal  # type: ignore[assignment]

Rows = Tuple[Optional[int], Optional[int]]


class SignalOptions(TypedDict, total=False):
    topic: Union[str, Sequence[str]]
    map: Mapping[str, str]
    units: Mapping[str, str]
    columns: Sequence[str]
    rate: float
    rows: Rows
    fix: Mapping[str, float]
    drive_gains: Sequence[float]


class RecordingOptions(SignalOptions, total=False):
    robot: Any


class PreprocessingOptions(SignalOptions, total=False):
    filter_cutoff: float
    filter_order: int
    filtering: Literal["matched", "signals"]
    velocity: Literal["recorded", "derived"]
    stale_rows: Literal["filled", "kept"]
    resample: float
    drop_start: float
    drop_end: float
    min_speed: float
    decimation: int
    threads: int
    friction: Literal["auto", "plain", "file"]
    progress: Callable[[str, float], Any]


class FitOptions(PreprocessingOptions, total=False):
    method: Literal["feasible", "wls", "ols"]
    weights: Literal["range", "residual"]
    condition: Literal["pseudo-inertia", "principal-moments"]
    signs: Literal["physical", "any"]
    prior: Any
    known_mass: Union[str, List[str]]
    test_rows: Rows


class DiagnosisOptions(FitOptions, total=False):
    effects: Sequence[str]
    max_effects: int
    values: Literal["facts", "prior"]


class ExcitationOptions(TypedDict, total=False):
    frequency: float
    harmonics: int
    duration: float
    rate: float
    slow_passes: int
    criterion: Literal["d-optimal", "condition", "a-optimal", "discriminate"]
    friction: Literal["auto", "plain", "file"]
    between: Tuple[str, str]
    essential: float
    starts: int
    iterations: int
    limit_share: float
    seed: int
    threads: int
    model: Any
    noise_of: Any
    collisions: bool
    shapes: str
    link_radius: float
    floor: float
    keep_out: Sequence[Tuple[float, float, float, float, float, float]]
    clearance: float
    progress: Callable[[str, float], Any]


class SimulationOptions(TypedDict, total=False):
    effects: Union[str, Sequence[str]]
    noise: str
    controller: Literal["none", "pid"]
    engine: Literal["veridyn", "mujoco"]
    sample_rate: float
    name: str
    seed: int
    arm_seed: int


class WatchOptions(TypedDict, total=False):
    learn: float
    false_alarms: float
    links: Sequence[str]
    fix: Mapping[str, float]
    drive_gains: Sequence[float]


class CaptureOptions(TypedDict, total=False):
    unit: Literal["m", "mm", "cm"]
    body: str
    rate: float


class LinksOptions(CaptureOptions, total=False):
    frame: str
    base: Literal["auto", "known", "free"]
    tool: Literal["auto", "known", "free"]
    threads: int


class AxisOptions(CaptureOptions, total=False):
    between: Sequence[Tuple[str, str]]
    frames: int
    threads: int


class HandEyeOptions(CaptureOptions, total=False):
    form: Literal["common-poses", "common-points", "hand-eye", "eye-in-hand", "two-bases"]


class FleetOptions(PreprocessingOptions, total=False):
    significance: float


class StabilityOptions(TypedDict, total=False):
    set: Mapping[str, float]
    map: Tuple[str, str]
    locus: str
    recommend: float
    bounds: int
    frame: str
    pose: Sequence[float]
    threads: int


class KinematicsOptions(TypedDict, total=False):
    forward: Any
    inverse: Any
    workspace: int
    frame: str
    start: Sequence[float]

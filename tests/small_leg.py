"""A small leg as an OpenSim model's text: pelvis, thigh, shank and foot, eight muscles; and motions of it."""

from pathlib import Path

import numpy as np

from osim_models import LINE, axes, body, coordinate, joint, model, muscle, point, spline, written
from warpmuscle.inverse.trial import Coordinates, Loads, Plate

ROOT = ("pelvis_tilt", "pelvis_list", "pelvis_rotation", "pelvis_tx", "pelvis_ty", "pelvis_tz")
NAMES = (*ROOT, "hip_flexion", "hip_adduction", "hip_rotation", "knee_angle", "ankle_angle")
STRENGTH = (
    "<max_isometric_force>1500</max_isometric_force><optimal_fiber_length>0.12</optimal_fiber_length>"
    "<tendon_slack_length>{slack}</tendon_slack_length>"
    "<pennation_angle_at_optimal>0.1</pennation_angle_at_optimal>"
)


def _muscle(name: str, slack: float, *points: tuple[str, str]) -> str:
    path = "".join(point(f"{name}{k}", where, place) for k, (where, place) in enumerate(points))
    return muscle(name, path, more=STRENGTH.format(slack=slack))


def text() -> str:
    """The model."""
    turned = {f"rotation{k + 1}": (ROOT[k], axis, LINE) for k, axis in enumerate(("0 0 1", "1 0 0", "0 1 0"))}
    moved = {f"translation{k + 1}": (ROOT[3 + k], axis, LINE) for k, axis in enumerate(("1 0 0", "0 1 0", "0 0 1"))}
    hip = {
        "rotation1": ("hip_flexion", "0 0 1", LINE), "rotation2": ("hip_adduction", "1 0 0", LINE),
        "rotation3": ("hip_rotation", "0 1 0", LINE),
    }  # fmt: skip
    knee = {
        "rotation1": ("knee_angle", "0 0 1", LINE),
        "translation1": ("knee_angle", "1 0 0", spline("SimmSpline", "-2 -1 0 1", "0.004 0.003 -0.002 -0.004")),
    }
    bodies = "".join(
        body(name, mass, center, inertia) for name, mass, center, inertia in (
            ("pelvis", 11.0, "-0.07 0 0", "0.1 0.09 0.06 0 0 0"),
            ("femur_r", 9.0, "0 -0.17 0", "0.13 0.035 0.14 0 0 0"),
            ("tibia_r", 3.7, "0 -0.19 0", "0.05 0.005 0.05 0 0 0"),
            ("calcn_r", 1.2, "0.08 0.0 0", "0.001 0.004 0.004 0 0 0"),
        )
    )  # fmt: skip
    joints = (
        joint("CustomJoint", "ground_pelvis", "ground", "pelvis", "".join(map(coordinate, ROOT)),
              axes(**turned, **moved))
        + joint("CustomJoint", "hip_r", "pelvis", "femur_r", "".join(map(coordinate, NAMES[6:9])), axes(**hip),
                place="-0.07 -0.07 0.08")
        + joint("CustomJoint", "knee_r", "femur_r", "tibia_r", coordinate("knee_angle"), axes(**knee), place="0 -0.4 0")
        + joint("PinJoint", "ankle_r", "tibia_r", "calcn_r", coordinate("ankle_angle"), place="0 -0.43 0",
                own="0.05 0.04 0")
    )  # fmt: skip
    muscles = "".join(
        (
            _muscle("iliacus", 0.08, ("pelvis", "0.02 0.02 0.09"), ("femur_r", "0.02 -0.06 0.02")),
            _muscle("glut_max", 0.08, ("pelvis", "-0.16 0.0 0.06"), ("femur_r", "-0.03 -0.1 0.03")),
            _muscle("glut_med", 0.08, ("pelvis", "-0.05 0.06 0.11"), ("femur_r", "-0.01 -0.02 0.06")),
            _muscle("adductor", 0.08, ("pelvis", "-0.06 -0.09 0.01"), ("femur_r", "0.0 -0.12 0.03")),
            _muscle("piriformis", 0.06, ("pelvis", "-0.15 -0.02 0.02"), ("femur_r", "-0.02 -0.01 0.05")),
            _muscle("tensor", 0.1, ("pelvis", "0.01 0.04 0.12"), ("femur_r", "0.04 -0.1 0.06")),
            _muscle(
                "rectus", 0.35, ("pelvis", "-0.02 -0.02 0.1"), ("femur_r", "0.05 -0.35 0"), ("tibia_r", "0.04 -0.05 0")
            ),
            _muscle("hamstrings", 0.33, ("pelvis", "-0.12 -0.1 0.07"), ("tibia_r", "-0.03 -0.05 0")),
            _muscle("gastrocnemius", 0.36, ("femur_r", "-0.02 -0.38 0"), ("calcn_r", "0.0 0.03 0")),
            _muscle(
                "tibialis", 0.25, ("tibia_r", "0.02 -0.1 0"), ("tibia_r", "0.03 -0.39 0"), ("calcn_r", "0.12 0.02 0")
            ),
        )
    )
    return model(bodies, joints, muscles)


def small_leg(folder: Path) -> Path:
    """The model's file in a folder."""
    return written(folder, text())


def motion(frames: int = 40, rate: float = 100.0, seed: int = 0) -> Coordinates:
    """A smooth motion of all coordinates."""
    random = np.random.default_rng(seed)
    times = np.arange(frames) / rate
    phase, swing = random.uniform(0.0, 6.0, len(NAMES)), random.uniform(0.5, 1.0, len(NAMES))
    size = np.array([0.1, 0.05, 0.1, 0.05, 0.02, 0.02, 0.4, 0.1, 0.1, 0.4, 0.2])
    middle = np.array([0.0, 0.0, 0.0, 0.0, 0.95, 0.0, 0.1, 0.0, 0.0, -0.5, 0.0])
    return Coordinates(NAMES, times, middle + size * np.sin(6.0 * swing * times[:, None] + phase))


def loads(times: np.ndarray, body_name: str | None = "calcn_r") -> Loads:
    """A plate that pushes upon the foot, over some more time than a motion's."""
    step = float(np.diff(times).mean())
    at = np.concatenate([times[0] - step * np.arange(5, 0, -1), times, times[-1] + step * np.arange(1, 6)])
    force = np.stack([20.0 * np.sin(9.0 * at), 200.0 + 50.0 * np.cos(5.0 * at), 5.0 * np.sin(3.0 * at)], axis=1)
    place = np.stack([0.05 + 0.02 * at, 0.0 * at, 0.08 + 0.0 * at], axis=1)
    return Loads(at, (Plate("plate", body_name, force, place, np.tile([0.0, 2.0, 0.0], (len(at), 1))),))

"""Two small legs in a plane as an OpenSim model's text, sixteen muscles, and a squat on level ground."""

from pathlib import Path

import numpy as np

from osim_models import LINE, axes, body, coordinate, joint, model, muscle, point, written
from warpmuscle.inverse.trial import Coordinates

SEGMENT = 0.42  # m, of thigh and shank alike, so that feet stay below the hips
ANKLE = 0.08  # m, of the ankle above the sole
ROOT = ("pelvis_tilt", "pelvis_tx", "pelvis_ty")
STRENGTH = (
    "<max_isometric_force>{force}</max_isometric_force><optimal_fiber_length>0.12</optimal_fiber_length>"
    "<tendon_slack_length>{slack}</tendon_slack_length><pennation_angle_at_optimal>0.1</pennation_angle_at_optimal>"
)
MUSCLES = (
    ("iliacus", 1500, 0.08, ("pelvis", "0.06 0.02 Z"), ("femur", "0.02 -0.06 0")),
    ("gluteus", 3000, 0.1, ("pelvis", "-0.1 0.03 Z"), ("femur", "-0.04 -0.1 0")),
    ("rectus", 1500, 0.37, ("pelvis", "0.05 0.0 Z"), ("femur", "0.05 -0.36 0"), ("tibia", "0.05 -0.05 0")),
    ("vasti", 5000, 0.17, ("femur", "0.03 -0.18 0"), ("femur", "0.05 -0.36 0"), ("tibia", "0.05 -0.05 0")),
    ("hamstrings", 3000, 0.33, ("pelvis", "-0.06 -0.06 Z"), ("tibia", "-0.03 -0.05 0")),
    ("gastrocnemius", 2000, 0.36, ("femur", "-0.02 -0.38 0"), ("calcn", "0.0 0.03 0")),
    ("soleus", 4000, 0.25, ("tibia", "-0.01 -0.1 0"), ("calcn", "0.0 0.03 0")),
    ("tibialis", 1500, 0.25, ("tibia", "0.03 -0.1 0"), ("tibia", "0.04 -0.37 0"), ("calcn", "0.12 0.04 0")),
)


def text() -> str:
    """The model."""
    turned = {"rotation1": (ROOT[0], "0 0 1", LINE)}
    moved = {f"translation{k + 1}": (ROOT[1 + k], axis, LINE) for k, axis in enumerate(("1 0 0", "0 1 0"))}
    bodies = body("pelvis", 45.0, "0.04 0.2 0", "1.5 0.9 1.5 0 0 0")
    joints = joint(
        "CustomJoint", "ground_pelvis", "ground", "pelvis", "".join(map(coordinate, ROOT)), axes(**turned, **moved)
    )
    muscles = ""
    for side, away in (("r", 0.08), ("l", -0.08)):
        for name, mass, center, inertia in (
            ("femur", 8.0, "0 -0.18 0", "0.13 0.035 0.14 0 0 0"), ("tibia", 3.7, "0 -0.19 0", "0.05 0.005 0.05 0 0 0"),
            ("calcn", 1.2, "0.1 0.02 0", "0.001 0.004 0.004 0 0 0"),
            ("toes", 0.2, "0.03 0 0", "0.001 0.001 0.001 0 0 0"),
        ):  # fmt: skip
            bodies += body(f"{name}_{side}", mass, center, inertia)
        for name, parent, child, place, own in (
            ("hip_flexion", "pelvis", "femur", f"0 0 {away}", "0 0 0"),
            ("knee_angle", "femur", "tibia", f"0 {-SEGMENT} 0", "0 0 0"),
            ("ankle_angle", "tibia", "calcn", f"0 {-SEGMENT} 0", f"0.05 {ANKLE - 0.01} 0"),
        ):
            parent = parent if parent == "pelvis" else f"{parent}_{side}"
            joints += joint(
                "PinJoint", f"{name}_{side}", parent, f"{child}_{side}", coordinate(f"{name}_{side}"), place=place,
                own=own,
            )  # fmt: skip
        joints += joint("WeldJoint", f"mtp_{side}", f"calcn_{side}", f"toes_{side}", place="0.18 0 0")
        for name, force, slack, *path in MUSCLES:
            places = [(w if w == "pelvis" else f"{w}_{side}", at.replace("Z", str(away))) for w, at in path]
            points = "".join(point(f"{name}_{side}{k}", *place) for k, place in enumerate(places))
            muscles += muscle(f"{name}_{side}", points, more=STRENGTH.format(force=force, slack=slack))
    return model(bodies, joints, muscles)


def small_squat(folder: Path) -> Path:
    """The model's file in a folder."""
    return written(folder, text())


def motion(seconds: float = 0.5, rate: float = 100.0) -> Coordinates:
    """Knees that bend a little and come up again, while the feet stand."""
    times = np.arange(round(seconds * rate) + 1) / rate
    bend = 0.35 - 0.1 * np.cos(2.0 * np.pi * times / 0.8)
    names, columns = list(ROOT), [0.0 * times, 0.0 * times, ANKLE + 2.0 * SEGMENT * np.cos(bend)]
    for side in "rl":
        names += [f"hip_flexion_{side}", f"knee_angle_{side}", f"ankle_angle_{side}"]
        columns += [bend, -2.0 * bend, bend]
    return Coordinates(tuple(names), times, np.stack(columns, axis=1))

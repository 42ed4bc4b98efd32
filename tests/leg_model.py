"""A leg of OpenSim's classes as text, with markers: a free pelvis, hip, a knee that rolls, a patella, an ankle."""

import warnings
from pathlib import Path

import numpy as np

import osim_models as small
from warpmuscle.formats import load
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.inverse.chain import Chain, chain_of
from warpmuscle.inverse.trial import Markers
from warpmuscle.scene import Scene

MARKERS = {
    "pelvis": ["0.1 0.05 0.12", "0.1 0.05 -0.12", "-0.12 0.04 0.02", "0 0.15 0"],
    "femur": ["0.05 -0.15 0.03", "-0.03 -0.2 0.05", "0.02 -0.3 0.04"],
    "patella": ["0.03 0.01 0"],
    "tibia": ["0.04 -0.1 0.02", "-0.02 -0.2 0.03", "0.01 -0.35 0.04"],
    "foot": ["0.15 -0.02 0.02", "-0.05 0 0", "0.12 -0.03 0.05"],
}
PLACES = {"pelvis": "-0.07 -0.06 0.08", "femur": "0 -0.4 0", "tibia": "0 -0.42 0.01"}
RANGES = {"knee": "-2 0.2", "ankle": "-0.7 0.7"}


def coordinate(name: str, more: str = "") -> str:
    return small.coordinate(name, more).replace("-2 2", RANGES.get(name, "-3 3"))


def leg_text(clamped: bool = True, locked: str = "") -> str:
    """The model; `locked` names a coordinate that does not move."""

    def own(*names: str) -> str:
        told = f"<clamped>{str(clamped).lower()}</clamped>"
        return "".join(coordinate(name, told + "<locked>true</locked>" * (name == locked)) for name in names)

    def turned(*names: str) -> dict[str, tuple[str, str, str]]:
        axes = zip(names, ("0 0 1", "1 0 0", "0 1 0"), strict=False)
        return {f"rotation{k + 1}": (name, axis, small.LINE) for k, (name, axis) in enumerate(axes)}

    def whole(**given: tuple[str, str, str]) -> str:
        """A transform with all six axes, as OpenSim asks for; others stay at 0."""
        still = '<Constant name="function"><value>0</value></Constant>'
        kinds = {"rotation": ("0 0 1", "1 0 0", "0 1 0"), "translation": ("1 0 0", "0 1 0", "0 0 1")}
        every = {f"{kind}{k + 1}": ("", axis, still) for kind, axes in kinds.items() for k, axis in enumerate(axes)}
        return small.axes(**every | given)

    roll = small.spline("SimmSpline", "-2 -1 -0.5 0 0.3", "-0.02 -0.012 -0.005 0 0.002")
    ways = enumerate((("tx", "1 0 0"), ("ty", "0 1 0"), ("tz", "0 0 1")))
    shifts = {f"translation{k + 1}": (name, axis, small.LINE) for k, (name, axis) in ways}
    masses = {"pelvis": 10.0, "femur": 8.0, "tibia": 3.0, "patella": 0.1, "foot": 1.0}
    bodies = "".join(small.body(name, mass, "0.01 -0.1 0", "0.1 0.02 0.1 0 0 0") for name, mass in masses.items())
    joints = (
        small.joint("CustomJoint", "ground_pelvis", "ground", "pelvis", own("tilt", "list", "turn", "tx", "ty", "tz"),
                    whole(**turned("tilt", "list", "turn"), **shifts))
        + small.joint("CustomJoint", "hip", "pelvis", "femur", own("flexion", "adduction", "rotation"),
                      whole(**turned("flexion", "adduction", "rotation")), PLACES["pelvis"])
        + small.joint("CustomJoint", "knee_joint", "femur", "tibia", own("knee"), whole(
            **turned("knee"), translation1=("knee", "1 0 0", roll)), PLACES["femur"])
        + small.joint("CustomJoint", "patella_joint", "femur", "patella", own("beta"), whole(
            rotation1=("beta", "0 0 1", small.LINE)), "0.04 -0.4 0")
        + small.joint("PinJoint", "ankle_joint", "tibia", "foot", own("ankle"), "", PLACES["tibia"], "0.1 0.2 0")
    )  # fmt: skip
    coupler = (
        '<ConstraintSet><objects><CoordinateCouplerConstraint name="c"><isEnforced>true</isEnforced>'
        '<coupled_coordinates_function><LinearFunction name="f"><coefficients>0.5 0.05</coefficients></LinearFunction>'
        "</coupled_coordinates_function><independent_coordinate_names>knee</independent_coordinate_names>"
        "<dependent_coordinate_name>beta</dependent_coordinate_name></CoordinateCouplerConstraint></objects>"
        "</ConstraintSet>"
    )
    markers = "".join(
        f'<Marker name="{body}{k}"><socket_parent_frame>/bodyset/{body}</socket_parent_frame>'
        f"<location>{place}</location></Marker>"
        for body, places in MARKERS.items()
        for k, place in enumerate(places)
    )
    return small.model(bodies, joints, more=f"{coupler}<MarkerSet><objects>{markers}</objects></MarkerSet>")


def leg(folder: Path, **options: object) -> Scene:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it starts in the ground
        return load(small.written(folder, leg_text(**options)), ignored=[])


def walk(chain: Chain, frames: int = 40, seed: int = 1) -> np.ndarray:
    """Coordinates (F, C) of a smooth motion, on which the root turns right round and goes 3 m."""
    random = np.random.default_rng(seed)
    time = np.linspace(0.0, 1.0, frames)
    values = np.array(
        [0.3 * np.sin(6.0 * time + phase) for phase in random.uniform(0.0, 6.0, len(chain.coordinates))]
    ).T
    values[:, chain.coordinates.index("knee")] -= 0.6
    values[:, chain.coordinates.index("turn")] += 2.2 + 2.0 * time
    values[:, chain.coordinates.index("tx")] += 3.0 * time
    return np.clip(values, chain.low, chain.high)


def markers_of(chain: Chain, values: np.ndarray, noise: float = 0.0, seed: int = 2) -> Markers:
    """Where a chain has its markers, in ground axes, off by some metres."""
    at = chain.places(chain.poses(values), list(chain.markers.values())) @ TO_OPENSIM.T
    at = at + noise * np.random.default_rng(seed).normal(size=at.shape)
    return Markers(tuple(chain.markers), np.arange(len(values)) / 100.0 + 2.0, at)


__all__ = ["Chain", "chain_of", "leg", "leg_text", "markers_of", "walk"]

"""How a character looks in MuJoCo: colours, ground, sky, cameras."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import rotate
from warpmuscle.formats.mjcf_text import texts
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import BONE_RADIUS, foot_bodies, sides_of

BONE = "bone"  # class of geoms that are only drawn
_COLORS = {
    "left": "0.35 0.55 0.75 0.5",
    "right": "0.75 0.5 0.35 0.5",
    "middle": "0.7 0.7 0.68 0.5",
    "foot": "0.3 0.32 0.36 1",
}
_MUSCLE, _BONE_COLOR = "0.75 0.16 0.14 1", "0.93 0.9 0.82 1"
SHORTEST_BONE = 1.0e-3  # m, that is drawn
_HEIGHT, _EXTENT = 0.95, 2.2  # m, of what the camera looks at, and of what it sees
_BESIDE = (-3.2, 0.0, 0.0)  # m, of the camera from the body: on its right


def add_defaults(defaults: Element) -> None:
    """How bones and tendons are drawn; bones touch nothing and have no mass."""
    SubElement(defaults, "tendon", width="0.006", rgba=_MUSCLE)
    bone = SubElement(defaults, "default", {"class": BONE})
    SubElement(bone, "geom", type="capsule", size=str(BONE_RADIUS), contype="0", conaffinity="0", group="1", mass="0",
               rgba=_BONE_COLOR)  # fmt: skip


def add_looks(model: Element, scene: Scene, up: str) -> None:
    """Sky and ground, and the free camera, which looks at the start from the right."""
    visual = SubElement(model, "visual")
    SubElement(visual, "global", azimuth="90" if up == "z" else "0", elevation="-10", offwidth="1280", offheight="960")
    SubElement(visual, "headlight", ambient="0.35 0.35 0.35", diffuse="0.5 0.5 0.5", specular="0 0 0")
    x, _, z = (float(number) for number in scene.initial_state.root_position)  # type: ignore[arg-type]
    center = (z, x, _HEIGHT) if up == "z" else (x, _HEIGHT, z)
    SubElement(model, "statistic", center=texts(center), extent=str(_EXTENT))
    assets = SubElement(model, "asset")
    SubElement(assets, "texture", type="skybox", builtin="gradient", rgb1="0.9 0.93 0.96", rgb2="0.6 0.68 0.76",
               width="64", height="384")  # fmt: skip
    SubElement(assets, "texture", name="ground", type="2d", builtin="checker", rgb1="0.82 0.83 0.82",
               rgb2="0.74 0.75 0.74", width="256", height="256")  # fmt: skip
    SubElement(assets, "material", name="ground", texture="ground", texrepeat="0.5 0.5", texuniform="true")


def add_camera(root: Element, turned_back: Floats) -> None:
    """A camera on the right that goes along; `turned_back`: from our world to the root's axes, (4,)."""
    place, right, upwards = (rotate(turned_back, axis).tolist() for axis in (_BESIDE, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)))
    SubElement(root, "camera", name="side", mode="trackcom", pos=texts(place), xyaxes=texts([*right, *upwards]))


def look_of(scene: Scene, body: str) -> str:
    """Colour of the shapes of a body: by its side, and of feet."""
    feet = [name for foot in scene.feet or () for name in foot_bodies(scene.character, foot)]
    return _COLORS["foot" if body in feet else sides_of(scene.character)[body]]

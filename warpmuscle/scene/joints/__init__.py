"""The table of joint types: what the host must know of each, in one entry.

`joint_type(joint)` and `root_type(character)` give the entry; no other code asks for a type's name. An entry is a
`JointType`: how many coordinates, speeds, axes and limits, their names, how coordinates follow from orientation and
angular velocity and the other way round, the motion subspace with its rate, what is checked, what MuJoCo and the
original program call it, and what stands for it on the device.

A joint whose pose is a function of one coordinate, as of a slide, a knee or a screw, takes one entry and one function:

1. a subclass of `coordinate.Coordinate` with `motion`: orientation, place, motion subspace S(q), S'(q) q'^2 in NumPy,
   and `shown`, which finds the coordinate in a pose; `unit`, if it is a length; `frame`, if axis a, along which torques
   are kept, is not the first of its `axes`; `check`, for what else can be wrong;
2. a Warp function (instance, body, q, model) -> `joint_motion.JointMotion` with the same S(q) and dS/dq, which
   the entry names in `kernel`. It is compiled into models that have such joints and into no other;
3. `register(entry)`, or the entry among those that are registered here if it is to be shipped.

All else follows: kinematics, dynamics, limits, muscles across it, control, prescribed motion, inverse dynamics, files,
viewer, figures. `tests/scene/joints/test_new_type.py` adds a screw so. A joint of several speeds, or with a quaternion,
needs stages of its own in `kernels.body.kinematics`, `dynamics`, `integration`, `limits` and `control` besides.

May import: core, scene, kernels.algebra.
To add: a type, as a `JointType` in a file here, and its name among those that are registered.
"""

from __future__ import annotations

from warpmuscle.core.errors import Error
from warpmuscle.scene import Character, Joint
from warpmuscle.scene.joints.coordinate import SLIDE
from warpmuscle.scene.joints.coupled import COUPLED, FOLLOWER
from warpmuscle.scene.joints.joint_type import JointKinematics as JointKinematics
from warpmuscle.scene.joints.joint_type import JointType as JointType
from warpmuscle.scene.joints.roots import FIXED_ROOT, FREE, PLANAR
from warpmuscle.scene.joints.roots import RootType as RootType
from warpmuscle.scene.joints.turning import BALL, FIXED, HINGE, UNIVERSAL

TYPES: dict[str, JointType] = {}
ROOT_TYPES: dict[str, RootType] = {entry.name: entry for entry in (FREE, PLANAR, FIXED_ROOT)}


def register(entry: JointType) -> None:
    """Let scenes have joints of one more type.

    Raises:
        Error: there is one of that name, or it does not say how it moves.
    """
    if not isinstance(entry, JointType):
        raise Error(f"register an instance of a `JointType`, such as Screw(name='screw', ...), not {entry!r}")
    if entry.name in TYPES:
        raise Error(f"there is a joint type {entry.name!r} already")
    for method in ("motion", "nearest"):
        if getattr(type(entry), method) is getattr(JointType, method):
            raise Error(f"joint type {entry.name!r} has no method `{method}`")
    if not entry.kernel and not entry.device:
        raise Error(f"joint type {entry.name!r} names no `kernel`, the 'module:function' of its motion on the device")
    TYPES[entry.name] = entry


for _entry in (BALL, UNIVERSAL, HINGE, FIXED, SLIDE, COUPLED):
    register(_entry)


def joint_type(joint: Joint) -> JointType:
    """The entry of a joint of a checked scene; one that follows another joint has one of its own."""
    return FOLLOWER if joint.follows else TYPES[joint.type]


def root_type(character: Character) -> RootType:
    """The entry of the root of a character."""
    return ROOT_TYPES[character.root_joint]


def __getattr__(name: str) -> None:
    """Say what a name of before is called now; an AttributeError would be swallowed by `from ... import`."""
    if name == "Motion":
        raise ImportError("warpmuscle.scene.joints.Motion is called JointKinematics now")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

"""Bones of a figure as people have them, made of tubes and ellipsoids in the proportions of its joints; numbers only.

Forms are of our own making: they are to be believed at a glance, and nothing is measured by them. All lengths are m of
a body of 75 kg, times its `scale`; y is up, x to the left and z forward.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.view.bones.meshes import ellipsoid, merged, plate, tube
from warpmuscle.view.hulls import Mesh

AHEAD = np.array([0.0, 0.0, 1.0])
ASIDE = np.array([1.0, 0.0, 0.0])
RIBS = 9  # pairs
ARM = 0.11  # m, shortest of a limb with a form of its own


def _unit(vector: Floats) -> Floats:
    return np.asarray(vector / max(float(np.linalg.norm(vector)), 1e-9))


def _perpendicular(axis: Floats, wanted: Floats) -> Floats:
    """The direction across an axis that is nearest to a wanted one."""
    across = wanted - np.dot(wanted, axis) * axis
    return _unit(across) if np.linalg.norm(across) > 0.2 else _unit(np.cross(axis, AHEAD))


def _turned(axis: Floats, aside: Floats) -> Floats:
    """Axes (3, 3), as columns, of which y is along a bone and x aside."""
    return np.stack([aside, axis, np.cross(aside, axis)], axis=1)


def plain_bone(start: Floats, end: Floats, scale: float) -> Mesh:
    """A bone with thick ends."""
    part = np.array([0.0, 0.06, 0.2, 0.5, 0.8, 0.94, 1.0])
    radius = scale * np.array([0.016, 0.017, 0.0105, 0.009, 0.0105, 0.017, 0.016])
    length = float(np.linalg.norm(end - start))
    return tube(start + part[:, None] * (end - start), np.minimum(radius, 0.2 * length))


def knee_cap(middle: Floats, scale: float) -> Mesh:
    """A patella that hangs on a body of its own."""
    return ellipsoid(middle, (0.018 * scale, 0.02 * scale, 0.009 * scale))


def thigh_bone(start: Floats, end: Floats, sign: float, scale: float, capped: bool = True) -> Mesh:
    """A femur from the middle of its head to the knee, with a kneecap if `capped`; `sign` is 1 on the left."""
    down, s = _unit(end - start), scale
    out = _perpendicular(down, sign * ASIDE)
    front = np.cross(down, out) * sign
    trochanter = start + s * (0.046 * out + 0.022 * down)
    below = start + s * 0.02 * out + 0.22 * (end - start) + s * 0.014 * out
    middle, above = start + 0.55 * (end - start) + s * 0.014 * out, start + 0.88 * (end - start) + s * 0.002 * out
    axes = _turned(-down, _unit(np.cross(-down, front)))
    return merged(
        [
            ellipsoid(start, (0.024 * s,) * 3),
            tube([start, 0.5 * (start + trochanter), trochanter], s * np.array([0.015, 0.014, 0.018])),
            tube(
                [trochanter, below, middle, above, end - s * 0.012 * down],
                s * np.array([0.019, 0.0145, 0.013, 0.0155, 0.025]),
            ),
            *(
                ellipsoid(end + s * (side * 0.02 * out - 0.004 * front), (0.0175 * s, 0.021 * s, 0.026 * s), axes)
                for side in (1, -1)
            ),
            *([ellipsoid(end + s * (0.036 * front - 0.012 * down), (0.018 * s, 0.02 * s, 0.009 * s), axes)] * capped),
        ]
    )


def shank_bones(start: Floats, end: Floats, sign: float, scale: float) -> Mesh:
    """Tibia and fibula from the knee to the ankle."""
    down, s, reach = _unit(end - start), scale, end - start
    out = _perpendicular(down, sign * ASIDE)
    front = np.cross(down, out) * sign
    axes = _turned(-down, _unit(np.cross(-down, front)))
    top = start + s * 0.026 * down
    part = np.array([0.0, 0.1, 0.3, 0.65, 0.92, 1.0])
    bow = np.array([0.0, 0.006, 0.008, 0.004, 0.0, 0.0])
    shin = top + part[:, None] * (end - top) + s * bow[:, None] * front - s * 0.004 * out
    calf = np.array(
        [start + 0.11 * reach + s * 0.03 * out, start + 0.5 * reach + s * 0.027 * out, end + s * 0.026 * out]
    )
    return merged(
        [
            ellipsoid(top, (0.036 * s, 0.012 * s, 0.026 * s), axes),
            tube(shin, s * np.array([0.024, 0.0165, 0.0125, 0.0105, 0.0145, 0.018])),
            tube(calf - s * 0.008 * front, s * np.array([0.009, 0.0055, 0.0085])),
            ellipsoid(end + s * (0.027 * out + 0.004 * down), (0.009 * s, 0.017 * s, 0.012 * s), axes),
            ellipsoid(end - s * 0.023 * out, (0.008 * s, 0.013 * s, 0.012 * s), axes),
        ]
    )


def upper_arm_bone(start: Floats, end: Floats, scale: float) -> Mesh:
    """A humerus from the shoulder to the elbow."""
    along, s = _unit(end - start), scale
    side = _perpendicular(along, AHEAD)
    part = np.array([0.03, 0.15, 0.4, 0.75, 0.92, 1.0])
    shaft = start + part[:, None] * (end - start)
    above = start + 0.8 * (end - start)
    ridges = [
        tube(
            [above, end + s * (way * 0.021 * side - 0.018 * along), end + s * way * 0.024 * side],
            s * np.array([0.009, 0.0105, 0.01]),
        )
        for way in (1.0, -1.0)
    ]
    return merged(
        [
            ellipsoid(start, (0.024 * s,) * 3),
            tube(shaft, s * np.array([0.018, 0.0125, 0.0105, 0.0105, 0.0125, 0.012])),
            *ridges,
            tube([end - s * 0.024 * side, end, end + s * 0.024 * side], s * np.array([0.0125, 0.011, 0.0125])),
        ]
    )


def forearm_bones(start: Floats, end: Floats, scale: float) -> Mesh:
    """Radius and ulna from the elbow to the wrist."""
    along, s, reach = _unit(end - start), scale, end - start
    side = _perpendicular(along, AHEAD)
    part = np.array([0.0, 0.12, 0.5, 0.88, 1.0])[:, None]
    apart = np.array([0.012, 0.014, 0.018, 0.015, 0.014])[:, None]
    first, second = (start + part * reach + s * way * apart * side for way in (1.0, -1.0))
    return merged(
        [
            tube(first, s * np.array([0.01, 0.0075, 0.007, 0.01, 0.0125])),
            tube(second, s * np.array([0.0135, 0.0105, 0.0065, 0.006, 0.0075])),
        ]
    )


def hand_bones(start: Floats, end: Floats, scale: float) -> Mesh:
    """Wrist, palm and fingers from the wrist to the finger tips."""
    along, s, reach = _unit(end - start), scale, end - start
    side = _perpendicular(along, AHEAD)
    parts = [ellipsoid(start + 0.08 * reach, (0.024 * s, 0.012 * s, 0.014 * s), _turned(along, side))]
    for k, length in enumerate((0.93, 1.0, 0.95, 0.82)):
        spread = (0.022 - 0.0148 * k) * s
        points = [
            start + 0.12 * reach + 0.6 * spread * side,
            start + 0.5 * reach + spread * side,
            start + 0.74 * length * reach + 1.15 * spread * side,
            start + length * reach + 1.2 * spread * side,
        ]
        parts.append(tube(points, s * np.array([0.006, 0.0065, 0.0055, 0.004]), 5))
    thumb = [
        start + 0.1 * reach + s * 0.018 * side,
        start + 0.3 * reach + s * 0.042 * side,
        start + 0.52 * reach + s * 0.052 * side,
    ]
    parts.append(tube(thumb, s * np.array([0.0065, 0.006, 0.0045]), 5))
    return merged(parts)


def pelvis_bones(hips: Sequence[Floats], top: Floats, scale: float) -> Mesh:
    """Two hip bones between the hips and the joint of the spine, and the sacrum."""
    s, middle = scale, 0.5 * (hips[0] + hips[1])
    tall = max(float(top[1] - middle[1]), 0.08 * s)
    front = np.array([0.0, middle[1] - 0.025 * s, middle[2] + 0.048 * s])  # where both meet
    tail = np.array([0.0, middle[1] - 0.01 * s, middle[2] - 0.075 * s])
    spine = np.array([0.0, min(float(top[1]), middle[1] + 0.14 * s), top[2] - 0.012 * s])
    parts = [
        tube(
            [spine, 0.5 * (spine + tail) - np.array([0.0, 0.0, 0.018 * s]), tail], s * np.array([0.032, 0.026, 0.009])
        ),
        tube(np.linspace(spine, top, 5), s * np.array([0.02, 0.0235, 0.02, 0.0235, 0.02])),
        ellipsoid(front, (0.024 * s, 0.016 * s, 0.011 * s)),
    ]
    for hip in hips:
        side, up = np.sign(hip[0]) * ASIDE, np.array([0.0, 1.0, 0.0])
        before = hip + s * (0.026 * side + 0.05 * AHEAD) + 0.52 * tall * up
        behind = np.array([0.036 * s * side[0], spine[1] - 0.2 * tall, spine[2] - 0.03 * s])
        high = 0.5 * (before + behind) + 0.02 * s * side + 0.36 * tall * up
        part = np.linspace(0.0, 1.0, 9)[:, None]
        crest = (
            (1.0 - part) ** 2 * before
            + 2.0 * part * (1.0 - part) * (2.0 * high - 0.5 * (before + behind))
            + part**2 * behind
        )
        rim = np.linspace(0.03, -0.028, 9)[:, None] * s * AHEAD + hip + 0.018 * s * up
        low = hip - s * (0.022 * side + 0.03 * AHEAD) - 0.072 * s * up
        parts += [
            tube(crest, s * np.array([0.009, 0.0095, 0.01, 0.0105, 0.0105, 0.0105, 0.01, 0.011, 0.012])),
            plate(rim, crest, 0.012 * s),
            ellipsoid(hip, (0.028 * s, 0.032 * s, 0.032 * s)),
            tube([hip, 0.6 * hip + 0.4 * behind, behind], s * np.array([0.026, 0.019, 0.014])),
            tube(
                [hip, 0.5 * (hip + front) + s * 0.014 * AHEAD, front + s * 0.012 * side],
                s * np.array([0.018, 0.0115, 0.0125]),
            ),
            tube(
                [hip - s * 0.012 * AHEAD, low, 0.5 * (low + front) - 0.012 * s * up, front],
                s * np.array([0.019, 0.0195, 0.01, 0.011]),
            ),
        ]
    return merged(parts)


def trunk_bones(start: Floats, neck: Floats, shoulders: Sequence[Floats], scale: float) -> Mesh:
    """Spine and ribs between the joints of loin and neck, breastbone, collar bones and shoulder blades."""
    reach, s = neck - start, scale
    tall, up = float(np.linalg.norm(reach)), _unit(reach)
    ahead = _perpendicular(up, AHEAD)
    wide = float(np.clip(max((abs(x[0]) for x in shoulders), default=0.2 * s) * 0.68, 0.09 * s, 0.15 * s))
    deep = 0.74 * wide
    aside = np.cross(up, ahead)

    def back(part: Floats) -> Floats:  # the spine, bowed backwards behind the ribs
        bow = np.sin(np.pi * np.clip((part - 0.1) / 0.9, 0.0, 1.0))
        return np.asarray(start + part[..., None] * reach - (0.78 * deep * bow)[..., None] * ahead)

    part = np.linspace(0.0, 1.0, 37)
    parts = [tube(back(part), s * np.where(np.arange(37) % 2, 0.0135, 0.019))]
    round_ = np.linspace(0.0, 0.93 * np.pi, 13)
    ends = []
    for k in range(RIBS):
        at = 0.9 - 0.56 * k / (RIBS - 1)
        form = np.sin(np.pi * (0.2 + 0.52 * k / (RIBS - 1)))  # narrow at the top
        floating = max(0, k - (RIBS - 3))
        sweep = round_ * (1.0 - 0.17 * floating)
        begin = back(np.array([at]))[0]
        centre = begin + 1.0 * deep * form * ahead
        drop = tall * (0.05 + 0.16 * (k + 1) / RIBS)
        for sign in (1.0, -1.0):
            points = (
                centre
                + sign * wide * form * np.sin(sweep)[:, None] * aside
                - deep * form * np.cos(sweep)[:, None] * ahead
                - (drop * (0.5 - 0.5 * np.cos(np.minimum(sweep * 1.15, np.pi))))[:, None] * up
                + (drop * 0.5 * np.clip((sweep - 2.2) / 0.7, 0.0, 1.0) ** 2)[:, None] * up
            )
            parts.append(tube(points, 0.0062 * s, 5))
            if not floating:
                ends.append(points[-1])
    high, low = ends[0], ends[-1]
    high, low = (np.asarray(x - np.dot(x - start, aside) * aside) for x in (high, low))
    bone = np.linspace(high + 0.01 * s * up, low, 5)
    parts.append(tube(bone, s * np.array([0.019, 0.016, 0.0135, 0.0135, 0.009])))
    for shoulder in shoulders:
        side = np.sign(np.dot(shoulder - start, aside)) * aside
        inner = high + 0.016 * s * side + 0.012 * s * up
        parts.append(
            tube(
                [
                    inner,
                    0.5 * (inner + shoulder) + s * (0.014 * up + 0.018 * ahead),
                    shoulder + s * (0.026 * up - 0.004 * ahead),
                ],
                s * np.array([0.0105, 0.0075, 0.0095]),
            )
        )
        blade = shoulder - s * (0.078 * side + 0.055 * up + 0.062 * ahead)
        axes = _turned(up, _unit(side + 0.55 * ahead))
        parts.append(ellipsoid(blade, (0.046 * s, 0.07 * s, 0.0085 * s), axes))
        parts.append(
            tube(
                [
                    blade + s * (0.045 * up - 0.03 * side - 0.006 * ahead),
                    shoulder + s * (0.02 * up - 0.02 * ahead),
                    shoulder + s * (0.027 * up + 0.004 * ahead),
                ],
                s * np.array([0.0065, 0.0085, 0.01]),
            )
        )
        parts.append(tube([blade + s * 0.02 * side, shoulder - s * 0.024 * side], s * np.array([0.012, 0.015])))
    return merged(parts)


def skull(joint: Floats, center: Floats, radius: float) -> tuple[Mesh, Mesh]:
    """Skull, jaw and spine of the neck, as high as a sphere; and its hollows, which are dark."""
    up = _unit(center - joint)
    ahead, r = _perpendicular(up, AHEAD), radius
    aside = np.cross(up, ahead)
    axes = np.stack([aside, up, ahead], axis=1)

    def at(x: float, y: float, z: float) -> Floats:
        return np.asarray(center + r * (x * aside + y * up + z * ahead))

    neck = np.linspace(joint, at(0.0, -0.42, -0.2), 15)
    half = np.array([[0.5, -0.26, 0.08], [0.49, -0.5, 0.09], [0.46, -0.66, 0.15], [0.38, -0.76, 0.36],
                     [0.25, -0.83, 0.58], [0.1, -0.87, 0.7]])  # fmt: skip
    jaw = [at(*place) for place in [*half, *(half[::-1] * [-1.0, 1.0, 1.0])]]
    thick = np.array([0.07, 0.12, 0.13, 0.12, 0.13, 0.14])
    bones = [
        ellipsoid(at(0.0, 0.26, -0.08), (0.66 * r, 0.68 * r, 0.84 * r), axes, 26),
        ellipsoid(at(0.0, 0.3, 0.2), (0.58 * r, 0.56 * r, 0.6 * r), axes, 22),  # the forehead
        ellipsoid(at(0.0, -0.2, 0.4), (0.43 * r, 0.42 * r, 0.36 * r), axes, 20),
        ellipsoid(at(0.0, 0.07, 0.5), (0.45 * r, 0.13 * r, 0.27 * r), axes, 18),
        ellipsoid(at(0.0, -0.52, 0.5), (0.29 * r, 0.15 * r, 0.24 * r), axes, 18),
        ellipsoid(at(0.0, -0.68, 0.52), (0.25 * r, 0.06 * r, 0.22 * r), axes, 16),  # teeth
        tube([at(0.0, 0.02, 0.7), at(0.0, -0.12, 0.79), at(0.0, -0.2, 0.83)], r * np.array([0.07, 0.055, 0.03])),
        tube(jaw, r * np.array([*thick, *thick[::-1]]), 12),
        tube(neck, r * np.where(np.arange(15) % 2, 0.15, 0.21)),
    ]
    for sign in (1.0, -1.0):
        cheek = [at(sign * 0.6, -0.17, 0.05), at(sign * 0.58, -0.2, 0.26), at(sign * 0.5, -0.22, 0.48),
                 at(sign * 0.3, -0.25, 0.64)]  # fmt: skip
        bones.append(tube(cheek, r * np.array([0.06, 0.06, 0.085, 0.12])))
        bones.append(ellipsoid(at(sign * 0.5, -0.34, -0.06), (0.1 * r, 0.17 * r, 0.11 * r), axes))  # behind the ear
    hollows = [ellipsoid(at(sign * 0.22, -0.07, 0.62), (0.15 * r, 0.13 * r, 0.12 * r), axes) for sign in (1.0, -1.0)]
    hollows.append(ellipsoid(at(0.0, -0.32, 0.73), (0.08 * r, 0.11 * r, 0.06 * r), axes))
    return merged(bones), merged(hollows)


def foot_bones(ankle: Floats, ball: Floats, heel: float, sole: float, sign: float, scale: float) -> Mesh:
    """Ankle, heel and metatarsals of a foot.

    Args:
        ankle, ball: joints of the foot and of its toes. heel: its end along z. sole: height of the ground below it.
    """
    s, length = scale, float(ball[2] - heel)
    under = max(float(ankle[1]) - sole, 0.03 * s)
    back = np.array([ankle[0], sole + 0.42 * under, heel + 0.028 * s])
    arch = np.array([ankle[0] - sign * 0.004 * s, sole + 0.62 * under, ankle[2] + 0.4 * float(ball[2] - ankle[2])])
    high = np.array([ankle[0], min(float(ankle[1]), sole + 0.085 * s), ankle[2]])
    parts = [
        ellipsoid(high - np.array([0.0, 0.008 * s, -0.004 * s]), (0.021 * s, 0.017 * s, 0.028 * s)),
        tube([back, 0.6 * back + 0.4 * arch, arch], s * np.array([0.023, 0.02, 0.017])),
        ellipsoid(arch, (0.03 * s, 0.015 * s, 0.022 * s)),
    ]
    for k in range(5):
        out = sign * (-0.026 + 0.0125 * k) * s
        begin = arch + np.array([0.75 * out, -0.12 * under * k / 4.0, 0.01 * s])
        end = np.array([ball[0] + out, sole + 0.012 * s, ball[2] - 0.05 * length * k / 4.0])
        thick = (0.0088 if k == 0 else 0.0062) * s
        parts.append(
            tube(
                [begin, 0.5 * (begin + end) + np.array([0.0, 0.004 * s, 0.0]), end],
                [thick, 0.85 * thick, 1.2 * thick],
                5,
            )
        )
    return merged(parts)


def toe_bones(ball: Floats, tip: float, sole: float, sign: float, scale: float) -> Mesh:
    """Five toes from their joint forwards to `tip`, along z."""
    s = scale
    parts = []
    for k in range(5):
        out, long = sign * (-0.026 + 0.0125 * k) * s, (0.97, 1.0, 0.93, 0.84, 0.72)[k]
        thick = (0.0085 if k == 0 else 0.0055) * s
        begin = np.array([ball[0] + out, sole + 0.012 * s, ball[2] - 0.01 * s * k / 4.0])
        end = np.array([ball[0] + 1.08 * out, sole + 0.008 * s, ball[2] + long * max(tip - float(ball[2]), 0.03 * s)])
        parts.append(
            tube(
                [begin, 0.5 * (begin + end) + np.array([0.0, 0.004 * s, 0.0]), end],
                [1.1 * thick, 0.9 * thick, thick],
                5,
            )
        )
    return merged(parts)

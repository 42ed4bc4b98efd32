"""Bones of a figure as people have them, made of tubes and ellipsoids in the proportions of its joints; numbers only.

Forms are of our own making: they are to be believed at a glance, and nothing is measured by them. All lengths are m of
a body of 75 kg, times its `scale`; y is up, x to the left and z forward.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import normalized
from warpmuscle.view.bones.blended import Part, blended, egg, fan, rod
from warpmuscle.view.bones.directions import AHEAD, ASIDE, perpendicular, turned, unit
from warpmuscle.view.bones.meshes import ellipsoid, merged, tube
from warpmuscle.view.bones.spine import vertebrae
from warpmuscle.view.hulls import Mesh

MIRROR = np.array([-1.0, 1.0, 1.0])
RIBS, TRUE_RIBS = 10, 6  # pairs, and those that end at the breastbone
LIMB_CELL, LIMB_BLEND = 0.0098, 0.0024  # m, of the surfaces of long bones
ARM = 0.11  # m, shortest of a limb with a form of its own


def _mirrored(mesh: Mesh) -> Mesh:
    """A mesh of the other side."""
    corners, normals, faces = mesh
    return corners * MIRROR, normals * MIRROR, faces[:, ::-1]


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
    if sign < 0.0:
        return _mirrored(thigh_bone(start * MIRROR, end * MIRROR, 1.0, scale, capped))
    down, s = unit(end - start), scale
    out = perpendicular(down, ASIDE)
    front = np.cross(down, out)
    trochanter = start + s * (0.046 * out + 0.018 * down - 0.004 * front)
    below = start + s * 0.02 * out + 0.2 * (end - start) + s * 0.012 * out
    middle = start + 0.55 * (end - start) + s * (0.014 * out + 0.008 * front)
    above = start + 0.88 * (end - start) + s * 0.002 * out
    axes = turned(-down, unit(np.cross(-down, front)))
    parts: list[Part] = [
        egg(start, (0.0235 * s,) * 3),
        rod([start, start + s * (0.024 * out + 0.013 * down), below], s * np.array([0.016, 0.0145, 0.0145])),
        egg(trochanter, (0.015 * s, 0.026 * s, 0.019 * s), axes),
        rod([start + s * (0.03 * out + 0.05 * down - 0.014 * front), below], s * np.array([0.009, 0.01])),
        rod(
            [trochanter, below, middle, above, end - s * 0.012 * down],
            s * np.array([0.013, 0.0145, 0.0128, 0.0155, 0.022]),
        ),
        *(
            egg(end + s * (side * 0.0205 * out - 0.008 * front), (0.0165 * s, 0.02 * s, 0.025 * s), axes)
            for side in (1, -1)
        ),
    ]
    bone = blended(parts, LIMB_CELL * s, LIMB_BLEND * s, axes=axes)
    cap = ellipsoid(end + s * (0.031 * front - 0.012 * down), (0.018 * s, 0.02 * s, 0.009 * s), axes)
    return merged([bone, cap]) if capped else bone


def shank_bones(start: Floats, end: Floats, sign: float, scale: float) -> Mesh:
    """Tibia and fibula from the knee to the ankle."""
    if sign < 0.0:
        return _mirrored(shank_bones(start * MIRROR, end * MIRROR, 1.0, scale))
    down, s, reach = unit(end - start), scale, end - start
    out = perpendicular(down, ASIDE)
    front = np.cross(down, out)
    axes = turned(-down, unit(np.cross(-down, front)))
    top = start + s * 0.028 * down
    part = np.array([0.0, 0.1, 0.3, 0.65, 0.92, 1.0])
    bow = np.array([0.0, 0.006, 0.008, 0.004, 0.0, 0.0])
    shin = top + part[:, None] * (end - top) + s * bow[:, None] * front - s * 0.004 * out
    calf = np.array(
        [start + 0.12 * reach + s * 0.031 * out, start + 0.5 * reach + s * 0.03 * out, end + s * 0.027 * out]
    )
    tibia: list[Part] = [
        egg(top, (0.037 * s, 0.0125 * s, 0.025 * s), axes),
        rod(shin, s * np.array([0.023, 0.0165, 0.0125, 0.0105, 0.0145, 0.0175])),
        rod([shin[1] + 0.011 * s * front, shin[2] + 0.006 * s * front], s * np.array([0.0095, 0.007])),
        egg(end - s * 0.022 * out, (0.009 * s, 0.014 * s, 0.013 * s), axes),
    ]
    fibula: list[Part] = [
        rod(calf - s * 0.01 * front, s * np.array([0.0095, 0.0064, 0.0085])),
        egg(calf[0] - s * 0.01 * front, (0.012 * s, 0.014 * s, 0.012 * s), axes),
        egg(end + s * (0.027 * out + 0.004 * down - 0.006 * front), (0.009 * s, 0.018 * s, 0.012 * s), axes),
    ]
    return merged([blended(one, LIMB_CELL * s, LIMB_BLEND * s, axes=axes) for one in (tibia, fibula)])


def upper_arm_bone(start: Floats, end: Floats, scale: float) -> Mesh:
    """A humerus from the shoulder to the elbow."""
    along, s = unit(end - start), scale
    side = perpendicular(along, AHEAD)
    axes = turned(-along, side)
    part = np.array([0.06, 0.15, 0.4, 0.75, 0.92, 1.0])
    shaft = start + part[:, None] * (end - start)
    above = start + 0.8 * (end - start)
    ridges = [
        rod([above, end + s * (way * 0.022 * side - 0.016 * along), end + s * way * 0.025 * side],
            s * np.array([0.0085, 0.0095, 0.009]))
        for way in (1.0, -1.0)
    ]  # fmt: skip
    parts: list[Part] = [
        egg(start, (0.0235 * s,) * 3),
        egg(start + s * (0.016 * side + 0.012 * along), (0.011 * s, 0.016 * s, 0.011 * s), axes),
        rod(shaft, s * np.array([0.0175, 0.0128, 0.0108, 0.0108, 0.012, 0.011])),
        *ridges,
        rod([end - s * 0.022 * side, end, end + s * 0.022 * side], s * np.array([0.0135, 0.0105, 0.013])),
    ]
    return blended(parts, LIMB_CELL * s, LIMB_BLEND * s, axes=axes)


def forearm_bones(start: Floats, end: Floats, scale: float) -> Mesh:
    """Radius and ulna from the elbow to the wrist."""
    along, s, reach = unit(end - start), scale, end - start
    side = perpendicular(along, AHEAD)
    part = np.array([0.02, 0.14, 0.5, 0.88, 0.98])[:, None]
    apart = np.array([0.012, 0.014, 0.019, 0.015, 0.013])[:, None]
    first, second = (start + part * reach + s * way * apart * side for way in (1.0, -1.0))
    parts: list[Part] = [
        rod(first, s * np.array([0.0105, 0.0075, 0.0075, 0.01, 0.0135])),
        rod([second[0] - 0.014 * s * along, *second], s * np.array([0.011, 0.0135, 0.0105, 0.007, 0.0062, 0.0078])),
    ]
    return blended(parts, 0.0078 * s, 0.0012 * s, axes=turned(-along, side))


def hand_bones(start: Floats, end: Floats, scale: float) -> Mesh:
    """Wrist, palm and fingers from the wrist to the finger tips."""
    along, s, reach = unit(end - start), scale, end - start
    side = perpendicular(along, AHEAD)
    parts = [ellipsoid(start + 0.08 * reach, (0.024 * s, 0.012 * s, 0.014 * s), turned(along, side))]
    part = np.array([0.1, 0.28, 0.46, 0.5, 0.62, 0.7, 0.74, 0.82, 0.87, 0.91, 1.0])
    thick = np.array([0.0058, 0.0045, 0.0068, 0.0066, 0.0045, 0.0056, 0.0055, 0.004, 0.0046, 0.0042, 0.0032])
    for k, length in enumerate((0.93, 1.0, 0.95, 0.82)):
        spread, far = (0.024 - 0.0158 * k) * s, np.where(part > 0.5, 0.5 + (part - 0.5) * (2.0 * length - 1.0), part)
        fan_out = np.interp(part, [0.1, 0.5, 1.0], [0.55, 1.0, 1.25])
        parts.append(tube(start + far[:, None] * reach + (fan_out * spread)[:, None] * side, s * thick, 6))
    thumb = [
        start + 0.1 * reach + s * 0.018 * side,
        start + 0.22 * reach + s * 0.033 * side,
        start + 0.32 * reach + s * 0.043 * side,
        start + 0.42 * reach + s * 0.049 * side,
        start + 0.54 * reach + s * 0.053 * side,
    ]
    parts.append(tube(thumb, s * np.array([0.0075, 0.0052, 0.007, 0.005, 0.004]), 6))
    return merged(parts)


def trunk_bones(start: Floats, neck: Floats, shoulders: Sequence[Floats], scale: float) -> Mesh:
    """Spine and ribs between the joints of loin and neck, breastbone, collar bones and shoulder blades."""
    reach, s = neck - start, scale
    tall, up = float(np.linalg.norm(reach)), unit(reach)
    ahead = perpendicular(up, AHEAD)
    wide = float(np.clip(max((abs(x[0]) for x in shoulders), default=0.2 * s) * 0.68, 0.09 * s, 0.15 * s))
    deep = 0.74 * wide
    aside = np.cross(up, ahead)

    def back(part: Floats) -> Floats:  # the spine, bowed backwards behind the ribs
        bow = np.sin(np.pi * np.clip((part - 0.1) / 0.9, 0.0, 1.0))
        return np.asarray(start + part[..., None] * reach - (0.78 * deep * bow)[..., None] * ahead)

    parts = [vertebrae(back(np.linspace(0.0, 1.0, 25)), 0.9 * s)]
    round_ = np.linspace(0.0, 0.93 * np.pi, 11)
    ends: dict[float, list[Floats]] = {1.0: [], -1.0: []}
    for k in range(RIBS):
        at = 0.91 - 0.6 * k / (RIBS - 1)
        form = np.sin(np.pi * (0.19 + 0.53 * k / (RIBS - 1)))  # narrow at the top
        floating = max(0, k - (RIBS - 3))
        sweep = round_ * (1.0 - 0.17 * floating)
        centre = back(np.array([at]))[0] + deep * form * ahead
        drop = tall * (0.05 + 0.16 * (k + 1) / RIBS)
        for sign in (1.0, -1.0):
            points = (
                centre
                + sign * wide * form * np.sin(sweep)[:, None] * aside
                - deep * form * np.cos(sweep)[:, None] * ahead
                - (drop * (0.5 - 0.5 * np.cos(np.minimum(sweep * 1.15, np.pi))))[:, None] * up
                + (drop * 0.5 * np.clip((sweep - 2.2) / 0.7, 0.0, 1.0) ** 2)[:, None] * up
            )
            if k < TRUE_RIBS:  # by its gristle
                points = np.append(
                    points, [points[-1] + (sign * 0.014 * s - (points[-1] - start) @ aside) * aside], axis=0
                )
            parts.append(_flat(tube(points, 0.0054 * s, 5), points, up, 1.75))
            if not floating:
                ends[sign].append(points[-1])
    high, low = (np.asarray(x - np.dot(x - start, aside) * aside) for x in (ends[1.0][0], ends[1.0][TRUE_RIBS - 1]))
    bone = np.linspace(high + 0.012 * s * up, low - 0.004 * s * up, 6)
    parts.append(_flat(tube(bone, s * np.array([0.014, 0.011, 0.009, 0.0095, 0.0095, 0.006])), bone, aside, 1.9))
    for sign in (1.0, -1.0):  # the gristle by which the lower ribs hang on the breastbone
        arch = [low + sign * 0.012 * s * aside, *ends[sign][TRUE_RIBS:]]
        parts.append(_flat(tube(arch, np.linspace(0.0075, 0.0055, len(arch)) * s, 6), np.array(arch), up, 1.3))
    for shoulder in shoulders:
        side = np.sign(np.dot(shoulder - start, aside)) * aside
        parts.append(_collar_bone(high + s * (0.016 * side + 0.014 * up), shoulder, (side, up, ahead), s))
        parts.append(shoulder_blade_bone(shoulder, (side, up, ahead), s))
    return merged(parts)


def _flat(mesh: Mesh, line: Floats, way: Floats, factor: float) -> Mesh:
    """A tube about a line whose section is higher along a direction, by a factor."""
    corners, normals, faces = mesh
    nearest = line[np.argmin(np.linalg.norm(corners[:, None] - line[None], axis=-1), axis=1)]
    tall = (corners - nearest) @ way
    turned = normals + ((1.0 / factor - 1.0) * (normals @ way))[:, None] * way
    return corners + ((factor - 1.0) * tall)[:, None] * way, normalized(turned), faces


def _collar_bone(inner: Floats, shoulder: Floats, axes: tuple[Floats, Floats, Floats], s: float) -> Mesh:
    """A clavicle, bent forwards near the breastbone and backwards near the shoulder."""
    _, up, ahead = axes
    outer = shoulder + s * (0.028 * up - 0.006 * ahead)
    part = np.linspace(0.0, 1.0, 7)[:, None]
    bend = 0.016 * s * np.sin(2.0 * np.pi * part) * ahead + 0.006 * s * np.sin(np.pi * part) * up
    return tube(
        inner + part * (outer - inner) + bend, s * np.array([0.012, 0.009, 0.0075, 0.007, 0.007, 0.008, 0.009]), 8
    )


def shoulder_blade_bone(shoulder: Floats, axes: tuple[Floats, Floats, Floats], scale: float) -> Mesh:
    """A scapula behind a shoulder, its spine and both of its processes; axes are aside, up and ahead."""
    frame = np.array(axes) * scale

    def at(out: float, up: float, forward: float) -> Floats:
        return np.asarray(shoulder + np.array([out, up, forward]) @ frame)

    low, root, high = at(-0.07, -0.128, -0.07), at(-0.108, -0.012, -0.078), at(-0.09, 0.028, -0.062)
    socket = at(-0.026, -0.012, -0.014)
    outer = np.concatenate([np.linspace(low, socket, 15), np.linspace(socket, at(-0.04, 0.018, -0.03), 6)[1:]])
    inner = np.concatenate([np.linspace(low + 0.1 * (root - low), root, 14), np.linspace(root, high, 7)[1:]])
    parts: list[Part] = [
        *fan(outer, inner, 0.0062 * scale, 0.0064 * scale),
        rod([low, *np.linspace(low, socket, 3)[1:]], scale * np.array([0.0065, 0.006, 0.008])),
        rod([root, at(-0.06, 0.012, -0.074), at(-0.02, 0.03, -0.055), at(0.012, 0.032, -0.02), at(0.006, 0.03, 0.006)],
            scale * np.array([0.005, 0.0075, 0.0085, 0.0095, 0.0085])),
        rod([at(-0.04, 0.016, -0.028), at(-0.036, 0.024, 0.0), at(-0.022, 0.01, 0.022)],
            scale * np.array([0.009, 0.0075, 0.0065])),
        egg(at(-0.026, -0.004, -0.01), (0.01 * scale, 0.018 * scale, 0.014 * scale)),
    ]  # fmt: skip
    return blended(parts, 0.0085 * scale, 0.0024 * scale)


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
    heel_bone = [back - [0.0, 0.06 * under, 0.0], 0.6 * back + 0.4 * arch, arch - [0.0, 0.1 * under, 0.0]]
    tarsals: list[Part] = [
        egg(high - np.array([0.0, 0.01 * s, -0.004 * s]), (0.0205 * s, 0.017 * s, 0.027 * s)),
        rod([high - np.array([0.0, 0.016 * s, -0.012 * s]), arch], s * np.array([0.015, 0.0155])),
        rod(heel_bone, s * np.array([0.0225, 0.018, 0.0155])),
        egg(arch + 0.008 * s * AHEAD, (0.031 * s, 0.0135 * s, 0.022 * s)),
    ]
    parts = [blended(tarsals, 0.0085 * s, 0.0022 * s)]
    for k in range(5):
        out = sign * (-0.026 + 0.0125 * k) * s
        begin = arch + np.array([0.75 * out, -0.12 * under * k / 4.0, 0.01 * s])
        end = np.array([ball[0] + out, sole + 0.012 * s, ball[2] - 0.05 * length * k / 4.0])
        thick = (0.0088 if k == 0 else 0.0062) * s
        part = np.array([0.0, 0.3, 0.75, 1.0])
        line = begin + part[:, None] * (end - begin) + 0.004 * s * np.sin(np.pi * part)[:, None] * [0.0, 1.0, 0.0]
        parts.append(tube(line, thick * np.array([1.1, 0.8, 0.8, 1.25]), 6))
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
        part = np.array([0.0, 0.3, 0.52, 0.72, 0.86, 1.0])
        line = begin + part[:, None] * (end - begin) + 0.004 * s * np.sin(np.pi * part)[:, None] * [0.0, 1.0, 0.0]
        parts.append(tube(line, thick * np.array([1.15, 0.75, 1.0, 0.72, 0.9, 0.8]), 6))
    return merged(parts)

"""Small OpenSim models as text, for tests that must always run."""

from pathlib import Path

LINE = '<LinearFunction name="function"><coefficients>1 0</coefficients></LinearFunction>'


def body(name: str, mass: float = 1.0, center: str = "0 0 0", inertia: str = "1 2 2 0 0 0", more: str = "") -> str:
    """A body."""
    return (
        f'<Body name="{name}"><mass>{mass}</mass><mass_center>{center}</mass_center>'
        f"<inertia>{inertia}</inertia>{more}</Body>\n"
    )


def coordinate(name: str, more: str = "") -> str:
    """A coordinate."""
    return f'<Coordinate name="{name}"><range>-2 2</range>{more}</Coordinate>\n'


def joint(
    kind: str, name: str, parent: str, child: str, coordinates: str = "", more: str = "", place: str = "0 0 0",
    turn: str = "0 0 0", own: str = "0 0 0", own_turn: str = "0 0 0",
) -> str:  # fmt: skip
    """A joint with offset frames in both bodies; `ground` is the ground."""
    first, second = (f"/bodyset/{one}" if one != "ground" else "/ground" for one in (parent, child))
    return (
        f'<{kind} name="{name}"><socket_parent_frame>near</socket_parent_frame>'
        f"<socket_child_frame>far</socket_child_frame>\n<coordinates>{coordinates}</coordinates>\n<frames>"
        f'<PhysicalOffsetFrame name="near"><socket_parent>{first}</socket_parent>'
        f"<translation>{place}</translation><orientation>{turn}</orientation></PhysicalOffsetFrame>\n"
        f'<PhysicalOffsetFrame name="far"><socket_parent>{second}</socket_parent>'
        f"<translation>{own}</translation><orientation>{own_turn}</orientation></PhysicalOffsetFrame>"
        f"</frames>\n{more}</{kind}>\n"
    )


def axes(**functions: tuple[str, str, str]) -> str:
    """A spatial transform: by names such as rotation1 a coordinate, an axis and a function."""
    inner = "".join(
        f'<TransformAxis name="{name}"><coordinates>{q}</coordinates><axis>{axis}</axis>{function}</TransformAxis>\n'
        for name, (q, axis, function) in functions.items()
    )
    return f"<SpatialTransform>{inner}</SpatialTransform>"


def joint_of_six(name: str, parent: str, child: str, words: tuple[str, ...]) -> str:
    """A custom joint that turns and shifts along each axis by a coordinate of its own: three turns, three shifts."""
    functions = {
        f"{kind}{k + 1}": (word, " ".join("1" if k == i else "0" for i in range(3)), LINE)
        for kind, own in (("rotation", words[:3]), ("translation", words[3:])) for k, word in enumerate(own)
    }  # fmt: skip
    return joint("CustomJoint", name, parent, child, "".join(map(coordinate, words)), axes(**functions))


def spline(kind: str, x: str, y: str) -> str:
    """A function through knots."""
    return f'<{kind} name="function"><x>{x}</x><y>{y}</y></{kind}>'


def point(name: str, where: str, location: str) -> str:
    """A point of a path on a body."""
    frame = f"/bodyset/{where}" if where != "ground" else "/ground"
    return (
        f'<PathPoint name="{name}"><socket_parent_frame>{frame}</socket_parent_frame>'
        f"<location>{location}</location></PathPoint>\n"
    )


def muscle(name: str, points: str, wraps: str = "", kind: str = "Millard2012EquilibriumMuscle", more: str = "") -> str:
    """A muscle along points."""
    return (
        f'<{kind} name="{name}"><GeometryPath name="path"><PathPointSet><objects>{points}</objects></PathPointSet>'
        f"<PathWrapSet><objects>{wraps}</objects></PathWrapSet></GeometryPath>\n"
        f"<max_isometric_force>500</max_isometric_force><optimal_fiber_length>0.1</optimal_fiber_length>"
        f"<tendon_slack_length>0.2</tendon_slack_length>{more}</{kind}>\n"
    )


def model(bodies: str, joints: str, forces: str = "", more: str = "", version: int = 40000, defaults: str = "") -> str:
    """A model in the layout of version 4."""
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<OpenSimDocument Version="{version}">\n<Model name="small">\n'
        f"{defaults}<BodySet><objects>\n{bodies}</objects></BodySet>\n"
        f"<JointSet><objects>\n{joints}</objects></JointSet>\n<ForceSet><objects>\n{forces}</objects></ForceSet>\n"
        f"{more}</Model>\n</OpenSimDocument>\n"
    )


def pendulum(**more: str) -> str:
    """A body on a pin about z at the ground."""
    return model(body("rod", center="0 -0.5 0"), joint("PinJoint", "pin", "ground", "rod", coordinate("q")), **more)


def written(folder: Path, text: str) -> Path:
    """A file with this text."""
    path = folder / "small.osim"
    path.write_text(text)
    return path

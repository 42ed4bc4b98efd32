"""Polynomials fitted to the lengths of muscles' paths, over poses within the limits of the joints that they cross.

The length of each path is taken in random poses of the joints that it acts on. Polynomials of rising order, in all
products of the coordinates up to that order, are fitted to two thirds of the poses by least squares; the first is taken
that misses the other third by no more than a bound in the root mean square, or else the best one.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.model.path_table import joints_of_muscles
from warpmuscle.scene import Character, PolynomialPath, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.topology import topology
from warpmuscle.scene.trusted_code import without_code
from warpmuscle.scene.validation.paths import GREATEST_EXPONENT, MOST_VARIABLES
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.moment_arms import joint_range

POSES = 6000
POSES_A_TERM = 4  # at least; a polynomial with more terms is not fitted
Variable = tuple[str, int]  # joint, and which of its coordinates


@dataclass(frozen=True)
class PathFit:
    """How well the polynomial of a muscle fits."""

    muscle: str
    order: int
    terms: int
    rms: float  # m, over poses that it was not fitted to
    worst: float  # m


def fit_paths(scene: Scene, rms: float = 1e-4, order: int = 8, seed: int = 0) -> tuple[Scene, list[PathFit]]:
    """The scene with polynomials in place of its muscles' paths, and how well each fits; numbers are no longer free.

    Muscles on pulleys, those whose path is a polynomial already, and those that act on no joint stay as they are.

    Args:
        rms: bound on the root mean square of what a polynomial misses, m. order: the greatest that is tried.

    Raises:
        SceneError: a path acts on a ball joint, which has no coordinates for a polynomial, or on too many coordinates.
    """
    if not 1 <= order <= GREATEST_EXPONENT:
        raise SceneError(f"the order must be within 1 and {GREATEST_EXPONENT}, is {order}")
    scene = without_code(substitute(scene, start_values(scene)))
    character = scene.character
    joints = joints_of_muscles(character, topology(character))
    fitted, fits = dict(character.muscles), list[PathFit]()
    chosen = [name for name, muscle in fitted.items() if muscle.path and joints[name]]
    variables = {name: _variables(name, joints[name], character) for name in chosen}
    every = list(dict.fromkeys(itertools.chain.from_iterable(variables.values())))
    q, lengths = _lengths(scene, every, np.random.default_rng(seed))
    number = {name: k for k, name in enumerate(character.muscles)}
    for name in chosen:
        own = q[:, [every.index(variable) for variable in variables[name]]]
        polynomial, fit = _fitted(name, variables[name], own, lengths[:, number[name]], rms, order)
        fitted[name] = msgspec.structs.replace(fitted[name], path=[], wraps=[], polynomial=polynomial)
        fits.append(fit)
    return msgspec.structs.replace(scene, character=msgspec.structs.replace(character, muscles=fitted)), fits


def _variables(name: str, joints: list[str], character: Character) -> list[Variable]:
    """The coordinates that the length of a muscle's path depends on."""
    found = []
    for joint in joints:
        kind = joint_type(character.joints[joint])
        if not kind.scalars:
            message = f"acts on the {kind.name} joint {joint!r}, which has no coordinates for a polynomial"
            raise SceneError(f"{message}; make it hinges, or leave the muscle out", key=f"character.muscles.{name}")
        found += [(joint, axis) for axis in range(kind.scalars)]
    if len(found) > MOST_VARIABLES:
        message = f"acts on {number_of(len(found), 'coordinate')}; a polynomial takes {MOST_VARIABLES} at most"
        raise SceneError(message, key=f"character.muscles.{name}")
    return found


def _lengths(scene: Scene, variables: list[Variable], rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Coordinates (n, V) within their limits, and the lengths of all paths (n, M) there."""
    stages = Stages(scene, POSES, "cpu")
    character, names = scene.character, stages.names
    coordinates = stages.state.coordinates.numpy().copy()
    columns = [names.coordinate_start[names.body_of_joint(joint)] + axis for joint, axis in variables]
    for column, (joint, axis) in zip(columns, variables, strict=True):
        coordinates[:, column] = rng.uniform(*joint_range(character.joints[joint], axis), POSES)
    stages.state.coordinates.assign(coordinates)
    return coordinates[:, columns].astype(float), stages.muscle_paths().length.astype(float)


def _fitted(
    name: str, variables: list[Variable], q: Floats, length: Floats, rms: float, greatest: int
) -> tuple[PolynomialPath, PathFit]:
    """The polynomial of lowest order that fits well enough, or the best one."""
    kept = len(q) * 2 // 3
    best: tuple[Floats, list[tuple[int, ...]], PathFit] | None = None
    for order in range(1, greatest + 1):
        exponents = [e for e in itertools.product(range(order + 1), repeat=len(variables)) if sum(e) <= order]
        if best is not None and len(exponents) * POSES_A_TERM > kept:
            break
        values = np.prod(q[:, None, :] ** np.array(exponents), axis=2)
        scale = np.linalg.norm(values[:kept], axis=0)
        scale[scale == 0.0] = 1.0
        coefficients = np.linalg.lstsq(values[:kept] / scale, length[:kept], rcond=None)[0] / scale
        off = values[kept:] @ coefficients - length[kept:]
        fit = PathFit(name, order, len(exponents), float(np.sqrt(np.mean(off**2))), float(np.abs(off).max()))
        if best is None or fit.rms < best[2].rms:
            best = coefficients, exponents, fit
        if fit.rms <= rms:
            break
    assert best is not None
    coefficients, exponents, fit = best
    axes = [axis for _, axis in variables]
    polynomial = PolynomialPath(
        [joint for joint, _ in variables],
        [list(term) for term in exponents],
        [float(c) for c in coefficients],
        axes if any(axes) else [],
    )
    return polynomial, fit

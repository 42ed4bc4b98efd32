"""Mistakes in modules of one's own are named in one line as the scene is read, before anything is compiled."""

import msgspec
import pytest

from importing import importable_from
from muscle_arm import arm
from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Force, Scene
from warpmuscle.scene.controller import Controller
from warpmuscle.simulation.rollout import Rollout

HEAD = """
import warp as wp
from warpmuscle.kernels.control.control import CustomController
from warpmuscle.kernels.force.forces import ForceKind, Wrench
from warpmuscle.kernels.objective.accelerations import centre_acceleration
from warpmuscle.kernels.objective.declaration import Declaration
from warpmuscle.kernels.structs import Model, Scratch, State

@wp.struct
class Own:
    gain: float

@wp.struct
class Other:
    gain: float

@wp.func
def plain(instance: int, model: Model, state: State, work: Scratch) -> float:
    return 1.0

@wp.func
def tuned(instance: int, model: Model, state: State, work: Scratch, own: Own) -> float:
    return own.gain

@wp.func
def counting(instance: int, model: Model, state: State, work: Scratch, memory: wp.array[int]) -> float:
    return 1.0

@wp.func
def falling(instance: int, model: Model, state: State, work: Scratch) -> float:
    return centre_acceleration(instance, 1, model, work)[1]

@wp.func
def moving(instance: int, model: Model, state: State, work: Scratch) -> float:
    return work.orientation[0][3] + work.center[1][1] + work.velocity[1][1]

@wp.func
def misspelt(instance: int, model: Model, state: State, work: Scratch) -> float:
    return work.centre[1][1]

@wp.func
def backwards(instance: int, model: Model, state: State, work: Scratch, memory: wp.array[float]) -> float:
    return memory[-1]

@wp.func
def thrown(instance: int, body: int, model: Model, state: State, work: Scratch) -> wp.vec3:
    return work.angular_acceleration[body]

@wp.func
def dragged(instance: int, body: int, model: Model, state: State, work: Scratch) -> Wrench:
    w = Wrench()
    w.force = work.acceleration[body]
    return w

@wp.func
def effort(instance: int, body: int, model: Model, state: State, work: Scratch) -> wp.vec3:
    return wp.vec3(0.0)

@wp.func
def of_each(instance: int, body: int, model: Model, state: State, work: Scratch, own: Own) -> wp.vec3:
    return wp.vec3(own.gain, 0.0, 0.0)

@wp.func
def remembering(instance: int, body: int, model: Model, state: State, work: Scratch, m: wp.array[float]) -> wp.vec3:
    return wp.vec3(m[0], 0.0, 0.0)

@wp.func
def number(instance: int, body: int, model: Model, state: State, work: Scratch) -> float:
    return 0.0

@wp.func
def push(instance: int, body: int, model: Model, state: State, work: Scratch, own: Own) -> Wrench:
    return Wrench()

"""
TERMS = {
    "function=tuned, parameters=Own, defaults={'gain': float('nan')}": "'gain' in defaults of .* is nan, which is not",
    "function=tuned, parameters=Own, defaults={'gain': 'x'}": "'gain' in defaults of .* is not a number, but 'x'",
    "function=tuned, parameters=Own, defaults={'gain': True}": "'gain' in defaults of .* is not a number, but True",
    "function=tuned, parameters=Own, defaults={'gain': 3.0}, limits={'gain': (0.0, 1.0)}": "within 0 and 1, is 3",
    "function=tuned, parameters=Own, limits={'gain': (0.0, float('nan'))}": "'gain' in limits of .* is nan",
    "function=tuned, parameters=Other": r"takes \(.*, Own\), without Other, the parameters that .* declares",
    "function=counting, memory=1": r"takes .*, wp.array\[int\]\), without wp.array\[float\], the memory",
    "function=plain, unit=3": "the unit of .* is not a line of text, but 3",
    "function=plain, unit='m\\n'": "the unit of .* is not a line of text",
    "function=plain, description='a\\nb'": "the description of .* is not a line of text",
    "function=plain, weight=2.0": "sets 'weight', which is for parts of warpmuscle: leave it out",
    "plain": "declares no function: write function=plain",
    "function=falling": "work.acceleration is not known yet at the stage 'forces'; declare stage='accel",
    "function=misspelt": "there is no work.centre; did you mean 'center'?",
    "function=backwards, memory=2": r": memory\[-1\] is not in a memory of 2: places are counted from 0 on",
    "function=moving, stage='accelerations'": "work.velocity is not known any more at the stage",
}
CONTROLLERS = {
    "effort=of_each, by_joint=Own, defaults=(('gain', float('inf')),)": "'gain' in defaults of .* is inf, which is not",
    "effort=of_each, by_joint=Own, defaults=(('gain', 'x'),)": "'gain' in defaults of .* is not a number, but 'x'",
    "effort=of_each, by_joint=Own, defaults=('gain', 1.0)": r"must be a tuple of \(parameter, number\)",
    "effort=of_each, by_joint=Own, defaults=(('gian', 1.0),)": "no parameter is called 'gian' in defaults of",
    "effort=effort, by_joint=Own": "no function of .* takes Own, its numbers by_joint",
    "effort=remembering": "takes a state: declare how many floats, state=1",
    "effort=effort, state=2": r"no function of .* takes wp.array\[float\], the state that it declares",
    "effort=effort, parameters=Own": "no function of .* takes Own, the parameters that it declares",
    "effort=effort, damping=number": "must say that it returns wp.vec3, and says float",
    "effort=thrown": "work.angular_acceleration is not known yet when an effort is asked for",
    "damping=effort": "has a damping, and no effort that it belongs to",
    "effort=effort, shipped=True": "sets 'shipped', which is for parts of warpmuscle",
}
FORCES = {
    "wrench=push, parameters=Own, positive=('gian',)": "no parameter is called 'gian' in what is positive",
    "wrench=push, parameters=Own, positive='gain'": "must be a tuple of names of parameters",
    "wrench=push, parameters=Own, positive=('gain',)": "forces.own.parameters.gain: must be greater than 0, is 0",
    "wrench=dragged": "work.acceleration is not known yet when a wrench is asked for",
    "wrench=push, parameters=Own, water=True": "sets 'water', which is for parts of warpmuscle",
    "wrench=push, parameters=Own, objects=3": "sets 'objects', which is for parts of warpmuscle",
}


def refused(scene: Scene, message: str) -> None:
    with pytest.raises(SceneError, match=message) as caught:
        Rollout(scene, 1, "cpu", trust=True)
    assert "\n" not in str(caught.value)


@pytest.fixture
def written(tmp_path):
    """Writes a part, and gives its name; a module of its own for each, since those that fail are not imported again."""

    def write(part: str) -> str:
        name = f"mistaken_{abs(hash(part)):x}"
        (tmp_path / f"{name}.py").write_text(HEAD + f"part = {part}\n")
        return f"{name}:part"

    with importable_from(tmp_path):
        yield write


@pytest.mark.parametrize("fields", TERMS)
def test_what_is_wrong_with_a_term_is_named(written, fields: str):
    scene = arm()
    scene.objective.custom = {written(f"Declaration({fields})"): 1.0}
    refused(scene, TERMS[fields])


@pytest.mark.parametrize("fields", CONTROLLERS)
def test_what_is_wrong_with_a_controller_is_named(written, fields: str):
    refused(msgspec.structs.replace(arm(), controller=Controller(type=written(f"CustomController({fields})"))),
            CONTROLLERS[fields])  # fmt: skip


@pytest.mark.parametrize("fields", FORCES)
def test_what_is_wrong_with_a_force_is_named(written, fields: str):
    scene = arm()
    body = list(scene.character.bodies)[-1]
    scene.forces = {"own": Force(written(f"ForceKind({fields})"), body=body, parameters={"gain": 0.0})}
    refused(scene, FORCES[fields])


def test_a_module_that_ends_the_program_is_named(written):
    scene = arm()
    scene.recorded = [written("exit(3)")]
    refused(scene, r"mistaken_.* fails: .*mistaken_.*py:\d+: SystemExit: 3")


@pytest.mark.parametrize("place", ["recorded", "failure"])
def test_a_part_is_named_once_in_a_list(place: str):
    scene = arm()
    if place == "recorded":
        scene.recorded = ["one:part", "one:part"]
    else:
        scene.failure.custom = ["one:part", "one:part"]
    refused(scene, "'one:part' is named more than once")

"""Functions of a module of one's own run inside the fused step, if trusted; what cannot be used is said in one line."""

import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest

from importing import importable_from
from muscle_arm import constant, leg
from warpmuscle.core.errors import Error, RolloutError, SceneError
from warpmuscle.formats import load, toml
from warpmuscle.scene import Actuation, MuscleModel, Objective, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.simulation.rollout import Rollout

FIVE_LINES = """import warp as wp
@wp.func
def effort(instance: int, m: int, w: MuscleWork, model: Model) -> float: return w.activation * w.activation
@wp.func
def bell(length: float) -> float: return wp.exp((length - 1.0) * (length - 1.0) * (-1.0 / 0.5))
"""
MORE = '''
@wp.func
def lee(speed: float) -> float:
    return hyperbolic_velocity(speed, 0.3, 1.8)[0]

@wp.func
def lee_sloped(speed: float) -> wp.vec2:
    return hyperbolic_velocity(speed, 0.3, 1.8)

@wp.func
def weak(length: float) -> float:
    return 0.5 * wp.exp((length - 1.0) * (length - 1.0) * (-1.0 / 0.5))

@wp.func
def torque(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    return wp.length(work.torque[body])

@wp.func
def height(instance: int, model: Model, state: State, work: Scratch) -> float:
    return work.center[0][1]

@wp.func
def away(instance: int, model: Model, state: State, work: Scratch) -> wp.vec3:
    return work.center[0]

@wp.func
def spring(instance: int, body: int, model: Model, state: State, work: Scratch) -> wp.vec3:
    """A torque of 3 N m about the first axis of every joint."""
    return wp.vec3(3.0, 0.0, 0.0)

@wp.func
def two(a: float, b: float) -> float:
    return a + b

@wp.func
def sometimes(x: float) -> float:
    if x > 1.0:
        return x - 1.0


@wp.func
def silent(length: float):
    return length

@wp.func
def broken(length: float) -> float:
    return wp.no_such_thing(length)

def plain(length: float) -> float:
    return length
'''
IMPORTS = """from warpmuscle.kernels.curve.curves import hyperbolic_velocity
from warpmuscle.kernels.objective.term_functions import MuscleWork
from warpmuscle.kernels.structs import Model, ModelRef, State, StateRef, Scratch, ScratchRef
"""
NAME = "their_parts"


@pytest.fixture(scope="module", autouse=True)
def folder(tmp_path_factory) -> Path:
    """A folder with the module, from which Python does not import of itself."""
    place = tmp_path_factory.mktemp("theirs")
    (place / f"{NAME}.py").write_text(IMPORTS + FIVE_LINES + MORE)
    (place / "failing_parts.py").write_text("1 / 0\n")
    (place / "unwritten_parts.py").write_text("import warp\ndef f(length)\n    return length\n")
    (place / "unannotated_parts.py").write_text("import warp as wp\n@wp.func\ndef f(length):\n    return length\n")
    (place / "older_parts.py").write_text("from warpmuscle.kernels.curves import lee_passive\n")
    toml.write(scene(objective={f"{NAME}:effort": 2.0}), place / "theirs.toml")
    return place


@pytest.fixture(scope="module")
def importable(folder: Path):
    """The module can be imported."""
    with importable_from(folder):
        yield


def scene(objective: dict | None = None, **changes) -> Scene:
    given = leg(duration=0.1, **changes)
    given.objective.effort_squared, given.objective.custom = 2.0, objective or {}
    for index, muscle in enumerate(given.character.muscles.values()):
        muscle.excitation = constant(0.2 + 0.3 * index)
    return given


def run(given: Scene) -> Rollout:
    rollout = Rollout(given, 2, "cpu", trust=True)
    rollout.run()
    return rollout


@pytest.mark.usefixtures("importable")
class TestRuns:
    """What runs inside the step."""

    @pytest.mark.long
    def test_five_lines_of_a_module_add_a_term_and_a_curve_that_do_what_those_of_the_package_do(self):
        given = scene({f"{NAME}:effort": 3.0})
        given.muscle_model = MuscleModel(active_force_length=f"{NAME}:bell")
        own, plain = run(given), run(scene())
        np.testing.assert_array_equal(own.state.speeds.numpy(), plain.state.speeds.numpy())
        terms = own.terms()
        np.testing.assert_array_equal(terms[f"{NAME}:effort"], terms["effort_squared"])
        np.testing.assert_allclose(own.cost() - plain.cost(), 3.0 * terms[f"{NAME}:effort"])

    @pytest.mark.parametrize("tendon", ["rigid", pytest.param("compliant", marks=pytest.mark.long)])
    def test_another_curve_is_another_motion(self, tendon: str):
        given, plain = (scene(muscle_model=MuscleModel(tendon=tendon)) for _ in "ab")
        given.objective = plain.objective = Objective()
        given.muscle_model.active_force_length = f"{NAME}:weak"
        own, usual = run(given), run(plain)
        assert (own.state.muscles.force.numpy() < usual.state.muscles.force.numpy() + 1e-3).all()
        assert not np.allclose(own.state.speeds.numpy(), usual.state.speeds.numpy(), rtol=0.01)

    @pytest.mark.long
    @pytest.mark.parametrize("velocity", ["lee", "lee_sloped"])
    def test_a_force_velocity_curve_may_come_with_its_slope_or_without(self, velocity: str):
        implicit = MuscleModel(implicit_damping=True)
        given = scene(muscle_model=msgspec.structs.replace(implicit, force_velocity=f"{NAME}:{velocity}"))
        own, usual = run(given), run(scene(muscle_model=implicit))
        np.testing.assert_allclose(own.state.speeds.numpy(), usual.state.speeds.numpy(), rtol=2e-3, atol=2e-3)

    @pytest.mark.long
    def test_metabolic_power_is_that_of_the_curves_in_use(self):
        given, plain = (scene() for _ in "ab")
        for one in (given, plain):
            one.objective.metabolic = 1.0
        given.muscle_model = MuscleModel(active_force_length=f"{NAME}:weak")
        assert run(given).terms()["metabolic"][0] != pytest.approx(run(plain).terms()["metabolic"][0], rel=1e-3)

    def test_terms_of_bodies_and_of_the_whole_are_summed(self):
        given = scene({f"{NAME}:torque": 1.0, f"{NAME}:height": Free(0.5, 0.0, 1.0)})
        given.objective.applied_torque = 1.0
        rollout = run(given)
        terms = rollout.terms()
        np.testing.assert_array_equal(terms[f"{NAME}:torque"], terms["applied_torque"])
        assert terms[f"{NAME}:height"][0] == pytest.approx(0.1 * 0.7, rel=0.1)
        assert [parameter.name for parameter in free_parameters(given)] == [f"objective.custom.{NAME}:height"]
        before = rollout.cost()[0]
        rollout.set_parameters([0.0])
        rollout.run()
        assert before - rollout.cost()[0] == pytest.approx(0.5 * terms[f"{NAME}:height"][0])

    def test_a_controller_drives_all_joints_as_the_same_torques_from_outside(self):
        torques = {name: Actuation("torque") for name in ("hip", "knee")}
        given, plain = scene(actuation=torques, custom_controller=f"{NAME}:spring"), scene(actuation=torques)
        own, usual = run(given), Rollout(plain, 2, "cpu")
        usual.step(200, torques=[[3.0, 0.0, 0.0, 3.0]])
        np.testing.assert_allclose(own.state.speeds.numpy(), usual.state.speeds.numpy(), rtol=1e-4, atol=1e-5)

    def test_code_that_does_not_compile_is_said_in_one_line(self):
        given = scene(muscle_model=MuscleModel(active_force_length=f"{NAME}:broken"))
        lines = (IMPORTS + FIVE_LINES + MORE).splitlines()
        line = next(number for number, text in enumerate(lines, 1) if "no_such_thing" in text)
        wanted = rf"{NAME}.py:{line}: function 'broken' does not compile: .*no_such_thing"
        with pytest.raises(RolloutError, match=wanted) as caught:
            run(given)
        assert "\n" not in str(caught.value)


@pytest.mark.usefixtures("importable")
@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"objective": {"nowhere:f": 1.0}}, "objective.custom.nowhere:f: there is no module 'nowhere'"),
        ({"objective": {f"{NAME}:efort": 1.0}}, f"module '{NAME}' has no function 'efort'; did you mean 'effort'"),
        ({"objective": {f"{NAME}:plain": 1.0}}, f"'{NAME}:plain' is not a Warp function: put @wp.func before it"),
        (
            {"objective": {f"{NAME}:bell": 1.0}},
            r"a term takes \(int, int, MuscleWork, Model\).*parts.py:\d+\) takes \(float\)",
        ),
        (
            {"objective": {"failing_parts:f": 1.0}},
            r"'failing_parts' fails: .*failing_parts.py:1: ZeroDivisionError",
        ),
        (
            {"objective": {"unannotated_parts:f": 1.0}},
            r"'unannotated_parts' fails: .*unannotated_parts.py:2: WarpCodegenError: Incomplete argument annotations",
        ),
        (
            {"objective": {"older_parts:f": 1.0}},
            r"'older_parts' fails: .*older_parts.py:1: ImportError: cannot import name 'lee_passive' .*; "
            r"warpmuscle.kernels.curve.lee_curves has one of this name",
        ),
        ({"objective": {"unwritten_parts:f": 1.0}}, r"'unwritten_parts' fails: .*unwritten_parts.py:2: expected ':'"),
        ({"objective": {"no colon": 1.0}}, "'no colon' is not the name of a function as in 'module:function'"),
        (
            {"muscle_model": MuscleModel(force_velocity=f"{NAME}:two")},
            r"takes \(float\), but .* takes \(float, float\)",
        ),
        ({"muscle_model": MuscleModel(passive_force_length=f"{NAME}:silent")}, "must say that it returns float"),
        (
            {"muscle_model": MuscleModel(passive_force_length=f"{NAME}:sometimes")},
            r"py:\d+\) has no return: end it with one of float",
        ),
        ({"objective": {f"{NAME}:away": 1.0}}, "must say that it returns float, and says wp.vec3"),
        ({"custom_controller": f"{NAME}:torque"}, "must say that it returns wp.vec3, and says float"),
        ({"muscle_model": MuscleModel(legacy=True, force_velocity=f"{NAME}:lee")}, "take no curve of one's own"),
    ],
    ids=str,
)
def test_what_cannot_be_used_is_said_in_one_line(changes: dict, message: str):
    with pytest.raises(Error, match=message) as caught:
        Rollout(scene(**changes), 1, "cpu", trust=True)
    assert "\n" not in str(caught.value)


def test_a_scene_file_that_names_code_runs_it_only_if_trusted(folder: Path, tmp_path: Path):
    for name in (f"{NAME}.py", "theirs.toml"):
        text = (folder / name).read_text().replace(NAME, "strange_parts")
        (tmp_path / name.replace(NAME, "strange_parts")).write_text(text)
    given = load(tmp_path / "theirs.toml")
    with pytest.raises(SceneError, match=r"'leg' wants to run code of 'strange_parts:effort'.*--trust, or trust=True"):
        Rollout(given, 1, "cpu")
    assert "strange_parts" not in sys.modules
    trusted = load(tmp_path / "theirs.toml", trust=True)
    assert Rollout(trusted, 1, "cpu").terms()["strange_parts:effort"] == 0.0


def test_a_scene_with_code_is_written_and_read_again(folder: Path):
    given = load(folder / "theirs.toml")
    assert given.objective.custom == {f"{NAME}:effort": 2.0}
    assert toml.loads(toml.dumps(given)) == given

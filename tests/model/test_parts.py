"""Parts that declare parameters, a memory, a stage and a sign: what they add, and what is said of those forgotten."""

from pathlib import Path

import numpy as np
import pytest

from importing import importable_from
from muscle_arm import constant, leg
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.formats import toml
from warpmuscle.model.structure import structure_of
from warpmuscle.scene import CustomPart, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.scene.trusted_code import trust
from warpmuscle.simulation.rollout import Rollout

NAME = "declared_parts"
MODULE = '''"""Parts that declare more than a function."""

import warp as wp

from warpmuscle.kernels.objective.accelerations import centre_acceleration
from warpmuscle.kernels.objective.declaration import Declaration
from warpmuscle.kernels.structs import Model, Scratch, State
from warpmuscle.kernels.objective.term_functions import MuscleWork


@wp.struct
class Gain:
    gain: float
    power: float


@wp.func
def _of_steps(instance: int, model: Model, state: State, work: Scratch, memory: wp.array[float]) -> float:
    memory[0] = memory[0] + 1.0
    memory[1] = memory[1] + 2.0
    return memory[0] + 0.5 * memory[1]


@wp.func
def _of_joint(
    instance: int, body: int, model: Model, state: State, work: Scratch, given: Gain, memory: wp.array[float]
) -> float:
    memory[0] = memory[0] + given.gain
    return wp.pow(memory[0], given.power)


@wp.func
def _of_muscle(instance: int, m: int, w: MuscleWork, model: Model, given: Gain, memory: wp.array[float]) -> float:
    memory[0] = memory[0] + 1.0
    return given.gain * memory[0]


@wp.func
def _of_place(instance: int, m: int, w: MuscleWork, model: Model, given: Gain) -> float:
    return given.gain * float(10 * instance + m)


@wp.func
def _of_work(instance: int, m: int, w: MuscleWork, model: Model) -> float:
    return w.activation + 2.0 * w.excitation + 30.0 * w.length + 5.0 * w.speed + 0.01 * w.force


@wp.func
def _accelerates(instance: int, model: Model, state: State, work: Scratch) -> float:
    return wp.length(centre_acceleration(instance, model.body_count - 1, model, work))


@wp.func
def _too_long(instance: int, model: Model, state: State, work: Scratch, given: Gain, memory: wp.array[float]) -> bool:
    memory[0] = memory[0] + 1.0
    return memory[0] > given.gain


steps = Declaration(function=_of_steps, memory=2, unit="1", description="steps, counted")
joint = Declaration(function=_of_joint, parameters=Gain, memory=1, defaults={"power": 1.0}, limits={"gain": (0.0, 9.0)})
muscle = Declaration(function=_of_muscle, parameters=Gain, memory=1, defaults={"power": 1.0})
of_place = Declaration(function=_of_place, parameters=Gain, defaults={"power": 1.0})
of_work = Declaration(function=_of_work)
accelerates = Declaration(function=_accelerates, stage="accelerations", sign="earned", unit="m/s")
too_long = Declaration(function=_too_long, parameters=Gain, memory=1, defaults={"power": 1.0})
of_cycles = Declaration(function=_accelerates, stage="accelerations", follows_cycles=True)
no_memory = Declaration(function=_of_steps)
forgetful = Declaration(function=_accelerates, memory=1)
nothing = Declaration()
late = Declaration(function=_accelerates, stage="acceleration")
signed = Declaration(function=_accelerates, sign="reward")
no_struct = Declaration(function=_of_joint, parameters=float, memory=1)
negative = Declaration(function=_of_steps, memory=-1)
unbounded = Declaration(function=_of_joint, parameters=Gain, memory=1, limits={"gain": 3.0})
crossed = Declaration(function=_of_joint, parameters=Gain, memory=1, limits={"gain": (2.0, 1.0)})
small = Declaration(function=_of_steps, memory=1)
undeclared = Declaration(function=_of_joint, memory=1)
scoped = Declaration(function=_of_steps, memory=2, scope="muscle")
misnamed = Declaration(function=_of_joint, parameters=Gain, memory=1, defaults={"gian": 1.0})
'''
OF_MUSCLES = {"hip": 0.5, "knee": 0.7, "both": 1.1}
GAINS = {
    "joint": CustomPart({"gain": 2.0}, {"knee": {"gain": 3.0, "power": 2.0}}),
    "muscle": CustomPart({"gain": 1.0}, {name: {"gain": gain} for name, gain in OF_MUSCLES.items()}),
    "of_place": CustomPart({"gain": 0.5}, {"both": {"gain": 0.8}}),
}
N = 200  # steps


@pytest.fixture(scope="module", autouse=True)
def importable(tmp_path_factory):
    place: Path = tmp_path_factory.mktemp("declared")
    (place / f"{NAME}.py").write_text(MODULE)
    with importable_from(place):
        yield


def scene(names: tuple[str, ...] = (), conditions: tuple[str, ...] = (), **given: CustomPart) -> Scene:
    one = leg(duration=0.1)
    one.objective.custom = {f"{NAME}:{name}": 1.0 for name in names}
    one.failure.custom = [f"{NAME}:{name}" for name in conditions]
    one.custom = {f"{NAME}:{name}": part for name, part in given.items()}
    for index, muscle in enumerate(one.character.muscles.values()):
        muscle.excitation = constant(0.2 + 0.3 * index)
    return one


class TestRuns:
    """One kernel with all of them."""

    @pytest.fixture(scope="class")
    def rollout(self) -> Rollout:
        gains = GAINS | {"joint": CustomPart({"gain": Free(2.0, 0.0, 4.0)}, GAINS["joint"].each)}
        terms = ("steps", "joint", "muscle", "of_place", "of_work", "accelerates")
        own = scene(terms, ("too_long",), too_long=CustomPart({"gain": 1e9}), **gains)
        return Rollout(own, 2, "cpu", record=[0], record_rate=1.0 / own.time_step, trust=True)

    def test_memories_count_the_steps_of_an_instance_of_each_joint_and_of_each_muscle(self, rollout: Rollout):
        rollout.reset()
        rollout.run()
        h, k = 0.1 / N, np.arange(1, N + 1)
        terms = rollout.terms()
        assert terms[f"{NAME}:steps"] == pytest.approx([h * (2.0 * k).sum()] * 2, rel=1e-5)
        joints = {name: 3.0 * k if name == "knee" else 2.0 * k for name in rollout.names.joints}
        wanted = sum((values**2 if name == "knee" else values).sum() for name, values in joints.items())
        assert terms[f"{NAME}:joint"] == pytest.approx([h * wanted] * 2, rel=1e-5)
        assert terms[f"{NAME}:muscle"] == pytest.approx([h * sum(OF_MUSCLES.values()) * k.sum()] * 2, rel=1e-5)

    def test_a_part_of_each_muscle_is_told_its_instance_and_its_muscle(self, rollout: Rollout):
        rollout.reset()
        rollout.run()
        muscles = rollout.structure.actuation.muscles
        gains = np.array([0.8 if name == "both" else 0.5 for name in muscles])
        wanted = [0.1 * gains @ (10 * instance + np.arange(len(muscles))) for instance in range(2)]
        assert len(muscles) == 3
        assert rollout.terms()[f"{NAME}:of_place"] == pytest.approx(wanted, rel=1e-5)

    def test_a_part_of_each_muscle_is_told_what_it_does(self, rollout: Rollout):
        rollout.reset()
        rollout.run()
        frames = rollout.recording()
        each = frames.muscle_activation + 2.0 * frames.muscle_excitation + 30.0 * frames.muscle_fibre_length
        each = each + 5.0 * frames.muscle_fibre_velocity + 0.01 * frames.muscle_force
        assert np.ptp(frames.muscle_fibre_velocity) > 0.1
        wanted = rollout.scene.time_step * float(np.sum(each, dtype=np.float64))
        assert rollout.terms()[f"{NAME}:of_work"][0] == pytest.approx(wanted, rel=1e-4)

    def test_a_memory_begins_anew_with_its_instance_alone(self, rollout: Rollout):
        rollout.reset()
        rollout.step(50)
        rollout.reset(mask=[True, False])
        rollout.step(50)
        rows = rollout.state.part_memory.numpy()[:, 0]
        np.testing.assert_array_equal(rows, [[50.0, 100.0], [100.0, 200.0]])
        rollout.reset()
        assert not rollout.state.part_memory.numpy().any()

    def test_parameters_may_be_free_and_differ_between_instances(self, rollout: Rollout):
        assert [one.name for one in free_parameters(rollout.scene)] == [f"custom.{NAME}:joint.parameters.gain"]
        rollout.set_parameters([[0.0], [1.0]])
        rollout.run()
        first, second = rollout.terms()[f"{NAME}:joint"]
        k, others = np.arange(1, N + 1), len(rollout.names.joints) - 1
        assert second - first == pytest.approx(0.1 / N * others * k.sum(), rel=1e-5)
        rollout.set_parameters([2.0])

    def test_what_is_earned_lowers_the_cost_and_sees_accelerations_of_the_step(self, rollout: Rollout):
        rollout.reset()
        rollout.run()
        terms = rollout.terms()
        assert rollout.cost() == pytest.approx(
            sum(terms.values()) - (1.0 - rollout.scene.objective.torque) * terms["torque"]
        )
        assert (terms[f"{NAME}:accelerates"] < 0.0).all()
        body = rollout.names.bodies[-1]
        again = Rollout(scene(), 1, "cpu", record=[0], record_rate=2000.0)
        again.run()
        motion = again.recording()
        place = motion.body_position[:, motion.body_names.index(body)]
        size = np.linalg.norm(np.diff(place, 2, axis=0), axis=1) * (N / 0.1) ** 2
        assert -terms[f"{NAME}:accelerates"][0] == pytest.approx(size.sum() * 0.1 / N, rel=0.05)


def test_a_condition_has_parameters_and_a_memory():
    rollout = Rollout(scene((), ("too_long",), too_long=CustomPart({"gain": 30.0})), 2, "cpu", trust=True)
    rollout.run()
    assert rollout.causes() == (f"the failing condition '{NAME}:too_long' is met",) * 2
    assert rollout.end_time() == pytest.approx([30 * 0.1 / N] * 2)


def test_feet_are_followed_where_a_part_asks_for_it():
    for name, asked in (("accelerates", False), ("of_cycles", True)):
        own = scene((name,))
        trust(own)
        assert structure_of(own).objective.follows_cycles == asked


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("joint", CustomPart(), f"custom.{NAME}:joint.parameters: there is no value of 'gain'"),
        ("joint", CustomPart({"gian": 1.0}), "parameters.gian: no parameter is called 'gian'; did you mean 'gain'"),
        ("joint", CustomPart({"gain": 10.0}), r"joint.parameters.gain: must be within 0 and 9, is 10"),
        ("joint", CustomPart({"gain": Free(1.0, -1.0, 2.0)}), "parameters.gain: must be within 0 and 9, is -1"),
        ("joint", CustomPart({"gain": 1.0, "powr": 1.0}), "no parameter is called 'powr'; did you mean 'power'"),
        ("joint", CustomPart({"gain": 1.0}, {"kne": {}}), "no joint is called 'kne'; did you mean 'knee'"),
        ("steps", CustomPart({}, {"knee": {}}), "is one of the whole body: it has no numbers for each"),
        ("no_memory", None, r"takes a memory: declare how many floats, memory=1"),
        ("forgetful", None, r"takes \(.*Scratch\), without wp.array\[float\], the memory that .* declares"),
        ("nothing", None, f"'{NAME}:nothing' declares no function"),
        ("Gain", None, "'declared_parts:Gain' must be a Warp function or Declaration; it is of the type Struct"),
        ("crossed", None, "limits of .*: the lowest 'gain' is above its highest value"),
        ("small", None, rf"small' \(.*{NAME}.py:20\): memory\[1\] is not in a memory of 1: declare more"),
        ("undeclared", CustomPart({"gain": 1.0}), "; declare Gain as its parameters"),
        ("scoped", None, "scope of .* is 'muscle', but its function takes what one of 'instance' does"),
        (
            "late",
            None,
            "stage of .* is 'forces' or 'accelerations' here, not 'acceleration'; did you mean 'accelerations'",
        ),
        ("signed", None, "is 'cost' or 'earned', not 'reward'"),
        ("no_struct", None, "are not a @wp.struct of floats"),
        ("negative", None, "the memory of .* is not a number of floats, but -1"),
        ("unbounded", None, "limits of .* have no lowest and highest value of 'gain'"),
        ("misnamed", None, "no parameter is called 'gian' in defaults of .*; did you mean 'gain'"),
    ],
)
def test_what_is_forgotten_is_named_in_one_line(name: str, given: CustomPart | None, message: str):
    own = scene((name,), **({} if given is None else {name: given}))
    with pytest.raises(Error, match=message) as caught:
        Rollout(own, 1, "cpu", trust=True)
    assert "\n" not in str(caught.value)


def test_numbers_of_a_part_that_nothing_names_are_an_error_and_all_are_written_and_read_again():
    own = scene(("joint",), **{"joint": GAINS["joint"]})
    assert toml.loads(toml.dumps(own)) == own
    own.objective.custom = {}
    with pytest.raises(
        SceneError, match=rf"custom.{NAME}:joint: no part is called '{NAME}:joint' that this scene uses"
    ):
        Rollout(own, 1, "cpu", trust=True)

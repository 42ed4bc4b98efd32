"""Controllers chosen by `type`, of the package or of a user's: numbers by joint, body or muscle, and a memory."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

import warpmuscle as wm
from importing import module_of
from muscle_arm import arm, leg
from small_scene import muscle_scene
from warpmuscle.core.errors import RolloutError, SceneError
from warpmuscle.formats import load, toml
from warpmuscle.kernels.control.controllers import CONTROLLERS
from warpmuscle.model.structure import structure_of
from warpmuscle.model.unused_parameters import unused_parameters
from warpmuscle.results.records import Result, parameter_table
from warpmuscle.scene import Actuation, Controller, MachineState, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.trusted_code import named_code, without_code
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout

NAME = "controllers_by_joint"
MODULE = '''
import warp as wp
from warpmuscle.kernels.control.control import CustomController
from warpmuscle.kernels.structs import Model, Scratch, State


@wp.struct
class Drive:
    rate: float  # 1/s


@wp.struct
class Push:
    torque: float  # N m
    grows: float  # N m


@wp.struct
class Tone:
    level: float


@wp.func
def count(instance: int, model: Model, state: State, work: Scratch, drive: Drive, joints: wp.array[Push],
          memory: wp.array[float]):
    """Time, how many joints there are, and of each body the sum of what its joint is to grow by."""
    memory[0] = memory[0] + model.time_step * drive.rate
    memory[1] = float(joints.shape[0] - 1)
    for body in range(model.body_count):
        memory[2 + body] = memory[2 + body] + joints[body].grows


@wp.func
def push(instance: int, body: int, model: Model, state: State, work: Scratch, own: Push,
         memory: wp.array[float]) -> wp.vec3:
    return wp.vec3(own.torque + own.grows * memory[0], 0.0, 0.0)


@wp.func
def tense(instance: int, muscle: int, model: Model, state: State, work: Scratch, tone: Tone) -> float:
    return tone.level


@wp.func
def heavy(instance: int, body: int, model: Model, state: State, work: Scratch, drive: Drive, tone: Tone) -> wp.vec3:
    return wp.vec3(drive.rate * tone.level, 0.0, 0.0)


@wp.func
def still(instance: int, body: int, model: Model, state: State, work: Scratch) -> wp.vec3:
    return wp.vec3(float(state.simbicon.stance[instance]), 0.0, 0.0)


@wp.func
def old(instance: int, body: int, model: Model, state: State, work: Scratch) -> wp.vec3:
    return wp.vec3(float(state.stance[instance]), 0.0, 0.0)


RECORDED = (("clock", "s"), ("joints", "1"))
pusher = CustomController(
    effort=push, update=count, parameters=Drive, by_joint=Push, state=2, state_a_body=1, recorded=RECORDED
)
tensing = CustomController(excitation=tense, by_muscle=Tone)
steady = CustomController(effort=heavy, parameters=Drive, by_body=Tone, defaults=(("rate", 2.0),))
loose = CustomController(effort=heavy, parameters=Drive, by_body=Tone, defaults=(("rate", 2.0, 1.0),))
bodily = CustomController(effort=heavy, parameters=Drive, by_body=Tone)
twice = CustomController(effort=push, by_joint=Push, by_muscle=Push, state=1)
flat = CustomController(effort=push, by_joint=wp.vec3, state=1)
swapped = CustomController(excitation=push, by_joint=Push, state=1)
silent = CustomController(effort=push, by_joint=Push, state=1, recorded=(("clock", "s"), ("other", "1")))
unnamed = CustomController(effort=push, by_joint=Push, state=1, recorded=("clock",))
odd = CustomController(effort=push, by_joint=Push, state=1, recorded=(("a b", "s"),))
'''
STEP = 0.0005
module = module_of(NAME, MODULE)


def with_controller(kind: str, **tables: object) -> Scene:
    """A leg that motors move."""
    motors = {joint: Actuation("torque") for joint in ("hip", "knee")}
    return leg(actuation=motors, controller=Controller(type=kind, **tables), duration=0.1)


def pushed(**changes: object) -> Scene:
    tables = {
        "parameters": {"rate": 1.0},
        "by_joint": {"others": {"torque": 0.5, "grows": 0.0}, "knee": {"torque": Free(1.0, 0.0, 3.0), "grows": 4.0}},
    }
    return with_controller(f"{NAME}:pusher", **tables | changes)


def test_each_joint_has_its_own_numbers_and_each_instance_its_own_values_and_memory():
    rollout = Rollout(pushed(), 3, "cpu", record=[0, 2], record_rate=1.0 / STEP, trust=True)
    assert [one.name for one in rollout.parameters] == ["controller.by_joint.knee.torque"]
    values = [0.5, 1.0, 2.0]
    rollout.set_parameters(np.array(values)[:, None])
    rollout.step(100)
    for instance in (0, 2):
        motion = rollout.recording(instance)
        clock = STEP * np.arange(1, 101)
        torque = np.einsum("fij,fj->fi", _axes(motion), motion.joint_torque_desired[:, 1])
        np.testing.assert_allclose(-torque[:, 0], values[instance] + 4.0 * clock, rtol=1e-4)
        assert motion.controller_value_names == ("clock", "joints")
        assert motion.controller_value_units == ("s", "1")
        np.testing.assert_allclose(motion.controller_value, np.stack([clock, 2.0 + 0.0 * clock], axis=1), rtol=1e-5)
    memory = rollout.controller_state
    np.testing.assert_allclose(memory, [[0.05, 2.0, 0.0, 0.0, 400.0]] * 3, rtol=1e-5)
    rollout.reset(np.array([False, True, False]))
    np.testing.assert_array_equal(rollout.controller_state, [memory[0], np.zeros(5), memory[2]])


def _axes(motion: wm.Recording) -> np.ndarray:
    """Rotations (F, 3, 3) from the world into the shank, about whose x axis the knee turns."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(motion.body_orientation[:, 2]).inv().as_matrix()


def test_what_is_recorded_of_a_memory_is_in_files_and_tables_with_its_units(tmp_path: Path):
    rollout = Rollout(pushed(), 1, "cpu", record=[0], trust=True)
    rollout.step(100)
    motion = rollout.recording()
    result = Result("", "cpu", "simulate", 0, parameter_table(rollout.parameters), replays=(motion,))
    wm.write(tmp_path / "m.h5", result)
    again = wm.read(tmp_path / "m.h5").replays[0]
    np.testing.assert_array_equal(again.controller_value, motion.controller_value)
    assert (again.controller_value_names, again.controller_value_units) == (("clock", "joints"), ("s", "1"))
    assert again.missing == ("phase", "stance", "state")
    assert list(motion.to_dataframe(["controller_value"]).columns) == [
        "controller_value.clock",
        "controller_value.joints",
    ]


def test_muscles_and_bodies_may_have_numbers_of_their_own():
    controller = Controller(type=f"{NAME}:tensing", by_muscle={"flexor": {"level": 0.7}, "others": {"level": 0.1}})
    rollout = Rollout(arm(duration=0.05, controller=controller), 1, "cpu", record=[0], trust=True)
    rollout.run()
    np.testing.assert_allclose(rollout.recording().muscle_excitation, [[0.7, 0.1]] * 5, atol=1e-6)
    by_body = {"others": {"level": 1.0}, "shank": {"level": 3.0}}
    for name, given in (("bodily", {"rate": 2.0}), ("steady", {})):  # which has 2.0 by default
        scene = with_controller(f"{NAME}:{name}", parameters=given, by_body=by_body)
        rollout = Rollout(scene, 1, "cpu", record=[0], trust=True)
        rollout.step(1)
        torque = np.linalg.norm(rollout.recording().joint_torque_desired[0], axis=1)
        np.testing.assert_allclose(torque, [2.0, 6.0], rtol=1e-5)


def test_a_scene_with_numbers_by_joint_is_written_and_read_again_and_all_of_them_are_used(tmp_path: Path):
    scene = pushed()
    toml.write(scene, tmp_path / "own.toml")
    assert msgspec.to_builtins(toml.read(tmp_path / "own.toml")) == msgspec.to_builtins(scene)
    wm.trust(scene)
    assert unused_parameters(scene) == []


def test_its_code_must_be_trusted_and_can_be_left_out():
    scene = msgspec.structs.replace(pushed(), controller=Controller(type="elsewhere:made"))
    assert named_code(scene) == {"controller.type": "elsewhere:made"}
    assert without_code(scene).controller is None
    with pytest.raises(SceneError, match=r"controller.type: scene 'leg' wants to run code of 'elsewhere:made'"):
        Rollout(scene, 1, "cpu")


def test_files_without_a_type_are_of_simbicon_and_do_not_say_it():
    scene = load("fwalk")
    assert scene.controller.type == "simbicon"
    assert scene.simbicon is scene.controller
    assert "type" not in msgspec.to_builtins(scene.controller)


def test_what_has_no_simbicon_has_neither_room_nor_frames_for_it():
    rollout = Rollout(with_controller("joint_pd", by_joint=PD_GAINS), 2, "cpu", record=[0])
    rollout.step(20)
    assert rollout.state.simbicon.phase is None
    assert "phase" not in rollout.observation()
    assert rollout.recording().missing == ("phase", "stance", "state")
    controller = rollout.structure.controller
    assert (controller.advance, controller.record, controller.coordinates) == (None, None, None)
    assert structure_of(muscle_scene()).controller.advance is not None


PD_GAINS = {"others": {"kp": 40.0, "kd": 4.0, "angle": 0.2}}


@pytest.mark.parametrize(
    ("controller", "message"),
    [
        (
            Controller(type="joint_pid"),
            r"controller.type: no controller is called 'joint_pid'; did you mean 'joint_pd'\?",
        ),
        (Controller(type="joint_pd"), "controller.by_joint.hip: there is no value of 'kp', 'kd', 'angle'; one under"),
        (
            Controller(type="joint_pd", by_joint={"hip": {"kp": 1.0, "kd": 1.0, "angle": 0.0}, "knee": {"kp": 1.0}}),
            "controller.by_joint.knee: there is no value of 'kd', 'angle'",
        ),
        (
            Controller(type="joint_pd", by_joint=PD_GAINS | {"kne": {"kp": 1.0}}),
            "controller.by_joint.kne: no joint is called 'kne'; did you mean 'knee'",
        ),
        (
            Controller(type="joint_pd", by_joint={"others": {"kp": 1.0, "kd": 1.0, "angel": 0.0}}),
            r"controller.by_joint.others.angel: no parameter is called 'angel'; did you mean 'angle'",
        ),
        (
            Controller(type="joint_pd", by_joint=PD_GAINS, parameters={"kp": 1.0}),
            "controller.parameters.kp: no parameter is called 'kp'; it takes none",
        ),
        (
            Controller(type="joint_pd", by_joint=PD_GAINS, by_muscle={"others": {"kp": 1.0}}),
            "controller.by_muscle: 'joint_pd' takes no values by muscle",
        ),
        (
            Controller([MachineState(0.5)], type="joint_pd", by_joint=PD_GAINS),
            "controller.states: a controller of type 'joint_pd' takes no states, which is of simbicon",
        ),
        (
            Controller([MachineState(0.5)], by_joint=PD_GAINS),
            "controller.by_joint: a simbicon controller does not take this",
        ),
        (Controller(hips=("hip", "hip2")), "controller.hips.1: no joint is called 'hip2'"),
    ],
    ids=str,
)
def test_what_a_type_lacks_or_does_not_take_is_said_in_one_line(controller: Controller, message: str):
    scene = with_controller("joint_pd")
    scene.controller = controller
    if scene.simbicon is not None:
        scene.character.feet = ("thigh", "shank")
    with pytest.raises(SceneError, match=message) as caught:
        check_scene(scene)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("twice", "has one structure in two places: make one for by_muscle"),
        ("flat", "those by_joint of .* are not a @wp.struct of floats"),
        (
            "swapped",
            r"it takes \(int, int, Model, State, Scratch \[, wp.array\[float\]\]\), but 'push' .*, Push, wp.arr",
        ),
        ("silent", "records 2 numbers of its state, which has 1"),
        ("unnamed", r"must be a tuple of \(name, unit\)"),
        ("odd", "must be words, each once"),
        ("still", "reads `state.simbicon`, and the scene has no simbicon controller"),
        ("loose", r"defaults of .* must be a tuple of \(parameter, number\)"),
        ("pushr", "has no function 'pushr'; did you mean 'pusher'"),
    ],
)
def test_what_a_declaration_lacks_is_said_in_one_line(entry: str, message: str):
    tables = {} if entry == "still" else {"by_joint": {"others": {"torque": 1.0, "grows": 0.0}}}
    scene = with_controller(f"{NAME}:{entry}", **tables)
    with pytest.raises(SceneError, match=message) as caught:
        Rollout(scene, 1, "cpu", trust=True)
    assert "\n" not in str(caught.value)


def test_a_function_that_reads_state_where_it_was_is_told_where_it_is():
    rollout = Rollout(with_controller(f"{NAME}:old"), 1, "cpu", trust=True)
    with pytest.raises(
        RolloutError, match=r"`stance` is not an attribute.*; it is `state.simbicon.stance` now"
    ) as caught:
        rollout.step(1)
    assert "\n" not in str(caught.value)


def test_values_by_joint_need_a_type_and_there_is_one_controller():
    scene = leg(custom_controller=f"{NAME}:pusher", custom_controller_parameters={"rate": 1.0})
    with pytest.raises(SceneError, match=r"custom_controller: .* takes values by_joint: name it as `type` in"):
        Rollout(scene, 1, "cpu", trust=True)
    scene = with_controller("joint_pd", by_joint=PD_GAINS)
    scene.custom_controller = f"{NAME}:pusher"
    with pytest.raises(SceneError, match="custom_controller: there is a controller of type 'joint_pd' already"):
        check_scene(scene)


def test_every_controller_of_the_package_says_what_it_does_and_what_it_takes():
    for name, one in CONTROLLERS.items():
        assert one.shipped, name
        assert one.description, name
        assert one.effort or one.excitation, name

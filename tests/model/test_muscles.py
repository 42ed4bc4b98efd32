"""Numbers of muscles and of what drives joints as the device has them, against typed ones."""

import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import warp as wp

from muscle_arm import constant, leg
from warpmuscle.kernels import structs
from warpmuscle.kernels.curve.curve_sets import LEE
from warpmuscle.kernels.muscle import muscle_laws
from warpmuscle.kernels.muscle.contraction import RIGID
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind
from warpmuscle.kernels.muscle.muscle_laws import HILL, IDEAL, LAWS, LEGACY
from warpmuscle.model import muscles as model
from warpmuscle.scene import Actuation, Condition, Excitation, MuscleModel, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.topology import topology

H = 0.0005  # s


def scene_of(**changes: object) -> Scene:
    """A leg with muscles that differ."""
    scene = leg(time_step=H, **changes)
    muscles = scene.character.muscles
    for name, numbers in {
        "both": {"f_max": 900.0, "l_opt": 0.12, "l_slack": 0.2, "pennation": 0.3, "slow_fibres": 0.7, "delay": 0.0102},
        "hip": {"f_max": 400.0, "l_opt": 0.15, "l_slack": 0.1, "pennation": 0.0, "slow_fibres": 0.4, "delay": 0.0},
        "knee": {"f_max": 650.0, "l_opt": 0.08, "l_slack": 0.3, "pennation": 0.1, "slow_fibres": 0.5, "delay": 0.004},
    }.items():
        for field, value in numbers.items():
            setattr(muscles[name], field, value)
    return scene


NAMES = ("both", "hip", "knee")


def test_numbers_of_muscles_are_those_of_the_scene_and_rests_are_exponentials():
    common = MuscleModel(v_max=9.0, rise_time=0.012, fall_time=0.05, neural_time=0.02, activation="scaled")
    struct = model.muscles_struct(scene_of(muscle_model=common), NAMES, "cpu")
    row = struct.row.numpy()[0]
    assert (struct.count, struct.scaled_rates) == (3, 1)
    expected = {
        "f_max": (900.0, 400.0, 650.0), "l_opt": (0.12, 0.15, 0.08), "l_slack": (0.2, 0.1, 0.3),
        "slow_fibres": (0.7, 0.4, 0.5), "width": (0.12 * np.sin(0.3), 0.0, 0.08 * np.sin(0.1)),
        "delay_steps": (20, 0, 8), "v_max": 9.0, "damping": common.damping, "rise_time": 0.012, "fall_time": 0.05,
        "rise_rest": np.exp(-H / 0.012), "fall_rest": np.exp(-H / 0.05), "neural_rest": np.exp(-H / 0.02),
    }  # fmt: skip
    for field, numbers in expected.items():
        np.testing.assert_allclose(row[field], np.broadcast_to(numbers, 3), rtol=1e-6, atol=1e-9, err_msg=field)


def test_masses_are_of_the_volume_of_the_fibres():
    """F_max / tension * l_opt * 1059.7 kg/m^3 (Mendez and Keys 1960), at the model's tension of 0.25 MPa by default."""
    struct = model.muscles_struct(scene_of(), NAMES, "cpu")
    tension = scene_of().muscle_model.specific_tension
    expected = np.array([900.0 * 0.12, 400.0 * 0.15, 650.0 * 0.08]) / tension * 1059.7
    np.testing.assert_allclose(struct.mass.numpy()[0], expected, rtol=1e-3)


def test_muscles_may_have_rates_and_speeds_of_their_own():
    scene = scene_of()
    scene.character.muscles["hip"].v_max, scene.character.muscles["knee"].fall_time = 14.0, 0.09
    row = model.muscles_struct(scene, NAMES, "cpu").row.numpy()[0]
    usual = scene.muscle_model
    np.testing.assert_allclose(row["v_max"], [usual.v_max, 14.0, usual.v_max], rtol=1e-6)
    np.testing.assert_allclose(row["fall_time"], [usual.fall_time, usual.fall_time, 0.09], rtol=1e-6)
    np.testing.assert_allclose(row["fall_rest"], np.exp(-H / row["fall_time"].astype(float)), rtol=1e-6)


def test_what_neural_dynamics_hands_on_is_the_integral_of_its_way():
    """a' = (n - a)/T with n = exp(-t/N) from a = 0: after a step a is the mix."""
    for neural, own in ((0.02, 0.05), (0.03, 0.01), (0.02, 0.02)):
        n, a, steps = 1.0, 0.0, 20000
        for _ in range(steps):
            middle = n * np.exp(-0.5 * H / steps / neural)
            a += (H / steps) * (middle - a) / own
            n *= np.exp(-H / steps / neural)
        assert model.neural_mix(H, neural, own) == pytest.approx(a, rel=1e-4)


def test_delays_of_the_original_program_are_whole_steps_of_its_rate_less_one():
    scene = scene_of(muscle_model=MuscleModel(legacy=True))
    for delay, steps in ((0.0, 0), (0.0005, 0), (0.001, 1), (0.0102, 19), (0.0105, 20)):
        scene.character.muscles["both"].delay = delay
        assert model.delay_steps(scene, ("both",))[0, 0] == steps
    scene.time_step = 0.001
    assert model.delay_steps(scene, ("both",))[0, 0] == 10


def test_excitations_of_their_own_lie_one_behind_the_other():
    scene = scene_of()
    scene.character.muscles["both"].excitation = Excitation([0.0, 0.4], [0.1, 0.9], period=0.8)
    scene.character.muscles["knee"].excitation = Excitation([0.0, 0.2, 0.3], [0.2, 0.3, 0.5], period=0.0)
    struct = model.muscles_struct(scene, NAMES, "cpu")
    own = struct.timed.numpy()[0]
    np.testing.assert_array_equal(own["first_knot"], [0, 2, 2])
    np.testing.assert_array_equal(own["end_knot"], [2, 2, 5])
    np.testing.assert_allclose(own["period"], [0.8, 0.0, 0.0])
    np.testing.assert_allclose(struct.knot_time.numpy()[0], [0.0, 0.4, 0.0, 0.2, 0.3])
    np.testing.assert_allclose(struct.knot_value.numpy()[0], [0.1, 0.9, 0.2, 0.3, 0.5])


def found_in(scene: Scene) -> model.ActuationMap:
    return model.driven(scene, topology(scene.character))


def test_joints_are_driven_by_what_crosses_them_unless_the_scene_says_otherwise():
    scene = scene_of()
    found = found_in(scene)
    assert found.drives == {"hip": ["muscle"] * 3, "knee": ["muscle"]}
    assert (found.muscles, found.by_torque_alone, found.torques_help) == (NAMES, False, False)
    scene.actuation = {"hip": Actuation("torque")}
    found = found_in(scene)
    assert (found.muscles, found.by_torque_alone, found.torques_help) == (("both", "knee"), False, True)
    scene.actuation["knee"] = Actuation("torque")
    found = found_in(scene)
    assert (found.muscles, found.by_torque_alone) == ((), True)
    scene.actuation = {"knee": Actuation("assisted")}
    assert found_in(scene).torques_help


def test_torque_is_shared_over_the_joints_that_a_muscle_crosses_and_muscles_drive():
    scene = scene_of(muscle_model=MuscleModel(sharing="each"))
    names = topology(scene.character)
    for sharing, actuation, joints in (
        ("each", {}, 0), ("together", {}, 2), ("together", {"hip": Actuation("torque")}, 1),
    ):  # fmt: skip
        scene.muscle_model.sharing, scene.actuation = sharing, actuation
        found = found_in(scene)
        assert model.shared_joints(scene, names, found) == joints


def test_weights_springs_and_rests_of_joints_are_those_of_their_drives():
    scene = scene_of()
    rest = (0.2, 0.0, 0.0)
    scene.actuation = {
        "hip": Actuation(["torque", "assisted", "passive"], stiffness=30.0, damping=2.0),
        "knee": Actuation("muscle", stiffness=0.0, damping=1.5, rest=rest),
    }
    names = topology(scene.character)
    found = found_in(scene)
    struct = model.actuation_struct(scene, names, found.drives, "cpu")
    np.testing.assert_array_equal(struct.drive.numpy(), [structs.BY_TORQUE, structs.MIXED, structs.MIXED])
    np.testing.assert_array_equal(struct.by_torque.numpy(), [[0, 0, 0], [1, 1, 0], [0, 0, 0]])
    np.testing.assert_array_equal(struct.by_muscles.numpy(), [[0, 0, 0], [0, 1, 0], [1, 0, 0]])
    np.testing.assert_array_equal(struct.passive.numpy(), [[0, 0, 0], [0, 1, 1], [1, 0, 0]])
    np.testing.assert_allclose(struct.stiffness.numpy(), [[0.0, 30.0, 0.0]])
    np.testing.assert_allclose(struct.damping.numpy(), [[0.0, 2.0, 1.5]])
    expected = [[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0], [np.sin(0.1), 0.0, 0.0, np.cos(0.1)]]
    np.testing.assert_allclose(struct.rest.numpy()[0], expected, atol=1e-6)
    plain = model.actuation_struct(scene_of(), names, found_in(scene_of()).drives, "cpu")
    np.testing.assert_array_equal(plain.drive.numpy(), [structs.BY_TORQUE, structs.BY_MUSCLES, structs.BY_MUSCLES])
    np.testing.assert_array_equal(plain.passive.numpy(), 0.0)


@pytest.mark.parametrize("field", ["stiffness", "damping"])
def test_a_joint_whose_spring_is_free_may_have_one(field: str):
    scene = scene_of()
    scene.actuation = {"knee": Actuation("muscle", **{field: Free(0.0, min=0.0, max=50.0)})}
    kind = model.compiled_kind(scene, topology(scene.character), found_in(scene), 8)
    assert kind is not None
    assert kind.mixed
    scene.actuation = {"knee": Actuation("muscle")}
    plain = model.compiled_kind(scene, topology(scene.character), found_in(scene), 8)
    assert plain is not None
    assert not plain.mixed


KIND = MuscleKind(LEE, RIGID, HILL)


def test_a_law_of_muscles_is_chosen_by_its_name_or_by_the_field_that_is_short_for_it():
    files = {path.stem for path in Path(muscle_laws.__file__).parent.glob("*_law.py")}
    assert {f"{name}_law" for name in LAWS} == files
    for name, law in LAWS.items():
        assert model.muscle_kind(MuscleModel(law=name)).law is law
    for name in ("legacy", "ideal"):
        assert model.muscle_kind(MuscleModel(law=name)) == model.muscle_kind(MuscleModel(**{name: True}))


def test_a_file_of_a_law_without_a_name_is_told(tmp_path: Path):
    (tmp_path / "elastic_law.py").touch()
    with pytest.raises(TypeError, match=r"'elastic' in elastic_law.py has no name: add it to `Law` in law_names.py"):
        muscle_laws.laws_of(tmp_path)


def test_what_a_law_forgets_is_told(monkeypatch: pytest.MonkeyPatch):
    with pytest.raises(TypeError, match=r"'elastic' has no file elastic_law.py with its ELASTIC"):
        muscle_laws.law_of_file("elastic")
    file = ModuleType("elastic_law")
    monkeypatch.setitem(sys.modules, f"{muscle_laws.__package__}.elastic_law", file)
    with pytest.raises(TypeError, match=r"'elastic': elastic_law.py has no ELASTIC, a `muscle_kind.MuscleLaw`"):
        muscle_laws.law_of_file("elastic")
    monkeypatch.setattr(file, "ELASTIC", HILL._replace(contract=None), raising=False)
    with pytest.raises(TypeError, match=r"'elastic' has no 'contract': ELASTIC in elastic_law.py needs a function"):
        muscle_laws.law_of_file("elastic")
    monkeypatch.setattr(file, "ELASTIC", HILL._replace(contract=IDEAL.contract(KIND)), raising=False)
    with pytest.raises(TypeError, match=r"'elastic': 'contract' is a Warp function: .* as `lambda kind: \.\.\.`"):
        muscle_laws.law_of_file("elastic")


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("field", muscle_laws.ARGUMENTS)
def test_functions_of_laws_take_what_they_are_given(name: str, field: str):
    assert muscle_laws.function_of(KIND._replace(law=LAWS[name]), field).key.endswith(field)


def test_what_a_function_of_a_law_forgets_is_told():
    idle, short = IDEAL.activate(KIND), LAWS["legacy"].strength
    for field, made, said in (
        ("activate", None, r"its 'activate' makes no Warp function .*instance, m, muscle.* NoneType"),
        ("contract", idle, r"its 'contract' must write `muscle.fibre`: activate \(.*ideal_law.py:\d+\) does not"),
        ("activate", short(KIND), r"its 'activate' must make a Warp function .* takes other arguments"),
        ("strength", idle, r"its 'strength' must make a Warp function .*-> wp.vec3: activate .* takes other"),
    ):
        law = IDEAL._replace(**{field: lambda kind, made=made: made})
        with pytest.raises(TypeError, match=said):
            muscle_laws.function_of(KIND._replace(law=law), field)


def test_a_step_has_compiled_in_what_its_muscles_need():
    for given, law in (({}, HILL), ({"ideal": True}, IDEAL), ({"legacy": True}, LEGACY)):
        kind = model.muscle_kind(MuscleModel(**given), scene_of().character.muscles.values())
        assert (kind.law, kind.tendon) == (law, RIGID)
        assert not kind.neural
    for field, value in (("neural", {"activation": "neural"}), ("implicit", {"implicit_damping": True})):
        assert getattr(model.muscle_kind(MuscleModel(**value)), field)
        assert not getattr(model.muscle_kind(MuscleModel(**value, ideal=True)), field)
    scene = scene_of()
    names = topology(scene.character)

    def compiled(lean: bool, capacity: int = 15):
        return model.compiled_kind(scene, names, found_in(scene), capacity, lean)

    full, lean = compiled(False), compiled(True)
    assert (full.timed, full.all_timed, full.delayed) == (True, False, True)
    assert (full.conditions, full.straight) == (False, False)
    assert (lean.timed, lean.all_timed, lean.delayed, lean.mixed) == (False, False, True, False)
    for own in scene.character.muscles.values():
        own.delay, own.excitation = 0.0, constant(0.3)
    assert (compiled(True).timed, compiled(True).all_timed, compiled(True).delayed) == (True, True, False)
    scene.character.muscles["hip"].delay = Free(0.0, 0.0, 0.01)
    scene.character.muscles["hip"].excitation = None
    assert (compiled(True).timed, compiled(True).all_timed, compiled(True).delayed) == (True, False, True)
    scene.character.muscles["both"].path[1].condition = Condition("knee", -1.0, 0.5)
    assert compiled(True).conditions
    scene.actuation = {"knee": Actuation("muscle", stiffness=3.0)}
    assert compiled(True).mixed
    scene.actuation = {"hip": Actuation("torque"), "knee": Actuation("torque")}
    assert compiled(True) is None


def test_time_constants_are_smoothed_where_a_width_is_given_or_free():
    scene = scene_of()
    muscles = scene.character.muscles
    assert not model.is_smoothed(muscles.values(), MuscleModel())
    assert model.is_smoothed(muscles.values(), MuscleModel(activation_smoothing=0.5))
    for width, smoothed in ((0.0, False), (1.5, True), (Free(0.0, 0.0, 1.0), True)):
        muscles["hip"].activation_smoothing = width
        assert model.is_smoothed(muscles.values(), MuscleModel()) == smoothed


def test_some_muscles_follow_their_excitation_by_another_law():
    scene = scene_of()
    muscles, scaled = scene.character.muscles, MuscleModel(activation="scaled")
    assert not model.muscle_kind(scaled, muscles.values()).smoothed
    muscles["hip"].activation = "blended"
    muscles["both"].activation = "excited"
    muscles["both"].activation_smoothing = 0.3
    kind = model.muscle_kind(scaled, muscles.values())
    assert (kind.smoothed, kind.blended, kind.excited) == (True, False, False)
    assert not model.muscle_kind(MuscleModel(activation="blended"), [muscles["hip"]]).smoothed
    alike = MuscleModel(activation="excited_rise")
    kind = model.muscle_kind(alike, [muscles["knee"]])
    assert (kind.smoothed, kind.excited, kind.excited_rise) == (False, False, True)
    kind = model.muscle_kind(alike, muscles.values())
    assert (kind.smoothed, kind.excited_rise) == (True, False)
    scene.muscle_model = scaled
    found = model.muscles_struct(scene, ("hip", "both", "knee"), "cpu").smoothing.numpy()
    np.testing.assert_array_equal(found, [[structs.BLENDED, structs.EXCITED, 0.0]])
    scene.muscle_model = alike
    found = model.muscles_struct(scene, ("hip", "knee"), "cpu").smoothing.numpy()
    np.testing.assert_array_equal(found, [[structs.BLENDED, structs.EXCITED_RISE]])


def test_the_state_has_room_for_every_muscle_crossing_and_delay():
    def zeros(*shape: int, dtype: type = float) -> wp.array:
        return wp.zeros(shape, dtype=dtype, device="cpu")

    state = model.muscle_state(4, 3, 5, 7, zeros, excited=True)
    assert (state.activation.shape, state.excitation_ring.shape, state.moment_arm.shape) == ((4, 3), (4, 7, 3), (4, 5))
    assert (state.sensed.shape, state.stands.shape, state.landed.shape) == ((4, 3), (4, 2), (4,))
    quiet = model.muscle_state(4, 0, 0, 0, zeros)
    assert (quiet.force.shape, quiet.excitation_ring.shape, quiet.moment_arm.shape) == ((4, 1), (4, 1, 1), (4, 1))
    assert (quiet.sensed.shape, quiet.lean_at_lift.shape) == ((0, 1), (0, 2))
    for own, rows, bodies in ((quiet.sharing, 0, 0), (model.muscle_state(4, 3, 5, 7, zeros, False, 6).sharing, 4, 6)):
        assert {len(own.muscle), len(own.share)} == {rows}
        assert own.price.shape == (rows, bodies)

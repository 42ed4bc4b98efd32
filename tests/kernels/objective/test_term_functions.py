"""Terms of the objective: on motions whose values are known, and as parts of the cost."""

import msgspec
import numpy as np
import pytest
import warp as wp
from probes import filled

from muscle_arm import arm, constant, leg
from short_walks import OF_TORQUES
from small_scene import sound_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.kernels.objective import term_functions
from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.kernels.structs import HINGE, Model, Scratch, Skeleton, State
from warpmuscle.model.objective import counted_terms, objective_kind
from warpmuscle.scene import InitialState, JointState, MuscleModel, Objective, Scene
from warpmuscle.scene.accounting import FORMULAS
from warpmuscle.scene.masses import DENSITY, muscle_mass
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout

ONES = dict.fromkeys(TERMS, 1.0) | {"tracking": 0.0}
WALKS_ONLY = {"norms": 0.0, "norm_force": 0.0, "norm_moments": 0.0, "step_width": 0.0, "stride_speed": 0.0}
EVERY = Objective(**ONES | WALKS_ONLY, head_body="tip")
ACTIVE = 0.6


def held(**changes) -> Scene:
    """An arm whose muscles have been equally active from the start, so that it hangs still, for a second."""
    scene = arm("hinge", {"excitation": constant(ACTIVE)}, duration=1.0, objective=EVERY, **changes)
    scene.character.muscles["extensor"].excitation = constant(ACTIVE)
    scene.muscle_model = MuscleModel(initial_activation=ACTIVE)
    return scene


def values(scene: Scene, instances: int = 1, **options) -> dict[str, np.ndarray]:
    rollout = recorded(scene, instances, **options)
    rollout.run()
    return rollout.terms()


def recorded(scene: Scene, instances: int = 1, **options) -> Rollout:
    """A batch whose first instance is recorded, also where no test looks at it: so all share one kernel."""
    return Rollout(scene, instances, "cpu", record=[0], **options)


def test_no_term_weighs_anything_by_default_and_each_has_a_unit():
    assert Objective.__struct_fields__[: len(TERMS)] == tuple(TERMS)
    assert not any(getattr(Objective(), name) for name in TERMS)
    assert all(term.unit and term.description for term in TERMS.values())


def test_each_metabolic_model_of_a_scene_is_summed_by_a_function_of_its_own():
    scene = msgspec.structs.replace(load("walk56"), objective=Objective(metabolic=1.0))
    for model in FORMULAS:
        scene.objective.metabolic_model = model
        assert objective_kind(scene, True).muscle == (f"metabolic_{model}",)


def test_only_terms_with_a_weight_are_summed_and_torque_always():
    assert counted_terms(Objective()) == ("torque",)
    assert counted_terms(Objective(torque=0.0, speed=2.0)) == ("torque", "speed")
    assert counted_terms(Objective(effort_cubed=Free(0.0, 0.0, 1.0))) == ("torque", "effort_cubed")


@pytest.mark.long
def test_efforts_of_two_muscles_at_constant_activation():
    terms = values(held())
    np.testing.assert_allclose(terms["effort_squared"], 2.0 * ACTIVE**2, rtol=1e-5)
    np.testing.assert_allclose(terms["effort_cubed"], 2.0 * ACTIVE**3, rtol=1e-5)
    mass = sum(muscle_mass(muscle, 6e5) for muscle in held().character.muscles.values())
    np.testing.assert_allclose(terms["mass_effort_squared"], mass * ACTIVE**2, rtol=1e-5)
    np.testing.assert_allclose(terms["mass_effort_cubed"], mass * ACTIVE**3, rtol=1e-5)


@pytest.mark.parametrize(("slow", "tensions"), [(0.5, [6e5, 6e5]), (1.0, [6e5, 6e5]), (0.5, [3e5, 1.5e6])])
def test_metabolic_energy_of_muscles_held_still(slow: float, tensions: list[float]):
    """Heat of activation and maintenance alone (Wang 2012), at the length that the tendon leaves the fibre."""
    scene = held()
    if tensions[1] != 6e5:  # of the muscle model, and of the second muscle itself
        scene.muscle_model.specific_tension = tensions[0]
        list(scene.character.muscles.values())[1].specific_tension = tensions[1]
    scene.muscle_model.damping = 0.0
    scene.objective = msgspec.structs.replace(EVERY, basal_rate=0.0)
    expected = 0.0
    for muscle, tension in zip(scene.character.muscles.values(), tensions, strict=True):
        muscle.slow_fibres = slow
        x = (0.3 - muscle.l_slack) / muscle.l_opt
        u = slow * np.sin(np.pi / 2 * ACTIVE), (1.0 - slow) * (1.0 - np.cos(np.pi / 2 * ACTIVE))
        mass = muscle.f_max * muscle.l_opt * DENSITY / tension
        maintained = np.interp(x, [0.5, 1.0, 1.5], [0.5, 1.0, 0.0])
        expected += mass * (40.0 * u[0] + 133.0 * u[1] + maintained * (74.0 * u[0] + 111.0 * u[1]))
    np.testing.assert_allclose(values(scene)["metabolic"], expected, rtol=2e-3)


def test_the_body_at_rest_costs_its_basal_rate_and_transport_counts_a_metre_at_least():
    scene = held()
    terms, mass = values(scene), 4.0
    still = values(msgspec.structs.replace(scene, objective=msgspec.structs.replace(EVERY, basal_rate=0.0)))
    np.testing.assert_allclose(terms["metabolic"] - still["metabolic"], 1.51 * mass * 1.0, rtol=1e-6)
    np.testing.assert_allclose(terms["cost_of_transport"], terms["metabolic"] / mass, rtol=1e-6)


def test_speed_error_of_what_stands_still_is_the_target_squared():
    scene = held()
    scene.objective = msgspec.structs.replace(EVERY, target_speed=1.5)
    np.testing.assert_allclose(values(scene)["speed"], 1.5**2, rtol=1e-4)


def test_turning_of_the_head_is_its_squared_angular_velocity_over_time():
    scene = arm("hinge", {"excitation": constant(0.8)}, duration=0.3, objective=EVERY)
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000.0)
    rollout.run()
    turning = np.sum(rollout.recording().joint_angular_velocity ** 2) * scene.time_step
    assert turning > 0.1
    np.testing.assert_allclose(rollout.terms()["head"], turning, rtol=1e-5)


def test_torques_of_limits_count_only_where_a_joint_is_beyond_them():
    scene = leg(duration=0.2, objective=msgspec.structs.replace(EVERY, head_body="shank"))
    scene.initial_state = InitialState((0.0, 1.0, 0.0), joints={"knee": JointState(angular_velocity=(5.0, 0.0, 0.0))})
    free = values(scene)
    scene.character.joints["knee"].limits = [(-0.05, 0.05)]
    stopped = values(scene)
    assert free["joint_limits"][0] == 0.0
    assert stopped["joint_limits"][0] > 1.0


@wp.kernel(enable_backward=False)
def excess(model: Model, state: State, work: Scratch, found: wp.array[wp.vec3]):
    its = work
    found[0] = term_functions.torque_of_limits(0, 1, model, state, its)


def test_asking_for_the_torque_of_limits_leaves_the_body_as_it_was():
    plan = {"joint_type": [0, HINGE], "parent": [-1, 0], "has_limits": [0, 1]}
    limits = {"low": [[[-0.5, 0.0, 0.0]] * 2], "high": [[[0.4, 0.0, 0.0]] * 2], "stiffness": [[400.0] * 2]}
    row = {"axis_a": [[[1.0, 0.0, 0.0]] * 2]}
    model = filled(Model, time_step=0.001, skeleton=filled(Skeleton, plan=plan, row=row, limits=limits))
    one = np.ones((1, 1), np.float32)
    state = filled(State, coordinates=0.6 * one, speeds=0.0 * one, accelerations=0.0 * one)
    torque, stiff = np.array([[0.0] * 3, [7.0, 8.0, 9.0]]), np.array([[0.0] * 6, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]])
    work = filled(Scratch, rotation=np.tile(np.eye(3), (2, 1, 1)), torque=torque, stiffness=stiff)
    found = wp.zeros(1, dtype=wp.vec3, device="cpu")
    wp.launch(excess, 1, [model, state, work, found], device="cpu")
    assert np.linalg.norm(found.numpy()) == pytest.approx(400.0 * 0.2, rel=1e-3)
    np.testing.assert_array_equal(work.torque.numpy(), torque)
    np.testing.assert_array_equal(work.stiffness.numpy().reshape(2, 6), stiff)


def test_without_feet_there_is_no_step_width():
    with pytest.raises(SceneError, match=r"step_width.*no feet"):
        check_scene(msgspec.structs.replace(arm("hinge", {}), objective=Objective(step_width=1.0)))


@pytest.mark.parametrize("term", ["norms", "norm_force", "norm_moments"])
def test_what_does_not_walk_is_not_compared_with_human_walking(term: str):
    with pytest.raises(SceneError, match=f"{term}.*no feet"):
        check_scene(msgspec.structs.replace(arm("hinge", {}), objective=Objective(**{term: 1.0})))
    scene = sound_scene()
    scene.objective = Objective(**{term: 1.0})
    with pytest.raises(SceneError, match="has no hip, knee and ankle"):
        check_scene(scene)


def test_moments_of_people_who_run_are_not_known():
    with pytest.raises(SceneError, match="walking only"):
        check_scene(msgspec.structs.replace(load("fjog"), objective=Objective(norm_moments=1.0, gait="run")))


@pytest.mark.usefixtures("optimized_test")
def test_cost_is_the_weighted_sum_and_a_failure_costs_more():
    scene = load("fwalk")
    weights = {name: 0.5 + number for number, name in enumerate(OF_TORQUES)}
    scene = msgspec.structs.replace(scene, duration=2.5, objective=Objective(**weights))  # steps have a width by then
    rollout = recorded(scene)
    rollout.run()
    terms = rollout.terms()
    expected = sum(weight * terms[name] for name, weight in weights.items())
    np.testing.assert_allclose(rollout.cost(), expected, rtol=1e-6)
    assert terms["torque"][0] > 100.0
    assert all(terms[name][0] * TERMS[name].factor > 0.0 for name in weights)
    state = InitialState((0.0, 3.0, 0.0))
    weak = msgspec.structs.replace(scene, duration=1.0, objective=Objective(fall=1.0), initial_state=state)
    rollout = Rollout(weak, 1, "cpu")
    rollout.run()
    assert rollout.status()[0] != Status.COMPLETED
    np.testing.assert_allclose(rollout.terms()["fall"], 1.0 - rollout.end_time())
    assert rollout.cost()[0] > 1e6


@pytest.mark.usefixtures("optimized_test")
def test_without_muscles_applied_torque_is_the_feedback_torque():
    scene = msgspec.structs.replace(load("fwalk"), duration=0.5, objective=Objective(**OF_TORQUES))
    terms = values(scene)
    np.testing.assert_allclose(terms["applied_torque"], terms["torque"], rtol=1e-6)


def test_terms_do_not_depend_on_batch_threads_or_chunks():
    scene = msgspec.structs.replace(load("walk56"), duration=0.3, objective=Objective(**ONES))
    alone, among = values(scene), values(scene, 5, threads=2)
    rollout = recorded(scene)
    for _ in range(6):
        rollout.run(0.05)
    for name, value in rollout.terms().items():
        assert value[0] == alone[name][0] == among[name][4], name


def test_legs_that_cross_fail_where_the_scene_says_so():
    scene = msgspec.structs.replace(load("fwalk"), duration=1.0)
    for hip, angle in (("lHip", -0.4), ("rHip", 0.4)):
        scene.initial_state.joints[hip] = JointState((0.0, 0.0, np.sin(angle / 2), np.cos(angle / 2)))
    outcome = []
    for largest in (0.0, 0.05):
        scene.failure.leg_crossing = largest
        rollout = recorded(scene)
        rollout.run()
        outcome.append(Status(rollout.status()[0]))
    assert outcome[1] == Status.CROSSED
    assert outcome[0] != Status.CROSSED


def test_a_head_that_is_no_body_is_named():
    scene = sound_scene()
    scene.objective = Objective(head=1.0, head_body="haed")
    with pytest.raises(SceneError, match="haed"):
        check_scene(scene)


def test_what_joints_and_muscles_add_to_terms_sums_up_to_them():
    rollout = recorded(held(), 2)
    rollout.run()
    terms, parts = rollout.terms(), rollout.parts(1)
    assert set(parts["effort_squared"]) == {"flexor", "extensor"}
    assert set(parts["metabolic"]) == {"flexor", "extensor", "basal rate"}
    assert set(parts["cost_of_transport"]) == set(parts["metabolic"])
    assert not {"speed", "heading", "head", "fall"} & set(parts)
    for name, own in parts.items():
        assert sum(own.values()) == pytest.approx(terms[name][1], rel=1e-6)


@pytest.mark.usefixtures("optimized_test")
def test_gait_cycles_begin_anew_after_a_reset_and_do_not_depend_on_the_batch():
    scene = msgspec.structs.replace(load("fwalk"), duration=2.5, objective=Objective(**OF_TORQUES))
    alone, batch = recorded(scene), recorded(scene, 3)
    for rollout in (alone, batch):
        rollout.run()
    first = batch.terms()
    for name in ("norms", "norm_force"):
        np.testing.assert_array_equal(first[name], np.repeat(alone.terms()[name], 3))
    batch.reset(mask=np.array([False, True, False]))
    batch.step(round(2.5 / scene.time_step))
    for name in ("norms", "norm_force"):
        np.testing.assert_array_equal(batch.terms()[name], first[name])


def test_umbergers_power_counts_each_muscles_own_mass():
    """Two mirror images at rest, one of twice the strength and so of twice the mass: twice the least heat, 1 W/kg."""
    scene = arm(flexor={"f_max": 800.0}, gravity=0.0, duration=0.02)
    scene.objective = Objective(metabolic=1.0, metabolic_model="umberger", basal_rate=0.0)
    rollout = recorded(scene)
    rollout.run()
    spent = rollout.parts(0)["metabolic"]
    assert spent["extensor"] > 0.0
    assert spent["flexor"] == pytest.approx(2.0 * spent["extensor"], rel=0.01)

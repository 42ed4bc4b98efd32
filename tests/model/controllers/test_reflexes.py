"""Reflexes in scenes: what is refused, what is written, what is compiled, and that they walk."""

import re
from pathlib import Path

import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.core.status import Status
from warpmuscle.formats import load, toml
from warpmuscle.model.controllers.reflexes import has_reflexes
from warpmuscle.model.controllers.table import compiled_controller
from warpmuscle.model.muscles import driven
from warpmuscle.scene import Actuation, Reflex, Reflexes, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.rollout import Rollout

pytestmark = pytest.mark.optimized  # shipped scenes, which others run as well


def with_reflex(reflex: Reflex, muscle: str = "SOL") -> Scene:
    """The walk by reflexes with one more."""
    scene = load("reflex_walk")
    assert scene.controller is not None
    assert scene.controller.reflexes is not None
    scene.controller.reflexes.muscles.setdefault(muscle, {})["own"] = reflex
    return scene


@pytest.mark.parametrize(
    ("reflex", "muscle", "key", "message"),
    [
        (Reflex(1.0, "force"), "SOLE", "SOLE", "no muscle of both legs .* is called 'SOLE'; did you mean 'SOL'"),
        (Reflex(1.0, "force", "HAMS"), "SOL", "SOL.own.of", "'HAMS'; did you mean 'HAM'"),
        (Reflex(1.0, "angle"), "SOL", "SOL.own.of", "an angle needs the joint"),
        (Reflex(1.0, "angle", "knee"), "SOL", "SOL.own.of", "no joint of both legs .*; did you mean 'Knee'"),
        (Reflex(1.0, "angle", "Hip"), "SOL", "SOL.own.of", "a ball joint has no angle"),
        (Reflex(1.0, "lean", "HAM"), "SOL", "SOL.own.of", "leave `of` out"),
        (Reflex(1.0, "force", lead=0.1), "SOL", "SOL.own.lead", "'force' has no rate"),
        (Reflex(1.0, "load", moving="rising"), "SOL", "SOL.own.moving", "'load' has no rate"),
        (Reflex(float("nan")), "SOL", "SOL.own.gain", "not a finite number"),
    ],
)
def test_a_reflex_that_senses_nothing_is_refused_by_its_key(reflex: Reflex, muscle: str, key: str, message: str):
    with pytest.raises(SceneError, match=message) as caught:
        Rollout(with_reflex(reflex, muscle), 1, "cpu")
    assert caught.value.key == f"controller.reflexes.muscles.{key}"


def test_a_muscle_that_is_not_simulated_cannot_be_sensed():
    scene = with_reflex(Reflex(1.0, "force", "HFL"))
    scene.actuation |= {hip: Actuation("torque") for hip in ("lHip", "rHip")}
    with pytest.raises(SceneError, match="lHFL acts on no joint that muscles drive") as caught:
        Rollout(scene, 1, "cpu")
    assert caught.value.key == "controller.reflexes.muscles.SOL.own.of"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("trunk = 'belly'", "no body is called 'belly'"),
        ("least = 1.5", "must be within 0 and 1, is 1.5"),
        ("stance_load = -1", "must not be negative"),
        ("muscles.SOL = {}", "at least one"),
        ("muscles.SOL.own = { gain = 1, signal = 'pain' }", "'pain'"),
        ("muscles.SOL.own = { signal = 'force' }", "missing key 'gain'"),
    ],
)
def test_faults_in_a_file_are_named_with_their_line(line: str, message: str, tmp_path: Path):
    file = tmp_path / "mine.toml"
    file.write_text(
        f'name = "mine"\nbase = "wang2012.toml"\n\n[controller.reflexes]\nmuscles.GAS.a = {{ gain = 1 }}\n{line}\n'
    )
    with pytest.raises(SceneError, match=message) as caught:
        load(file)
    assert (caught.value.file, caught.value.line) == (file, 6)
    assert re.match(r"controller\.reflexes\.", caught.value.key)


def test_reflexes_are_read_as_they_were_written():
    scene = with_reflex(
        Reflex(Free(0.5, 0.0, 1.0), "angle", "Ankle", 0.1, 0.02, "negative", "falling", "trailing", "load")
    )
    assert toml.loads(toml.dumps(scene)) == scene
    assert "controller.reflexes.muscles.SOL.own.gain" in [p.name for p in free_parameters(scene)]


@pytest.mark.parametrize(("name", "reflexes"), [("reflex_walk", True), ("wang2012", False), ("fwalk", False)])
def test_reflexes_are_compiled_and_kept_only_where_there_are_some(name: str, reflexes: bool):
    scene = load(name)
    found = driven(scene, topology(scene.character))
    assert has_reflexes(scene, found.muscles) is reflexes
    assert (compiled_controller(scene, found.muscles).sense is not None) is reflexes
    state = Rollout(scene, 3, "cpu").state
    assert len(state.muscles.reflex) == len(state.muscles.landed) == (3 if reflexes else 0)


@pytest.mark.long
def test_an_instance_that_starts_again_repeats_its_walk():
    rollout = Rollout(load("reflex_walk"), 2, "cpu", threads=1)
    rollout.run(0.8)
    first = rollout.state.coordinates.numpy().copy()
    felt = rollout.state.muscles.stands.numpy().copy()
    rollout.reset(mask=np.array([False, True]))
    rollout.run(0.8)
    np.testing.assert_array_equal(rollout.state.coordinates.numpy()[1], first[1])
    np.testing.assert_array_equal(rollout.state.muscles.stands.numpy()[1], felt[1])
    assert np.any(rollout.state.coordinates.numpy()[0] != first[0])


@pytest.mark.parametrize("name", ["reflex_planar", "reflex_walk"])
def test_reflexes_walk(name: str):
    scene = load(name, set={"objective.heading": 10.0})  # as the walk in space values it, so that both share a step
    rollout = Rollout(scene, 1, "cpu", record=[0], threads=1)
    rollout.run(5.0)
    assert rollout.status()[0] == Status.RUNNING
    speed = rollout.recording(start=2.0).com_velocity[:, 2].mean()
    assert 1.1 < speed < 1.5


@pytest.mark.usefixtures("unoptimized_test")
def test_spastic_muscles_add_what_they_feel_to_what_torques_ask_for():
    """Until muscles hear of it, the motion is that without: what is wanted of them differs by the reflex alone."""
    gain, threshold, delay = 0.8, 0.02, 0.03
    scene = load("walk56", set={"duration": 0.1, "character.muscles.*.delay": delay})
    stretch = Reflex(Free(0.0, 0.0, 2.0), "velocity", offset=threshold, part="positive", side="right")
    assert scene.controller is not None
    scene.controller.reflexes = Reflexes({"SOL": {"stretch": stretch}}, besides=True)
    rollout = Rollout(scene, 2, "cpu", record=[0, 1], record_rate=1.0 / scene.time_step)
    rollout.set_parameters({"controller.reflexes.muscles.SOL.stretch.gain": [0.0, gain]})
    rollout.run()
    without, spastic = (rollout.recording(instance) for instance in (0, 1))
    same = round(delay / scene.time_step)
    added = (spastic.muscle_desired_force - without.muscle_desired_force)[1:same]
    right = list(without.muscle_names).index("rSOL")
    muscle = rollout.numeric.character.muscles["rSOL"]
    f_max, l_opt = (float(np.ravel(number)[0]) for number in (muscle.f_max, muscle.l_opt))
    felt = without.muscle_fibre_velocity[: same - 1, right] / l_opt  # in the step before
    wanted = f_max * np.clip(gain * np.maximum(felt - threshold, 0.0), 0.0, 1.0)
    assert added[:, right] == pytest.approx(wanted, abs=1e-3 * f_max)
    assert wanted.max() > 0.05 * f_max
    assert np.all(np.delete(added, right, axis=1) == 0.0)
    assert np.any(spastic.muscle_activation[same + 2 :, right] > without.muscle_activation[same + 2 :, right])

"""Gaits that cannot be imitated are refused with the key that asks for them."""

import msgspec
import pytest

from person_walk import SCENE, as_of_policy
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, toml
from warpmuscle.learning import EpisodeBatch, Imitation, Task
from warpmuscle.scene.learning import ImitatedRun


@pytest.mark.parametrize(
    ("imitation", "key", "message"),
    [
        (Imitation(norm="Winter"), "learning.imitation.norm", "no norm is called"),
        (Imitation(weights={"lElbo": 1.0}), "learning.imitation.weights.lElbo", "did you mean 'lElbow'"),
        (Imitation(weights={"lElbow": -1.0}), "learning.imitation.weights.lElbow", "must not be negative"),
        (Imitation(pelvis_tilt=60.0), "learning.imitation.pelvis_tilt", "must be within 45 degrees, is 60"),
        (Imitation(cycle_time=0.0), "learning.imitation.cycle_time", "greater than 0"),
        (Imitation(moving=True), "learning.imitation.moving", "name one in `norm`"),
        (Imitation(norm_alone=True), "learning.imitation.norm_alone", "a norm alone is a gait: name one"),
        (
            Imitation(norm="Fukuchi 2017", norm_alone=True),
            "learning.imitation.cycle_time",
            "how long a cycle of the run",
        ),
        (Imitation(clock_speed=0.0), "learning.imitation.clock_speed", "greater than 0"),
        (
            Imitation(norm="key points", run=ImitatedRun()),
            "learning.imitation.run.above",
            "the wanted speeds, 1.2 and",
        ),
        (Imitation(run=ImitatedRun(norm="key points")), "learning.imitation.run.norm", "no norm of a run is called"),
        (
            Imitation(norm="Fukuchi 2017", run=ImitatedRun()),
            "learning.imitation.run",
            "a run at all speeds by its norm",
        ),
        (Imitation(step_width=-0.1), "learning.imitation.step_width", "must not be negative"),
    ],
)
def test_impossible_gaits_are_refused(imitation: Imitation, key: str, message: str):
    with pytest.raises(SceneError, match=message) as caught:
        EpisodeBatch(SCENE, 1, "cpu", Task(imitation=imitation))
    assert caught.value.key == key


def test_a_body_without_a_controller_has_no_gait():
    with pytest.raises(SceneError, match="no gait to imitate") as caught:
        EpisodeBatch("throw18", 1, "cpu", Task(imitation=Imitation()))
    assert caught.value.key == "learning.imitation"


def test_a_gait_that_falls_at_once_cannot_be_imitated():
    walker = as_of_policy()
    falls = msgspec.structs.replace(walker, failure=msgspec.structs.replace(walker.failure, com_height=1.2))
    with pytest.raises(SceneError, match="no two whole cycles"):
        EpisodeBatch(falls, 1, "cpu", Task(imitation=Imitation()))


def test_an_imitated_file_needs_feet_and_no_controller():
    scene = load("gait2392")
    assert scene.simbicon is None
    character = msgspec.structs.replace(scene.character, feet=("talus_l", "talus_r"))
    alone = msgspec.structs.replace(scene, character=character, learning=Task(imitation=Imitation(file="walk.h5")))
    assert toml.loads(toml.dumps(alone)).learning == alone.learning
    with pytest.raises(SceneError, match=r"learning\.imitation: there is no gait to imitate: give a `file`"):
        toml.loads(toml.dumps(msgspec.structs.replace(alone, learning=Task(imitation=Imitation()))))
    with pytest.raises(SceneError, match=r"learning\.imitation\.replay: is used only with learning.imitation.file"):
        toml.loads(toml.dumps(msgspec.structs.replace(load(SCENE), learning=Task(imitation=Imitation(replay=1)))))

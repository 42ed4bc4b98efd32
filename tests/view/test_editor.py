"""Changes by hand: what a page may ask for, what is taken back and saved, and what the motion does then."""

import json
import math
import shlex
import tomllib
from typing import Any

import numpy as np
import pytest

from live_viewer import PATIENCE, answer, page_socket, place_of, running_viewer, still_serves, until
from warpmuscle.cli.common import with_settings
from warpmuscle.core.errors import SceneError
from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.formats.toml import loads
from warpmuscle.model.structure import structure_of
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import free_parameters, leaves, start_values, substitute
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.view.editor import MOST_POINTS, NAMED, Editor
from warpmuscle.view.live_run import LiveRun
from warpmuscle.view.messages import Edit, read_edit

KNEE = "controller.pd.lKnee.kp"
HIP = "controller.states.0.trajectories.SWING_Hip.components.1"


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def editor_of(name: str = "fwalk") -> tuple[Editor, Clock]:
    clock = Clock()
    return Editor(load(name), clock), clock


def number(editor: Editor, key: str, value: float | None) -> Edit:
    return Edit("number", [one.key for one in editor.numbers].index(key), value=value)


def curve(editor: Editor, key: str = HIP) -> int:
    return [one.key for one in editor.curves].index(key)


def plain(scene: Scene) -> Scene:
    return substitute(scene, start_values(scene))


def numbers_of(scene: Scene) -> dict[str, float]:
    return {key: leaf for key, leaf in leaves(plain(scene)) if isinstance(leaf, int | float)}


def used(editor: Editor, *edits: Edit) -> None:
    for edit in edits:
        assert editor.takes(edit)
        assert editor.use(edit) == ""
        editor.accept(editor.make())


def test_what_no_page_would_ask_for_is_not_taken():
    editor, _ = editor_of()
    hip, most = curve(editor), len(editor.numbers)
    for edit in (
        Edit("number", 0), Edit("number", 0, value=1e12), Edit("move", hip, 0, 0.1, 0.2), Edit("insert", hip, 6, 1, 0),
        Edit("remove", hip, 5), Edit("straighten", hip), Edit("undo"), Edit("redo"), Edit("back"), Edit("save"),
        Edit("settings"), Edit("points", hip),
    ):  # fmt: skip
        assert editor.takes(edit), edit
    for edit in (
        Edit("number", most, value=1.0), Edit("number", -1, value=1.0), Edit("number", 0, value=math.inf),
        Edit("number", 0, value=math.nan), Edit("number", 0, value=1e13), Edit("number", 0, 0, 1.0),
        Edit("number", 0, 0, 1.0, 1.0), Edit("move", hip, 0, 0.1), Edit("move", hip, 0),
        Edit("move", hip, 0, 0.1, math.nan), Edit("insert", len(editor.curves), 0, 0, 0),
        Edit("insert", hip, -1, 0.1, 0.2), Edit("insert", hip, 1 << 70, 0.1, 0.2),
        Edit("remove", hip, 0, 0.1), Edit("undo", 5), Edit("save", value=1.0), Edit("straighten", -1),
    ):  # fmt: skip
        assert not editor.takes(edit), edit
    for raw in (
        '{"edit": "number", "target": "0", "value": 1}', '{"edit": "open"}', '{"edit": "save", "file": "x"}',
        '{"edit": "number", "target": 0, "value": NaN}', '{"edit": "number", "target": 0, "value": 1e999}',
        '{"edit": "number", "target": 0, "value": [1, 2]}', '{"edit": "move", "at": [0, 1]}', "[" * 4000, b"\xff", "[]",
        '{"target": 0}', '{"edit": null}', "",
    ):  # fmt: skip
        assert read_edit(raw) is None, raw


def test_changes_are_taken_back_one_by_one_and_those_of_a_drag_together():
    editor, clock = editor_of()
    first = editor.values()
    used(editor, *(number(editor, KNEE, value) for value in (310.0, 320.0, 330.0)))
    clock.now = 5.0
    used(editor, number(editor, KNEE, 340.0), Edit("remove", curve(editor), 1))
    assert editor.values()["undo"] == 3
    assert editor.parameters()[KNEE] == 340.0
    assert f"{HIP}.angle.1" not in editor.parameters()
    used(editor, Edit("undo"))
    assert editor.values()["curves"] == {}
    used(editor, Edit("undo"))
    assert editor.parameters()[KNEE] == 330.0
    used(editor, Edit("redo"))
    assert editor.parameters()[KNEE] == 340.0
    used(editor, Edit("undo"), Edit("undo"), Edit("undo"))  # the last of which finds nothing
    assert editor.values() == {**first, "redo": 3}
    used(editor, number(editor, KNEE, 350.0))
    assert (editor.values()["undo"], editor.values()["redo"]) == (1, 0)
    used(editor, number(editor, KNEE, None))
    assert (editor.values()["numbers"], editor.values()["moved"]) == ({}, [])
    used(editor, Edit("move", curve(editor), 0, 0.05, 0.1), number(editor, KNEE, 400.0), Edit("back"))
    assert {**editor.values(), "undo": 0} == first
    assert editor.make() == load("fwalk")


def test_a_curve_is_told_with_what_its_points_follow_and_gets_its_own_points_back():
    editor, _ = editor_of("walk56")
    lean = curve(editor, "controller.states.0.trajectories.root.components.0")
    used(editor, Edit("move", lean, 0, 0.02, 0.15))
    assert editor.values()["curves"][lean]["along"] == [0.15, 0.15, 0.15]
    used(editor, Edit("insert", lean, 1, 0.3, 0.0))
    assert editor.values()["curves"][lean]["along"] == [0.15, 0.0, 0.15, 0.15]
    used(editor, Edit("straighten", lean))
    assert (editor.values()["curves"], editor.values()["bent"]) == ({}, [])
    for k in range(MOST_POINTS - 3):
        used(editor, Edit("insert", lean, 1, 0.5 - 0.001 * k, 0.0))
    assert "points at most" in editor.use(Edit("insert", lean, 1, 0.1, 0.0))
    assert editor.use(Edit("remove", lean, MOST_POINTS)) == ""  # of another page, which is late


def test_refused_changes_leave_everything_as_it_was():
    run = LiveRun(load("fwalk"))
    editor, _ = editor_of()
    used(editor, number(editor, KNEE, 310.0))
    run.use(editor.make())
    before, numeric, scene = editor.values(), run.numeric, run.scene
    hip = curve(editor)
    refused = [
        number(editor, "controller.states.0.time", -1.0),
        number(editor, KNEE, -5.0),
        Edit("move", hip, 0, 0.9, 0.0),
    ]
    for edit in refused:
        assert editor.takes(edit)
        editor.use(edit)
        with pytest.raises(SceneError) as why:
            run.use(editor.make())
        assert "\n" not in str(why.value)
        editor.refuse()
        assert editor.values() == before
        assert run.scene is scene
        assert run.numeric is numeric


def test_motion_goes_on_with_changes_and_what_is_saved_moves_alike_to_the_bit():
    run = LiveRun(load("walk56"))
    editor = Editor(run.given)
    compiled = structure_of(run.scene)
    run.step()
    begun = run.time
    hip, strength = curve(editor), f"character.muscles.{next(iter(run.scene.character.muscles))}.f_max"
    for edit in (
        Edit("insert", hip, 2, 0.4, -0.3), Edit("remove", hip, 0), Edit("move", hip, 1, 0.5, -0.1),
        number(editor, KNEE, 250.0), number(editor, strength, 5000.0),
    ):  # fmt: skip
        editor.use(edit)
        parts = ("controller",) if editor.only_controller() else None
        scene = editor.make()
        run.use(scene, parts)
        editor.accept(scene)
    assert run.time == begun  # it goes on from where it was
    assert structure_of(run.scene) == compiled  # so that nothing has to be compiled
    assert [p.name for p in run.parameters] == [p.name for p in free_parameters(run.scene)]
    run.restart()
    for _ in range(20):
        run.step()
    name, text = editor.file()
    saved = loads(text)
    assert name == "walk56_edited.toml"
    assert saved.duration == load("walk56").duration
    assert KNEE in saved.description
    assert len(saved.description) < 1000
    rollout = Rollout(saved, 1, "cpu", record=[0], record_rate=50.0)
    rollout.run(run.time)
    assert np.array_equal(run.window(9.0).com, rollout.recording().com)


@pytest.mark.parametrize("name", ["fwalk", "walk56_person"])
def test_the_copied_settings_make_the_same_scene(name):
    editor, _ = editor_of(name)
    assert editor.settings() == f"warpmuscle simulate {name}"
    hip = curve(editor)
    used(editor, Edit("insert", hip, 2, 0.4, -0.3), Edit("remove", hip, 0), Edit("move", hip, 1, 0.5, -0.1),
         number(editor, KNEE, 250.0), number(editor, "controller.states.0.time", 0.4321))  # fmt: skip
    command, *options = shlex.split(editor.settings().replace("\\\n", " "))[2:]
    assert command == name
    assert options[::2] == ["--set"] * 4
    scene = with_settings(load(name), options[1::2])
    assert numbers_of(scene) == pytest.approx(numbers_of(editor.scene), abs=1e-8)
    at, along = tomllib.loads(editor.points(hip)).values()
    component = plain(editor.scene).controller.states[0].trajectories["SWING_Hip"].components[1]
    assert at == pytest.approx(list(component.phase), abs=1e-8)
    assert along == pytest.approx(list(component.angle), abs=1e-8)


def test_what_is_copied_of_hostile_names_is_quoted_for_a_shell():
    scene = load("fwalk")
    scene.name = "a'; rm -rf ~ #"
    editor = Editor(scene)
    used(editor, number(editor, KNEE, 250.0))
    assert shlex.split(editor.settings().replace("\\\n", " "))[2:] == [scene.name, "--set", f"{KNEE}=250.0"]


def test_an_arm_that_nothing_excites_is_excited_by_a_curve_drawn_by_hand():
    run = LiveRun(load("throw"))  # whose trunk moves as recorded for 1.5 s, and no longer
    editor = Editor(run.given)
    drawn, structure = curve(editor, "character.muscles.m1.excitation"), structure_of(run.scene)
    assert editor.values()["curves"] == {}
    for edit in (Edit("insert", drawn, 0, 0.1, 0.1), Edit("insert", drawn, 1, 0.3, 0.9)):
        editor.use(edit)
    run.use(editor.make())
    editor.accept(editor.make())
    assert editor.values()["curves"] == {drawn: {"at": [0.1, 0.3], "along": [0.1, 0.9]}}
    assert structure_of(run.scene) == structure
    run.restart()
    for _ in range(20):
        run.step()
    rollout = Rollout(loads(editor.file()[1]), 1, "cpu", record=[0], record_rate=50.0)
    rollout.run(run.time)
    seen = run.window(9.0)
    assert np.array_equal(seen.muscle_excitation, rollout.recording().muscle_excitation)
    asked = np.interp(seen.time, [0.1, 0.3], [0.1, 0.9])
    column = seen.muscle_names.index("m1")
    np.testing.assert_allclose(seen.muscle_excitation[1:, column], asked[1:], atol=0.005)  # a step behind
    editor.use(Edit("straighten", drawn))
    assert editor.make() == load("throw")
    while run.status == Status.RUNNING:
        run.advance(0.1)
    assert run.time == pytest.approx(1.5, abs=0.15)


def test_description_of_a_saved_scene_names_few_changes():
    editor, _ = editor_of()
    used(editor, *(number(editor, one.key, 0.77) for one in editor.numbers if one.path[-1] == "torque_limit"))
    assert "and" in editor._description()
    assert editor._description().count("=") == NAMED


def heard(client: Any, wanted: str) -> Any:
    """The next message that has something."""
    while True:
        raw = client.recv(timeout=PATIENCE)
        if isinstance(raw, str) and wanted in (told := json.loads(raw)):
            return told[wanted]


def test_a_page_edits_the_running_body_over_its_socket_and_nobody_else_does():
    with running_viewer() as live:
        assert live.editor is not None
        knee, hip = number(live.editor, KNEE, 0.0).target, curve(live.editor)
        body = live.run.rollout.names.body_of_joint("rKnee")
        place = place_of(live)
        assert answer(place._replace(token=""), f"Host: 127.0.0.1:{place.port}").startswith("HTTP/1.1 403")
        with page_socket(place) as client:
            assert heard(client, "edits")["moved"] == []
            client.send(json.dumps({"edit": "number", "target": knee, "value": 700.0}))
            assert heard(client, "edits")["numbers"][str(knee)] == 700.0
            with live.lock:
                assert live.run.rollout.model.simbicon.gains.numpy()["kp"][0, body] == 700.0
            slider = live.parameters[KNEE]
            assert (slider.value, slider.max) == (700.0, 700.0)
            client.send(json.dumps({"edit": "move", "target": hip, "point": 0, "at": 0.9, "value": 0.0}))
            assert "phase" in heard(client, "refused")
            client.send(json.dumps({"edit": "save"}))
            assert loads(heard(client, "saved")["text"]).controller.pd["lKnee"].kp.value == 700.0
            client.send(json.dumps({"edit": "undo"}))
            until(lambda: slider.value == 300.0)
            for k in range(300):  # more than are read at once
                client.send(
                    json.dumps({"edit": "insert", "target": hip, "point": 1, "at": 0.2 - 1e-4 * k, "value": 9e9})
                )
            until(lambda: "points at most" in str(heard(client, "refused")))
            client.send(json.dumps({"edit": "back"}))
            until(lambda: live.editor.values()["bent"] == [])
        still_serves(live)

"""Wrong guesses of somebody new are answered in a line that says what to type."""

import copy
import pickle
import re

import pytest

import warpmuscle as wm
from warpmuscle.core.arguments import obtained_by

WRONG = [  # what is typed, and what is to be in the one line that answers
    ("wm.simulate(['fwalk', 'iwalk'])", "call it once for each"),
    ("wm.simulate(run)", "its scene is run.scene"),
    ("wm.load('fwalk').simulate()", "wm.simulate(scene) runs it"),
    ("wm.load('fwalk').show()", "wm.show(scene) shows it"),
    ("wm.load('fwalk').muscles", "scene.character.muscles"),
    ("wm.load('fwalk').duraton", "did you mean 'duration'?"),
    ("wm.load('run.h5')", "wm.read opens a result"),
    ("wm.read('fwalk')", "wm.simulate('fwalk') runs it"),
    ("wm.read('run.h5').cost", "best.cost is the lowest"),
    ("wm.list_scenes()", "wm.scenes() lists them"),
    ("wm.view('run.h5')", "wm.show shows a motion"),
    ("wm.gait(run)", "run.gait"),
    ("wm.show(3)", "motion must be a run, a result or its file"),
    ("wm.show(wm.Rollout('fwalk'))", "name instances in Rollout(..., record=[0])"),
    ("wm.Rollout('fwalk').recording()", "nothing was recorded: name it in Rollout(..., record=[0])"),
    ("wm.Rollout('fwalk').to_xarray()", "recording(i).to_xarray()"),
    ("wm.sweep('fwalk')", "a scene takes a grid"),
    ("wm.sweep('fwalk', grid={'seed': 3})", "grid: seed must have a list of values, not 3"),
    ("wm.convert('fwalk', 'a.docx')", "by wm.convert as .xml, too"),
    ("run.save('a.nc')", "to_xarray().to_netcdf(path)"),
    ("run.view()", "show() shows the motion"),
    ("run.angles", "run.plot('joints') draws them"),
    ("run.gait.speed", "speed_forward"),
    ("run.recording.plot()", "wm.plot(recording"),
    ("run['hip flexoin']", "did you mean 'Hip flexion'?"),
    ("run['joint_angel']", "did you mean 'joint_angle'?"),
    ("run['angle']", "no quantity is called 'angle'"),
    ("run[0:10]", "run.recording.window(begin, end), in s"),
    ("run.grf", "run['foot_force'] has them"),
    ("run.export('a.mot')", "save('run.mot')"),
    ("run.report()", "`warpmuscle report run.h5`"),
    ("run.fell", "run.status says how it ended"),
    ("wm.simulate('fwalk', push=20)", "simulate has no argument 'push'; `warpmuscle robustness SCENE"),
    ("wm.simulate('fwalk', gravity=1.6)", "set={'gravity': ...} changes the scene"),
    ("wm.simulate('fwalk', instances=9)", "wm.Rollout(scene, instances=100)"),
    ("wm.simulate('fwalk', duraton=9)", "did you mean 'duration'?"),
    ("wm.simulate('walk56', 1, excitations=0.3)", "excitations are by muscle, such as {'lGLU': 0.3}, not 0.3"),
    ("wm.simulate('walk56', 1, excitations={'rsol': 0.3})", "did you mean 'rSOL'?"),
    ("wm.optimize('fwalk', generations=9)", "candidates=1000"),
    ("wm.sweep('fwalk', {'seed': [1]})", "grid={'seed': [1, 2]}"),
    ("wm.sweep('fwalk', grid={}, duration=1)", "sweep has no argument 'duration'; set={'duration': 5}"),
    ("wm.Rollout('fwalk', n=9)", "Rollout has no argument 'n'; instances=100"),
    ("wm.static_optimization('arm18', 'ik.mot')", "ik.mot: there is no such file"),
    ("wm.ik('a.osim', 'a.trc')", "wm.inverse_kinematics(model, 'walk.trc')"),
    ("wm.Model('a.osim')", "wm.load reads a model"),
    ("wm.scene('fwalk')", "wm.load('walk56') reads a scene"),
    ("wm.compare(run, run)", "wm.show([a, b])"),
    ("wm.load('fwalk').copy()", "copy.deepcopy(scene) is one"),
    ("run.plot('com')", "name one of 'centre of mass x'"),
    ("run.plot('hip flexoin')", "did you mean 'Hip flexion'?"),
    ("run.plot(['hip flexion', 3])", "kind must be a list of texts; 3 is none"),
    ("run.t", "run.time has the times"),
    ("run.df", "to_dataframe()"),
    ("run.sel(time=0.1)", "to_xarray() has it"),
    ("run.fps", "record_rate=200"),
    ("run.columns", "run.keys() names the quantities"),
    ("run['grf x']", "no quantity is called 'grf x'"),
    ("run.plot('hip flexion', save='a.png')", "path='hip.png' writes the figure"),
    ("run.plot('hip flexion', ax=None)", "plot returns a figure of matplotlib"),
    ("run.plot('hip flexion', side='left')", "run['hip flexion'].sel(side='left')"),
    ("run.plot(y='hip flexion')", "the first argument names the curve"),
    ("run.show(speed=0.5)", "the page has buttons for it"),
    ("run.recording[0:10]", "recording.window(begin, end), in s"),
    ("run.recording['hip flexion']", "a run has curves: run['hip flexion']"),
    ("[frame for frame in run.recording]", "recording['joint_angle']"),
    ("run.recording.units", "to_xarray() has the units"),
    ("run.recording.dt", "time has the times of all frames"),
    ("wm.simulate('fwalk', T=1)", "duration is in s"),
    ("wm.simulate('fwalk', verbose=True)", "a line says what takes long"),
    ("wm.optimize('fwalk', budget=9)", "candidates=1000"),
    ("wm.optimize('fwalk', callback=print)", "progress=print"),
    ("wm.learn('walk56', total_timesteps=9)", "iterations=100"),
    ("wm.learn('walk56', num_envs=9)", "options={'instances': 1024}"),
    ("wm.make('walk56')", "gymnasium.make('warpmuscle/walk56-v0')"),
    ("wm.set_device('cuda')", "device='cuda:0'"),
    ("wm.read_osim('a.osim')", "wm.load reads it"),
    ("wm.load('fwalk').n_muscles", "len(scene.character.muscles)"),
    ("wm.load('fwalk').replace(duration=3)", "wm.load(scene, set={'duration': 3})"),
    ("wm.Rollout('fwalk').num_envs", "instances are as many"),
    ("wm.Rollout('fwalk').qpos", "state.coordinates.numpy()"),
    ("pickle.dumps(wm.Rollout('fwalk'))", "neither copied nor pickled"),
    ("copy.deepcopy(wm.Rollout('fwalk'))", "neither copied nor pickled"),
    ("run[['hip flexion', 'knee flexion']]", "run.plot(['hip flexion', 'knee flexion']) draws several"),
    ("run.loc[0.1]", "to_xarray().sel(time=0.5, method='nearest')"),
    ("run.shape", "to_xarray() has it"),
    ("run.items()", "dict(run) has all that are recorded"),
    ("run.ctrl", "run.recording.muscle_excitation"),
    ("run.qvel", "run.recording.speed"),
    ("run.moments", "run.plot('moments') draws them"),
    ("run.to_sto('a.sto')", "save('run.mot') writes one"),
    ("run.plot('hip flexion', xlim=(0, 1))", "plot returns a figure of matplotlib"),
    ("run.plot('hip flexion').show()", "figure.savefig('figure.png') writes it"),
    ("run.recording.shape", "frames are as many"),
    ("wm.simulate('fwalk', n_envs=9)", "wm.Rollout(scene, instances=100)"),
    ("wm.simulate('fwalk', n_steps=9)", "duration is in s"),
    ("wm.simulate('fwalk', final_time=9)", "duration is in s"),
    ("wm.simulate('fwalk', render=True)", "run.show() shows it"),
    ("wm.MjModel.from_xml_path('a.xml')", "wm.load reads a model"),
    ("wm.PPO('fwalk')", "wm.learn trains a policy"),
    ("wm.cma('fwalk')", "search='cma'"),
    ("wm.cuda.is_available()", "wm.Rollout(scene).device says"),
    ("wm.viewer(run)", "wm.show shows a motion"),
    ("wm.examples()", "wm.scenes() lists what comes"),
    ("wm.scenes().head()", "to_dataframe() has it"),
    ("wm.scenes().fwalk", "wm.load('fwalk') reads it"),
    ("wm.load('fwalk').to_xml()", "wm.convert(scene, 'scene.xml')"),
    ("wm.load('fwalk').nbody", "len(scene.character.bodies)"),
    ("wm.load('a.urdf')", "a.urdf: there is no such file"),
    ("wm.load('a.mot')", "wm.inverse_dynamics(model, 'walk.mot') takes a motion"),
    ("wm.load('a.trc')", "wm.inverse_kinematics(model, 'walk.trc') takes markers"),
    ("wm.load('gone.h5')", "wm.read opens a result"),
    ("wm.read('run.h5')['hip flexoin']", "did you mean 'Hip flexion'?"),
    ("wm.read('run.h5')['nothing']", "no quantity is called 'nothing'; there are curves: Hip flexion"),
    ("wm.read('run.h5')[0]", "such as result['hip flexion']"),
    ("wm.read('run.h5').simulate()", "wm.best_scene(result)[0]"),
    ("wm.show(run, title='a')", "the page is called as its scene is"),
    ("wm.show('fwalk', live=True)", "`warpmuscle view SCENE --live` runs one"),
    ("wm.Rollout('fwalk').to('cuda')", "device='cuda:0'"),
    ("wm.Rollout('fwalk').obs", "gymnasium.make('warpmuscle/walk56-v0')"),
    ("wm.load('walk56', gravity=1.6)", "load has no argument 'gravity'; set={'objective.target_speed': 1.25, ...}"),
    ("wm.load('walk56', {'duration': 2})", "other numbers go by name: load('walk56', set={'duration': 2.0})"),
    ("wm.load('walk57')", "did you mean 'walk56'? `warpmuscle scenes` or wm.scenes() lists all"),
    ("wm.load('walk56')['duraton']", "there is no 'duraton' in this scene; a scene has no 'duraton'; did you mean"),
    ("wm.load('walk56')['character.muscles.SOL']", "no muscle is called 'SOL'; did you mean 'lSOL' or 'rSOL'?"),
    ("wm.load('walk56').character.muscles['rSOL'].max_isometric_force", "f_max is the greatest force, N"),
    ("wm.load('walk56').character.muscles['rSOL'].name", "parts have no names of their own"),
    ("wm.load('walk56').character.mass", "sum(body.mass for body in character.bodies.values())"),
    (
        "wm.Rollout('fwalk').set_parameters(speed=1)",
        "Rollout.set_parameters has no argument 'speed'; set_parameters({name",
    ),
    ("wm.Rollout('fwalk').set_commands(speed=1)", "set_commands({'speed': 1.2})"),
    ("wm.Rollout('fwalk').run(steps=10)", "step(10) makes ten steps"),
    ("wm.Rollout('fwalk')[0]", "instance 0 was not recorded: name it in Rollout(..., record=[0])"),
    ("wm.Rollout('fwalk', 2, record=[0])[0:1]", "list(rollout)[0:2] are several"),
    ("wm.Rollout('fwalk', 2, record='all')", "record=range(2) are all"),
    ("wm.Rollout('fwalk', seed=3)", "nothing in a rollout is random"),
    ("wm.Rollout('fwalk').body_names", "names.bodies has their names"),
    ("wm.Rollout('fwalk').fell", "status_names() says how each ended"),
    ("wm.simulate('fwalk', 1, device='cuda:7')", "there is no device 'cuda:7' here; known: cpu"),
    ("wm.simulate((wm.load('fwalk'), ''))", "the scene is the first of these: best_scene(result)[0]"),
    ("wm.plot('walk56')", "a scene is simulated before it is drawn: wm.simulate('walk56').plot()"),
    ("wm.plot(wm.load('fwalk'))", "wm.simulate(scene).plot()"),
    ("wm.plot(3)", "source must be a run, a result or its file, a recording, a rollout, or a table over time, not 3"),
    ("wm.plot(wm.Rollout('fwalk'))", "name instances in Rollout(..., record=[0])"),
    ("wm.plot(run, ax=None)", "plot returns a figure of matplotlib"),
    ("run.plot('hip flexion', 'knee flexion')", "a list draws several: ['hip flexion', 'knee flexion']"),
    ("run.plot('right hip flexion')", "'hip flexion' shows both sides, run['right hip flexion'] is one"),
    ("run.hip_flexion", "run['hip flexion'] is a curve by its name"),
    ("run.show('page.html')", "run.save('page.html') writes the page"),
    ("run.show(path='page.html')", "run.save('page.html') writes it"),
    ("run.save('a.mp4', fps=30)", "`warpmuscle video run.h5 -o run.mp4` has such options"),
    ("run.show().show()", "open() shows it in the browser"),
    ("wm.show(run, run)", "several motions are given as a list: show([a, b])"),
    ("wm.show(run, 'page.html')", "show(result).save('page.html')"),
    ("run.gait.stride_length", "a stride is two steps"),
    ("run.gait.cost_of_transport", "`warpmuscle gait run.h5`"),
    ("wm.optimize('fwalk', save='a.h5')", "output='found.h5' writes it"),
    ("wm.optimize('fwalk', parameters=['gravity'])", "frees a number"),
    ("wm.scenes(muscles=56)", "wm.scenes('56') are those with this word"),
    ("wm.walk56", "wm.simulate('walk56') runs this scene"),
]


@pytest.fixture(scope="module")
def walked():
    return wm.simulate("fwalk", duration=0.2)


@pytest.mark.parametrize(("typed", "answer"), WRONG)
def test_a_wrong_guess_is_answered_in_a_line_that_says_what_to_type(walked, typed, answer, tmp_path, monkeypatch):
    for package in ("matplotlib", "xarray"):
        pytest.importorskip(package)
    monkeypatch.chdir(tmp_path)
    walked.save("run.h5")
    with pytest.raises((wm.Error, AttributeError, TypeError)) as told:
        eval(typed, {"wm": wm, "run": walked, "pickle": pickle, "copy": copy})
    assert answer in str(told.value)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("name", "instead"),
    [
        ("Scene", "wm.load('walk56') reads one"),
        ("Recording", "wm.simulate(scene).recording is one"),
        ("Result", 'wm.read("walk.h5") reads one'),
        ("Motions", 'wm.read_motions("walk.h5") reads them'),
        ("Sweep", 'wm.read("sweep.h5") reads one'),
        ("Run", 'wm.simulate("walk56") makes one'),
    ],
)
def test_a_class_that_is_called_with_a_name_or_a_file_says_what_to_type(name: str, instead: str):
    for given in ([], ["walk56"]):
        with pytest.raises(
            TypeError, match=re.escape(f"wm.{name} takes the parts of one, not a name or a file: ")
        ) as told:
            getattr(wm, name)(*given)
        assert instead in str(told.value)
        assert len(str(told.value)) < 220


def test_errors_from_within_a_class_are_its_own():
    @obtained_by("wm.other() makes one")
    class Kind:
        def __init__(self, number: int) -> None:
            self.half = number / 2

    assert Kind(3).half == 1.5
    with pytest.raises(TypeError, match="unsupported operand"):
        Kind("three")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"wm.Kind takes .*: wm.other\(\) makes one \(missing 1 required"):
        Kind()  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("name", "instead"),
    [
        ("Muscle", "from warpmuscle.scene import Muscle"),
        ("Free", "from warpmuscle.scene.number import Free"),
        ("Declaration", "from warpmuscle.kernels.objective.declaration import Declaration"),
        ("Task", "from warpmuscle.learning import Task, Rewards"),
    ],
)
def test_parts_of_a_scene_are_named_with_where_they_are(name: str, instead: str):
    with pytest.raises(AttributeError, match=re.escape(instead)):
        getattr(wm, name)
    exec(instead, {})

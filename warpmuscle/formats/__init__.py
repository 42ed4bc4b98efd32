"""Files into scenes and scenes into files.

May import: core, kernels, scene, results, model, synergy.
To add: a format in a module of its own, its suffix in `load` or `save`.
"""

from warpmuscle.formats.lines import Ignored
from warpmuscle.formats.load import SceneLike, load, scene_names, scene_of
from warpmuscle.formats.save import save
from warpmuscle.scene.drawing import table  # noqa: F401  scenes then show themselves in notebooks

__all__ = ["Ignored", "SceneLike", "load", "save", "scene_names", "scene_of"]

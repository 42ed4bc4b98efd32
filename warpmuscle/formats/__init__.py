"""Files into scenes and scenes into files."""

from warpmuscle.formats.lines import Ignored
from warpmuscle.formats.load import SceneLike, load, scene_names, scene_of
from warpmuscle.formats.save import save

__all__ = ["Ignored", "SceneLike", "load", "save", "scene_names", "scene_of"]

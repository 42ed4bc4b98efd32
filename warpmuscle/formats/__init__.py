"""Files into scenes and scenes into files."""

from warpmuscle.formats.lines import Ignored
from warpmuscle.formats.load import load, scene_names
from warpmuscle.formats.save import save

__all__ = ["Ignored", "load", "save", "scene_names"]

"""Scenes show themselves in notebooks, also those that no file was read for."""

import subprocess
import sys

MADE_BY_HAND = """
import warpmuscle as wm
from warpmuscle.scene import Body, Character
scene = wm.Scene("a <ball>", Character("ball", {"ball": Body(1.0, (1.0, 1.0, 1.0))}), duration=2.0)
print(scene._repr_html_())
"""


def test_a_scene_made_by_hand_shows_itself_in_a_process_of_its_own():
    told = subprocess.run([sys.executable, "-c", MADE_BY_HAND], capture_output=True, text=True, check=True).stdout
    assert "a &lt;ball&gt;" in told
    assert "torques" in told
    assert "2 s" in told

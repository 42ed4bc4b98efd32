"""Environments of Gymnasium, for libraries that learn with it; needs the extra `gym`.

Importing this registers them; `gymnasium.make("warpmuscle.gym:warpmuscle/Biped-v0")` does so by itself.
Gymnasium loads no plugins of its own accord.

May import: video and all below.
To add: an environment as a module, and its name to `registration`.
"""

from warpmuscle.gym.registration import register

register()

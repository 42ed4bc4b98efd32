"""The commands that extract muscle synergies from electromyograms, and sort those of several people.

May import: cli and all below.
To add: a command in a module of its own, its name below.
"""

from __future__ import annotations

from warpmuscle.cli.groups import add, group, instead
from warpmuscle.cli.synergies.cluster import cluster
from warpmuscle.cli.synergies.extract import extract

synergies = group(
    "Extract muscle synergies from EMG, and sort those of several people.",
    lambda arguments: instead("synergies extract", arguments),
)
for command in (extract, cluster):
    add(synergies, command.__name__, command)

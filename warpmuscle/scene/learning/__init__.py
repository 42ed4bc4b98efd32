"""What a policy learns in a scene.

May import: core, scene, kernels.objective.
To add: what a task says to `task`, and its check to `scene.validation.learning`.
"""

from warpmuscle.scene.learning.task import Goal as Goal
from warpmuscle.scene.learning.task import ImitatedRun as ImitatedRun
from warpmuscle.scene.learning.task import Imitation as Imitation
from warpmuscle.scene.learning.task import Rewards as Rewards
from warpmuscle.scene.learning.task import Sense as Sense
from warpmuscle.scene.learning.task import Task as Task
from warpmuscle.scene.learning.task import Tightening as Tightening
from warpmuscle.scene.learning.task import Variation as Variation

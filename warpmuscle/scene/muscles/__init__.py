"""Muscles as a scene describes them: `muscle`, where they run and what they are; `curves`, shapes of their curves;
`cables`, what else pulls along a path.

May import: kernels, scene.
To add: a number of a muscle to `Muscle`, and to `MuscleModel` if all muscles may share it; checks beside those
of its range into `scene.validation.muscle_values`.
"""

from warpmuscle.scene.muscles.muscle import Actuation as Actuation
from warpmuscle.scene.muscles.muscle import Branch as Branch
from warpmuscle.scene.muscles.muscle import Condition as Condition
from warpmuscle.scene.muscles.muscle import Drive as Drive
from warpmuscle.scene.muscles.muscle import Excitation as Excitation
from warpmuscle.scene.muscles.muscle import Muscle as Muscle
from warpmuscle.scene.muscles.muscle import MuscleModel as MuscleModel
from warpmuscle.scene.muscles.muscle import PointMotion as PointMotion
from warpmuscle.scene.muscles.muscle import PolynomialPath as PolynomialPath
from warpmuscle.scene.muscles.muscle import Pulley as Pulley
from warpmuscle.scene.muscles.muscle import ViaPoint as ViaPoint
from warpmuscle.scene.muscles.muscle import Wrap as Wrap
from warpmuscle.scene.muscles.muscle import given as given
from warpmuscle.scene.muscles.muscle import is_cable as is_cable
from warpmuscle.scene.muscles.muscle import law_of as law_of

"""The names of environments, told to Gymnasium; what they are made of is imported when one is made."""

from __future__ import annotations

from warpmuscle.core.errors import Error
from warpmuscle.core.shipped import shipped_scenes

BIPED = "warpmuscle/Biped-v0"


def register() -> None:
    """Register all environments: of any scene, and of each shipped one by its name; raises Error without Gymnasium."""
    try:
        import gymnasium
    except ModuleNotFoundError as error:
        raise Error('environments need Gymnasium: pip install "warpmuscle[gym]"') from error
    if BIPED in gymnasium.registry:
        return
    shipped = {f"warpmuscle/{scene}-v0": {"scene": scene} for scene in shipped_scenes()}
    for name, options in {BIPED: {}, **shipped}.items():
        gymnasium.register(
            id=name,
            entry_point="warpmuscle.gym.biped:BipedEnv",
            vector_entry_point="warpmuscle.gym.biped:BipedVectorEnv",
            kwargs=options,
        )

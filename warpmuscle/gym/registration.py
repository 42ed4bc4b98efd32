"""The names of environments, told to Gymnasium; what they are made of is imported when one is made."""

from __future__ import annotations

from warpmuscle.core.errors import Error

BIPED = "warpmuscle/Biped-v0"


def register() -> None:
    """Register all environments; raises Error without Gymnasium."""
    try:
        import gymnasium
    except ModuleNotFoundError as error:
        raise Error('environments need Gymnasium: pip install "warpmuscle[gym]"') from error
    if BIPED not in gymnasium.registry:
        gymnasium.register(
            id=BIPED,
            entry_point="warpmuscle.gym.biped:BipedEnv",
            vector_entry_point="warpmuscle.gym.biped:BipedVectorEnv",
        )

"""How many synergies there are: factorisations of 1, 2, 3, ... synergies, and rules to choose one of them by."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SignalError
from warpmuscle.synergy.factorization import RESTARTS, Account, Synergies, factorize

AUTO, KNEE = "auto", "knee"
ENOUGH = 0.99  # VAF from which on more synergies are of no interest
SETTLED = 1e-4  # mean squared deviation of r2 from a line, see `knee`


@dataclass(frozen=True)
class Rule:
    """Which number of synergies to take."""

    count: int | None = None  # this many, or
    method: str = AUTO  # the fewest by `least_sufficient` (AUTO) or by `knee` (KNEE)
    vaf: float = 0.95  # of all muscles together, for AUTO
    muscle_vaf: float = 0.75  # of each muscle, for AUTO

    @classmethod
    def of(cls, text: str, vaf: float, muscle_vaf: float) -> Rule:
        """A rule from a number, `auto` or `knee`; raises SignalError for other text, and for a VAF outside 0..1."""
        for name, value in (("VAF", vaf), ("VAF of each muscle", muscle_vaf)):
            if not 0.0 <= value <= 1.0:
                raise SignalError(f"a {name} to reach must be from 0 to 1, not {value:g}")
        if text in (AUTO, KNEE):
            return cls(None, text, vaf, muscle_vaf)
        if not text.isdecimal() or int(text) < 1:
            raise SignalError(f"a number of synergies is at least 1, or {AUTO} or {KNEE}, not {text!r}")
        return cls(int(text), AUTO, vaf, muscle_vaf)


def extract(
    activations: Floats,
    rule: Rule,
    restarts: int = RESTARTS,
    seed: int = 0,
    progress: Callable[[int], None] = lambda count: None,
) -> tuple[Synergies, list[Account]]:
    """Synergies as many as a rule wants, and the account of each number up to where little is left to explain.

    Args:
        activations: (T, M), not negative.
        progress: called with each number of synergies before its factorisation.

    Raises:
        SignalError: more synergies than muscles or samples, or no number meets the rule.
        Error: scikit-learn is not installed.
    """
    samples, muscles = activations.shape
    if rule.count is not None and rule.count > min(samples, muscles):
        raise SignalError(f"{rule.count} synergies are more than the {muscles} channels with {samples} samples allow")
    found: list[Synergies] = []
    for count in _counts(samples, muscles, rule, found):
        progress(count)
        found.append(factorize(activations, count, restarts, seed))
    accounts = [synergies.account for synergies in found]
    if rule.count is not None:
        chosen = accounts[rule.count - 1]
    else:
        limit = _knee_limit(muscles)
        chosen = knee(accounts[:limit]) if rule.method == KNEE else least_sufficient(accounts, rule)
    return found[chosen.count - 1], accounts


def least_sufficient(accounts: Sequence[Account], rule: Rule) -> Account:
    """The fewest synergies that account for at least so much, of all muscles together and of each one.

    Raises:
        SignalError: none of them do.
    """
    for account in accounts:
        if _suffices(account, rule):
            return account
    last = accounts[-1]
    raise SignalError(
        f"{last.count} synergies account for {last.vaf:.3f} of all and {last.muscle_vaf.min():.3f} of the worst "
        f"channel, not for {rule.vaf:g} and {rule.muscle_vaf:g}; ask for less"
    )


def knee(accounts: Sequence[Account]) -> Account:
    """The fewest synergies from which on r2 grows in a straight line (Cheung et al. 2005, as in Santuz et al. 2017).

    r2 over N, from some N on, is fitted by a line; the first N with a mean squared deviation below 1e-4 is taken.

    Args:
        accounts: of 1, 2, 3, ... synergies; in that source up to three quarters of the channels.
    """
    r2 = np.array([account.r2 for account in accounts])
    for first in range(len(r2) - 2):
        counts = np.arange(len(r2) - first)
        line = np.polyval(np.polyfit(counts, r2[first:], 1), counts)
        if np.mean((line - r2[first:]) ** 2) < SETTLED:
            return accounts[first]
    return accounts[-1]


def _counts(samples: int, muscles: int, rule: Rule, found: Sequence[Synergies]) -> Iterator[int]:
    """Numbers of synergies to try, given what was found by those before."""
    needed = _knee_limit(muscles) if rule.method == KNEE else rule.count or 1
    for count in range(1, min(samples, muscles) + 1):
        if count > needed and found:
            last = found[-1].account
            if last.vaf >= ENOUGH and (rule.count is not None or rule.method == KNEE or _suffices(last, rule)):
                return
        yield count


def _suffices(account: Account, rule: Rule) -> bool:
    return account.vaf >= rule.vaf and float(account.muscle_vaf.min()) >= rule.muscle_vaf


def _knee_limit(muscles: int) -> int:
    return max(1, muscles - round(muscles / 4))

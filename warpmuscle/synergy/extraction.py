"""How many synergies there are: factorisations of 1, 2, 3, ... synergies, and rules to choose one of them by.

KNEE is the default: of 15 people who walked (Santuz et al.) it takes more than were published of none, AUTO of 7.

AUTO takes the fewest that account for enough, of all muscles together and of each. But how much is enough hangs on how
noisy a recording is, and one weak muscle can ask for many more. So it does not go farther than one beyond the knee of
the curve: from there on each further synergy adds as little as the next, and is mostly one muscle's own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SignalError
from warpmuscle.core.plain_text import number_of
from warpmuscle.synergy.cross_validation import cross_validate
from warpmuscle.synergy.factorization import RESTARTS, Account, Synergies, factorize

AUTO, KNEE, CROSS = "auto", "knee", "cross"
ENOUGH = 0.99  # VAF from which on more synergies are of no interest
SETTLED = 1e-4  # mean squared deviation of r2 from a line, see `knee`
KNEE_VAF = 0.8  # that the knee must account for; what accounts for less has no synergies that a knee could show


@dataclass(frozen=True)
class Rule:
    """Which number of synergies to take."""

    count: int | None = None  # this many, or
    method: str = KNEE  # by `sufficient` (AUTO), by `knee` (KNEE) or by `cross_validate` (CROSS)
    vaf: float = 0.95  # of all muscles together, for AUTO
    muscle_vaf: float = 0.75  # of each muscle, for AUTO

    @classmethod
    def of(cls, text: str, vaf: float, muscle_vaf: float) -> Rule:
        """A rule from a number, `auto`, `knee` or `cross`.

        Raises:
            SignalError: other text, or a VAF outside 0..1.
        """
        for name, value in (("VAF", vaf), ("VAF of each muscle", muscle_vaf)):
            if not 0.0 <= value <= 1.0:
                raise SignalError(f"a {name} to reach must be from 0 to 1, not {value:g}")
        if text in (AUTO, KNEE, CROSS):
            return cls(None, text, vaf, muscle_vaf)
        if not text.isdecimal() or int(text) < 1:
            raise SignalError(f"a number of synergies is at least 1, or {AUTO}, {KNEE} or {CROSS}, not {text!r}")
        return cls(int(text), KNEE, vaf, muscle_vaf)


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
        raise SignalError(
            f"{number_of(rule.count, 'synergy')} are more than the {number_of(muscles, 'channel')} with "
            f"{number_of(samples, 'sample')} allow"
        )
    if rule.count is None and rule.method == CROSS:
        rule = replace(rule, count=cross_validate(activations, largest(muscles), seed, progress).count)
    found: list[Synergies] = []
    for count in _counts(samples, muscles, rule, found):
        progress(count)
        found.append(factorize(activations, count, restarts, seed))
    accounts = [synergies.account for synergies in found]
    if rule.count is not None:
        chosen = accounts[rule.count - 1]
    else:
        chosen = knee(accounts[: largest(muscles)]) if rule.method == KNEE else sufficient(accounts, rule)
    return found[chosen.count - 1], accounts


def sufficient(accounts: Sequence[Account], rule: Rule) -> Account:
    """What `least_sufficient` takes, or the knee if that takes more than one synergy fewer.

    Raises:
        SignalError: neither is to be had.
    """
    bend = knee(accounts[: largest(len(accounts[0].muscle_vaf))])
    if bend.vaf >= KNEE_VAF and not any(_suffices(account, rule) for account in accounts[: bend.count + 1]):
        return bend
    return least_sufficient(accounts, rule)


def reason(accounts: Sequence[Account], rule: Rule, count: int, muscles: Sequence[str]) -> str:
    """Why AUTO took so many, in one line; empty if it met both of its bars."""
    taken = accounts[count - 1]
    if rule.count is not None or rule.method != AUTO or _suffices(taken, rule):
        return ""
    worst = int(taken.muscle_vaf.argmin())
    enough = next((account.count for account in accounts if _suffices(account, rule)), None)
    more = "more than were tried" if enough is None else f"{enough}"
    return (
        f"{count} is where further synergies begin to add as little as the next; {rule.vaf:g} of all and "
        f"{rule.muscle_vaf:g} of each channel take {more} (now {taken.vaf:.3f} of all, {muscles[worst]} "
        f"{taken.muscle_vaf[worst]:.3f})"
    )


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
        f"{number_of(last.count, 'synergy', 'account')} for {last.vaf:.3f} of all and {last.muscle_vaf.min():.3f} "
        "of the worst "
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
    needed = rule.count or largest(muscles)
    for count in range(1, min(samples, muscles) + 1):
        if count > needed and found:
            last = found[-1].account
            if last.vaf >= ENOUGH and (rule.count is not None or rule.method == KNEE or _suffices(last, rule)):
                return
        yield count


def _suffices(account: Account, rule: Rule) -> bool:
    return account.vaf >= rule.vaf and float(account.muscle_vaf.min()) >= rule.muscle_vaf


def largest(muscles: int) -> int:
    """The most synergies that it makes sense to look at, of so many muscles: three quarters (Santuz et al. 2017)."""
    return max(1, muscles - round(muscles / 4))

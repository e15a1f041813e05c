"""Places at which an effect explains a measurement as well as at its best one."""

from collections.abc import Collection, Sequence

from modallab.diagnosis.fitting.fit import Fit
from modallab.diagnosis.searching.search_path import kind_and_place
from modallab.diagnosis.searching.settings import ACCEPTANCE


def next_equivalent(fits: Sequence[Fit], kind: str, explored: Collection[tuple[str, str]]) -> Fit | None:
    """Return the best fit of a kind at an unexplored place that is equivalent to its best place; None: none.

    Parameters
    ----------
    fits
        Fits with the same effects but the last one.
    explored
        Kinds and places that are left out.
    """
    of_kind = [fit for fit in fits if fit.effects[-1].kind == kind]
    limit = min(fit.bic_between_kinds() for fit in of_kind) + ACCEPTANCE.equivalence_chi_square
    unexplored = [fit for fit in of_kind if kind_and_place(fit.effects[-1]) not in explored]
    equivalent = [fit for fit in unexplored if fit.bic_between_kinds() <= limit]
    return min(equivalent, key=Fit.bic_between_kinds, default=None)

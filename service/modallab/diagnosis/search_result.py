"""Result of a search for missing effects."""

from dataclasses import dataclass
from functools import cached_property

from modallab.core.dof import Dof
from modallab.diagnosis.fitting.fit import Fit, fit, with_optional_parameters
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.gap_tests import is_noise_only, unexplained_parts
from modallab.diagnosis.searching.search_path import SearchPath
from modallab.rig.effect import Effect


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Effects that a search found, and how it predicts."""

    predictor: Predictor
    """Predictor of the tests."""
    path: SearchPath
    """The accepted effects."""
    unmeasured: tuple[Dof, ...]
    """Held-out responses without a test."""

    @cached_property
    def unexplained_parts(self) -> set[str]:
        """Parts of the measurement whose gap is more than random error."""
        return unexplained_parts(self.predictor, self.path.fit, max_lag=None)

    def with_effects(self, effects: tuple[Effect, ...]) -> Fit:
        """Return a fit that starts from effects and the fit found; the same again for equal effects."""
        if effects not in self._fits:
            found = fit(self.predictor, effects, near=self.path.fit)
            self._fits[effects] = with_optional_parameters(self.predictor, found, self.path.fit)
        return self._fits[effects]

    def explains(self, effects: tuple[Effect, ...]) -> bool:
        """Return whether effects, fitted from there, leave random error alone."""
        return is_noise_only(self.predictor, self.with_effects(effects))

    @cached_property
    def _fits(self) -> dict[tuple[Effect, ...], Fit]:
        return {}

"""Number of predictions after which a search follows no further candidate."""

from modallab.diagnosis.predicting.settings import BUDGET


class PredictionBudget:
    """Counts predictions, so that a search for an effect outside the catalogue ends.

    Predictions and not seconds: the same request has the same answer on every machine.
    """

    def __init__(self, limit: float = BUDGET.predictions_per_test) -> None:
        self._limit, self.spent = limit, 0.0

    def spend(self, predictions: float = 1.0) -> None:
        """Count predictions, the predictions that take as long, or the share of the lines of one."""
        self.spent += predictions

    def scale_limit(self, ratio: float) -> None:
        """Multiply the limit by a ratio."""
        self._limit *= ratio

    @property
    def remaining(self) -> float:
        """Number of predictions that are left."""
        return max(0.0, self._limit - self.spent)

    @property
    def exhausted(self) -> bool:
        """Whether the search should try nothing new."""
        return self.spent >= self._limit


def no_heartbeat() -> None:
    """Do nothing: no caller waits for a sign of progress."""

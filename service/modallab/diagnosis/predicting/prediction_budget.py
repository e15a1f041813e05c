"""How much is predicted before a search follows no further lead."""

ENOUGH = 5_000  # predictions for one test: what a pair explains mostly takes half as many


class PredictionBudget:
    """Counts predictions, so that a search for what no catalogue holds comes to an end.

    Predictions and not seconds: the same question has the same answer on every machine.
    """

    def __init__(self, most: float = ENOUGH) -> None:
        self._most, self.spent = most, 0

    def spend(self, predictions: int = 1) -> None:
        """Count a prediction, or what takes as long as so many."""
        self.spent += predictions

    @property
    def exhausted(self) -> bool:
        """Whether nothing new is worth beginning."""
        return self.spent >= self._most

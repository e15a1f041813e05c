"""Coefficients moved until a model's responses are the measured ones."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.progress import Progress, part, silent
from modallab.updating.iteration import Ending, Iteration, check_sensitivity, resting
from modallab.updating.log_coefficients import changed, changes
from modallab.updating.one_stage_path import (
    DOUBLED,
    SHORTER,
    TRIES,
    Rule,
    believed,
    opened,
    unweighted,
    within_bounds,
)
from modallab.updating.responses.fields import ResponseModel
from modallab.updating.responses.rows import Rows, doubt, log_ratios, log_rows, mean_square, tolerant_rows
from modallab.updating.sparse_bayes import Equations, Posterior

# Times the share that a model must be wrong by to miss what it does, that it is taken to be wrong by, and
# steps so at most: the second path is the more careful one.
PATHS = ((1.0, 12), (3.0, 30))
RIGHT = 1e-5  # share of its stiffness that a model may be wrong by where log ratios take over
BEGINNING = 4_000  # real numbers that are looked at while the model is far off
WORSE, WELL = 1.5, 2.0  # times the mean square before that a step may leave, and what it may leave anyway
EXPLAINED = 4.0  # mean square beyond which a second path is tried
# Rows of a block, whose error is found with the coefficients: at first of few lines, as one near a resonance
# says nothing straight; at last of many, so that chance does not widen it.
FEW_ROWS, MANY_ROWS = 60, 300


@dataclass(frozen=True, eq=False)
class ResponsePath:
    """How the coefficients went, and what was believed of them at the end."""

    values: FloatArray  # (n_params,)
    history: tuple[Iteration, ...]
    ending: Ending
    why: str
    belief: Posterior  # of their changes, `relative.changes`
    linear: Equations  # at the values, by the coefficients, in units of their errors
    before: float  # mean square of log ratios over their random error
    after: float


def correct(
    model: ResponseModel, beginning: ResponseModel, rule: Rule, progress: Progress = silent
) -> ResponsePath:
    """Return the path from no change to where no coefficient moves by the tolerance.

    Log ratios have a valley for every way in which resonances of the model can meet measured ones. The
    path begins with a model that is taken to be wrong everywhere (`tolerant_rows`), by less and less, and
    ends with log ratios alone. Where these then miss the measurement a second path takes smaller steps,
    and the better one counts.

    Parameters
    ----------
    beginning
        The same model at fewer lines, for the first part of the path.

    Raises
    ------
    UnderdeterminedError
        If no response moves with any coefficient.
    """
    best: ResponsePath | None = None
    for i, (care, steps) in enumerate(PATHS):
        told = part(progress, i / len(PATHS), (i + 1) / len(PATHS))
        path = _Walk(model, rule, told).along(beginning, care, steps)
        best = path if best is None or path.after < best.after else best
        if best.after < EXPLAINED:
            break
    assert best is not None
    return best


class _Walk:
    """One path, step by step."""

    def __init__(self, model: ResponseModel, rule: Rule, progress: Progress) -> None:
        self._model, self._rule, self._progress = model, rule, progress
        self._may_move = model.parameterisation
        self._values = self._may_move.unchanged
        self._belief = opened(self._may_move, np.ones(1), rule.prior)
        self._history: list[Iteration] = []

    def along(self, beginning: ResponseModel, care: float, steps: int) -> ResponsePath:
        """Return the path whose first part has so many steps at most, each of `care`."""
        before = self._missed(self._values)
        for _ in range(steps):
            wrong = care * doubt(beginning, self._values)
            if wrong < RIGHT:
                break
            rows = tolerant_rows(beginning, self._values, wrong)
            to = self._wanted(rows, _blocks(rows, FEW_ROWS))
            self._moved(rows, self._shortened(to, 1.0))
        ending, why = self._finished()
        rows = log_rows(self._model, self._values)
        return ResponsePath(
            self._values,
            tuple(self._history),
            ending,
            why + resting(self._may_move, self._values),
            self._belief,
            _blocks(rows, MANY_ROWS),
            before,
            self._missed(self._values),
        )

    def _finished(self) -> tuple[Ending, str]:
        """Walk on by log ratios alone, no step to where they miss much more than before."""
        missed = self._missed(self._values)
        for _ in range(self._rule.max_iterations):
            rows = log_rows(self._model, self._values)
            wanted = self._wanted(rows, _blocks(rows, MANY_ROWS))
            share, now = 1.0, changes(self._may_move, self._values)
            for _ in range(TRIES):
                to = self._shortened(wanted, share)
                after = self._missed(to)
                if after < max(WORSE * missed, WELL):
                    break
                share *= SHORTER
            else:
                return Ending.DIVERGED, f"{Ending.DIVERGED}: the model moved away from the measurement"
            missed = after
            self._moved(rows, to)
            far = float(np.abs(wanted - now).max())
            if far < self._rule.tolerance and share == 1.0:
                return Ending.CONVERGED, str(Ending.CONVERGED)
        return Ending.STILL_MOVING, str(Ending.STILL_MOVING)

    def _wanted(self, rows: Rows, linear: Equations) -> FloatArray:
        check_sensitivity(rows.matrix)
        widths = self._belief.widths
        self._belief = believed(self._may_move, self._values, linear, self._rule.prior, widths)
        return within_bounds(self._may_move, self._belief)

    def _shortened(self, wanted: FloatArray, share: float) -> FloatArray:
        """Return the coefficients a share of the way to what is wanted, none doubled or halved."""
        now = changes(self._may_move, self._values)
        share = min(share, DOUBLED / max(float(np.abs(wanted - now).max()), DOUBLED))
        return changed(self._may_move, wanted if share == 1.0 else now + share * (wanted - now))

    def _moved(self, rows: Rows, to: FloatArray) -> None:
        solved = unweighted(rows.matrix, rows.missed, self._rule.jump)
        nothing = np.zeros(0)
        self._history.append(
            Iteration(
                "updating",
                self._may_move.macros,
                to - self._values,
                solved.rank,
                solved.singular_values,
                solved.condition_number,
                to,
                nothing,
                nothing,
            )
        )
        self._values = to
        largest = self._history[-1].max_change
        count = len(self._history)
        self._progress(1 - 0.9**count, f"iteration {count}: largest change {largest:.2g}")

    def _missed(self, values: FloatArray) -> float:
        target = self._model.target
        return float(mean_square(log_ratios(target, self._model.receptance(values)), target))


def _blocks(rows: Rows, numbers: int) -> Equations:
    block = rows.blocks(numbers)
    return Equations(rows.matrix, rows.missed, block, np.full(int(block.max()) + 1, 1.0))

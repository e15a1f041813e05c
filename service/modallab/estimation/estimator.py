"""Family of FRF estimators: averaged spectra to FRFs."""

from collections.abc import Callable

from modallab.core.arrays import ComplexArray
from modallab.core.registry import Family
from modallab.estimation.spectra import CrossSpectra

Estimator = Callable[[CrossSpectra], ComplexArray]  # (n_run, n_freq, n_out, n_in), response per N

ESTIMATORS: Family[Estimator] = Family("estimator", home="modallab.estimation.estimators")

MULTIPLE_INPUT_ESTIMATORS = ("h1",)  # estimators defined for several simultaneous forces

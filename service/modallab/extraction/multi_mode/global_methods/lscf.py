"""Least-squares complex frequency: one denominator for all FRFs."""

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.extraction.multi_mode.fraction_poles import poles_of_fractions
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS, Poles, RegisteredGlobalMethod


def lscf(freq: FloatArray, frf: ComplexArray, weight: FloatArray, orders: IntArray) -> Poles:
    """Poles of scalar fractions `H_oi = B_oi / A`; parameters and errors as `GlobalMethod`.

    FRFs of all inputs are treated as separate outputs. Only one of several coincident modes is found.

    References
    ----------
    Guillaume, P., Verboven, P. and Vanlanduit, S. (1998), Proc. 23rd International Seminar on Modal
    Analysis, Leuven, 1355-1362.
    """
    rows = (len(freq), -1, 1)
    return poles_of_fractions(freq, frf.reshape(rows), weight.reshape(rows), orders)


GLOBAL_METHODS.register("lscf")(RegisteredGlobalMethod(lscf))

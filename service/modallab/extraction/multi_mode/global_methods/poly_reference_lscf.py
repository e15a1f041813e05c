"""Poly-reference least-squares complex frequency: a right matrix fraction for several inputs."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.errors import InvalidInputError, bounds
from modallab.extraction.multi_mode.chart_settings import MATRIX_FRACTION
from modallab.extraction.multi_mode.fraction_poles import poles_of_fractions
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS, Poles, RegisteredGlobalMethod


def poly_reference_lscf(freq: FloatArray, frf: ComplexArray, weight: FloatArray, orders: IntArray) -> Poles:
    """Poles of matrix fractions `H = B A^-1`; parameters and errors as `GlobalMethod`.

    A polynomial of order n has n poles for each input, and as many modes may coincide as there are inputs.
    With one input the method is equal to `lscf`. Lines of an output are weighted by the mean variance over
    its inputs. The number of inputs is limited, because the fit of all participation factors needs memory.

    References
    ----------
    Peeters, B., Van der Auweraer, H., Guillaume, P. and Leuridan, J. (2004), Shock and Vibration 11,
    395-409.
    """
    if frf.shape[2] > MATRIX_FRACTION.largest_inputs:
        raise InvalidInputError(
            "poly_reference_lscf fits few references together; lscf "
            "and methods of single modes take any number",
            field="inputs",
            value=frf.shape[2],
            allowed=bounds(maximum=MATRIX_FRACTION.largest_inputs),
        )
    poles = poles_of_fractions(freq, frf, weight, orders)
    residue = poles.vector.reshape(-1, *frf.shape[1:])
    # of rank one, so that each row is the participation
    clearest = np.linalg.norm(residue, axis=2).argmax(axis=1)
    return replace(poles, participation=residue[np.arange(len(residue)), clearest])


GLOBAL_METHODS.register("poly_reference_lscf")(RegisteredGlobalMethod(poly_reference_lscf))

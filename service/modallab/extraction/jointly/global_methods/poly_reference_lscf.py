"""Poly-reference least-squares complex frequency: a right matrix fraction for several inputs."""

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.extraction.jointly.fraction_poles import poles_of_fractions
from modallab.extraction.jointly.global_method import GLOBAL_METHODS, Poles


@GLOBAL_METHODS.register("poly_reference_lscf")
def poly_reference_lscf(freq: FloatArray, frf: ComplexArray, weight: FloatArray, orders: IntArray) -> Poles:
    """Poles of matrix fractions `H = B A^-1`; parameters and errors as `GlobalMethod`.

    A polynomial of order n has n poles an input, and as many modes may coincide as there are inputs. With
    one input it is `lscf`. A line of an output counts by the mean variance over its inputs.

    References
    ----------
    Peeters, B., Van der Auweraer, H., Guillaume, P. and Leuridan, J. (2004), Shock and Vibration 11,
    395-409.
    """
    return poles_of_fractions(freq, frf, weight, orders)

"""H2: least squares on the force."""

from modallab.core.arrays import ComplexArray
from modallab.core.errors import InvalidInputError
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.spectra import CrossSpectra


@ESTIMATORS.register("h2")
def h2(spectra: CrossSpectra) -> ComplexArray:
    """Least squares on the force: high where the response is noisy, worst at antiresonances.

    Returns H2 = G_xx / G_xf, (n_run, n_freq, n_out, 1), response unit per N; one force at a time.
    1992 thesis, eq. [5.7].

    Raises
    ------
    InvalidInputError
        If several forces act at once.
    """
    if spectra.ff.shape[-1] != 1:
        raise InvalidInputError("H2 is defined for one force", field="estimator", value="h2", allowed="h1")
    fx = spectra.fx[:, :, 0, :]
    h: ComplexArray = spectra.xx / fx.conj()
    return h[..., None]

"""Arrays of every reply that carries some: names, shapes, units."""

from collections.abc import Mapping
from dataclasses import replace

from modallab.api.array_docs import arrays_of
from modallab.api.arrays import ArraySpec, array_replies
from modallab.api.diagnoses.unknown_arrays import UNKNOWN_ARRAYS
from modallab.core.frf import FrfSet
from modallab.core.modal_model import ModalModel
from modallab.correlation.compare import Correlation
from modallab.correlation.orthogonality import Orthogonality
from modallab.correlation.responses import ResponseCorrelation
from modallab.diagnosis.result_curves import DiagnosisCurves
from modallab.rig.estimates import Estimates
from modallab.rig.measurement import Measurement
from modallab.rig.time_records import TimeRecords
from modallab.updating.direct.result import DirectResult
from modallab.updating.identifiability import Identifiability
from modallab.updating.posterior import PosteriorSample


def optional(specs: Mapping[str, ArraySpec]) -> dict[str, ArraySpec]:
    """Return arrays that a reply may leave out together."""
    return {name: replace(spec, optional=True) for name, spec in specs.items()}


_DOFS = ArraySpec("degrees of freedom of the rows, `node:direction`", "n_dofs", "text")
_FRF = {
    **arrays_of(FrfSet, "freq", "values", "outputs", "inputs"),
    "kind": ArraySpec("`inertance`, `mobility` or `receptance`", "", "text"),
    "notes": ArraySpec("remarks on lines left out", "n_notes", "text", optional=True),
}

FRFS = array_replies("FrfArrays", "Frequency response functions", _FRF)
MEASUREMENT = array_replies(
    "MeasurementArrays",
    "FRFs, coherence and auto spectra of a measurement",
    _FRF
    | arrays_of(
        Measurement,
        "coherence",
        "averages",
        "force_spectrum",
        "response_spectrum",
        "input_condition",
        "force_cross_spectra",
    ),
)
RECORDS = array_replies(
    "TimeRecordArrays",
    "Time records of a measurement, before the window",
    {
        **arrays_of(TimeRecords, "force", "response"),
        "sample_rate": ArraySpec("Hz, sample rate", ""),
        "inputs": ArraySpec("force DoFs of every run", "n_runs, n_forces", "text"),
        "outputs": ArraySpec("response DoFs of every run", "n_runs, n_responses", "text"),
        "force_unit": ArraySpec("unit of `force`", "", "text"),
        "response_unit": ArraySpec("unit of `response`", "", "text"),
    },
)
ESTIMATES = array_replies(
    "EstimateArrays",
    "FRFs and coherence of a measurement after its first averages, up to all of them",
    {
        **arrays_of(Estimates, "n_averages", "values", "coherence"),
        **arrays_of(FrfSet, "freq", "outputs", "inputs"),
        "kind": _FRF["kind"],
    },
)
STRUCTURE_MODES = array_replies(
    "StructureModeArrays",
    "Elastic modes of a structure with their shapes",
    {
        "frequencies": ArraySpec("Hz, natural frequencies, ascending", "n_modes"),
        "shapes": ArraySpec(
            "1/sqrt(kg), mass-normalised mode shapes", "n_dofs, n_modes | n_dofs, n_modes, 2"
        ),
        "dofs": _DOFS,
    },
)
REDUCED = array_replies(
    "ReducedModelArrays",
    "Mass and stiffness reduced to master degrees of freedom",
    {
        "masters": ArraySpec("master degrees of freedom", "n_masters", "text"),
        "dofs": _DOFS,
        "transformation": ArraySpec(
            "1, motion of all degrees of freedom by the masters'", "n_dofs, n_masters"
        ),
        "mass": ArraySpec("kg, reduced mass matrix", "n_masters, n_masters"),
        "stiffness": ArraySpec("N/m, reduced stiffness matrix", "n_masters, n_masters"),
        "frequencies": ArraySpec("Hz, natural frequencies of the reduced model", "n_modes"),
        "shapes": ArraySpec("1/sqrt(kg), mode shapes of the reduced model", "n_masters, n_modes"),
        "model_frequencies": ArraySpec("Hz, natural frequencies of the full model", "n_full"),
        "frequency_errors": ArraySpec("1, relative frequency errors of the reduced model", "n_full"),
    },
)
MODAL_MODEL = array_replies(
    "ModalModelArrays",
    "Modes with their shapes, and modal constants of each FRF",
    {
        "frequencies": ArraySpec("Hz, natural frequencies, ascending", "n_modes"),
        "loss_factors": ArraySpec("1, loss factors", "n_modes"),
        "shapes": ArraySpec("mode shapes", "n_dofs, n_modes", "complex"),
        "dofs": _DOFS,
        **arrays_of(ModalModel, "resynthesis_error", modal_constants="modal_constant"),
    },
)
CORRELATION = array_replies(
    "CorrelationArrays",
    "Matrices of a correlation",
    {
        **arrays_of(Correlation, "mac", "frequency_differences", "comac", "ecomac", "pole_weighted_mac"),
        "pairs": ArraySpec("numbers of the measured and the model's mode, from 1", "n_pairs, 2", "integer"),
        "dofs": _DOFS,
        **optional(arrays_of(Orthogonality, cross_orthogonality="cross", auto_orthogonality="auto")),
        **optional(arrays_of(ResponseCorrelation, "outputs", "inputs", "frac", "fdac", fdac_freq="freq")),
    },
)
UPDATED_MATRICES = array_replies(
    "UpdatedMatrixArrays",
    "Matrices of a direct updating method, and error matrices by name",
    {
        "dofs": _DOFS,
        **arrays_of(DirectResult, "mass", "stiffness"),
    },
)
COVARIANCE = array_replies(
    "CovarianceArrays",
    "Covariance of updated coefficients",
    {
        "coefficients": ArraySpec("names of the coefficients", "n_coefficients", "text"),
        "singular_values": ArraySpec("1, singular values of the scaled sensitivity matrix", "n_values"),
        **arrays_of(Identifiability, "intervals", "covariance"),
    },
)
POSTERIOR = array_replies(
    "PosteriorArrays",
    "Draws from the posterior of updated coefficients",
    {
        "coefficients": ArraySpec("names of the coefficients", "n_coefficients", "text"),
        **arrays_of(PosteriorSample, "draws", "log_density"),
    },
)
STUDY = array_replies(
    "StudyArrays",
    "Coefficients of all runs of a study",
    {
        "coefficients": ArraySpec(
            "1, coefficients by run, null where a run failed", "n_runs, n_coefficients"
        ),
        "parts": ArraySpec("matrix part of each coefficient", "n_coefficients", "text"),
        "members": ArraySpec("member of each coefficient", "n_coefficients", "integer"),
        "true": ArraySpec("1, true coefficients", "n_coefficients"),
        "levels": ArraySpec("noise level of each run", "n_runs", "text"),
        "divisions": ArraySpec("parameterisation of each run", "n_runs", "text"),
        "seeds": ArraySpec("random seed of each run", "n_runs", "integer"),
    },
)
DIAGNOSIS = array_replies(
    "DiagnosisArrays",
    "Measured FRFs and those predicted before and after a diagnosis",
    arrays_of(
        DiagnosisCurves,
        *("freq", "measured", "before", "after", "random_error", "held_out"),
        *("outputs", "inputs", "predicted", "predicted_outputs"),
    )
    | UNKNOWN_ARRAYS,
)

"""Arrays of every reply that carries some: names, shapes, units."""

from modallab.api.arrays import ArraySpec, array_replies

_DOFS = ArraySpec("degrees of freedom of the rows, `node:direction`", "n_dofs", "text")
_FRF = {
    "freq": ArraySpec("Hz, frequency of each line", "n_lines"),
    "values": ArraySpec("m/s^2/N, m/s/N or m/N as `kind` says, FRFs", "n_lines, n_out, n_in", "complex"),
    "outputs": ArraySpec("response degrees of freedom", "n_out", "text"),
    "inputs": ArraySpec("force degrees of freedom", "n_in", "text"),
    "kind": ArraySpec("`inertance`, `mobility` or `receptance`", "", "text"),
    "notes": ArraySpec("remarks on lines left out", "n_notes", "text", optional=True),
}
_COVERED = "n_lines, n_out | n_lines, n_out, n_in"

FRFS = array_replies("FrfArrays", "Frequency response functions", _FRF)
MEASUREMENT = array_replies(
    "MeasurementArrays",
    "FRFs, coherence and auto spectra of a measurement",
    _FRF
    | {
        "coherence": ArraySpec(
            "1, ordinary coherence with one input, multiple with several at once", _COVERED, optional=True
        ),
        "averages": ArraySpec("1, effective number of averages", ""),
        "force_spectrum": ArraySpec(
            "N^2/Hz, one-sided auto spectrum of the force", "n_lines, n_out, n_in", optional=True
        ),
        "response_spectrum": ArraySpec(
            "unit^2/Hz, one-sided auto spectrum of the response", _COVERED, optional=True
        ),
        "input_condition": ArraySpec(
            "1, condition number of the input spectral matrix", "n_lines", optional=True
        ),
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
        "modal_constants": ArraySpec(
            "1/kg, modal constants of receptance", "n_modes, n_frfs", "complex", optional=True
        ),
        "resynthesis_error": ArraySpec(
            "1, rms of the residual over rms of the FRF, as mobility", "n_frfs", optional=True
        ),
    },
)
CORRELATION = array_replies(
    "CorrelationArrays",
    "Matrices of a correlation",
    {
        "mac": ArraySpec("1, modal assurance criterion", "n_measured, n_model"),
        "pairs": ArraySpec("numbers of the measured and the model's mode, from 1", "n_pairs, 2", "integer"),
        "frequency_differences": ArraySpec("Hz, measured less model", "n_pairs"),
        "comac": ArraySpec("1, coordinate modal assurance criterion", "n_dofs"),
        "dofs": _DOFS,
        "ecomac": ArraySpec("1, enhanced coordinate MAC", "n_dofs", optional=True),
        "pole_weighted_mac": ArraySpec("1, pole-weighted MAC", "n_measured, n_model", optional=True),
        "cross_orthogonality": ArraySpec(
            "1, cross orthogonality in the reduced mass", "n_measured, n_model", optional=True
        ),
        "auto_orthogonality": ArraySpec(
            "1, orthogonality of the measured modes in the reduced mass",
            "n_measured, n_measured",
            optional=True,
        ),
        "outputs": ArraySpec("response degrees of freedom", "n_out", "text", optional=True),
        "inputs": ArraySpec("force degrees of freedom", "n_in", "text", optional=True),
        "frac": ArraySpec("1, frequency response assurance criterion", "n_out, n_in", optional=True),
        "fdac_freq": ArraySpec("Hz, lines of the FDAC", "n_fdac", optional=True),
        "fdac": ArraySpec("1, frequency domain assurance criterion", "n_in, n_fdac, n_fdac", optional=True),
    },
)
UPDATED_MATRICES = array_replies(
    "UpdatedMatrixArrays",
    "Matrices of a direct updating method, and error matrices by name",
    {
        "dofs": _DOFS,
        "mass": ArraySpec("kg, updated mass matrix", "n_dofs, n_dofs", optional=True),
        "stiffness": ArraySpec("N/m, updated stiffness matrix", "n_dofs, n_dofs", optional=True),
    },
)
COVARIANCE = array_replies(
    "CovarianceArrays",
    "Covariance of updated coefficients",
    {
        "coefficients": ArraySpec("names of the coefficients", "n_coefficients", "text"),
        "intervals": ArraySpec("1, 95 % confidence intervals", "n_coefficients, 2"),
        "singular_values": ArraySpec("1, singular values of the scaled sensitivity matrix", "n_values"),
        "covariance": ArraySpec("1, covariance matrix", "n_coefficients, n_coefficients", optional=True),
    },
)
POSTERIOR = array_replies(
    "PosteriorArrays",
    "Draws from the posterior of updated coefficients",
    {
        "coefficients": ArraySpec("names of the coefficients", "n_coefficients", "text"),
        "draws": ArraySpec("1, coefficients of each draw", "n_draws, n_coefficients"),
        "log_density": ArraySpec("1, logarithm of the posterior density", "n_draws"),
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
_CURVES = "m/s^2/N, m/s/N or m/N, FRFs"
DIAGNOSIS = array_replies(
    "DiagnosisArrays",
    "Measured FRFs and those predicted before and after a diagnosis",
    {
        "freq": ArraySpec("Hz, frequency of each line", "n_lines"),
        "measured": ArraySpec(f"{_CURVES} measured", "n_lines, n_out, n_in", "complex"),
        "before": ArraySpec(f"{_CURVES} predicted by the given model", "n_lines, n_out, n_in", "complex"),
        "after": ArraySpec(f"{_CURVES} predicted with the named effects", "n_lines, n_out, n_in", "complex"),
        "random_error": ArraySpec("1, relative random error of |H|", "n_lines, n_out, n_in"),
        "held_out": ArraySpec("true for a response kept out of every fit", "n_out", "flag"),
        "outputs": ArraySpec("response degrees of freedom", "n_out", "text"),
        "inputs": ArraySpec("force degrees of freedom", "n_in", "text"),
        "predicted": ArraySpec(
            f"{_CURVES} predicted at responses that were not measured",
            "n_lines, n_pred, n_in",
            "complex",
            optional=True,
        ),
        "predicted_outputs": ArraySpec(
            "degrees of freedom that were not measured", "n_pred", "text", optional=True
        ),
    },
)

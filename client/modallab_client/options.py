"""Keywords of jobs, by kind of work; written by `client/generate_options.py`."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, TypedDict


class MeasurementOptions(TypedDict, total=False):
    """Options of a virtual test."""

    effects: Annotated[
        Sequence[Mapping[str, Any]],
        "effects beside those of the structure and the rig; no log book shows them",
    ]
    route: Annotated[
        str,
        "`expected`: without random error; `drawn`: spectra from their distribution; `sampled`: time "
        "records: expected, drawn, sampled",
    ]
    seed: Annotated[int, "seed of the random numbers"]
    records: Annotated[
        int,
        "number of time records of every run that are kept, at most as many as averages; of the route "
        "`sampled`, records",
    ]
    estimates: Annotated[
        int,
        "number of estimates of FRFs and coherence that are kept while averages are taken, the last "
        "after all; of the route `sampled`, estimates",
    ]


class ExtractionOptions(TypedDict, total=False):
    """Options of the extraction methods."""

    damping: Annotated[
        str | None,
        "law of a mode's damping: structural, viscous; of circle_fit, dobson, line_fit, linear_fit, "
        "lscf, peak_picking, poly_reference_lscf",
    ]
    lines: Annotated[
        int | None,
        "frequency lines around each resonance that a fit draws on; of circle_fit, dobson, line_fit, "
        "linear_fit, peak_picking",
    ]
    arc: Annotated[
        float | None,
        "angle of the circle, centred on resonance, whose lines are fitted; None: the whole circle, "
        "degree; of circle_fit",
    ]
    leave_out: Annotated[
        int | None,
        "number of these lines, nearest resonance, that are not used; of dobson, line_fit, linear_fit",
    ]
    max_order: Annotated[
        int | None, "highest model order of the stabilisation chart; of lscf, poly_reference_lscf"
    ]


class UpdateOptions(TypedDict, total=False):
    """Options of the updating methods."""

    min_mac: Annotated[
        float,
        "modal assurance criterion below which a measured and a model mode do not pair; of "
        "complex_inverse_eigensensitivity, complex_one_shot, inverse_eigensensitivity, one_shot, "
        "zhang_sensitivity, zhang_subspace",
    ]
    rank_jump: Annotated[
        float,
        "ratio of consecutive singular values that ends the rank; of complex_inverse_eigensensitivity, "
        "complex_one_shot, frf_residual, inverse_eigensensitivity, one_shot, zhang_sensitivity, "
        "zhang_subspace",
    ]
    max_iterations: Annotated[
        int,
        "largest number of steps of a stage; of complex_inverse_eigensensitivity, complex_one_shot, "
        "frf_residual, inverse_eigensensitivity, one_shot",
    ]
    tolerance: Annotated[
        float,
        "largest change of a coefficient that ends the last stage; of complex_inverse_eigensensitivity, "
        "complex_one_shot, frf_residual, inverse_eigensensitivity, one_shot",
    ]
    identified_within: Annotated[
        float,
        "relative standard error, by the data alone, above which a coefficient is not identified; of "
        "complex_inverse_eigensensitivity, complex_one_shot, frf_residual, inverse_eigensensitivity, "
        "one_shot",
    ]
    location_tolerance: Annotated[
        float,
        "largest change of a macro element's coefficient that ends the location stage; of "
        "complex_inverse_eigensensitivity, inverse_eigensensitivity",
    ]
    suspect_threshold: Annotated[
        float,
        "distance from 1 at which a macro element is suspected; of complex_inverse_eigensensitivity, "
        "inverse_eigensensitivity, zhang_sensitivity, zhang_subspace",
    ]
    max_step: Annotated[
        float,
        "largest change of a coefficient in one step of the updating stage; of "
        "complex_inverse_eigensensitivity, inverse_eigensensitivity",
    ]
    n_shapes: Annotated[
        int,
        "number of lowest measured modes whose shapes count; of the others only the eigenvalue; of "
        "complex_inverse_eigensensitivity, inverse_eigensensitivity",
    ]
    balance: Annotated[
        str,
        "rows divided by their size: those of eigenvalues alone, or both these and those of shapes: "
        "eigenvalues, both; of complex_inverse_eigensensitivity, inverse_eigensensitivity",
    ]
    damping_threshold: Annotated[
        float,
        "loss factor from which the damping of a macro element is suspected; of "
        "complex_inverse_eigensensitivity",
    ]
    prior: Annotated[
        str,
        "prior of the coefficients: sparse, few elements are wrong; common, many are a little wrong; "
        "range, only the bounds: sparse, common, range; of complex_one_shot, frf_residual, one_shot",
    ]
    underdetermined: Annotated[
        str,
        "treatment of fewer measured numbers than coefficients: refused, regularised; of "
        "complex_one_shot, frf_residual, one_shot",
    ]
    samples: Annotated[int, "number of draws from the posterior; 0: none; of complex_one_shot, one_shot"]
    seed: Annotated[int, "seed of these draws; of complex_one_shot, one_shot"]
    completion: Annotated[
        str | Mapping[str, Any],
        "measured shapes expanded to all DoFs of the model, or the model reduced to measured ones: "
        "expansion, dynamic, guyan, irs, serep; of baruch, berman_nagy, eigendynamic_constraint, "
        "error_matrix, modified_error_matrix",
    ]
    expansion: Annotated[
        str | Mapping[str, Any],
        "the reduction by which shapes are expanded: dynamic, guyan, irs, serep; of baruch, berman_nagy, "
        "eigendynamic_constraint, error_matrix, modified_error_matrix",
    ]
    n_modes: Annotated[
        int | None,
        "number of lowest measured modes that are used; all by default; of baruch, berman_nagy, "
        "eigendynamic_constraint, error_matrix, modified_error_matrix",
    ]


class DiagnosisOptions(TypedDict, total=False):
    """Options of a diagnosis."""

    exclude: Annotated[Sequence[Sequence[float]], "bands, lower and upper end, whose lines are left out, Hz"]
    bands: Annotated[
        Sequence[Sequence[float]] | None,
        "bands, lower and upper end, whose lines alone count; null: all lines, Hz",
    ]
    suspects: Annotated[Sequence[str] | str, "kinds of effects to look for"]
    hold_out: Annotated[Mapping[str, Any], "FRFs kept out of every fit"]
    tolerances: Annotated[
        Mapping[str, Any] | str | None,
        "what may differ a little and is no missing effect, one standard deviation each, or a preset's "
        "name; left out: `none` for a simulated test, `ordinary` for an uploaded one that is not "
        "explained without: none, careful, ordinary, student",
    ]
    act: Annotated[bool, "run the proposed next tests, where the rig is a simulated one"]
    noise_floor: Annotated[
        float | None,
        "relative random error of every FRF, of its median where it is below that; beside what coherence "
        "and averages tell, alone where there is no coherence",
    ]
    max_effects: Annotated[int, "largest number of effects added"]
    seed: Annotated[int, "seed of the draw of the FRFs that are kept out"]

"""The flags of `modallab diagnose` are the options of a diagnosis."""

import inspect

from modallab.api.cli import diagnose
from modallab.diagnosis.options import DiagnosisOptions

# Files, output, and what belongs to the measurement; `act` needs a rig that a file has not.
NO_OPTIONS = {"model", "measured", "rig", "report", "averages", "as_json"}
RENAMED = {"tolerance": "tolerances"}  # one of them each time


def test_every_option_but_the_running_of_tests_is_a_flag_with_the_same_default() -> None:
    flags = inspect.signature(diagnose).parameters
    names = {RENAMED.get(name, name): name for name in flags if name not in NO_OPTIONS}
    specs = DiagnosisOptions.specs()
    assert names.keys() == specs.keys() - {"act"}
    for name in ("max_effects", "noise_floor", "seed"):
        assert flags[name].default == specs[name].default

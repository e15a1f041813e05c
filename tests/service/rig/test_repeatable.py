"""The same seed gives the same bytes: on every route, of every signal, in whatever process."""

import hashlib
import json
import os
import subprocess
import sys
from dataclasses import fields

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import EffectSpec, Members
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.effect import build
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.hardware import Accelerometers, Exciter, ForceTransducer, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from tests.rigs import dofs, steel_beam

RESPONSES = (1, 7, 16)
HIDDEN = (
    EffectSpec("stiffness_error", Members((4,)), {"factor": 1.2}),
    EffectSpec("extra_mass", Dof(9, "Y"), {"mass": 0.05}),
    EffectSpec("mains_hum", None, {}),
    EffectSpec("drift", None, {}),
)
NONLINEAR = (*HIDDEN, EffectSpec("cubic_stiffness", Dof(7, "Y"), {}))


def bench(kind: str, **settings: object) -> RigSetup:
    """A rig with noise, rounding, and a mass that roves; random signals overlap and are windowed."""
    random = EXCITATIONS[kind].continuous > 0
    given = {"frequency_max": 400.0, "n_lines": 41, "averages": 6, "bits": 12, "coupling": "ac"}
    if random:
        given |= {"window": "hann", "overlap": 0.5}
    if kind == "impact":
        given |= {"window": "force_exponential", "range_factor": 16.0, "bits": 16}
    own = ExcitationSetting(kind, level_scatter=0.1, place_scatter=0.005, angle_scatter=0.05)
    return RigSetup(
        dofs(1),
        dofs(*RESPONSES),
        Exciter("hammer") if kind == "impact" else Exciter(armature_mass=0.02),
        force_transducer=ForceTransducer() if kind == "impact" else ForceTransducer(0.01),
        accelerometers=Accelerometers(0.02, roving=True, mounting="wax", transverse_sensitivity=0.03),
        noise=Noise(1e-2, 1e-3),
        analyser=Analyser(**(given | settings), excitation=own),  # type: ignore[arg-type]
    )


def digest(measurement: Measurement) -> str:
    """SHA-256 of all arrays of a measurement, names and shapes included."""
    found = hashlib.sha256()
    arrays = {field.name: getattr(measurement, field.name) for field in fields(measurement)}
    arrays |= {"freq": measurement.frf.freq, "values": measurement.frf.values}
    for name, array in sorted(arrays.items()):
        if isinstance(array, np.ndarray):
            found.update(f"{name} {array.shape} {array.dtype}".encode())
            found.update(np.ascontiguousarray(array).tobytes())
    return found.hexdigest()


def made(kind: str, route: Route, *, seed: int = 7, specs: tuple[EffectSpec, ...] = HIDDEN) -> str:
    rng = np.random.default_rng(seed)
    effects = [build(spec) for spec in specs]
    return digest(measure(steel_beam(), bench(kind), effects, route=route, rng=rng))


def everything() -> dict[str, str]:
    """Digests of all signals on all routes, and of a nonlinear structure stepped through time."""
    found = {f"{kind} {route}": made(kind, route) for kind in sorted(EXCITATIONS) for route in Route}
    for kind in ("random", "periodic_random"):
        found[f"{kind}, nonlinear"] = made(kind, Route.SAMPLED, specs=NONLINEAR)
    return found


def elsewhere(hash_seed: str) -> "subprocess.Popen[str]":
    """The same in a process of its own."""
    code = (
        "import json; from tests.service.rig.test_repeatable import everything as e; print(json.dumps(e()))"
    )
    environment = os.environ | {"PYTHONHASHSEED": hash_seed}
    return subprocess.Popen([sys.executable, "-c", code], env=environment, stdout=subprocess.PIPE, text=True)


def test_the_same_seed_gives_the_same_bytes_in_other_processes() -> None:
    others = [elsewhere("1"), elsewhere("77")]
    found = [json.loads(other.communicate(timeout=120)[0]) for other in others]
    assert found[0] == found[1]
    assert len(set(found[0].values())) == len(found[0]), "each is a measurement of its own"
    # and so it is in a process that has done other work before
    assert made("random", Route.SAMPLED) == found[0][f"random {Route.SAMPLED}"]


@pytest.mark.parametrize("route", [Route.DRAWN, Route.SAMPLED])
def test_another_seed_gives_other_bytes(route: Route) -> None:
    assert made("random", route, seed=1) != made("random", route, seed=2)


def test_the_expected_route_asks_no_seed() -> None:
    assert made("random", Route.EXPECTED, seed=1) == made("random", Route.EXPECTED, seed=2)

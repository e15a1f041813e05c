"""Rigs: the log book of a test."""

from collections.abc import Mapping, Sequence
from typing import Any

from modallab_client import _wire
from modallab_client._plausibility import warned
from modallab_client._sync.shelf import Shelf
from modallab_client.results import (
    Accelerometers,
    Analyser,
    EffectSpec,
    Exciter,
    ForceTransducer,
    Noise,
    Rig,
    StingerRod,
    StingerStiffness,
    Suspension,
)
from modallab_client.stored import Identified, id_of

# Parts of a stored rig may be sent again.
Part = Exciter | StingerRod | StingerStiffness | ForceTransducer | Accelerometers | Suspension | Analyser
JsonObject = Mapping[str, Any] | Part | Noise | EffectSpec


class Rigs(Shelf):
    """Rigs on the service."""

    path = "/v1/rigs"

    def create(
        self,
        *,
        responses: Sequence[str],
        drive: str | None = None,
        drives: Sequence[str] | None = None,
        exciter: JsonObject | None = None,
        stinger: JsonObject | None = None,
        force_transducer: JsonObject | None = None,
        accelerometers: JsonObject | Sequence[JsonObject] | None = None,
        suspension: JsonObject | None = None,
        analyser: JsonObject | None = None,
        noise: JsonObject | None = None,
        effects: Sequence[JsonObject] | None = None,
    ) -> Rig:
        """Return a new rig; parts left out are ideal: no mass, no noise.

        Parameters
        ----------
        responses
            DoFs of the accelerometers.
        drive, drives
            DoF of the exciter; a roving hammer has several.
        exciter, stinger, force_transducer, accelerometers, suspension
            Data sheets of the hardware, `exciter={"kind": "shaker", "armature_mass": 0.02}`.
        analyser
            `frequency_max`, `n_lines`, `window`, `averages`, `overlap`, `estimator`, `excitation`.
        noise
            Noise-to-signal ratios `force` and `response`.
        effects
            What has no field here: `[{"kind", "at", "parameters"}]`.
        """
        test = _wire.body(responses=responses, drive=drive, drives=drives, analyser=analyser, noise=noise)
        hardware = _wire.body(exciter=exciter, stinger=stinger, force_transducer=force_transducer)
        attached = _wire.body(accelerometers=accelerometers, suspension=suspension, effects=effects)
        body = test | hardware | attached
        return warned(_wire.reply(Rig, self._transport.request("POST", self.path, json=body)))

    def get(self, rig_id: Identified) -> Rig:
        """Return a rig as it was declared."""
        return _wire.reply(Rig, self._transport.request("GET", f"{self.path}/{id_of(rig_id)}"))

    def body(self, rig_id: Identified) -> dict[str, Any]:
        """Return the body that declares a rig; `create(**body)` makes the same one, on any service."""
        return _wire.read(dict, self._transport.request("GET", f"{self.path}/{id_of(rig_id)}/body"))

"""Questions of the trial put to a service over HTTP: it is sent what a diagnosis is given, no truth."""

import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from typing import Any

from benchmarks.trial.running import Answer, Question
from benchmarks.trial.scoring import built
from modallab.api.rigs.replies import rig_request
from modallab.api.wire import EffectIn
from modallab.core.dof import Dof
from modallab.core.place import Place
from modallab.diagnosis import result
from modallab.diagnosis.result_builder import extended
from modallab.diagnosis.result_curves import DiagnosisCurves
from modallab.diagnosis.result_localisation import Localisation
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Member, Structure
from modallab.rig.measurement import Measurement
from modallab_client import ModalLab, results
from modallab_client.errors import ClientError, UnreachableError
from modallab_client.results import Measurement as Imported

EMBEDDED = "embedded"
Json = dict[str, Any]


@contextmanager
def service_at(address: str) -> Iterator[str]:
    """Yield the address of a service: the one told, or of one that lives as long as this context."""
    if address != EMBEDDED:
        yield address
        return
    with ModalLab.embedded() as lab:
        yield lab.base_url


def answered_by(url: str, question: Question) -> Answer:
    """Return what a service answers, and the seconds for which its worker was at it.

    Raises
    ------
    UnreachableError
        If it does not answer: that is no wrong diagnosis.
    """
    begun: list[float] = []

    def on_progress(_: float, message: str) -> None:
        if message:  # what waits for a worker says nothing
            begun.append(time.perf_counter())

    with ModalLab(url) as lab:
        try:
            model = lab.structures.create(**model_body(question.structure))
            rig = lab.rigs.create(**rig_request(question.measurement.setup))
            test = _imported(lab, rig.id, question.measurement)
            job = lab.diagnoses.start(
                model.id,
                test.id,
                suspects="all" if question.suspects is None else question.suspects,
                tolerances=asdict(question.tolerances),
            )
            started = time.perf_counter()
            reply, trouble = read(job.result(on_progress), question), ""
        except UnreachableError:
            raise
        except ClientError:
            reply, trouble = None, traceback.format_exc(limit=-6)
            started = time.perf_counter()
    return Answer(reply, time.perf_counter() - next(iter(begun), started), trouble)


def _imported(lab: ModalLab, rig_id: str, measurement: Measurement) -> Imported:
    frf = measurement.frf
    return lab.measurements.import_npz(
        rig_id,
        freq=frf.freq,
        values=frf.values,
        outputs=[str(dof) for dof in frf.outputs],
        inputs=[str(dof) for dof in frf.inputs],
        kind=frf.kind.value,
        coherence=measurement.coherence,
        averages=measurement.averages,
        force_spectrum=measurement.force_spectrum,
        response_spectrum=measurement.response_spectrum,
    )


def model_body(structure: Structure) -> Json:
    """Return a model of the trial as the service takes it: a straight beam or a frame, to the last digit."""
    law = structure.damping
    assert isinstance(law, StructuralDamping)
    common = {
        "damping": {"law": "structural", **asdict(law)},
        "supports": [{"node": s.node, "directions": list(s.directions)} for s in structure.supports],
        "name": structure.name,
    }
    if structure.directions == ("Y", "RZ"):
        first = structure.members[0]
        return common | {
            "kind": "beam",
            "length": structure.nodes[len(structure.nodes)][0],
            "n_elements": len(structure.members),
            "section": _numbers(first.section),
            "material": _numbers(first.material),
        }
    return common | {
        "kind": "frame",
        "nodes": {str(number): place for number, place in structure.nodes.items()},
        "sections": {m.section.name: _numbers(m.section) for m in structure.members},
        "materials": {m.material.name: _numbers(m.material) for m in structure.members},
        "members": [_member(m) for m in structure.members],
    }


def _numbers(part: Any) -> Json:
    return {name: value for name, value in asdict(part).items() if name != "name"}


def _member(m: Member) -> Json:
    return {"number": m.number, "nodes": m.nodes, "section": m.section.name, "material": m.material.name}


def read(reply: results.Diagnosis, question: Question) -> result.Diagnosis:
    """Return an answer as the scorer reads it; other candidates than a step's rivals no reply has."""
    steps = tuple(_step(item) for item in reply.steps)
    effects = [built(step.effect) for step in steps]
    model, log_book = extended(question.structure, question.measurement.setup, effects)
    assert reply.curves is not None
    return result.Diagnosis(
        verdict=result.Verdict(reply.verdict),
        located=Localisation(words=reply.located.words),
        steps=steps,
        remaining_gap=_number(reply.remaining_gap),
        remaining_scatter=_number(reply.remaining_scatter),
        gaps={
            when: {part: _number(gap) for part, gap in parts.items()} for when, parts in reply.gaps.items()
        },
        structure=model,
        setup=log_book,
        curves=_curves(reply.curves),
        notes=reply.notes,
    )


def _step(item: results.Step) -> result.Step:
    parameters = {
        name: result.FittedParameter(_number(p.value), _number(p.standard_error), p.unit)
        for name, p in item.effect.parameters.items()
    }
    return result.Step(
        effect=result.FittedEffect(item.effect.kind, _place(item.effect), parameters),
        probability=_number(item.probability),
        gap_before=_number(item.gap_before),
        gap_after=_number(item.gap_after),
        held_out_gap_before=_number(item.held_out_gap_before),
        held_out_gap_after=_number(item.held_out_gap_after),
        held_out_scatter=_number(item.held_out_scatter),
        rivals_alike=tuple(result.EquivalentEffect(rival.kind, _place(rival)) for rival in item.rivals_alike),
    )


def _place(item: results.FittedEffect | results.EquivalentEffect) -> Place:
    return EffectIn.model_validate({"kind": item.kind, "at": item.at}).place()


def _curves(curves: results.DiagnosisCurves) -> DiagnosisCurves:
    return DiagnosisCurves(
        freq=curves.freq,
        measured=curves.measured,
        before=curves.before,
        after=curves.after,
        random_error=curves.random_error,
        held_out=curves.held_out,
        outputs=tuple(Dof.parse(text) for text in curves.outputs),
        inputs=tuple(Dof.parse(text) for text in curves.inputs),
    )


def _number(value: float | None) -> float:
    """Return a number; what is not finite has no form over HTTP."""
    return float("nan") if value is None else value

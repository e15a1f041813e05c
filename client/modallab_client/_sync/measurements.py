"""Measurements: made on the virtual rig, or brought from elsewhere."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Unpack

from numpy.typing import ArrayLike

from modallab_client import _wire
from modallab_client._plausibility import warned
from modallab_client._sync.jobs import Job
from modallab_client._sync.shelf import Shelf
from modallab_client.estimates import Estimates, estimates_of
from modallab_client.methods.measurements import measurement_of
from modallab_client.options import MeasurementOptions
from modallab_client.results import (
    Curves,
    Indicators,
    Measurement,
    MeasurementLog,
    ReciprocityCheck,
    Truth,
)
from modallab_client.stored import Identified, id_of
from modallab_client.time_records import TimeRecords, time_records_of
from modallab_client.uploads import UploadOptions, upload_files, upload_form

JsonObject = Mapping[str, Any]


class Measurements(Shelf):
    """Measurements on the service."""

    path = "/v1/measurements"

    def start(
        self,
        structure_id: Identified,
        rig_id: Identified,
        **options: Unpack[MeasurementOptions],
    ) -> Job[Measurement]:
        """Start a virtual test; `result` of the job gives the measurement.

        Parameters
        ----------
        structure_id, rig_id
            What is tested, and with what.
        options
            Options of the test: `effects`, `[{"kind", "at", "parameters"}]`, `route`, `seed`, and `records`
            and `estimates`, how many time records and estimates are kept. Their meaning:
            `modallab_client.options.MeasurementOptions`.
        """
        given = _wire.body(**options)
        effects = [*given.pop("effects", ())]  # of any sequence
        body = {"structure_id": id_of(structure_id), "rig_id": id_of(rig_id), "effects": effects}
        defaults = {"route": "sampled", "seed": 0}
        job = self._transport.request("POST", self.path, json=body | defaults | given)
        return Job(job["id"], self._transport, self._made)

    def upload(
        self,
        file: str | Path | bytes | Sequence[str | Path],
        rig_id: Identified | None = None,
        *,
        averages: float | None = None,
        **given: Unpack[UploadOptions],
    ) -> Measurement:
        """Return a measurement from a file, or several files of one test, by path or as bytes.

        Parameters
        ----------
        file
            Universal (58), npz, HDF5, MATLAB, delimited text, `.FRF`, or a zip of such files: the content
            says which of them it is, not its name.
        rig_id
            The log book of the test: drive, responses, analyser. Left out, it is made of what the file
            tells: points and lines, and records that do not leak.
        averages
            Effective averages, which text and universal files do not hold; by default the rig's.
        given
            What the files do not say: `unit`, `scale`, `kind`, `map`, `outputs`, `inputs`, `columns`,
            `variables`, `exciter`, `window`, `window_end`. Their meaning:
            `modallab_client.uploads.UploadOptions`.
        """
        data = upload_form(given) | _wire.body(rig_id=id_of(rig_id))
        if averages is not None:
            data["averages"] = str(averages)
        reply = self._transport.request(
            "POST", "/v1/measurements/import", files=upload_files(file), data=data
        )
        return self._made(reply["id"])

    def import_npz(
        self,
        rig_id: Identified,
        *,
        freq: ArrayLike,
        values: ArrayLike,
        outputs: Sequence[str],
        inputs: Sequence[str],
        kind: str,
        coherence: ArrayLike | None = None,
        averages: float | None = None,
        force_spectrum: ArrayLike | None = None,
        response_spectrum: ArrayLike | None = None,
    ) -> Measurement:
        """Return a measurement from arrays, named and shaped as those of a `Measurement`."""
        axes = {"freq": freq, "outputs": list(outputs), "inputs": list(inputs), "kind": kind}
        spectra = {"force_spectrum": force_spectrum, "response_spectrum": response_spectrum}
        content = _wire.npz(values=values, coherence=coherence, averages=averages, **axes, **spectra)
        return self.upload(content, rig_id)

    def get(self, measurement_id: Identified, *, kind: str | None = None) -> Measurement:
        """Return a measurement with its arrays.

        Parameters
        ----------
        measurement_id
            The measurement.
        kind
            Of its FRFs: `receptance`, `mobility` or `inertance`; left out: as measured. Where a line at
            0 Hz cannot be of that kind it is left out, and `notes` say so.
        """
        about = self._transport.request("GET", f"/v1/measurements/{id_of(measurement_id)}")
        arrays = self._transport.npz(
            f"/v1/measurements/{id_of(measurement_id)}/arrays", _wire.body(kind=kind)
        )
        return _wire.read(measurement_of, about, arrays)

    def records(self, measurement_id: Identified) -> TimeRecords:
        """Return the time records that a measurement kept, started with `records=n`."""
        path = f"{self.path}/{id_of(measurement_id)}/records"
        return _wire.read(time_records_of, self._transport.npz(path))

    def estimates(self, measurement_id: Identified) -> Estimates:
        """Return FRFs and coherence while averages were taken, of a test started with `estimates=n`."""
        path = f"{self.path}/{id_of(measurement_id)}/estimates"
        return _wire.read(estimates_of, self._transport.npz(path))

    def wav(self, measurement_id: Identified) -> bytes:
        """Return the time records as a sound file: all channels side by side, forces first."""
        path = f"{self.path}/{id_of(measurement_id)}/records"
        content: bytes = self._transport.request("GET", path, params={"format": "wav"})
        return content

    def _made(self, measurement_id: str) -> Measurement:
        """Return a new measurement, and warn of what looks like a slip."""
        return warned(self.get(measurement_id))

    def curves(self, measurement_id: Identified, points: int = 800, *, kind: str | None = None) -> Curves:
        """Return the FRFs thinned to about that many lines, for plots; of the kind measured or another."""
        path = f"{self.path}/{id_of(measurement_id)}/curves"
        params = _wire.body(points=points, kind=kind)
        return _wire.reply(Curves, self._transport.request("GET", path, params=params))

    def indicators(self, measurement_id: Identified, points: int = 800) -> Indicators:
        """Return mode indicator functions, thinned to about that many lines: where modes are."""
        path = f"{self.path}/{id_of(measurement_id)}/indicators"
        reply = self._transport.request("GET", path, params={"points": points})
        return _wire.reply(Indicators, reply)

    def reciprocity(self, measurement_id: Identified) -> ReciprocityCheck:
        """Return how far FRFs differ when force and response change places."""
        path = f"{self.path}/{id_of(measurement_id)}/reciprocity"
        return _wire.reply(ReciprocityCheck, self._transport.request("GET", path))

    def log(self, measurement_id: Identified) -> MeasurementLog:
        """Return what was declared and asked; with the truth it is enough to make the same bytes again."""
        path = f"{self.path}/{id_of(measurement_id)}/log"
        return _wire.reply(MeasurementLog, self._transport.request("GET", path))

    def truth(self, measurement_id: Identified) -> Truth:
        """Return what the measurement was made with; for its owner only."""
        path = f"{self.path}/{id_of(measurement_id)}/truth"
        return _wire.reply(Truth, self._transport.request("GET", path))

    def uff(self, measurement_id: Identified, *, kind: str | None = None) -> bytes:
        """Return FRFs, coherence and auto spectra as a universal file (dataset 58), as in `get`."""
        path = f"/v1/measurements/{id_of(measurement_id)}/frf.uff"
        content: bytes = self._transport.request("GET", path, params=_wire.body(kind=kind))
        return content

    def hdf5(self, measurement_id: Identified, *, kind: str | None = None) -> bytes:
        """Return the measurement's arrays as an HDF5 file, with units; `kind` as in `get`."""
        path = f"{self.path}/{id_of(measurement_id)}/arrays.h5"
        content: bytes = self._transport.request("GET", path, params=_wire.body(kind=kind))
        return content

    def thesis(self, measurement_id: Identified, decimals: int = 3, *, kind: str | None = None) -> bytes:
        """Return FRFs and coherence in the text layout of the thesis program.

        Parameters
        ----------
        measurement_id
            The measurement.
        decimals
            Of every number: 3 keeps to the program's columns, 16 loses nothing.
        kind
            As in `get`.
        """
        path = f"{self.path}/{id_of(measurement_id)}/thesis.frf"
        params = _wire.body(decimals=decimals, kind=kind)
        content: bytes = self._transport.request("GET", path, params=params)
        return content

"""Write the files of docs/own-data.md: `python -m docs.own_data`.

A virtual rig stands in for the laboratory: the test of a boom with a loose clamp, as other programs
write it.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.io import savemat

from modallab_client import Measurement, ModalLab

FOLDER = Path("own-data")
STANDARD_GRAVITY = 9.80665  # m/s^2
NAMES = ("nose", "b2", "b3", "b4", "b5", "clamp", "b7", "b8", "b9", "b10", "tail")
SENSOR = "tail"
FIRST_LINE = 15.0  # Hz, below it the suspension moves

BOOM = {
    "kind": "beam",
    "length": 1.5,
    "n_elements": 10,
    "section": {"area": 4.8e-4, "second_moment": 5.76e-9},
    "material": {"modulus": 7.1e10, "density": 2700.0},
    "damping": {"law": "structural", "stiffness_coefficient": 0.02},
}
WEAK_MEMBER, FACTOR = 6, 0.7
ANALYSER = {
    "frequency_max": 300.0,
    "n_lines": 1201,
    "averages": 5,
    "excitation": {
        "kind": "impact",
        "tip_stiffness": 3e6,
        "hammer_mass": 0.15,
        "level": 1.0,
        "level_scatter": 0.2,
    },
}
NOISE = {"force": {"psd": 2e-8}, "response": {"psd": 1e-3}}


def tested() -> Measurement:
    """Return the test of the real boom: a hammer strikes eleven points, one accelerometer listens."""
    points = [f"{node}:+Y" for node in range(1, len(NAMES) + 1)]
    sensor = points[NAMES.index(SENSOR)]
    with ModalLab.embedded() as lab:
        model = lab.structures.create(**BOOM)
        real = lab.structures.change(model.id, members=[WEAK_MEMBER], property="modulus", factor=FACTOR)
        rig = lab.rigs.create(
            drives=points, responses=[sensor], exciter={"kind": "hammer"}, analyser=ANALYSER, noise=NOISE
        )
        return lab.measurements.start(real.id, rig.id, seed=11).result()


def write(folder: Path, test: Measurement) -> None:
    """Write the test as one text for each struck point, as MATLAB variables, and as columns of one text."""
    folder.mkdir(parents=True, exist_ok=True)
    kept = test.freq >= FIRST_LINE
    freq, frf = test.freq[kept], test.values[kept, 0, :] / STANDARD_GRAVITY
    assert test.coherence is not None
    coherence = test.coherence[kept, 0, :]
    for index, name in enumerate(NAMES):
        columns = np.column_stack([freq, frf[:, index].real, frf[:, index].imag, coherence[:, index]])
        write_text(folder / f"{name}.csv", columns)
    savemat(
        folder / "hammer.mat",
        {"f": freq, "frf": frf.astype(np.complex64), "coh": coherence.astype(np.float32)},
    )


def write_text(path: Path, columns: NDArray[np.float64]) -> None:
    """Write frequency, real and imaginary part and coherence below a header of an analyser."""
    header = f"Response: {SENSOR}\nForce: {path.stem}\nFreq [Hz];Real [g/N];Imag [g/N];Coherence"
    np.savetxt(path, columns, fmt=("%.2f", "%.5e", "%.5e", "%.5f"), delimiter=";", header=header, comments="")


if __name__ == "__main__":
    write(FOLDER, tested())

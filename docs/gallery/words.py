"""Texts beside the classes of effects: the hardware that implies an effect, and similar effects."""

from collections.abc import Mapping
from typing import Any

# Parts of a rig's body that imply an effect; effects without an entry are declared by name.
HARDWARE: Mapping[str, Mapping[str, Any]] = {
    "ac_coupling": {"analyser": {"coupling": "ac", "coupling_frequency": 1.0}},
    "accelerometer_mass": {"accelerometers": {"mass": 0.02, "roving": True}},
    "cable_mass": {"accelerometers": {"cable_mass": 0.005}},
    "cancelled_mass": {"force_transducer": {"mass_below": 0.01, "mass_cancelled": True}},
    "exciter_armature": {"exciter": {"armature_mass": 0.02}},
    "exciter_coil": {
        "exciter": {
            "armature_mass": 0.02,
            "coil": {"force_factor": 8.0, "resistance": 2.0, "inductance": 2e-4},
            "amplifier": "voltage",
        }
    },
    "exciter_suspension": {"exciter": {"suspension_stiffness": 5e3, "suspension_damping": 1.0}},
    "force_noise": {"noise": {"force": 1e-3}},
    "force_transducer_mass": {"force_transducer": {"mass_below": 0.01}},
    "force_transducer_stiffness": {"force_transducer": {"stiffness": 1e8}},
    "mounted_resonance": {"accelerometers": {"mounting": "magnet"}},
    "overload": {"analyser": {"bits": 12, "range_factor": 1.5}},
    "quantisation": {"analyser": {"bits": 8, "range_factor": 4.0}},
    "response_noise": {"noise": {"response": 1e-3}},
    "stinger_axial": {"stinger": {"axial_stiffness": 2e6}},
    "stinger_bending": {"stinger": {"bending_stiffness": 10.0, "lateral_stiffness": 12e3}},
    "stinger_mass": {"stinger": {"diameter": 2e-3, "length": 0.05, "modulus": 2.1e11, "density": 7800.0}},
    "suspension": {"suspension": {"at": ["1:+Y", "21:+Y"], "stiffness": 100.0, "loss_factor": 0.05}},
    "transverse_sensitivity": {"accelerometers": {"transverse_sensitivity": 0.03}},
}

SIMILAR_EFFECTS: Mapping[str, str] = {
    "ac_coupling": "`channel_delay` changes the phase in proportion to frequency, `ac_coupling` in inverse "
    "proportion: see the lowest lines.",
    "accelerometer_mass": "`extra_mass` shifts all FRFs by the same amount, a roving accelerometer each by "
    "its own amount. Reciprocity, or a second test with another accelerometer, shows this.",
    "attached_oscillator": "`extra_mass` never splits a resonance. Far above its own frequency an "
    "oscillator acts as a `ground_spring`, far below it as an `extra_mass`: the band must contain its "
    "resonance.",
    "cable_mass": "`accelerometer_mass` shifts frequencies in the same way, but does not increase the "
    "damping.",
    "cancelled_mass": "The spectra alone do not distinguish it from an `exciter_armature` of the same mass.",
    "channel_delay": "`ac_coupling` changes the phase at low frequency, `polarity` by 180 degrees "
    "everywhere; the phase of a delay is a straight line through 0 Hz. Check: two sensors at the same "
    "point.",
    "cubic_stiffness": "`ground_spring` has the same effect at one level. Check: a test at three times the "
    "level, in which only the cubic spring shifts the frequencies.",
    "damping_law": "`loss_factor_error` multiplies the damping of all modes by one factor; another law "
    "changes it in proportion to frequency.",
    "density_error": "With `at: null` its effect on frequencies is the inverse of that of "
    "`stiffness_error`; modal constants, and the mass line below the first mode, distinguish them.",
    "double_hit": "The force spectrum has ripples of constant spacing, one over the time between the "
    "blows. The dips of an `exciter_armature` are at resonances instead.",
    "drift": "`accelerometer_mass` shifts FRFs by an amount that depends on the place of the sensor; drift "
    "shifts them by an amount that depends on the order of the runs. Check: repeat the first run at the end.",
    "elastic_support": "`rotational_elastic_support` lowers modes with a large moment at the support, this "
    "effect those with a large reaction. `stiffness_error` of the member there is similar in low modes.",
    "exciter_armature": "The FRF does not change. `exciter_coil` broadens the dips of the force spectrum; "
    "`stinger_axial` adds a resonance above which the force is lost.",
    "exciter_coil": "`exciter_armature` alone leaves peaks beside the dips of the force spectrum; back-EMF "
    "damps them.",
    "exciter_suspension": "Only the force spectrum at low frequency changes; `exciter_armature` changes it "
    "at high frequency.",
    "extra_mass": "At the drive point it is equivalent to `force_transducer_mass`, at a fixed "
    "accelerometer to `accelerometer_mass`. Check: another drive point. `ground_spring` raises "
    "frequencies.",
    "force_noise": "`response_noise` lowers the coherence at antiresonances, `force_noise` lowers it at "
    "resonances, where the force is small. With `force_noise` H2 is correct and H1 is too small.",
    "force_transducer_mass": "`extra_mass` at the drive point is equivalent. Check: another drive point, "
    "or mass cancellation.",
    "force_transducer_stiffness": "It acts in series with `stinger_axial`: the spectra determine only the "
    "sum of both flexibilities.",
    "friction": "`local_damping` has the same effect at one level. Check: a higher level, at which "
    "friction damps less.",
    "gain_error": "`density_error` and `stiffness_error` of equal size everywhere scale all FRFs, as a "
    "gain error of the force transducer does. No other FRF confirms the gain error of a single response.",
    "ground_spring": "`stiffness_error` does not affect rigid-body motion; a spring to the ground raises "
    "the frequencies of rigid-body modes above 0 Hz. `suspension` does the same, and also adds damping.",
    "integrated_response": "`ac_coupling` differentiates below its corner only. `gain_error` is the "
    "same at every line, `polarity` a turn of 180 degrees; an integration is one of 90 degrees, and a slope.",
    "joint_flexibility": "`stiffness_error` of a member beside the joint is similar in low modes. A joint "
    "does not change modes without bending there.",
    "leakage": "`response_noise` lowers the coherence wherever the response is small; leakage lowers it at "
    "sharp resonances and beside them. A longer record reduces leakage, but not noise.",
    "local_damping": "`loss_factor_error` damps all modes, a local damper only those that move at its "
    "place. `friction` depends on the level.",
    "loss_factor_error": "`damping_law` changes damping according to frequency, `local_damping` according "
    "to mode shapes. `leakage` also lowers peaks, but reduces the coherence.",
    "mains_hum": "Lines at the mains frequency and its odd harmonics remain when the exciter is off.",
    "misplaced_accelerometer": "`gain_error` is the same at every line. The error of a wrong place is "
    "largest where shapes are steep; modes with a node at the channel become visible.",
    "mounted_resonance": "`gain_error` is independent of frequency; this error grows with the square of "
    "frequency.",
    "overload": "Noise and `quantisation` also raise the floor of the spectra. At a lower signal level they "
    "remain, whereas clipping disappears.",
    "polarity": "`channel_delay` has a phase of 180 degrees at one frequency only. The imaginary part of "
    "the drive point FRF has a known sign.",
    "quantisation": "The effect is that of `response_noise` and `force_noise` together. Its level is in "
    "proportion to the range of the converter, 6 dB lower for each bit, and independent of the signal level.",
    "rattle": "The effect of `cubic_stiffness` grows gradually with the level; a gap has no effect up to a "
    "certain level.",
    "response_noise": "`response_noise` lowers the coherence at antiresonances, `force_noise` lowers it at "
    "resonances. With `response_noise` H1 is correct and H2 is too large.",
    "rotational_elastic_support": "`joint_flexibility` at the next node and `stiffness_error` of the member "
    "at the clamp are similar in low modes. `rotational_ground_spring` restrains what the model has as a "
    "pin, this effect releases what it has as a clamp.",
    "rotational_ground_spring": "`ground_spring` at the same node restrains modes that translate there, "
    "this effect those that rotate there.",
    "shear_and_rotary_inertia": "`stiffness_error` everywhere changes all frequencies by one factor; shear "
    "lowers them in proportion to the square of the mode number.",
    "stiffness_error": "With `at: null` its effect on frequencies is the inverse of that of "
    "`density_error`. In one member its effect on a mode is in proportion to the strain energy "
    "there; `ground_spring` also raises the frequencies of rigid-body modes.",
    "stinger_axial": "It acts in series with `force_transducer_stiffness`. `exciter_armature` alone has no "
    "resonance above which the force is lost.",
    "stinger_bending": "`rotational_ground_spring` or `ground_spring` at the drive point is equivalent. "
    "Check: another drive point.",
    "stinger_mass": "Below its own resonances, a rigid stinger has the same effect as an `exciter_armature` "
    "of the same mass.",
    "suspension": "`ground_spring` is the same spring without damping.",
    "swapped_channels": "Each of two FRFs agrees with the prediction of the other; all others agree with "
    "their own.",
    "tabulated_response": "`gain_error`, `ac_coupling` and `channel_delay` are channels whose curve has a "
    "formula. A curve imitates anything in its channel: a diagnosis does not suspect it.",
    "tabulated_stiffness": "`ground_spring`, `extra_mass`, `local_damping`, `attached_oscillator` are parts "
    "whose curve has a formula. A curve imitates anything at its place: a diagnosis does not suspect it.",
    "transverse_sensitivity": "The error of `misplaced_accelerometer` follows the slope of the shape, this "
    "one the motion across the axis. Check: rotate the accelerometer by 180 degrees about its axis; the "
    "sign of the error changes.",
}

"""What a class cannot know of itself: the part of a log book that declares it, and what looks like it."""

from collections.abc import Mapping
from typing import Any

# Parts of a rig's body that imply an effect; what has none here is declared by name.
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
    "ac_coupling": "A `channel_delay` turns the phase in proportion to frequency, this in proportion to the"
    " period: look at the lowest lines.",
    "accelerometer_mass": "An `extra_mass` shifts every FRF alike; an accelerometer that roves shifts each by"
    " its own amount, which reciprocity and a second pass with another accelerometer show.",
    "attached_oscillator": "An `extra_mass` never splits a resonance. Far above its own frequency an"
    " oscillator does what a `ground_spring` does, far below it what an `extra_mass` does: the band must"
    " hold its resonance.",
    "cable_mass": "As `accelerometer_mass`, and the damping rises with it.",
    "cancelled_mass": "Of the spectra alone no different from an `exciter_armature` of the same mass.",
    "channel_delay": "`ac_coupling` turns the phase at low frequency, `polarity` by half a turn everywhere;"
    " a delay draws a straight line through 0 Hz. Repeat with two gauges on one point.",
    "cubic_stiffness": "A `ground_spring` does the same at one level. Repeat at three times the level:"
    " only this one moves.",
    "damping_law": "A `loss_factor_error` changes all modes by one factor; the law tilts damping over"
    " frequency.",
    "density_error": "Everywhere, it does to frequencies what `stiffness_error` does the other way round;"
    " modal constants and the mass line below the first mode tell them apart.",
    "double_hit": "Ripples of the force spectrum that are even over the band, their distance one over the"
    " time between the blows; an armature's drop-outs sit at resonances instead.",
    "drift": "`accelerometer_mass` shifts FRFs by place, drift by the order in which they were measured:"
    " repeat the first run last.",
    "exciter_armature": "Nothing in the FRF. `exciter_coil` makes the drop-outs broad, `stinger_axial`"
    " brings a resonance of its own above which force is lost.",
    "exciter_coil": "An `exciter_armature` alone leaves peaks beside the drop-outs; back-EMF damps them.",
    "exciter_suspension": "Only the force at low frequency knows; an `exciter_armature` shows at high"
    " frequency.",
    "extra_mass": "At the drive point it cannot be told from a `force_transducer_mass`, nor at a fixed"
    " accelerometer from its mass: drive elsewhere. A `ground_spring` raises frequencies.",
    "force_noise": "`response_noise` takes coherence at antiresonances, this at resonances, where the"
    " force drops out. H2 is right where H1 is low.",
    "force_transducer_mass": "An `extra_mass` at the drive point is the same: move the drive point, or"
    " cancel the mass.",
    "force_transducer_stiffness": "In series with `stinger_axial`: from the spectra only the sum of both"
    " flexibilities can be known.",
    "friction": "`local_damping` does the same at one level. Repeat louder: friction damps less.",
    "gain_error": "A `density_error` and a `stiffness_error` of equal size everywhere scale all FRFs as a"
    " force gauge's gain does. One channel's gain is borne out by no other FRF.",
    "ground_spring": "A `stiffness_error` leaves rigid-body motion alone; a spring to the ground lifts it"
    " off 0 Hz, as a `suspension` does with loss.",
    "joint_flexibility": "`stiffness_error` of one member beside the joint is close in low modes;"
    " a joint leaves modes alone that do not bend there.",
    "leakage": "`response_noise` lowers coherence by level alone; leakage does it beside and at sharp"
    " resonances. A longer record lessens it, and leaves noise as it is.",
    "local_damping": "`loss_factor_error` damps all modes; a damper only those that move where it sits."
    " `friction` depends on the level.",
    "loss_factor_error": "`damping_law` changes damping by frequency, `local_damping` by mode shape."
    " `leakage` lowers peaks too, but with coherence.",
    "mains_hum": "Lines at the mains frequency and its odd harmonics that stay when the exciter is silent.",
    "misplaced_accelerometer": "A `gain_error` is the same at every line; a wrong place is most wrong where"
    " shapes are steep, and shows modes that have a node at the channel.",
    "mounted_resonance": "A `gain_error` does not grow with frequency; this grows with its square.",
    "overload": "Noise and `quantisation` raise the floor too, but go on as the level falls; clipping ends.",
    "polarity": "A `channel_delay` of half a turn is one at one frequency only. The drive point's imaginary"
    " part has one sign.",
    "quantisation": "As `response_noise` and `force_noise` together, tied to the converter's range:"
    " it falls by 6 dB a bit and does not follow the level.",
    "rattle": "`cubic_stiffness` grows smoothly with the level; a gap is nothing up to a level, then all.",
    "response_noise": "Coherence falls at antiresonances; with `force_noise` at resonances. H1 stays right,"
    " H2 is too high.",
    "rotational_ground_spring": "A `ground_spring` at the same node holds modes that move there, this those"
    " that turn there.",
    "shear_and_rotary_inertia": "A `stiffness_error` everywhere changes all frequencies by one factor;"
    " shear lowers them by the square of the order.",
    "stiffness_error": "Everywhere, it does to frequencies what `density_error` does the other way round."
    " In one member it follows the strain energy there; a `ground_spring` lifts rigid-body motion too.",
    "stinger_axial": "With `force_transducer_stiffness` in series. An `exciter_armature` alone has no"
    " resonance above which force is lost.",
    "stinger_bending": "A `rotational_ground_spring` or a `ground_spring` at the drive point does the same;"
    " it goes when the drive point moves.",
    "stinger_mass": "As an `exciter_armature` of the same mass, on a rigid stinger below its own resonances.",
    "suspension": "A `ground_spring` is the same without loss.",
    "swapped_channels": "Two FRFs fit each other's prediction and nothing else is wrong.",
    "transverse_sensitivity": "A `misplaced_accelerometer` errs by the slope, this by motion across the axis:"
    " turn the accelerometer by 180 degrees about its axis and the sign changes.",
}

"""The valve driver's settings as parameters that people set, also while it runs: names, units, ranges."""

from forest_control.config.tunables import Tunable

TUNABLES = (
    Tunable("compensate", "false: commands pass, for experiments"),
    Tunable("beyond_valve", "allow for hoses, leakage and the spool's lag"),
    Tunable("hold_zone", "commands that leave the spool centred", "V", 0.0, 1.0),
    Tunable("load_bandwidth", "low-pass of the loads", "Hz", 0.01, 50.0),
    Tunable("minimum_drop", "least share of pressure left", "", 0.01, 1.0),
    Tunable("slew_limit", "of every voltage; 0: none", "V/s", 0.0, 1e5),
    Tunable("dither_amplitude", "added to every voltage that is not zero", "V", 0.0, 1.0),
    Tunable("dither_frequency", "of the dither", "Hz", 1.0, 100.0),
    Tunable("adapt", "learn deadband and gain of every valve and direction"),
    Tunable("forgetting_time", "after which a sample counts for a third", "s", 1.0, 3600.0),
    Tunable("deadband_range", "that a learnt deadband may be off the machine's file", "V", 0.0, 2.0),
    Tunable("gain_range", "factor that a learnt gain may be off by", "", 1.0, 5.0),
)

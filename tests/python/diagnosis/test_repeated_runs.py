"""`berth diagnose --repeat` and `--standstill` with runs of the closed loop, and records whose own command repeats itself."""

import pytest
from checks import causes, check, near
from make_noise import GIVEN, NOISE_N, NOISE_m, column_of_zeros, repeated
from table import Refused, Row, each


def measured_floors(told):
    return {one["block"]: one["residual"]["fit"]["floor"] for one in told.found["blocks"]
            if one["residual"]["floor_is_measured"]}


@check
def tells_the_noise(told, **noise):
    """Half the variance of what two runs differ by, less what the other command does: the noise that was put in."""
    for name, rms in noise.items():
        assert measured_floors(told)[name] == near(rms, rel=0.05), name


@check
def force_is_not_measured(told, *texts):
    """And the one note of the force's noise says why."""
    assert "force" not in measured_floors(told)
    [note] = [note for note in told.found["notes"] if "the noise of the force" in note]
    assert all(text in note for text in texts), note


# A tick of 20 ms is long for a run's own steps, and play turns within them; a robot that switches goes another way after
# another command.
AGAIN = [("ess", {}, [], {"force": NOISE_N, "robot": NOISE_m}), ("ess-50hz", {"robot.backlash_m": 2e-4}, ["robot.backlash"], {}),
         ("ess", {"robot.deadband_m": 1e-4}, ["robot.deadband"], {"force": NOISE_N}),
         ("ess-50hz", {}, [], {"force": NOISE_N, "robot": NOISE_m}),
         ("ess", {"robot.backlash_m": 5e-5}, ["robot.backlash"], {"force": NOISE_N})]
PLAYS = [("ess-50hz", 2e-4), ("ess", 2e-4), ("ess-50hz", 5e-5)]

ROWS = [
    *[Row(f"a run of {rig} again, {' '.join(fault) or 'nothing wrong'}", repeated(rig=rig, fault=fault), causes(*found),
          tells_the_noise(**noise), rig=rig, given=GIVEN, slow=n > 2) for n, (rig, fault, found, noise) in enumerate(AGAIN)],
    Row("a repetition without a column says so", repeated(lacks=("force_N",)), force_is_not_measured("it lacks columns"),
        given=GIVEN),
    Row("a standstill that is noisier than the record",
        repeated(beside={"standstill": {"sensor.noise_N": 2.0, "profile.kind": "rest"}}),
        force_is_not_measured("--standstill does not tell", "estimated from the record"), given=GIVEN),
    # Play makes it jerk at the same places in both halves; the noise is another one.
    *[Row(f"a motion of {rig} that repeats itself is no copy, play of {gap_m} m, seed {seed}",
          repeated(rig=rig, fault={"robot.backlash_m": gap_m}, again=False, seed=seed), causes("robot.backlash"), rig=rig,
          given=GIVEN, slow=seed == 2) for seed in (1, 2) for rig, gap_m in PLAYS],
    Refused("a run with another command repeats none",
            repeated(beside={"repeat": {"profile.kind": "chirp", "profile.amplitude_m": 5e-3}}), "repeats no command",
            given=GIVEN),
    *[Refused(f"a column of zeros makes no repetition, {nothing}", column_of_zeros(nothing=nothing, something=something),
              "repeats no command") for nothing, something in (("operator_force_N", "operator_position_m"),
                                                               ("operator_position_m", "operator_force_N"))],
]


@pytest.mark.long
@each(ROWS)
def test_repeated(row, tmp_path):
    row.check(tmp_path / "out")

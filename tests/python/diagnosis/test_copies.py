"""Records that are their own copy or another one's, whatever was done to it, are no evidence. What a command does again is
none of that."""

import pytest
from conftest import EXIT_DONE, EXIT_INPUT, command
from make_copies import (DERIVED, MIRRORED, REPEATED, a_little_late, all_of_that, as_it_was, bent_without_lag,
                         command_that_repeats_itself, copied_half, derived, derived_half, in_other_digits, late,
                         measured_again, mirrored, pushed, same_command_again, turned_over, wave, with_noise_upon_it,
                         without_lag)
from table import Refused, Row, each


def says(function):
    return function.__name__.replace("_", " ")


SECOND_HALF = ("second half", "independent evidence")
ROBOTS = (late, a_little_late, without_lag, bent_without_lag)
PUSHES = [(mirrored, 0.0), (mirrored, 0.01), (as_it_was, 0.0), (turned_over, 0.0)]
WAVES = [(shape, lag_s, phase) for shape in ("triangle", "sine") for lag_s in (0.0, 0.001, 0.0175)
         for phase in dict.fromkeys((0.0, 0.25, 0.25 + lag_s / 2.0, 0.6))]

COPIES = [
    *[Refused(f"a second half that is the first, {says(turn)}", copied_half(turn=turn), *SECOND_HALF)
      for turn in REPEATED],
    # Time cannot run backwards in a robot that lags: neither with its command, nor without.
    *[Refused(f"the first half {says(turn)} with {share} of noise, {'command and all' if command_too else 'the robot alone'}",
              copied_half(turn=turn, share=share, command_too=command_too), "backwards", *SECOND_HALF)
      for command_too in (True, False) for turn in MIRRORED for share in (0.0, 1e-3, 0.01, 0.03)],
    *[Refused(f"a motion that dies away, {says(turn)}", copied_half(turn=turn, share=1e-3, command_too=True, dies_away=True),
              "backwards", *SECOND_HALF) for turn in MIRRORED],
    Refused("a robot that does the same again without being told", copied_half(turn=as_it_was, share=0.01), "again",
            *SECOND_HALF),
    # Of a manipulator alone the position is what was measured: a mass, whose damping turns with time.
    *[Refused(f"a push and its way, {says(turn)} with {share} of noise", pushed(turn=turn, share=share), "second half",
              "no independent evidence", slow=(turn, share) not in PUSHES[:2]) for turn, share in PUSHES],
    *[Refused(f"the first half {says(turn)} {says(change)}, command and all", derived_half(turn=turn, change=change),
              "measured in one go", *SECOND_HALF)
      for turn in (*MIRRORED, *REPEATED) for change in (in_other_digits, with_noise_upon_it)],
    # Its noise gives it away. A repetition starts with the same command, or it is refused as none.
    *[Refused(f"a {role} made from the {given}, {says(form)}", derived(form=form, role=role, given=given),
              f"{{folder}}/{role}.csv", f"{given}.csv", "robot_position_m", "no independent evidence",
              "give another measurement",
              *["backwards, turned over, times 1.5, from its 14.9975 s on"] * (form is all_of_that and role == "validate"))
      for form in DERIVED for given, role in (("record", "validate"), ("record", "repeat"), ("validate", "repeat"))],
]

NO_COPIES = [
    Row("a mass that is pushed once", pushed()),
    *[Row(f"a command {says(turn)}, a robot {says(robot)}", same_command_again(turn=turn, robot=robot),
          slow=n > 5) for n, (turn, robot) in enumerate((t, r) for t in (*MIRRORED, *REPEATED) for r in ROBOTS)],
    *[Row(f"a {shape} that is {lag_s} s late, phase {phase:.5g}", wave(shape=shape, lag_s=lag_s, phase=phase),
          given={"robot.dead_time_ms": max(2.5, 1e3 * lag_s)}, slow=lag_s > 0.001 or shape == "sine")
      for shape, lag_s, phase in WAVES],
    *[Row(f"a {role} with another {turns} of the command and steps of {quantum_m} m",
          measured_again(role=role, turns=turns, quantum_m=quantum_m))
      for role, turns in (("repeat", 1.0), ("validate", 1.0), ("validate", 1.3)) for quantum_m in (0.0, 1e-6, 2e-5, 1e-3)],
]
REPEATING = [(1e-9, 0.0), (5e-6, 0.0), (5e-6, 1e-6), (5e-6, 2e-5)]


@pytest.mark.long
@each(COPIES + NO_COPIES)
def test_copy(row, tmp_path):
    row.check(tmp_path / "out")


@each([Row(f"noise of {noise_m} m in steps of {quantum_m} m", command_that_repeats_itself(noise_m=noise_m, quantum_m=quantum_m))
       for noise_m, quantum_m in REPEATING])
def test_a_command_that_repeats_itself_makes_no_copy_of_what_it_moves(row, tmp_path):
    """It may be refused for something else."""
    done = command(*row.command(tmp_path / "out"))
    assert done.returncode in (EXIT_DONE, EXIT_INPUT) and b"second half" not in done.stderr

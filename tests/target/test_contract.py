"""tests/contract and tests/linux on SocketCAN and libgpiod 1 and 2."""

import re

import pytest


@pytest.mark.parametrize("program", ["target_tests", "target_tests_gpiod2"])
def test_the_contract_holds_on_real_buses_and_lines(guest, program):
    step = guest("contract")
    step.check_done()
    report = step.text(f"{program}.report")
    assert step.number(f"{program}.exit_code") == 0, report
    [(cases, passed)] = re.findall(r"test cases: *(\d+) *\| *(\d+) passed", report)
    assert int(cases) == int(passed) > 0

"""tests/contract on SocketCAN and libgpiod: the cases that simulation passes as well."""

import re


def test_the_contract_holds_on_real_buses_and_lines(guest):
    step = guest("contract")
    assert step.number("exit_code") == 0, step.text("report") + step.text("stderr")
    [(cases, passed)] = re.findall(r"test cases: *(\d+) *\| *(\d+) passed", step.text("report"))
    assert int(cases) == int(passed) > 0

"""restirpg.harness.program: how the harness's programs end."""

import os
import signal

import pytest

from restirpg.harness import UserError, program


def interrupted(number):
    def body(display):
        os.kill(os.getpid(), number)
        pytest.fail("it went on")

    return body


def mistaken(display):
    raise UserError("a mistake")


@pytest.mark.parametrize(
    "body, code",
    [
        (lambda display: 0, 0),
        (mistaken, 2),
        (interrupted(signal.SIGINT), 130),
        (interrupted(signal.SIGTERM), 143),
    ],
)
def test_signals_do_afterwards_what_they_did_before(body, code):
    before = [signal.getsignal(number) for number in program.ENDING]
    assert signal.SIG_IGN not in before
    try:
        assert program.run("program.py", body) == code
        assert [signal.getsignal(number) for number in program.ENDING] == before
    finally:
        for number, handler in zip(program.ENDING, before):
            signal.signal(number, handler)

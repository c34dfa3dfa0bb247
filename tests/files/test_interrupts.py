from __future__ import annotations

import os
import signal

import pytest
from tolman.files.interrupts import Deferred, UserInterrupt, ends_run, raised


def interrupt() -> None:
    os.kill(os.getpid(), signal.SIGINT)


def test_a_signal_that_asks_to_end_is_raised_with_its_number() -> None:
    with pytest.raises(UserInterrupt) as caught, raised():
        os.kill(os.getpid(), signal.SIGTERM)
    assert caught.value.number == signal.SIGTERM
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def test_the_first_waits_for_a_check_and_the_second_does_not() -> None:
    done = []

    def checked(interrupts: Deferred) -> None:
        interrupt()
        done.append("this step")
        interrupts.check()
        done.append("never")

    def twice(interrupts: Deferred) -> None:
        interrupt()
        done.append("that step")
        interrupt()
        done.append("never")

    for work in (checked, twice):
        with pytest.raises(UserInterrupt), Deferred() as interrupts:
            work(interrupts)
    assert done == ["this step", "that step"]


def test_it_waits_for_the_end_of_the_block_at_most() -> None:
    done = []

    def work() -> None:
        interrupt()
        interrupt()
        done.append("all")

    with pytest.raises(UserInterrupt), Deferred(patient=True):
        work()
    assert done == ["all"]


def test_what_is_ignored_stays_so() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with Deferred():
            os.kill(os.getpid(), signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)


def test_a_plugins_keyboard_interrupt_is_a_fault_where_the_users_is_told_apart() -> None:
    assert ends_run(KeyboardInterrupt())  # Python's own handler: it may be the user's
    with raised():
        assert not ends_run(KeyboardInterrupt())
        assert ends_run(UserInterrupt())
    assert not ends_run(GeneratorExit())

"""Progress, Ctrl-C, threads, memory, and the program."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from typing import Any

import gravcal
import pytest
from conftest import ROOT, SEVEN


def test_progress_is_told(seven: dict[str, Any]) -> None:
    told: list[str] = []
    gravcal.Session(**seven).calibrate(progress=told.append)
    assert any(stage.startswith("starting") for stage in told) and any("iteration" in stage for stage in told)


def test_news_and_doubts_are_logged(seven: dict[str, Any], caplog: pytest.LogCaptureFixture) -> None:
    torque = seven["torque"].copy()
    torque[40:, 1] = torque[40, 1]  # a sensor that is stuck
    told: list[str] = []
    with caplog.at_level("DEBUG", logger="gravcal"):
        session = gravcal.Session(**{**seven, "torque": torque})
        session.calibrate("joint", progress=told.append)
        gravcal.inspect(SEVEN / "bare.csv")
    by_level = {level: [one.getMessage() for one in caplog.records if one.levelname == level] for level in ("DEBUG", "INFO", "WARNING")}
    assert session.doubts and set(session.doubts) <= set(by_level["WARNING"])
    assert told and set(told) <= set(by_level["DEBUG"]) and any("inspect" in line for line in by_level["DEBUG"])
    assert any(line.startswith("<gravcal.Session") for line in by_level["INFO"])
    assert any(line.startswith("<gravcal.Calibration joint") for line in by_level["INFO"])


def test_without_logging_nothing_is_said(seven: dict[str, Any], capfd: pytest.CaptureFixture[str]) -> None:
    code = "import gravcal, sys; gravcal.inspect(sys.argv[1])"
    run = subprocess.run([sys.executable, "-c", code, str(SEVEN / "bare.csv")], capture_output=True, text=True, check=True)
    assert run.stdout == "" and run.stderr == ""


def test_what_a_callback_raises_ends_the_calibration(seven: dict[str, Any]) -> None:
    def refuse(stage: str) -> None:
        raise RuntimeError(f"enough of {stage}")

    with pytest.raises(RuntimeError, match="enough of"):
        gravcal.Session(**seven).calibrate(progress=refuse)


def test_ctrl_c_ends_the_calibration(seven: dict[str, Any]) -> None:
    def interrupt(_stage: str) -> None:
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        gravcal.Session(**seven).calibrate(progress=interrupt)


def test_other_threads_run_meanwhile(seven: dict[str, Any]) -> None:
    session, met = gravcal.Session(**seven), threading.Barrier(2, timeout=60)
    # Each waits within its own calibration for the other's: with the lock held, they would never meet.
    first: list[bool] = []

    def meet_once(_stage: str) -> None:
        if threading.current_thread() not in seen:
            seen.add(threading.current_thread())
            met.wait()
            first.append(True)

    seen: set[threading.Thread] = set()
    threads = [threading.Thread(target=lambda: session.calibrate("joint", progress=meet_once)) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(120)
    assert first == [True, True]


FORKING = """
import os, signal, sys, gravcal, gravcal.estimation, pytest
sys.path.insert(0, sys.argv[1])
from conftest import arrays_of_seven

def solve():
    problem = gravcal.estimation.Problem()
    problem.add_block("a", 1.0)
    problem.add_residual(lambda a: a - 2.0, "a", std=0.1)
    return problem.solve()

def in_child(work):
    child = os.fork()
    if child == 0:
        signal.alarm(60)
        try:
            work()
            os._exit(0)
        except gravcal.GravcalError as error:
            told = str(error)
            os._exit(7 if 'multiprocessing.get_context("spawn") or ("forkserver")' in told else 1)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])

session = gravcal.Session(**arrays_of_seven())
works = [session.check, lambda: session.calibrate("joint"), solve]
# A process that is forked before has its own threads.
assert [in_child(work) for work in works] == [0, 0, 0]
works[int(sys.argv[2])]()
assert [in_child(work) for work in works] == [7, 7, 7]
assert in_child(lambda: len(gravcal.Session(**arrays_of_seven()))) == 0
session.calibrate("joint")
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
@pytest.mark.parametrize("first", [0, 1, 2], ids=["check", "calibrate", "solve"])
def test_a_forked_process_says_that_it_lost_the_threads(first: int) -> None:
    command = [sys.executable, "-c", FORKING, str(ROOT / "crates/gravcal-python/tests"), str(first)]
    run = subprocess.run(command, capture_output=True, text=True, check=False, timeout=240)
    assert run.returncode == 0, run.stdout + run.stderr


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="memory is read from /proc")
def test_ten_thousand_calls_leak_nothing() -> None:
    # Those that take no time: benches/leaks.py has them all, and says how much is lost.
    names = ["session", "session, refused", "arrays of a session", "calibrate, refused", "estimation, residual that raises"]
    run = subprocess.run([sys.executable, ROOT / "crates/gravcal-python/benches/leaks.py", *names], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    assert all(f"\n{name} " in run.stdout for name in names), run.stdout


def test_the_program_comes_along() -> None:
    run = subprocess.run([sys.executable, "-m", "gravcal", "--help"], capture_output=True, text=True, check=False)
    assert run.returncode == 0 and "Usage: gravcal <COMMAND>" in run.stdout
    script = os.path.join(os.path.dirname(sys.executable), "gravcal")
    run = subprocess.run([script, "check", str(SEVEN / "absent.toml")], capture_output=True, text=True, check=False)
    assert run.returncode == 2 and run.stderr.startswith("error: ") and "no such file" in run.stderr
    run = subprocess.run([script, "fly"], capture_output=True, text=True, check=False)
    assert run.returncode == 2 and "unrecognized subcommand 'fly'" in run.stderr

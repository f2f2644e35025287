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
from conftest import SEVEN


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


RESIDENT = """
import gc, gravcal, sys
sys.path.insert(0, {tests!r})
from conftest import arrays_of_seven

def resident():
    gc.collect()
    return int(open("/proc/self/statm").read().split()[1]) * 4096

seven = arrays_of_seven()
seven.update(position=seven["position"][:4], torque=seven["torque"][:4], load=seven["load"][:4])

def use(times):
    for _ in range(times):
        session = gravcal.Session(**seven)
        session.position, session.torque, repr(session)
        try:
            session.calibrate("kalman")
        except gravcal.InputError:
            pass

use(1000)
before = resident()
use(10000)
print(resident() - before)
"""


RESIDENT_OF_FUNCTIONS = """
import gc, numpy as np
from gravcal.estimation import Problem

def resident():
    gc.collect()
    return int(open("/proc/self/statm").read().split()[1]) * 4096

x = np.linspace(0.0, 1.0, 200)

def use(times):
    for _ in range(times):
        problem = Problem()
        problem.add_block("a", 1.0)
        problem.add_residual(lambda a: np.exp(a * x) - 2.0, "a", std=0.1)
        problem.solve()
        problem.add_residual(lambda a: 1.0 if a == 1.0 else int("moved"), "a", std=0.1)
        try:
            problem.solve()
        except ValueError:
            continue
        raise SystemExit("what a residual raises was lost")

use(1000)
before = resident()
use(5000)
print(resident() - before)
"""


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="memory is read from /proc")
@pytest.mark.parametrize("script", [RESIDENT, RESIDENT_OF_FUNCTIONS], ids=["sessions", "residuals"])
def test_ten_thousand_calls_leak_nothing(script: str) -> None:
    tests = os.path.dirname(os.path.abspath(__file__))
    run = subprocess.run([sys.executable, "-c", script.format(tests=tests)], capture_output=True, text=True, check=True)
    # 100 bytes a call would be a megabyte.
    assert int(run.stdout) < 1 << 20, run.stdout


def test_the_program_comes_along() -> None:
    run = subprocess.run([sys.executable, "-m", "gravcal", "--help"], capture_output=True, text=True, check=False)
    assert run.returncode == 0 and "Usage: gravcal <COMMAND>" in run.stdout
    script = os.path.join(os.path.dirname(sys.executable), "gravcal")
    run = subprocess.run([script, "check", str(SEVEN / "absent.toml")], capture_output=True, text=True, check=False)
    assert run.returncode == 2 and run.stderr.startswith("error: ") and "no such file" in run.stderr
    run = subprocess.run([script, "fly"], capture_output=True, text=True, check=False)
    assert run.returncode == 2 and "unrecognized subcommand 'fly'" in run.stderr

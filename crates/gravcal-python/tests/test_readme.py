"""What README.md of the package tells to paste."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from conftest import ROOT

README = (ROOT / "crates/gravcal-python/README.md").read_text(encoding="utf-8")


def blocks(language: str) -> "list[str]":
    found: list[str] = re.findall(rf"```{language}\n(.*?)```", README.split("\n## Try it without a robot\n")[1], re.DOTALL)
    return found


def test_it_runs_without_a_robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda url: opened.append(url) is None)
    for block in blocks("toml"):
        Path(block.split(":")[0].removeprefix("# ")).write_text(block, encoding="utf-8")
    first, plot = blocks("python")
    names: dict[str, object] = {}
    exec(first, names)
    printed = capsys.readouterr().out
    assert "Check of my-arm: everything that is asked for can be determined" in printed
    gain = names["result"]["joint"]["joint2.torque_gain"]  # type: ignore[index]
    bias = names["result"]["joint"]["joint2.torque_bias"]  # type: ignore[index]
    told = f"joint2: {gain.value:.4f} ± {gain.std:.4f}, {bias.value:.4f} ± {bias.std:.4f} N·m"
    assert told in first, told
    assert len(opened) == 1
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    exec(plot, names)
    assert Path("residuals.png").stat().st_size > 5000

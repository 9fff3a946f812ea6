"""The examples run as their first lines say."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


def run(name, *arguments, cwd):
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / name), *arguments], cwd=cwd, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def needs(name):
    return pytest.mark.skipif(
        importlib.util.find_spec(name) is None, reason=f"{name} is not installed: pip install {name}"
    )


def test_amass(tmp_path):
    told = run("amass.py", "--frames", "20", "-o", "run.npz", cwd=tmp_path)
    assert "20 frames" in told
    with np.load(tmp_path / "run.npz") as run_:
        assert run_["vertices"].shape == run_["displacement"].shape
        assert run_["time"].shape == (20,)
        assert 1e-3 < np.abs(run_["displacement"]).max() < 0.1


@needs("matplotlib")
def test_force_map(tmp_path):
    told = run("force_map.py", "-o", "map.png", cwd=tmp_path)
    newtons = float(told.split(" N on ")[0])
    assert 1.0 < newtons < 100.0, told
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")


@needs("anny")
def test_anny(tmp_path):
    told = run("anny_body.py", "--frames", "10", "-o", "anny.supple", cwd=tmp_path)
    assert "10 frames" in told and (tmp_path / "anny.supple").exists()


@needs("viser")
def test_viewer(tmp_path):
    assert "5 frames" in run("viewer.py", "--frames", "5", "--port", "18080", cwd=tmp_path)

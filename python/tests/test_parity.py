"""The package does what the command does, bit by bit."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import supple

ROOT = Path(__file__).parents[2]

#: A finger that is held, and a rod that is pressed 1.5 mm into it.
SCENE = """
name = "parity"
steps = 40
settle = false

[avatar]
sample = "finger"

[avatar.bake]
handles = [{ count = 12 }]
cubature = { points = 80 }

[[pins]]
bone = "proximal"
[[pins]]
bone = "middle"
[[pins]]
bone = "distal"

[[colliders]]
name = "rod"
shape = { shape = "cylinder", radius = 0.006, half_length = 0.02 }
friction = 0.4

[colliders.motion]
x = [[0.0, 0.04]]
z = [[0.0, %(start)r], [0.3, %(end)r]]
rotation_degrees = [[0.0, 90.0, 0.0, 0.0]]
"""


def command():
    """The command of this tree, or the one that is installed."""
    built = [ROOT / "target" / profile / "supple" for profile in ("debug", "release")]
    found = [os.environ.get("SUPPLE_COMMAND")] + [str(b) for b in built if b.exists()]
    found.append(shutil.which("supple"))
    return next((f for f in found if f), None)


def test_a_scene_of_the_command_is_the_same_bits(quick, tmp_path):
    program = command()
    if program is None:
        pytest.skip("no command supple: cargo build -p supple-cli, or set SUPPLE_COMMAND")
    avatar = supple.Avatar.sample("finger", recipe=quick)
    assert avatar.bone_names == ["proximal", "middle", "distal"]
    above = avatar.skin[np.abs(avatar.skin[:, 0] - 0.04) < 0.005][:, 2].max() + 0.006
    start, end = above + 0.003, above - 0.0015
    (tmp_path / "parity.toml").write_text(SCENE % {"start": float(start), "end": float(end)})
    arguments = ["simulate", "parity.toml", "--backend", "cpu", "--no-pictures", "--series", "run.npz"]
    subprocess.run([program, *arguments], cwd=tmp_path, check=True, capture_output=True)

    sim = supple.Simulation(avatar, "cpu").follow(np.zeros((3, 3)))
    side = np.array([0.0, 0.02, 0.0])
    middle = np.array([0.04, 0.0, start])
    rod = sim.add_cylinder(middle - side, middle + side, 0.006, friction=0.4)
    # As the scene's rotation vector has it, with its rounding.
    turn = np.array([90.0, 0.0, 0.0]) * np.pi / 180.0
    rod.place_at(middle, turn)
    contacts = 0
    with np.load(tmp_path / "run.npz") as run:
        assert np.array_equal(run["faces"], avatar.faces)
        assert list(run["bone_names"]) == avatar.bone_names
        energies = run["energies"]
        names = list(run["energy_names"])
        for k, time in enumerate(run["time"]):
            u = min(time / 0.3, 1.0)
            z = start + (end - start) * (u * u * (3.0 - 2.0 * u))
            rod.move_to([0.04, 0.0, z])
            step = sim.step(0.01)
            assert np.array_equal(step.vertices, run["vertices"][k]), k
            assert np.array_equal(step.displacements, run["displacement"][k]), k
            assert np.array_equal(step.contact_forces, run["contact_force"][k]), k
            assert np.array_equal(step.loads, run["loads"][k]), k
            assert [step.energies[name] for name in names] == list(energies[k]), k
            contacts += step.report["contacts"]
    assert contacts > 20 and step.contact_force[2] < -0.1

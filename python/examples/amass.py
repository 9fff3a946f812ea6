"""A motion of AMASS on a body of SMPL, with flesh: all of the clip as arrays.

    python amass.py smpl_female.pkl walk.npz [--betas 1.5,-0.3] [-o run.npz]

Without files the package's own body of 24 bones, and arms that are shaken, stand in: SMPL's files are their owners'.
"""

import argparse
from pathlib import Path

import numpy as np

import supple


def stand_in():
    """Two seconds of a person who hops and swings the arms, as arrays of AMASS: z is up."""
    time = np.arange(120) / 60.0
    poses = np.zeros((len(time), 24, 3))
    poses[:, 0, 0] = np.pi / 2
    swing = 0.5 * np.sin(2 * np.pi * 1.5 * time)
    poses[:, 16, 2], poses[:, 17, 2] = -1.0 + swing, 1.0 - swing
    trans = np.zeros((len(time), 3))
    trans[:, 2] = 0.04 * np.sin(2 * np.pi * 2.0 * time)
    return poses, trans, 60.0


arguments = argparse.ArgumentParser()
arguments.add_argument("model", nargs="?", help="SMPL, SMPL-H or SMPL-X: .pkl, .npz")
arguments.add_argument("motion", nargs="?", help="a motion of AMASS: .npz")
arguments.add_argument("--betas", default="", help="amounts of the model's shapes: 1.5,-0.3")
arguments.add_argument("-o", "--output", type=Path, default=Path("amass_run.npz"))
arguments.add_argument("--frames", type=int, help="so many at most")
arguments = arguments.parse_args()

if arguments.model:
    betas = [float(b) for b in arguments.betas.split(",") if b]
    avatar = supple.Avatar.load(arguments.model, betas, progress=lambda k, n, name: print(f"{k}/{n} {name}"))
else:
    avatar = supple.Avatar.sample("body", [0.0, 2.4, 0.0, 0.0, 0.3, 0.5])
print(avatar)

sim = supple.Simulation(avatar, up="z")
record = ["vertices", "displacements"]
if arguments.motion:
    # Bones are found by their names: of SMPL-H's fingers a body without them takes none.
    duration = arguments.frames and arguments.frames / 60.0
    clip = sim.simulate(arguments.motion, duration=duration, record=record)
    print("\n".join(sim.motion_notes))
else:
    poses, trans, fps = stand_in()
    clip = sim.simulate(poses[: arguments.frames], trans[: arguments.frames], fps, record=record)
moved = 1e3 * np.linalg.norm(clip.displacements, axis=2)
print(f"{len(clip)} frames on {sim.backend}: tissue moves by up to {moved.max():.1f} mm")
print(f"most at vertex {np.unravel_index(moved.argmax(), moved.shape)[1]}, {clip.time[moved.max(axis=1).argmax()]:.2f} s")
clip.save(arguments.output)
print(f"written to {arguments.output}")

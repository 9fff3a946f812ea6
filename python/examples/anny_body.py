"""ANNY's body (pip install anny: the wheel carries its data) with flesh: it hops, and tissue swings.

    python anny_body.py [--phenotype weight=0.8 age=0.6] [-o anny.supple]

ANNY (Brégier et al., 2025) models people of all ages as a module of PyTorch. Its vertices at rest, skeleton and skin weights go
into Avatar.from_arrays as they are.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

import supple

try:
    import anny
    import torch
except ImportError as missing:
    sys.exit(f"{missing.name} is not installed, which this example shows: pip install anny")

parser = argparse.ArgumentParser()
parser.add_argument("--phenotype", nargs="*", default=[], help="amounts from 0 to 1, as ANNY calls them: weight=0.8")
parser.add_argument("-o", "--output", type=Path, help="the baked avatar")
parser.add_argument("--frames", type=int, default=60)
arguments = parser.parse_args()

model = anny.Anny()
phenotype = {label: 0.5 for label in model.phenotype_labels}
phenotype.update((name, float(amount)) for name, amount in (a.split("=") for a in arguments.phenotype))
with torch.no_grad():
    rest = model(phenotype_kwargs=phenotype)
vertices = rest["rest_vertices"][0].numpy()
# The arms are along x: of the other two the long one is up.
up = "yz"[int(np.ptp(vertices[:, 2]) > np.ptp(vertices[:, 1]))]
avatar = supple.Avatar.from_arrays(
    vertices,
    model.get_triangular_faces(),
    rest["rest_bone_heads"][0],
    [-1 if parent is None else parent for parent in model.bone_parents],
    model.vertex_bone_weights,
    weight_bones=model.vertex_bone_indices,
    names=list(model.bone_labels),
    up=up,
    name="anny",
    progress=lambda done, of, name: print(f"{done}/{of} {name}"),
)
print(avatar)
for note in avatar.notes:
    print(f"note: {note}")

time = np.arange(arguments.frames) / 60.0
trans = np.zeros((len(time), 3))
trans[:, "xyz".index(up)] = 0.05 * np.sin(2 * np.pi * 2.0 * time)
poses = np.zeros((len(time), len(avatar.pose_names), 3))
clip = supple.Simulation(avatar).simulate(poses, trans, 60.0, record=["displacements"])
moved = np.linalg.norm(clip.displacements, axis=2)
print(f"{len(clip)} frames: tissue moves by up to {1e3 * moved.max():.1f} mm")
if arguments.output:
    avatar.save(arguments.output)
    print(f"written to {arguments.output}")

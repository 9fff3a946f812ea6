"""The force on each vertex of a hand that is pressed onto a ball: a picture, or a list where matplotlib is not there.

    python force_map.py [-o force_map.png] [--file hand.pkl]
"""

import argparse
from pathlib import Path

import numpy as np

import supple

arguments = argparse.ArgumentParser()
arguments.add_argument("-o", "--output", type=Path, default=Path("force_map.png"))
arguments.add_argument("--file", help="a hand of one's own: MANO's .pkl, a .glb")
arguments.add_argument("--depth", type=float, default=0.006, help="how deep it is pressed, m")
arguments = arguments.parse_args()

hand = supple.Avatar.load(arguments.file) if arguments.file else supple.Avatar.sample("hand")
sim = supple.Simulation(hand).follow(np.zeros((len(hand.pose_names), 3)))
# Springs hold the hand, as an arm would; the ball comes from where the palm looks: the side with most handles.
axis = "xyz".index(hand.up)
palm = hand.handles[np.argsort(np.linalg.norm(hand.handles - hand.handles.mean(axis=0), axis=1))[0]]
side = np.zeros(3)
side[axis] = np.sign(palm[axis] - hand.joints[:, axis].mean())
near = np.linalg.norm((hand.skin - palm)[:, np.arange(3) != axis], axis=1) < 0.01
surface = (hand.skin[near] @ side).max()
centre = palm - side * (palm @ side) + side * (surface + 0.025)
ball = sim.add_sphere(0.025, centre, friction=0.5)
for k in range(1, 41):
    ball.move_to(centre - side * arguments.depth * min(k / 25, 1.0))
    step = sim.step(0.01)

force = np.linalg.norm(step.contact_forces, axis=1)
print(f"{np.linalg.norm(step.contact_force):.2f} N on {np.count_nonzero(force)} vertices")
print(f"skin moved by {1e3 * np.linalg.norm(step.displacements, axis=1).max():.2f} mm at most")

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError:
    for vertex in np.argsort(-force)[:10]:
        print(f"vertex {vertex}: {force[vertex]:.3f} N at {step.vertices[vertex].round(4)} m")
    raise SystemExit("matplotlib is not installed, so there is no picture: pip install matplotlib")

plane = [k for k in range(3) if k != axis]
facing = step.vertices[hand.faces].mean(axis=1) @ side > step.vertices.mean(axis=0) @ side - 0.02
faces = hand.faces[(np.cross(*np.diff(step.vertices[hand.faces], axis=1).transpose(1, 0, 2)) @ side > 0) & facing]
moved = 1e3 * np.linalg.norm(step.displacements, axis=1)
figure, axes = plt.subplots(1, 2, figsize=(11, 4.5))
for axes_of, values, title in zip(axes, (1e3 * force, moved), ("force, mN a vertex", "displacement, mm")):
    of_face = values[faces].mean(axis=1)
    drawn = axes_of.tripcolor(*step.vertices[:, plane].T, faces, facecolors=of_face, cmap="inferno")
    axes_of.set_aspect("equal")
    axes_of.set_axis_off()
    axes_of.set_title(title)
    figure.colorbar(drawn, ax=axes_of, shrink=0.8)
figure.tight_layout()
figure.savefig(arguments.output, dpi=120)
print(f"written to {arguments.output}")

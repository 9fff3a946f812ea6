"""A soft body in the browser, by viser (pip install viser): sliders for softness, bounce and tension.

    python viewer.py [me.glb] [--motion walk.npz] [--frames 600]
"""

import argparse
import sys
import time

import numpy as np

import supple

try:
    import viser
except ImportError:
    sys.exit("viser is not installed, which this example shows: pip install viser")

parser = argparse.ArgumentParser()
parser.add_argument("file", nargs="?", help="a character of any kind; the package's own body without it")
parser.add_argument("--motion", help="what it follows: .npz of AMASS, .bvh, .glb; it is shaken without it")
parser.add_argument("--port", type=int, default=8080)
parser.add_argument("--frames", type=int, help="so many, and then it ends")
arguments = parser.parse_args()

if arguments.file:
    avatar = supple.Avatar.load(arguments.file, progress=lambda k, n, name: print(f"{k}/{n} {name}"))
else:
    avatar = supple.Avatar.sample("body", [0.0, 2.4, 0.0, 0.0, 0.3, 0.5])
sim = supple.Simulation(avatar)
if arguments.motion:
    sim.follow(arguments.motion)
print(avatar, "on", sim.backend)

server = viser.ViserServer(port=arguments.port)
server.scene.set_up_direction(f"+{sim.up}")
sliders = {
    "softness": server.gui.add_slider("softness", 0.25, 4.0, 0.05, 1.0),
    "bounce": server.gui.add_slider("bounce", 0.0, 1.0, 0.05, 0.5),
    "tension": server.gui.add_slider("tension", 0.0, 1.0, 0.05, 0.0),
}
mesh = server.scene.add_mesh_simple("/skin", avatar.skin, avatar.faces, color=(220, 170, 150))

still = np.zeros((len(avatar.pose_names), 3))
upward = np.eye(3)["xyz".index(sim.up)]
frame, began = 0, time.monotonic()
while arguments.frames is None or frame < arguments.frames:
    frame += 1
    if not arguments.motion:
        sim.follow(still, 0.04 * np.sin(2 * np.pi * 2.0 * frame / 60) * upward)
    # Between steps: a simulation is one thread's at a time.
    sim.configure(**{name: slider.value for name, slider in sliders.items()})
    mesh.vertices = sim.step(1 / 60).vertices.astype(np.float32)
    # In real time, as far as this machine can.
    time.sleep(max(0.0, began + frame / 60 - time.monotonic()))
print(f"{frame} frames in {time.monotonic() - began:.1f} s")

"""Bodies that several tests use, baked once."""

import numpy as np
import pytest

import supple


@pytest.fixture(scope="session")
def finger():
    """A finger of three bones along x; z points up."""
    return supple.Avatar.sample("finger")


@pytest.fixture(scope="session")
def body():
    """The sample body, of SMPL's 24 bones."""
    return supple.Avatar.sample("body")


@pytest.fixture()
def arrays(finger):
    """The finger's own skin as a program has it, with a shape that lengthens it."""
    stretch = np.zeros(finger.skin.shape + (1,))
    stretch[:, 0, 0] = 0.1 * finger.skin[:, 0]
    along = np.zeros((3, 3, 1))
    along[:, 0, 0] = 0.1 * finger.joints[:, 0]
    return {
        "vertices": finger.skin,
        "faces": finger.faces,
        "joints": finger.joints,
        "parents": finger.parents,
        "weights": finger.weights,
        "names": finger.bone_names,
        "shape_directions": stretch,
        "joint_directions": along,
    }


#: Few handles and points: a bake of a second.
QUICK = {"handles": [{"count": 12}], "cubature": {"points": 80}}


@pytest.fixture(scope="session")
def quick():
    return QUICK


def pressed(avatar, **settings):
    """A held finger with a ball 1 mm deep in the middle of its upper side."""
    sim = supple.Simulation(avatar, "cpu", **settings).follow(np.zeros((3, 3)))
    top = avatar.skin[np.argmax(avatar.skin[:, 2])]
    sim.add_sphere(0.01, top + [0.0, 0.0, 0.009], friction=0.3)
    return sim

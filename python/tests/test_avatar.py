"""Avatars: from samples, files and arrays."""

import os

import numpy as np
import pytest

import supple


def test_a_sample_is_arrays(finger):
    vertices, bones = len(finger.skin), len(finger.joints)
    assert finger.skin.shape == (vertices, 3) and finger.skin.dtype == np.float64
    assert finger.faces.max() == vertices - 1 and finger.faces.min() == 0
    assert finger.bone_names == finger.pose_names and len(finger.bone_names) == bones == 3
    assert list(finger.parents) == [-1, 0, 1]
    assert np.allclose(finger.weights.sum(axis=1), 1.0, atol=1e-12)
    assert finger.dofs == 6 * bones + 3 * len(finger.handles)
    assert finger.up == "z" and finger.name == "finger"
    # Volume times density, over points and as a whole.
    density = finger.tissue_mass / finger.cubature_weights.sum()
    assert 900 < density < 1200
    assert finger.report["skin_vertices"] == vertices


def test_arrays_are_copies(finger):
    finger.skin[:] = 0.0
    assert np.abs(finger.skin).max() > 0.01


def test_what_is_saved_is_loaded(finger, tmp_path):
    path = tmp_path / "finger.supple"
    finger.save(path)
    again = supple.Avatar.load(path)
    for name in ["skin", "faces", "joints", "weights", "handles", "cubature_weights"]:
        assert np.array_equal(getattr(again, name), getattr(finger, name)), name
    again.save(tmp_path / "again.supple")
    assert (tmp_path / "again.supple").read_bytes() == path.read_bytes()
    finger.save(tmp_path / "small.supple", layer=False)
    assert os.path.getsize(tmp_path / "small.supple") < 0.6 * os.path.getsize(path)


def test_arrays_and_a_file_of_them_are_one_avatar(arrays, quick, tmp_path):
    made = supple.Avatar.from_arrays(**arrays, betas=[0.5], name="own", recipe=quick)
    np.savez(tmp_path / "own.npz", **arrays)
    loaded = supple.Avatar.load(tmp_path / "own.npz", betas=[0.5], recipe=quick)
    assert made.skin[:, 0].max() > 1.04 * arrays["vertices"][:, 0].max()
    made.save(tmp_path / "made.supple")
    loaded.save(tmp_path / "loaded.supple")
    assert (tmp_path / "made.supple").read_bytes() == (tmp_path / "loaded.supple").read_bytes()
    assert np.array_equal(made.file_vertices, np.arange(len(made.skin)))


def test_smpls_own_keys_are_taken(arrays, quick, tmp_path):
    """v_template, kintree_table, J_regressor, shapedirs, posedirs, as SMPL's files have them."""
    vertices = arrays["vertices"]
    bones = len(arrays["parents"])
    # Each joint in the middle of its nearest vertices.
    regressor = np.zeros((bones, len(vertices)))
    for j, joint in enumerate(arrays["joints"]):
        near = np.argsort(np.linalg.norm(vertices - joint, axis=1))[:40]
        regressor[j, near] = 1.0 / 40
    posedirs = np.random.default_rng(1).normal(scale=1e-4, size=vertices.shape + (9 * (bones - 1),))
    kintree = np.array([[2**32 - 1, 0, 1], [0, 1, 2]], dtype=np.uint32)
    np.savez(
        tmp_path / "model.npz",
        v_template=vertices,
        f=arrays["faces"].astype(np.uint32),
        weights=arrays["weights"],
        kintree_table=kintree,
        J_regressor=regressor,
        shapedirs=arrays["shape_directions"],
        posedirs=posedirs,
        joint_names=np.array(arrays["names"]),
    )
    loaded = supple.Avatar.load(str(tmp_path / "model.npz"), [1.0], recipe=quick)
    sparse = pytest.importorskip("scipy.sparse")
    made = supple.Avatar.from_arrays(
        vertices,
        arrays["faces"],
        None,
        kintree,
        arrays["weights"].tolist(),
        names=arrays["names"],
        joint_regressor=sparse.csc_matrix(regressor),
        shape_directions=arrays["shape_directions"],
        pose_offsets=posedirs,
        betas=[1.0],
        name="model",
        recipe=quick,
    )
    for path, avatar in [("a", loaded), ("b", made)]:
        avatar.save(tmp_path / path)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_a_function_adds_to_the_pose(arrays, quick):
    """A function of the pose that gives what SMPL's own directions would, gives the same skin."""
    bones, count = len(arrays["parents"]), len(arrays["vertices"])
    directions = np.random.default_rng(2).normal(scale=2e-4, size=(count, 3, 9 * (bones - 1)))
    seen = []

    def offsets(pose):
        seen.append(pose)
        feature = np.concatenate([(matrix(pose[j]) - np.eye(3)).ravel() for j in range(1, bones)])
        return directions @ feature

    kept = {key: arrays[key] for key in ["vertices", "faces", "joints", "parents", "weights"]}
    poses = np.zeros((bones, 3))
    poses[1] = [0.1, 0.5, -0.2]
    skins = []
    for given in [directions, offsets]:
        avatar = supple.Avatar.from_arrays(**kept, pose_offsets=given, up="z", recipe=quick)
        sim = supple.Simulation(avatar, "cpu", gravity=0).follow(poses)
        for _ in range(3):
            step = sim.step(0.01)
        skins.append(step.vertices)
    assert len(seen) == 3 and np.allclose(seen[0], poses, atol=1e-12)
    moved = np.abs(skins[0] - skins[1]).max()
    # The function's come as f32 of at most a millimetre, the directions' as f32 columns.
    assert moved < 1e-8, moved
    flat = supple.Simulation(supple.Avatar.from_arrays(**kept, up="z", recipe=quick), "cpu", gravity=0)
    without = flat.follow(poses).step(0.01).vertices
    assert np.abs(skins[1] - without).max() > 1e-4


def matrix(vector):
    """Rodrigues' formula."""
    angle = np.linalg.norm(vector)
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def test_a_functions_mistakes_are_told(arrays, quick):
    kept = {key: arrays[key] for key in ["vertices", "faces", "joints", "parents", "weights"]}
    answers = [np.zeros((2, 3)), np.full(arrays["vertices"].shape, np.nan), None]

    def offsets(pose):
        answer = answers.pop(0)
        if answer is None:
            raise RuntimeError("mine")
        return answer

    avatar = supple.Avatar.from_arrays(**kept, pose_offsets=offsets, recipe=quick)
    sim = supple.Simulation(avatar, "cpu")
    with pytest.raises(supple.InvalidError, match=r"pose_offsets: has the shape \(2, 3\); expected \(V="):
        sim.step()
    with pytest.raises(supple.InvalidError, match=r"pose_offsets\[0, 0\]: nan is not finite"):
        sim.step()
    with pytest.raises(RuntimeError, match="mine"):
        sim.step()


@pytest.mark.parametrize(
    "key, value, message",
    [
        ("vertices", np.zeros((5, 2)), r"vertices: has the shape \(5, 2\); expected \(V, 3\)"),
        ("faces", [[0, 1, -1]], r"faces\[0, 2\]: -1 is no index"),
        ("faces", [[0, 1, 10**6]], r"faces: .*vertex 1000000"),
        ("joints", np.zeros((2, 3)), r"joints: has the shape \(2, 3\); expected \(J=3, 3\)"),
        ("weights", np.zeros((5, 3)), r"weights: has the shape \(5, 3\); expected \(V=\d+, J=3\)"),
        ("parents", [[0.5, 0, 0]], r"parents: has the shape"),
        ("parents", [-1, 2, 1], r"parents: .*circle"),
        ("names", ["a", "b"], r"names: has the shape \(2,\); expected \(J=3,\)"),
        ("joints", "text", r"joints: a str holds no numbers"),
        ("shape_directions", np.zeros((7, 3, 1)), r"shape_directions: .*expected \(V=\d+, 3, S\)"),
    ],
)
def test_arrays_that_do_not_fit_are_named(arrays, key, value, message):
    with pytest.raises(supple.InvalidError, match=message) as caught:
        supple.Avatar.from_arrays(**{**arrays, key: value})
    assert caught.value.field.startswith(key) and isinstance(caught.value, ValueError)


def test_what_is_not_finite_is_named(arrays):
    arrays["vertices"][7, 1] = np.nan
    with pytest.raises(supple.InvalidError, match=r"vertices\[7, 1\]: nan is not finite"):
        supple.Avatar.from_arrays(**arrays)


def test_errors_of_files_carry_path_field_and_cure(tmp_path, arrays):
    missing = tmp_path / "none.npz"
    with pytest.raises(FileNotFoundError) as caught:
        supple.Avatar.load(missing)
    assert isinstance(caught.value, supple.Error) and caught.value.path == str(missing)

    strange = tmp_path / "strange.xyz"
    strange.write_text("hello")
    with pytest.raises(supple.FormatError) as caught:
        supple.Avatar.load(strange)
    error = caught.value
    assert (error.path, error.field) == (str(strange), "format")
    assert ".npz and .pkl" in error.cure

    del arrays["weights"]
    np.savez(tmp_path / "half.npz", **arrays)
    with pytest.raises(supple.FormatError, match="weights: is missing") as caught:
        supple.Avatar.load(tmp_path / "half.npz")
    assert caught.value.field == "weights"


def test_errors_of_recipes_carry_the_key(finger, quick):
    with pytest.raises(supple.InvalidError, match="handels"):
        supple.Avatar.sample("finger", recipe={"handels": []})
    with pytest.raises(supple.InvalidError) as caught:
        supple.Avatar.sample("finger", recipe={"bounce": 3.0})
    assert caught.value.field == "recipe.bounce"
    with pytest.raises(supple.InvalidError, match='no sample is called "foot"'):
        supple.Avatar.sample("foot")
    with pytest.raises(supple.InvalidError, match="one shape only"):
        supple.Avatar.sample("finger", betas=[1.0])


def test_a_bake_tells_its_phases(quick):
    told = []
    supple.Avatar.sample("finger", recipe=quick, progress=lambda *phase: told.append(phase))
    names = list(supple.BAKE_PHASES)
    assert told == [(k, len(names), name) for k, name in enumerate(names + ["done"])]


def test_the_same_bake_gives_the_same_bits(quick, tmp_path):
    for name in ["a", "b"]:
        supple.Avatar.sample("finger", recipe=quick).save(tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()

"""Steps, clips, what drives them and what they touch."""

import gc

import numpy as np
import pytest

import supple
from conftest import pressed


def skinned(avatar, pose, trans=(0.0, 0.0, 0.0)):
    """Linear blend skinning, written here again."""
    from test_avatar import matrix

    rotations, places = [], []
    for j, parent in enumerate(avatar.parents):
        local = matrix(pose[j])
        if parent < 0:
            rotations.append(local)
            places.append(avatar.joints[j] + trans)
        else:
            rotations.append(rotations[parent] @ local)
            places.append(places[parent] + rotations[parent] @ (avatar.joints[j] - avatar.joints[parent]))
    moved = [(avatar.skin - avatar.joints[j]) @ rotations[j].T + places[j] for j in range(len(places))]
    return sum(w[:, None] * x for w, x in zip(avatar.weights.T, moved))


def test_at_rest_the_skin_is_linear_blend_skinning(finger):
    pose = np.array([[0.0, 0.3, 0.0], [0.0, 0.5, 0.1], [0.1, 0.4, 0.0]])
    trans = np.array([0.5, -0.2, 1.0])
    step = supple.Simulation(finger, "cpu").follow(pose, trans).step(0.01)
    # Weights and places are f64 on both sides: rounding of a body a metre off.
    assert np.abs(step.vertices - skinned(finger, pose, trans)).max() < 1e-9
    assert np.abs(step.displacements).max() < 1e-9
    assert np.allclose(step.positions[0], finger.joints[0] + trans, atol=1e-12)


def test_a_press_gives_forces(finger):
    sim = pressed(finger)
    for _ in range(20):
        step = sim.step(0.01)
    assert 0.05 < step.contact_force[2] * -1 < 100, step
    assert np.allclose(step.contact_forces.sum(axis=0), step.contact_force)
    assert (np.linalg.norm(step.contact_forces, axis=1) > 0).sum() == step.report["contacts"] > 0
    assert step.pressures.shape == (len(finger.skin),) and step.pressures.max() > 0
    assert 1e-4 < np.linalg.norm(step.displacements, axis=1).max() < 2e-3
    # What holds the bones bears the press and the weight, at rest.
    held = step.loads[:, :3].sum(axis=0)
    expected = -step.contact_force - step.report["weight"]
    assert np.abs(held - expected).max() < 0.02 * np.abs(expected).max()
    assert set(step.energies) >= {"elastic", "contact", "inertia", "tracking"}


def test_results_stay_when_the_simulation_goes_on(finger):
    sim = pressed(finger)
    first = sim.step(0.01)
    before = first.vertices.copy()
    for _ in range(5):
        last = sim.step(0.01)
    assert np.array_equal(first.vertices, before)
    assert not np.array_equal(last.vertices, before)
    assert last.time == pytest.approx(0.06)


def test_nothing_hangs_on_what_was_dropped(quick):
    """The avatar, the simulation and its colliders may go in any order."""
    avatar = supple.Avatar.sample("finger", recipe=quick)
    sim = supple.Simulation(avatar, "cpu")
    skin = avatar.skin
    del avatar
    gc.collect()
    ball = sim.add_sphere(0.01, [0.02, 0.0, 0.015])
    step = sim.step(0.01)
    potential = sim.potential(0.01)
    del sim
    gc.collect()
    # The handle keeps its simulation.
    ball.move_to([0.02, 0.0, 0.02])
    assert ball.position[2] == 0.02
    del ball
    gc.collect()
    assert np.isfinite(potential.gradient()).all()
    assert step.vertices.shape == skin.shape


def test_the_same_steps_give_the_same_bits(finger):
    runs = []
    for _ in range(2):
        sim = pressed(finger)
        runs.append([sim.step(0.01).vertices for _ in range(6)])
    assert all(np.array_equal(a, b) for a, b in zip(*runs))
    # And again after a reset.
    sim.reset()
    assert sim.time == 0.0
    assert all(np.array_equal(sim.step(0.01).vertices, x) for x in runs[0])


def wave(frames, fps):
    time = np.arange(frames) / fps
    poses = np.zeros((frames, 3, 3))
    poses[:, 0, 1] = 0.4 * np.sin(8.0 * time)
    trans = np.zeros((frames, 3))
    trans[:, 2] = 0.02 * np.sin(12.0 * time)
    return poses, trans


def test_a_clip_is_its_steps(finger):
    poses, trans = wave(20, 60.0)
    clip = supple.Simulation(finger, "cpu").simulate(poses, trans, fps=60.0)
    assert clip.vertices.shape == clip.contact_forces.shape == (20,) + finger.skin.shape
    assert np.allclose(clip.time, np.arange(20) / 60.0) and len(clip) == 20
    sim = supple.Simulation(finger, "cpu").follow(poses, trans, fps=60.0)
    assert np.array_equal(clip.vertices[0], sim.state().vertices)
    for k in range(1, 20):
        step = sim.step(1.0 / 60.0)
        assert np.array_equal(step.vertices, clip.vertices[k]), k
        assert np.array_equal(step.displacements, clip.displacements[k])
        assert np.array_equal(step.loads, clip.loads[k])
        assert step.energies["elastic"] == clip.energies["elastic"][k]
    # A shaken finger swings; the bones are where they were told to be.
    assert np.abs(clip.displacements[1:]).max() > 1e-6
    assert np.abs(clip.positions[:, 0] - finger.joints[0] - trans).max() < 1e-12


def test_a_clip_starts_on_its_way(finger):
    """No blow at the start: a finger that flies evenly does not swing."""
    trans = np.zeros((15, 3))
    trans[:, 0] = np.arange(15) / 60.0
    clip = supple.Simulation(finger, "cpu").simulate(np.zeros((15, 9)), trans, fps=60.0)
    assert np.abs(clip.displacements).max() < 1e-7


def test_a_pose_a_step(finger):
    poses, trans = wave(8, 60.0)
    a = supple.Simulation(finger, "cpu").follow(poses, trans)
    b = supple.Simulation(finger, "cpu").follow(poses, trans, fps=60.0)
    for _ in range(7):
        assert np.abs(a.step(1 / 60).vertices - b.step(1 / 60).vertices).max() < 1e-12
    with pytest.raises(supple.InvalidError, match="fps: is needed"):
        a.simulate(poses, trans)


def test_a_clip_keeps_what_is_asked_for(finger, tmp_path):
    poses, trans = wave(5, 60.0)
    clip = supple.Simulation(finger, "cpu").simulate(poses, trans, 60.0, record=["displacements"])
    assert clip.vertices is None and clip.displacements.shape[0] == 5
    clip.save(tmp_path / "clip.npz")
    with np.load(tmp_path / "clip.npz") as read:
        assert np.array_equal(read["displacement"], clip.displacements)
        assert list(read["energy_names"])[2] == "elastic"
        assert read["energies"].shape == (5, 13) and read["loads"].shape == (5, 3, 6)
    with pytest.raises(supple.InvalidError, match='"velocities" is none'):
        supple.Simulation(finger, "cpu").simulate(poses, fps=60.0, record=["velocities"])


def test_amass_is_followed(body, tmp_path):
    """A file of AMASS, and its arrays in AMASS's world: z is up there."""
    frames = 12
    poses = np.zeros((frames, 72))
    poses[:, 0] = np.pi / 2
    poses[:, 3 * 16 + 2] = -0.6 - 0.2 * np.sin(np.arange(frames) / 3.0)
    trans = np.zeros((frames, 3))
    trans[:, 1] = -0.01 * np.arange(frames)
    path = tmp_path / "walk.npz"
    np.savez(path, poses=poses, trans=trans, mocap_framerate=60.0, betas=np.zeros(10))
    sim = supple.Simulation(body, "cpu")
    clip = sim.simulate(path, record=["vertices"])
    assert clip.vertices.shape[0] == frames
    assert any("24" in note or "bones" in note for note in sim.motion_notes), sim.motion_notes
    # The arms move, the feet go on by 1 cm a frame; in this world y is up.
    extent = clip.vertices[0].max(axis=0) - clip.vertices[0].min(axis=0)
    assert extent[1] > 1.4
    way = clip.positions[-1, 0] - clip.positions[0, 0]
    assert 0.09 < np.linalg.norm(way) < 0.13 and abs(way[1]) < 0.02, way

    direct = supple.Simulation(body, "cpu", up="z").simulate(poses, trans, fps=60.0)
    extent = direct.vertices[0].max(axis=0) - direct.vertices[0].min(axis=0)
    assert extent[2] > 1.4
    assert np.allclose(direct.positions[:, 0], body.joints[0] + trans, atol=1e-12)
    with pytest.raises(supple.InvalidError, match="trans: is in the file"):
        sim.follow(path, trans)

    # Again, and it begins where it began: in the bind pose's place.
    again = sim.simulate(path, record=["vertices"])
    assert np.array_equal(again.vertices, clip.vertices)
    slow = sim.simulate(path, options={"speed": 0.5, "mirror": True}, duration=0.1, record=[])
    assert len(slow) == 7
    assert np.abs(slow.positions[-1] - clip.positions[-1]).max() > 0.01
    with pytest.raises(supple.InvalidError, match="options: .*sped"):
        sim.follow(path, options={"sped": 2})
    with pytest.raises(supple.FormatError, match="motion.map: .*could be mapped|motion.map"):
        supple.Simulation(body, "cpu").follow(path, options={"map": {"pelvis": "tail"}})


def test_springs_give_way_where_pins_do_not(finger):
    pose = np.zeros((3, 3))
    tip = finger.skin[np.argmax(finger.skin[:, 0])]
    moved = []
    for name in ["follow", "track"]:
        sim = supple.Simulation(finger, "cpu", gravity=0)
        if name == "follow":
            sim.follow(pose)
        else:
            sim.track(pose, rotation=(0.5, 0.01), position=(100.0, 1.0))
        ball = sim.add_sphere(0.01, tip + [-0.005, 0.0, 0.025])
        for k in range(20):
            ball.move_to(tip + [-0.005, 0.0, 0.025 - 0.0007 * k])
            step = sim.step(0.01)
        moved.append(step.positions[2] - finger.joints[2])
    assert np.abs(moved[0]).max() < 1e-12
    assert moved[1][2] < -5e-4, moved


def test_a_ragdoll_falls(finger):
    sim = supple.Simulation(finger, "cpu").ragdoll(0.1)
    for _ in range(10):
        step = sim.step(0.01)
    fallen = step.positions[:, 2].mean() - finger.joints[:, 2].mean()
    assert fallen == pytest.approx(-0.5 * 9.81 * 0.1**2, rel=0.2)
    held = supple.Simulation(finger, "cpu").hold().step(0.01)
    assert np.abs(held.positions[0] - finger.joints[0]).max() < 1e-12


def test_matrices_of_a_game_are_followed(finger):
    turned = np.tile(np.eye(4), (3, 1, 1))
    from test_avatar import matrix

    turn = matrix(np.array([0.0, 0.0, 0.5]))
    for j in range(3):
        turned[j, :3, :3] = turn
        turned[j, :3, 3] = turn @ finger.joints[j]
    step = supple.Simulation(finger, "cpu", gravity=0).follow_matrices(turned).step(0.01)
    # The host's matrices are f32.
    assert np.abs(step.vertices - finger.skin @ turn.T).max() < 1e-7
    with pytest.raises(supple.InvalidError, match=r"matrices: .*expected \(J=3, 4, 4\)"):
        supple.Simulation(finger, "cpu").follow_matrices(np.eye(4))


def test_all_colliders_push(finger):
    """Each shape 1 mm into the same place, from above."""
    top = finger.skin[np.argmax(finger.skin[:, 2])]
    side = [0.01, 0.0, 0.0]
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.01
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    cube = [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])]
    centre = top + [0.0, 0.0, 0.009]
    adders = {
        "sphere": lambda s: s.add_sphere(0.01, centre),
        "capsule": lambda s: s.add_capsule(centre - side, centre + side, 0.01),
        "cylinder": lambda s: s.add_cylinder(centre - side, centre + side, 0.01),
        "box": lambda s: s.add_box([0.02, 0.02, 0.02], centre),
        "half_space": lambda s: s.add_half_space(top - [0, 0, 0.001], [0, 0, -1]),
        "mesh": lambda s: s.add_mesh(corners, cube, centre),
    }
    forces = {}
    for name, add in adders.items():
        sim = supple.Simulation(finger, "cpu").follow(np.zeros((3, 3)))
        handle = add(sim)
        for _ in range(5):
            step = sim.step(0.01)
        forces[name] = -step.contact_force[2]
        handle.remove()
        assert np.abs(sim.step(0.01).contact_forces).max() == 0.0
        with pytest.raises(supple.InvalidError, match="collider"):
            handle.position
    assert all(force > 0.05 for force in forces.values()), forces
    # A box that is a mesh is a box, but for the grid of its distances.
    assert forces["mesh"] == pytest.approx(forces["box"], rel=0.2)
    ground = supple.Simulation(finger, "cpu").add_ground(-1.0)
    assert ground.position[2] == -1.0 and ground.friction == 0.5


def test_a_collider_that_is_placed_has_no_speed(finger):
    """Moved there within a step it drags the skin along, placed there it does not."""
    top = finger.skin[np.argmax(finger.skin[:, 2])]
    shares = []
    for name in ["move_to", "place_at"]:
        sim = supple.Simulation(finger, "cpu").follow(np.zeros((3, 3)))
        ball = sim.add_sphere(0.01, top + [0, 0, 0.009], friction=1.0)
        # Friction is lagged by a step: it needs a contact that was there.
        sim.step(0.01)
        getattr(ball, name)(top + [0.003, 0, 0.009], rotation=[0.0, 0.0, 0.3])
        assert ball.rotation[0, 1] == pytest.approx(-np.sin(0.3))
        force = sim.step(0.01).contact_force
        shares.append(force[0] / -force[2])
    assert shares[0] > 0.8 and abs(shares[1]) < 0.5, shares


def test_fine_handles_wake_where_something_touches(quick):
    """Flesh gives way to a ball that no recipe foresaw, and the potential of a step knows what is awake."""
    fine = supple.Avatar.sample("finger", recipe={**quick, "fine_handles": {}})
    forces = {}
    for budget in [0, 10]:
        sim = pressed(fine, fine_handles=budget)
        assert sim.settings["fine_handles"] == budget
        for _ in range(20):
            step = sim.step(0.01)
        forces[budget] = -step.contact_force[2]
        assert len(step.handles) == len(fine.handles) + budget
        awake = np.abs(step.handles[len(fine.handles) :]).max(axis=1, initial=0.0)
        assert 2 * np.count_nonzero(awake) >= budget, awake
        potential = sim.potential(0.01)
        assert potential.dofs == len(potential.gradient())
    assert forces[10] < 0.95 * forces[0], forces


def test_settings_do_what_they_say(finger):
    def force(**settings):
        sim = pressed(finger, **settings)
        for _ in range(8):
            step = sim.step(0.01)
        return -step.contact_force[2]

    usual, soft = force(), force(softness=4.0)
    assert soft < 0.5 * usual, (usual, soft)

    sim = supple.Simulation(finger, "cpu", solver="converged", integrator="backward_euler", bounce=0.9)
    sim.configure(gravity=[0.0, 1.0, 0.0], tension=0.5, friction=0.0)
    settings = sim.settings
    assert settings["solver"] == {"mode": "converged", "tolerance": 1e-8, "max_iterations": 100}
    assert settings["integrator"] == "backward_euler" and settings["bounce"] == 0.9
    assert settings["gravity"] == [0.0, 1.0, 0.0] and settings["tension"] == 0.5
    assert sim.step(0.01).report["stop"] == "converged"
    sim.configure(solver="one_iteration", gravity=1.62)
    assert sim.settings["gravity"] == [0.0, 0.0, -1.62]
    assert sim.step(0.01).report["stop"] == "one_iteration"


@pytest.mark.parametrize(
    "settings, message",
    [
        ({"softnes": 1.0}, "softnes: is no setting; there are softness"),
        ({"softness": -1.0}, "softness: -1; must be positive"),
        ({"softness": float("nan")}, "softness: NaN"),
        ({"bounce": 2.0}, "factors.bounce"),
        ({"tension": "high"}, "tension: must be a number"),
        ({"gravity": [0.0, 1.0]}, r"gravity: has the shape \(2,\); expected \(3,\)"),
        ({"gravity": [0.0, np.inf, 0.0]}, r"gravity\[1\]: inf is not finite"),
        ({"solver": "magic"}, "settings: .*magic"),
        ({"joint_stiffness": 1e9}, "settings.joint_stiffness"),
        ({"time_step": 0.1}, "time_step: is what step"),
        ({"up": "w"}, 'up: "w" is no axis'),
        ({"backend": "cuda"}, 'backend: "cuda" is none'),
    ],
)
def test_settings_that_do_not_exist_are_named(finger, settings, message):
    with pytest.raises(supple.InvalidError, match=message):
        supple.Simulation(finger, **{"backend": "cpu", **settings})


def test_wrong_settings_change_nothing(finger):
    sim = supple.Simulation(finger, "cpu", softness=2.0)
    with pytest.raises(supple.InvalidError):
        sim.configure(softness=3.0, bounce=5.0)
    assert sim.settings["softness"] == 2.0
    assert np.isfinite(sim.step(0.01).vertices).all()


def test_inputs_that_are_not_usable_are_named(finger):
    sim = supple.Simulation(finger, "cpu")
    poses = np.zeros((4, 3, 3))
    poses[2, 1, 0] = np.nan
    with pytest.raises(supple.InvalidError, match=r"poses\[2, 1, 0\]: nan is not finite"):
        sim.follow(poses)
    with pytest.raises(supple.InvalidError, match=r"expected \(T, J=3, 3\) or \(T, 3J=9\)"):
        sim.follow(np.zeros((4, 2, 3)))
    with pytest.raises(supple.InvalidError, match=r"trans: .*expected \(T=4, 3\)"):
        sim.follow(np.zeros((4, 9)), np.zeros((3, 3)))
    with pytest.raises(supple.InvalidError, match="poses: holds no frame"):
        sim.follow(np.zeros((0, 9)))
    with pytest.raises(supple.InvalidError, match="fps: 0; must be positive"):
        sim.follow(np.zeros((4, 9)), fps=0.0)
    for dt in [0.0, -1.0, float("nan")]:
        with pytest.raises(supple.InvalidError, match="dt: "):
            sim.step(dt)
    with pytest.raises(supple.InvalidError, match=r"position\[0\]: nan is not finite"):
        sim.add_sphere(0.1, [np.nan, 0, 0])
    with pytest.raises(supple.InvalidError, match="collider.shape.radius: -1"):
        sim.add_sphere(-1.0, [0, 0, 0])
    with pytest.raises(supple.InvalidError, match="rotation: scales"):
        sim.add_box([1, 1, 1], [0, 0, 0], 2 * np.eye(3))
    with pytest.raises(supple.InvalidError, match="normal: gives no direction"):
        sim.add_half_space([0, 0, 0], [0, 0, 0])
    with pytest.raises(supple.InvalidError, match="duration: is needed"):
        sim.simulate()
    # After all of these it still steps.
    assert np.isfinite(sim.step(0.01).vertices).all()


def test_a_long_frame_is_cut_and_substeps_are_steps(finger):
    poses, trans = wave(6, 30.0)
    coarse = supple.Simulation(finger, "cpu").simulate(poses, trans, 30.0)
    fine = supple.Simulation(finger, "cpu").simulate(poses, trans, 30.0, substeps=4)
    assert np.allclose(coarse.time, fine.time)
    apart = np.abs(coarse.vertices - fine.vertices).max()
    assert 0.0 < apart < 5e-3, apart


def test_a_software_gpu_agrees(finger):
    try:
        gpu = supple.Simulation(finger, "software_gpu")
    except supple.GpuError as error:
        pytest.skip(f"no software adapter: {error}")
    top = finger.skin[np.argmax(finger.skin[:, 2])]
    sims = [gpu, supple.Simulation(finger, "cpu")]
    for sim in sims:
        sim.follow(np.zeros((3, 3)))
        sim.add_sphere(0.01, top + [0, 0, 0.009])
    for _ in range(5):
        a, b = [sim.step(0.01) for sim in sims]
    assert gpu.backend != "cpu"
    assert np.abs(a.vertices - b.vertices).max() < 1e-5
    assert np.abs(a.contact_force - b.contact_force).max() < 0.02 * np.abs(b.contact_force).max()

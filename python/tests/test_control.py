"""Controllers from Python: they hold and lead a simulated arm."""

import numpy as np
import pytest

import veridyn


@pytest.fixture(scope="module")
def smooth(arm):
    """The arm without dry friction."""
    kinds = {n: n.startswith("coulomb_friction") for n in arm.parameter_names}
    values = np.where([kinds[n] for n in arm.parameter_names], 0.0, arm.parameters)
    return arm.with_parameters(values)


def test_computed_torque_leads_the_plant(smooth):
    frame = smooth.frames[-1]
    state = veridyn.ArmState(smooth, frame)
    law = veridyn.ComputedTorque(3, p=np.full(3, 400.0), d=np.full(3, 40.0))
    plant = veridyn.Engine(smooth)
    start = np.array([0.1, -0.1, 0.1])
    plant.set_state(start, np.zeros(3))
    wanted = start + np.array([0.2, 0.1, 0.03])
    viscous = np.zeros((3, 3))
    for effect in smooth.effects:
        if effect["effect"] == "viscous_friction":
            viscous += effect["values"]["coefficient"] * np.outer(effect["axis"], effect["axis"])
    for _ in range(1500):
        state.update(plant.q, plant.dq)
        plant.step(law.update(state, wanted) + viscous @ plant.dq, 0.001)
    assert plant.time == pytest.approx(1.5)
    np.testing.assert_allclose(plant.q, wanted, atol=1e-4)


def test_joint_controller_is_the_whole_loop(smooth):
    controller = veridyn.JointController(smooth, kp=400, kd=[40, 40, 40], torque=40)
    plant = veridyn.Plant(smooth)
    start = np.array([0.1, -0.1, 0.1])
    plant.set_state(start, np.zeros(3))
    wanted = start + np.array([0.05, 0.05, 0.005])
    for _ in range(1500):
        plant.step(controller.update(plant.q, wanted, 0.001), 0.001)
    np.testing.assert_allclose(plant.q, wanted, atol=1e-3)
    assert controller.fault is None
    assert np.isfinite(controller.update([np.nan, 0.0, 0.1], wanted, 0.001)).all()
    assert "joint 1" in controller.fault
    controller.reset()
    assert controller.fault is None
    with pytest.raises(veridyn.InvalidInput, match="3"):
        controller.update([0.0, 0.0], wanted, 0.001)
    with pytest.raises(veridyn.InvalidInput, match="yaw"):
        veridyn.JointController(smooth)  # its file gives no torque limit


def test_tip_controller_rests_where_it_is(smooth):
    controller = veridyn.TipController(smooth, stiffness=400, torque=40)
    plant = veridyn.Plant(smooth)
    q = np.array([0.1, 0.2, 0.12])
    plant.set_state(q, np.zeros(3))
    x = controller.reference_at(q)
    for _ in range(300):
        plant.step(controller.update(plant.q, x, 0.001), 0.001)
    np.testing.assert_allclose(plant.q, q, atol=1e-3)
    assert controller.fault is None and controller.hold()


def test_impedance_is_a_spring_at_rest(smooth):
    frame = smooth.frames[-1]
    state = veridyn.ArmState(smooth, frame)
    q = np.array([0.1, 0.2, 0.1])
    state.update(q, np.zeros(3))
    law = veridyn.Impedance(
        smooth, frame, mass=np.ones(3), damping=np.full(3, 20.0), stiffness=np.full(3, 100.0)
    )
    there = law.update(state, state.position)
    np.testing.assert_allclose(there, state.bias, atol=1e-9 * np.abs(state.bias).max())
    away = law.update(state, state.position + np.array([0.0, 0.0, 0.01]))
    acceleration = state.jacobian[:3] @ np.linalg.solve(state.mass_matrix, away - state.bias)
    np.testing.assert_allclose(acceleration, [0.0, 0.0, 1.0], atol=1e-6)


def test_gravity_compensation_holds(smooth):
    hold = veridyn.GravityCompensation(smooth)
    plant = veridyn.Engine(smooth)
    q = np.array([0.3, 0.2, 0.12])
    plant.set_state(q, np.zeros(3))
    for _ in range(200):
        plant.step(hold.update(smooth, plant.q), 0.001)
    np.testing.assert_allclose(plant.q, q, atol=1e-6)


def test_sizes_are_checked(smooth):
    state = veridyn.ArmState(smooth, smooth.frames[-1])
    with pytest.raises(veridyn.InvalidInput, match="q has 2 entries, expected 3"):
        state.update(np.zeros(2), np.zeros(3))
    law = veridyn.ComputedTorque(3, p=np.ones(3), d=np.ones(3))
    with pytest.raises(veridyn.InvalidInput, match="ComputedTorque.update: q"):
        law.update(state, np.zeros(4))


def test_excite_makes_a_motion_within_the_limits():
    found = veridyn.excite("psm-3dof", duration=15.4, starts=1, iterations=30, seed=3)
    motion = found.motion
    limits = veridyn.read_model("psm-3dof").coordinates
    for joint, limit in enumerate(limits):
        assert motion.q[:, joint].max() <= limit["upper"] + 1e-6
        assert motion.q[:, joint].min() >= limit["lower"] - 1e-6
    assert np.abs(motion.dq[[0, -1]]).max() < 1e-6
    assert found["condition_number"] > 1.0
    assert veridyn.simulate("psm-3dof", found).recording.rows == motion.rows

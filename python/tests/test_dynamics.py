"""Batch calls: the same numbers in every layout, and the same physics."""

import numpy as np
import pytest

import veridyn


def states(n, rows=700, seed=1):
    rng = np.random.default_rng(seed)
    return [rng.uniform(-1.0, 1.0, (rows, n)) for _ in range(3)]


def test_layouts_give_the_same_torques(arm):
    q, dq, ddq = states(arm.joints)
    tau = veridyn.inverse_dynamics(arm, q, dq, ddq)
    columns = [np.asfortranarray(x) for x in (q, dq, ddq)]
    strided = [np.repeat(x, 2, axis=0)[::2] for x in (q, dq, ddq)]
    assert tau.shape == q.shape and tau.flags.c_contiguous
    by_columns = veridyn.inverse_dynamics(arm, *columns)
    assert by_columns.flags.f_contiguous
    np.testing.assert_array_equal(by_columns, tau)
    np.testing.assert_array_equal(veridyn.inverse_dynamics(arm, *strided), tau)
    one = veridyn.inverse_dynamics(arm, q[5], dq[5], ddq[5])
    np.testing.assert_allclose(one, tau[5], rtol=1e-12)


def test_torques_are_linear_in_phi(arm):
    q, dq, ddq = states(arm.joints, rows=1100)
    Y = veridyn.regressor(arm, q, dq, ddq)
    assert Y.shape == (1100, arm.joints, 10 * len(arm.bodies))
    tau = veridyn.inverse_dynamics(arm, q, dq, ddq)
    np.testing.assert_allclose(Y @ arm.phi, tau, atol=1e-10 * np.abs(tau).max())
    np.testing.assert_allclose(veridyn.regressor(arm, q[3], dq[3], ddq[3]), Y[3], atol=1e-12)


def test_mass_and_coriolis_matrices_make_the_torques(arm):
    q, dq, ddq = (x[0] for x in states(arm.joints))
    zero = np.zeros_like(q)
    gravity = veridyn.inverse_dynamics(arm, q, zero, zero)
    tau = veridyn.mass_matrix(arm, q) @ ddq + veridyn.coriolis_matrix(arm, q, dq) @ dq + gravity
    np.testing.assert_allclose(tau, veridyn.inverse_dynamics(arm, q, dq, ddq), rtol=1e-9)


def test_the_whole_torque_has_the_friction_in_it(arm):
    q, dq, ddq = states(arm.joints, rows=50)
    rest = veridyn.joint_torques(arm, q, dq, ddq) - veridyn.inverse_dynamics(arm, q, dq, ddq)
    friction = np.zeros_like(rest)
    for effect in arm.effects:
        s = dq @ effect["axis"]
        values = effect["values"]
        force = {
            "viscous_friction": lambda: values["coefficient"] * s,
            "coulomb_friction": lambda: values["level"] * np.clip(s / 1e-4, -1.0, 1.0),
            "torque_offset": lambda: values["offset"] + 0.0 * s,
        }[effect["effect"]]()
        friction += np.outer(force, effect["axis"])
    np.testing.assert_allclose(rest, friction, atol=1e-9)


def test_frame_jacobian_is_the_slope_of_the_pose(arm):
    q = np.array([0.2, -0.3, 0.1])
    frame = arm.frames[-1]
    J = arm.frame_jacobian(q, frame)
    h = 1e-6
    for i in range(arm.joints):
        step = h * np.eye(arm.joints)[i]
        slope = (arm.frame_pose(q + step, frame) - arm.frame_pose(q - step, frame)) / (2.0 * h)
        np.testing.assert_allclose(J[:3, i], slope[:3, 3], atol=1e-8)


@pytest.mark.parametrize(
    "wrong",
    [np.zeros((4, 2)), np.zeros((2, 2, 3)), np.zeros(4)],
)
def test_sizes_that_do_not_fit_are_said(arm, wrong):
    with pytest.raises(veridyn.InvalidInput, match="inverse_dynamics: q has"):
        veridyn.inverse_dynamics(arm, wrong, wrong, wrong)


def test_an_arm_without_values_has_no_torques():
    bare = veridyn.read_model("psm-3dof")
    zero = np.zeros(3)
    assert bare.phi is None
    assert veridyn.regressor(bare, zero, zero, zero).shape == (3, 10 * len(bare.bodies))
    with pytest.raises(veridyn.InvalidInput, match="bodies without mass"):
        veridyn.inverse_dynamics(bare, zero, zero, zero)

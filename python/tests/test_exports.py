"""Exported files compute the same torques: C compiled here, SDF read and evaluated here."""

import ctypes
import hashlib
import json
import os
import re
import subprocess
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import veridyn

TOOL = os.environ.get("VERIDYN_TOOL", "")

# Every effect that can be written as C, on an arm with a turning and a turning joint.
EFFECTS = """
  - {effect: viscous_friction, axis: {q1: 1}, coefficient: 0.3}
  - {effect: coulomb_friction, axis: {q1: 1, q2: 0.5}, level: 0.7}
  - {effect: coulomb_friction, axis: {q2: 1}, level: 0.4, slope: 40}
  - {effect: torque_offset, axis: {q2: 1}, offset: -0.2}
  - {effect: rotor_inertia, axis: {q1: 2}, inertia: 0.05}
  - {effect: joint_spring, axis: {q1: 1}, offset: 0.3, stiffness: 1.5}
  - {effect: joint_spring, axis: {q2: 1}, stiffness: 90, lever: 0.05, anchor: 0.1, rest_length: 0.06, angle: 0.4}
  - {effect: stribeck_friction, axis: {q1: 1}, level: 0.5, velocity: 0.2}
  - {effect: presliding_hysteresis, axis: {q1: 1}, level: 0.6, distance: 0.05}
  - {effect: asymmetric_friction, axis: {q2: 1}, level_difference: 0.2, viscous_difference: -0.1}
  - {effect: position_dependent_friction, axis: {q1: 1}, slope: 0.3, curvature: 0.2, centre: 0.1}
  - {effect: position_dependent_friction, axis: {q2: 1}, slope: 0.3, curvature: 0.2, centre: 0.1, distance: 0.03}
  - {effect: position_dependent_viscosity, axis: {q1: 1}, slope: 0.3, curvature: -0.2, centre: -0.1}
  - {effect: load_dependent_friction, axis: {q1: 1}, coefficient: 0.05}
  - {effect: load_dependent_friction, axis: {q2: 1}, coefficient: 0.05, distance: 0.02}
  - {effect: quadratic_drag, axis: {q2: 1}, coefficient: 0.15}
  - {effect: sublinear_viscous, axis: {q1: 1}, coefficient: 0.4, exponent: 0.6}
  - {effect: torque_ripple, axis: {q1: 1}, cosine: 0.1, sine: -0.2, order: 12}
  - {effect: cable_coupling, axis: {q1: 1}, from: {q2: 1.5}, stiffness: 0.3, curvature: 0.1, drag: 0.2}
  - {effect: position_force, axis: {q2: 1}, chebyshev_2: 0.1, chebyshev_3: -0.2, chebyshev_4: 0.05, chebyshev_5: 0.3, centre: 0.1, half_range: 0.8}
  - {effect: backlash, axis: {q1: 1}, level: 0.3, gap: 0.04}
"""


def states(n, rows=60, seed=3):
    """A walk that turns round, so that memories have something to remember."""
    rng = np.random.default_rng(seed)
    steps = np.arange(rows)[:, None]
    q = 0.4 * np.sin(0.35 * steps + np.arange(n)) + 0.01 * rng.uniform(-1, 1, (rows, n))
    dq = rng.uniform(-1, 1, (rows, n))
    dq[::7] *= 5e-5
    return q, dq, rng.uniform(-1, 1, (rows, n))


class Compiled:
    """The generated file as a shared library."""

    def __init__(self, model, folder, compiler, suffix):
        source = folder / f"arm{suffix}"
        source.write_text(model.to_c_code())
        library = folder / f"arm{suffix}.so"
        subprocess.run(
            [*compiler, "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror",
             "-shared", "-fPIC",
             "-o", library, source, "-lm"],
            check=True,
        )
        self.name = re.sub(r"[^A-Za-z0-9]", "_", model.name)
        self.library = ctypes.CDLL(str(library))
        self.memory = int(re.search(rf"{self.name}_memory = (\d+)", source.read_text()).group(1))

    def call(self, function, sizes, *states_and_memory):
        pointers = [x.ctypes.data_as(ctypes.c_void_p) for x in states_and_memory]
        out = np.zeros(sizes)
        getattr(self.library, f"{self.name}_{function}")(
            *pointers, out.ctypes.data_as(ctypes.c_void_p)
        )
        return out

    def derivatives(self, n, *state):
        by_q, by_dq = np.zeros((n, n)), np.zeros((n, n))
        pointers = [x.ctypes.data_as(ctypes.c_void_p) for x in (*state, by_q, by_dq)]
        getattr(self.library, f"{self.name}_derivatives")(*pointers)
        return by_q, by_dq


def slope(model, q, dq, ddq, step=1e-5):
    """Derivatives of the torques by q, by central differences."""
    up = q + step * np.eye(len(q))
    down = q - step * np.eye(len(q))
    rates = np.tile(dq, (len(q), 1)), np.tile(ddq, (len(q), 1))
    ahead, behind = (veridyn.inverse_dynamics(model, at, *rates) for at in (up, down))
    return ((ahead - behind) / (2 * step)).T


def expect_same(model, compiled):
    q, dq, ddq = states(model.joints)
    rigid = veridyn.inverse_dynamics(model, q, dq, ddq)
    whole = veridyn.joint_torques(model, q, dq, ddq)
    Y = veridyn.regressor(model, q, dq, ddq)
    size = np.abs(whole).max()
    memory, again = np.zeros(compiled.memory), np.zeros(compiled.memory)
    n, p = model.joints, Y.shape[2]
    for k in range(len(q)):
        state = q[k], dq[k], ddq[k]
        tau = compiled.call("inverse_dynamics", n, *state)
        np.testing.assert_allclose(tau, rigid[k], atol=1e-12 * size)
        np.testing.assert_allclose(compiled.call("regressor", (n, p), *state), Y[k], atol=1e-11)
        M, C = veridyn.mass_matrix(model, q[k]), veridyn.coriolis_matrix(model, q[k], dq[k])
        np.testing.assert_allclose(compiled.call("mass_matrix", (n, n), q[k]), M, atol=1e-12 * size)
        rest = veridyn.inverse_dynamics(model, q[k : k + 1], 0 * q[k : k + 1], 0 * q[k : k + 1])[0]
        np.testing.assert_allclose(compiled.call("gravity", n, q[k]), rest, atol=1e-12 * size)
        if np.linalg.cond(M) < 1e12:  # a wrist without rotors has no forward dynamics
            back = compiled.call("forward_dynamics", n, q[k], dq[k], tau)
            np.testing.assert_allclose(M @ back, M @ ddq[k], atol=1e-10 * size)
        by_q, by_dq = compiled.derivatives(n, *state)
        # Torques are quadratic in dq, and central differences exact there: 2 C.
        np.testing.assert_allclose(by_dq, 2 * C, atol=1e-11 * size)
        if k % 10 == 0:
            np.testing.assert_allclose(by_q, slope(model, q[k], dq[k], ddq[k]), atol=1e-5 * size)
        friction = compiled.call("friction", n, *state, memory)
        np.testing.assert_allclose(friction, whole[k] - rigid[k], atol=1e-10 * size)
        np.testing.assert_allclose(
            compiled.call("torque", n, *state, again), whole[k], atol=1e-10 * size
        )


@pytest.mark.parametrize("compiler, suffix", [(("cc", "-std=c99"), ".c"), (("c++", "-std=c++11"), ".cpp")])
@pytest.mark.parametrize("robot", ["psm-3dof", "psm-wrist", "ur10e"])
def test_c_computes_the_torques(robot, compiler, suffix, tmp_path):
    model = veridyn.read_model(robot).with_plausible_values(3)
    expect_same(model, Compiled(model, tmp_path, compiler, suffix))


FLOATS = """
#include <cstdio>
#include "arm.h"
int main() {
  float q[%(n)d], dq[%(n)d], ddq[%(n)d], tau[%(n)d];
  for (int i = 0; i < %(n)d; ++i) q[i] = 0.1F * (i + 1), dq[i] = 0.2F * (i + 1), ddq[i] = -0.3F;
  %(name)s_inverse_dynamics(q, dq, ddq, tau);
  for (float t : tau) std::printf("%%.9g\\n", t);
}
"""


def test_templates_compute_in_floats(tmp_path):
    model = veridyn.read_model("ur10e").with_plausible_values(3)
    n, name = model.joints, re.sub(r"[^A-Za-z0-9]", "_", model.name)
    (tmp_path / "arm.h").write_text(model.to_c_code())
    (tmp_path / "main.cpp").write_text(FLOATS % {"n": n, "name": name})
    flags = ["-std=c++11", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(["c++", *flags, "-o", tmp_path / "main", tmp_path / "main.cpp"], check=True)
    said = subprocess.run([tmp_path / "main"], check=True, capture_output=True, text=True).stdout
    i = np.arange(1.0, n + 1)[None, :]
    tau = veridyn.inverse_dynamics(model, 0.1 * i, 0.2 * i, -0.3 + 0 * i)[0]
    np.testing.assert_allclose(np.array(said.split(), float), tau, atol=1e-5 * np.abs(tau).max())


def planar(tmp_path, effects):
    yaml = veridyn.read_model("planar-2r").with_plausible_values(3).to_yaml()
    yaml = re.sub(r"(?ms)^effects:.*?(?=^\S|\Z)", "", yaml)
    path = tmp_path / "planar.yaml"
    path.write_text(yaml + "effects:" + effects)
    return veridyn.read_model(path)


def test_c_has_every_effect(tmp_path):
    names = [c["name"] for c in veridyn.read_model("planar-2r").coordinates]
    text = EFFECTS.replace("q1:", f"{names[0]}:").replace("q2:", f"{names[1]}:")
    model = planar(tmp_path, text)
    expect_same(model, Compiled(model, tmp_path, ("cc", "-std=c99"), ".c"))
    late = text + f"  - {{effect: torque_drift, axis: {{{names[0]}: 1}}, rate: 0.1}}\n"
    assert "Left out: torque_drift" in planar(tmp_path, late).to_c_code()


def test_friction_at_rest_chatters_no_more_than_it_is_told_to(tmp_path):
    names = [c["name"] for c in veridyn.read_model("planar-2r").coordinates]
    model = planar(tmp_path, f"\n  - {{effect: coulomb_friction, axis: {{{names[0]}: 1}}, level: 2.0}}\n")
    noise = 0.003 * np.random.default_rng(1).standard_normal(500)
    spread = {}
    for name, define in (("narrow", ()), ("wide", ("-Dplanar_2r_rest_speed=0.1",))):
        folder = tmp_path / name
        folder.mkdir()
        compiled = Compiled(model, folder, ("cc", "-std=c99", *define), ".c")
        memory = np.zeros(compiled.memory)
        friction = [compiled.call("friction", 2, np.zeros(2), np.array([v, 0.0]), np.zeros(2), memory)[0] for v in noise]
        spread[name] = np.std(friction)
        moving = compiled.call("friction", 2, np.zeros(2), np.array([0.2, 0.0]), np.zeros(2), memory)[0]
        assert moving == pytest.approx(2.0)
    assert spread["narrow"] > 1.5
    assert spread["wide"] < 0.1


def test_c_needs_values():
    with pytest.raises(veridyn.InvalidInput, match="without values"):
        veridyn.read_model("psm-3dof").to_c_code()


def rotation(rpy):
    cr, cp, cy = np.cos(rpy)
    sr, sp, sy = np.sin(rpy)
    return np.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                     [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                     [-sp, cp * sr, cp * cr]])


def numbers(element):
    return np.array([float(word) for word in element.text.split()])


class FromSdf:
    """An SDF model's kinetic and potential energy, from its own words alone."""

    def __init__(self, text, coordinates):
        self.model = ET.fromstring(text).find("model")
        self.coordinates = coordinates
        self.joints = {j.find("child").text: j for j in self.model.findall("joint")}
        for link in self.model.findall("link"):
            pose = link.find("pose")
            assert pose.get("relative_to") == self.joints[link.get("name")].get("name")
            assert not numbers(pose).any()

    def variable(self, joint, q):
        mimic = joint.find("axis/mimic")
        if mimic is None:
            return q[self.coordinates.index(joint.get("name"))]
        leader = q[self.coordinates.index(mimic.get("joint"))]
        return float(mimic.find("multiplier").text) * leader + float(mimic.find("offset").text)

    def pose(self, link, q):
        if link == "world":
            return np.eye(3), np.zeros(3)
        joint = self.joints[link]
        parent = joint.find("parent").text
        assert joint.find("pose").get("relative_to") == ("__model__" if parent == "world" else parent)
        R, p = self.pose(parent, q)
        pose = numbers(joint.find("pose"))
        p = p + R @ pose[:3]
        R = R @ rotation(pose[3:])
        if joint.get("type") == "fixed":
            return R, p
        axis, s = numbers(joint.find("axis/xyz")), self.variable(joint, q)
        if joint.get("type") == "prismatic":
            return R, p + R @ axis * s
        K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        return R @ (np.eye(3) + np.sin(s) * K + (1 - np.cos(s)) * K @ K), p

    def bodies(self, q):
        for link in self.model.findall("link"):
            inertial = link.find("inertial")
            mass = float(inertial.find("mass").text)
            pose = inertial.find("pose")
            local = np.zeros(6) if pose is None else numbers(pose)
            I = {k: float(inertial.find(f"inertia/{k}").text)
                 for k in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")}
            I = np.array([[I["ixx"], I["ixy"], I["ixz"]], [I["ixy"], I["iyy"], I["iyz"]],
                          [I["ixz"], I["iyz"], I["izz"]]])
            R, p = self.pose(link.get("name"), q)
            yield mass, p + R @ local[:3], R @ rotation(local[3:]), I

    def gravity_torque(self, q, g, h=1e-5):
        def potential(at):
            return -sum(m * g @ c for m, c, _, _ in self.bodies(at))
        e = np.eye(len(q)) * h
        return np.array([(potential(q + d) - potential(q - d)) / (2 * h) for d in e])

    def mass_matrix(self, q, h=1e-5):
        n = len(q)
        M = np.zeros((n, n))
        plus = [list(self.bodies(q + h * d)) for d in np.eye(n)]
        minus = [list(self.bodies(q - h * d)) for d in np.eye(n)]
        for b, (m, _, R, I) in enumerate(self.bodies(q)):
            v, w = np.zeros((3, n)), np.zeros((3, n))
            for i in range(n):
                v[:, i] = (plus[i][b][1] - minus[i][b][1]) / (2 * h)
                W = R.T @ (plus[i][b][2] - minus[i][b][2]) / (2 * h)
                w[:, i] = [W[2, 1], W[0, 2], W[1, 0]]
            M += m * v.T @ v + w.T @ I @ w
        return M


@pytest.mark.parametrize("robot", ["ur10e", "psm-3dof"])
def test_sdf_is_the_same_arm(robot):
    model = veridyn.read_model(robot).with_plausible_values(3)
    sdf = FromSdf(model.to_sdf(), [c["name"] for c in model.coordinates])
    rng = np.random.default_rng(1)
    zero = np.zeros(model.joints)
    for _ in range(3):
        q = rng.uniform(-0.8, 0.8, model.joints)
        gravity = veridyn.inverse_dynamics(model, q, zero, zero)
        np.testing.assert_allclose(
            sdf.gravity_torque(q, np.asarray(model.gravity)), gravity, atol=1e-6 * np.abs(gravity).max()
        )
        M = veridyn.mass_matrix(model, q)
        np.testing.assert_allclose(sdf.mass_matrix(q), M, atol=1e-6 * np.abs(M).max())


URDF = """<robot name="two">
  <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>
  <link name="base"><visual><geometry><mesh filename="package://two/base.stl" scale="1 1 1"/></geometry></visual></link>
  <link name="upper"><inertial><origin xyz="0.15 0 0.01"/><mass value="2"/>
    <inertia ixx="0.002" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0 0 0.1" rpy="0 0 1"/><geometry><mesh filename="package://two/upper.dae"/></geometry><material name="grey"/></visual>
    <collision><geometry><cylinder radius="0.05" length="0.3"/></geometry></collision></link>
  <link name="lower"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
    <inertia ixx="0.001" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="1.5" velocity="2" effort="60"/><dynamics damping="0.3" friction="0.2"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0.3 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="3" effort="30"/></joint>
</robot>"""


@pytest.fixture(scope="module")
def from_urdf(tmp_path_factory):
    """A URDF, the true arm (heavier than drawn), and what is identified of it."""
    folder = tmp_path_factory.mktemp("urdf")
    path = folder / "two.urdf"
    path.write_text(URDF)
    cad = veridyn.read_model(path)
    true = cad.with_parameters(
        cad.parameters * np.where(["upper" in name for name in cad.parameter_names], 1.3, 1.0)
    )
    time = np.arange(0.0, 20.0, 0.005)
    q = np.stack([0.8 * np.sin(1.1 * time) + 0.3 * np.sin(3.1 * time),
                  0.9 * np.sin(1.7 * time + 1) + 0.4 * np.sin(2.9 * time)], axis=1)
    recording = veridyn.simulate(true, veridyn.Recording(time, q), noise="none").recording
    identified = veridyn.identify(cad, recording)
    identified.save(folder / "identified.yaml")
    return path, cad, identified, folder


def test_meshes_stay_and_masses_come_near_the_drawing(from_urdf):
    path, cad, identified, folder = from_urdf
    model = identified.model
    text = model.to_urdf(prior=cad)
    assert 'filename="package://two/upper.dae"' in text and "package://two/base.stl" in text
    assert '<cylinder radius="0.05" length="0.3"' in text and '<material name="grey">' in text
    assert "not determined by torques alone" in text
    (folder / "out.urdf").write_text(text)
    exported = veridyn.read_model(folder / "out.urdf")
    rng = np.random.default_rng(2)
    q, dq, ddq = rng.uniform(-1, 1, (3, 50, 2))
    tau = veridyn.inverse_dynamics(model, q, dq, ddq)
    there = veridyn.inverse_dynamics(exported, q, dq, ddq)
    np.testing.assert_allclose(there, tau, atol=1e-9 * np.abs(tau).max())
    masses = dict(zip(exported.bodies, exported.phi[::10]))
    drawn = dict(zip(cad.bodies, cad.phi[::10]))
    for name in ("upper", "lower"):
        assert 0.5 * drawn[name] < masses[name] < 2.0 * drawn[name]
    assert "package://two/upper.dae" in model.to_sdf(prior=cad)


def test_without_another_drawing_masses_come_near_the_file_that_was_identified(from_urdf):
    _, cad, identified, folder = from_urdf
    text = identified.model.to_urdf()
    assert "chosen near the bodies of the robot file that the model was identified from" in text
    (folder / "near.urdf").write_text(text)
    exported = veridyn.read_model(folder / "near.urdf")
    masses = dict(zip(exported.bodies, exported.phi[::10]))
    for name, drawn in zip(cad.bodies, cad.phi[::10]):
        assert 0.5 * drawn <= masses[name] <= 2.0 * drawn


def test_without_any_drawing_masses_are_those_of_small_rods():
    time = np.arange(0.0, 20.0, 0.005)
    q = np.stack([0.8 * np.sin(1.1 * time), 0.6 * np.sin(1.7 * time + 1)], axis=1)
    recording = veridyn.simulate("planar-2r", veridyn.Recording(time, q), noise="none").recording
    text = veridyn.identify("planar-2r", recording).model.to_urdf()
    assert "density of water" in text


def test_values_that_nobody_identified_stay(from_urdf):
    _, cad, _, folder = from_urdf
    (folder / "same.urdf").write_text(cad.to_urdf())
    np.testing.assert_allclose(veridyn.read_model(folder / "same.urdf").phi, cad.phi, atol=1e-12)


def test_json_is_the_robot_file(tmp_path):
    model = veridyn.read_model("psm-3dof").with_plausible_values(3)
    path = tmp_path / "model.json"
    path.write_text(model.to_json())
    assert json.loads(path.read_text())["frames"][0]["parent"] == "world"
    again = veridyn.read_model(path)
    np.testing.assert_allclose(again.phi, model.phi, rtol=1e-14)
    q, dq, ddq = states(3)
    np.testing.assert_allclose(
        veridyn.joint_torques(again, q, dq, ddq), veridyn.joint_torques(model, q, dq, ddq), rtol=1e-12
    )


@pytest.mark.skipif(not TOOL, reason="no tool here")
def test_model_files_say_what_they_were_made_from(tmp_path, recording):
    rows = tmp_path / "rows.csv"
    recording.write(rows)
    model = tmp_path / "model.yaml"
    subprocess.run(
        [TOOL, "identify", "psm-3dof", "--train", rows, "--model-out", model, "--quiet"],
        check=True, stdout=subprocess.DEVNULL, env={**os.environ, "SOURCE_DATE_EPOCH": "86400"},
    )
    text = model.read_text()
    assert "1970-01-02T00:00:00Z" in text and "identify" in text
    assert f"veridyn: {veridyn.__version__}" in text
    assert f"rows.csv, sha256: {hashlib.sha256(rows.read_bytes()).hexdigest()}" in text
    assert "psm-3dof.yaml, sha256:" in text
    copy = tmp_path / "copy.yaml"
    outs = {f"--{kind}": tmp_path / f"out.{kind}" for kind in ("urdf", "mjcf", "sdf", "cpp", "json")}
    subprocess.run(
        [TOOL, "export", model, "--yaml", copy, "--quiet",
         *[word for pair in outs.items() for word in pair]],
        check=True,
    )
    assert copy.read_text() == text
    assert all(path.stat().st_size > 500 for path in outs.values())
    assert "<mujoco" in outs["--mjcf"].read_text()
    refused = subprocess.run(
        [TOOL, "export", "psm-3dof", "--mjcf", tmp_path / "no.xml"], capture_output=True, text=True
    )
    assert refused.returncode == 3 and "without values" in refused.stderr
    assert len(refused.stderr.strip().splitlines()) == 1


def test_the_file_of_a_simulation_takes_the_values_of_a_model(tmp_path):
    arm = veridyn.read_model("planar-2r").with_plausible_values(3)
    path = tmp_path / "sim.xml"
    path.write_text(arm.to_mjcf().replace("<worldbody>", "<!-- the floor --><worldbody>"))
    there = veridyn.read_model(path)
    np.testing.assert_allclose(there.phi, arm.phi, rtol=1e-9, atol=1e-12)
    other = there.with_parameters(1.2 * np.asarray(there.parameters))
    text = other.to_mjcf(into=str(path))
    assert "<!-- the floor -->" in text
    path.write_text(text)
    np.testing.assert_allclose(veridyn.read_model(path).phi, 1.2 * there.phi, rtol=1e-9, atol=1e-12)

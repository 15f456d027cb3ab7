"""The equations of motion against an independent rigid-body library that reads our URDF (Pinocchio)."""

import dataclasses

import numpy as np
import pytest

from forest_description.derived.passive_joints import HEAD_JOINTS
from forest_description.machine import load_machine
from forest_description.mechanics.load import Log, Pendulum
from forest_description.urdf.robot_description import robot_description
from forest_sim.mechanics.manipulator import dynamics, fold_head
from forest_sim.mechanics.pendulum import hanging_head, pendulum_dynamics

pin = pytest.importorskip("pinocchio", reason="the rigid-body library (PyPI: pin) is not installed")

TILT, COUNT, CLOSE = 0.13, 100, 1e-8
C180, THESIS, LOADER = load_machine("c180_hoses"), load_machine("c180_thesis"), load_machine("loader")
LOG = Log(mass=900.0, x=0.4, y=-0.3)
LONG_LOG = Log(mass=500.0, x=1.4, y=0.0, length=4.0)
HANGING = {"pendulum": Pendulum(0.9, 60.0, 0.0), "log": Log(500.0, 1.4, 0.0)}
DRIVEN = ("swing", "boom", "stick")
FROM_ABSOLUTE = np.eye(5)  # the joint at the tip turns against the stick, alpha counts from the vertical
FROM_ABSOLUTE[3, 1:3] = -1.0


def variant(machine, **changes):
    manipulator = dataclasses.replace(machine.manipulator, platform_tilt=TILT, **changes)
    return dataclasses.replace(machine, manipulator=manipulator)


def library_model(machine):
    """Load the machine's URDF, gravity as on the tilted platform; the cylinders' joints carry no mass."""
    model = pin.buildModelFromXML(robot_description(machine))
    m = machine.manipulator
    pull = m.gravity * np.array([0.0, np.sin(TILT), np.cos(TILT)])
    model.gravity.linear = -pull
    return model


def library_terms(model, names, q, u):
    """Return M, V + G and G of the library, in the order of the names, all by its inverse dynamics."""
    data, still = model.createData(), np.zeros(model.nv)
    order = [model.joints[model.getJointId(name)].idx_v for name in names]
    angles, rates = np.zeros(model.nq), np.zeros(model.nv)
    angles[order], rates[order] = q, u

    def torques(speed, acceleration):
        return pin.rnea(model, data, angles, speed, acceleration)[order].copy()

    gravity = torques(still, still)
    mass = np.column_stack([torques(still, np.eye(model.nv)[i]) - gravity for i in order])
    return mass, torques(rates, still), gravity


def assert_close(ours, theirs):
    np.testing.assert_allclose(ours, theirs, rtol=CLOSE, atol=CLOSE * np.abs(theirs).max())


@pytest.mark.parametrize(
    "machine",
    [
        variant(C180),
        variant(THESIS),
        variant(C180, log=LOG),
        variant(C180, log=LONG_LOG),
        variant(THESIS, log=LOG, stick_xy=120.0),
        variant(LOADER, pendulum=None),
    ],
    ids=[
        "c180_hoses",
        "thesis",
        "c180_hoses with log",
        "c180_hoses with a long log",
        "thesis with log and product",
        "loader with its head fixed",
    ],
)
def test_mass_matrix_bias_and_gravity_are_those_of_the_library(machine):
    model, body = library_model(machine), fold_head(machine.manipulator)
    rng = np.random.default_rng(11)
    for _ in range(COUNT):
        q, u = rng.uniform(-3.0, 3.0, 3), rng.normal(0.0, 1.0, 3)
        mass, bias, gravity = library_terms(model, DRIVEN, q, u)
        d = dynamics(tuple(q), tuple(u), body)
        assert_close([[d.m_11, 0.0, 0.0], [0.0, d.m_22, d.m_23], [0.0, d.m_23, d.m_33]], mass)
        assert_close(d.bias, bias)
        assert_close(dynamics(tuple(q), (0.0, 0.0, 0.0), body).bias, gravity)


def model_by_hand(machine):
    """Hang the head from a crane without one, joint by joint, in place of the URDF's hanging head."""
    m, head = machine.manipulator, hanging_head(machine.manipulator)
    bare = dataclasses.replace(m, pendulum=None, log=None, head_mass=0.0)
    model = library_model(dataclasses.replace(machine, manipulator=bare))
    at_tip = pin.SE3(np.eye(3), np.array([m.stick_length, 0.0, 0.0]))
    lifting = pin.JointModelRevoluteUnaligned(0.0, -1.0, 0.0)
    cross = model.addJoint(model.getJointId("stick"), lifting, at_tip, HEAD_JOINTS[0])
    hook = model.addJoint(cross, pin.JointModelRX(), pin.SE3.Identity(), HEAD_JOINTS[1])
    centre, log = np.array([0.0, 0.0, -head.length]), head.log_inertia
    tensor = np.diag([head.inertia, head.inertia + log, log])
    model.appendBodyToJoint(hook, pin.Inertia(head.mass, centre, tensor), pin.SE3.Identity())
    return model


@pytest.mark.parametrize("build", [library_model, model_by_hand], ids=["URDF", "by hand"])
@pytest.mark.parametrize(
    "machine",
    [variant(C180, **HANGING), variant(C180, **(HANGING | {"log": LONG_LOG})), variant(LOADER)],
    ids=["c180_hoses", "c180_hoses with a long log", "loader"],
)
def test_hanging_head_moves_as_in_the_library(machine, build):
    model, m = build(machine), machine.manipulator
    body, head = fold_head(m), hanging_head(m)
    rng = np.random.default_rng(12)
    for _ in range(COUNT):
        q, u = rng.uniform(-3.0, 3.0, 5), rng.normal(0.0, 1.0, 5)
        q[4] *= 0.45
        theirs = library_terms(model, (*DRIVEN, *HEAD_JOINTS), FROM_ABSOLUTE @ q, FROM_ABSOLUTE @ u)
        d = dynamics(tuple(q[:3]), tuple(u[:3]), body)
        p = pendulum_dynamics(tuple(q[:3]), tuple(u[:3]), tuple(q[3:]), tuple(u[3:]), head, body)
        crane = [
            [d.m_11 + p.m_11, p.m_12, p.m_13],
            [p.m_12, d.m_22 + p.m_22, d.m_23 + p.m_23],
            [p.m_13, d.m_23 + p.m_23, d.m_33 + p.m_33],
        ]
        own = np.diag([p.m_alpha, p.m_beta])
        mass = np.block([[np.array(crane), np.array(p.coupling)], [np.transpose(p.coupling), own]])
        assert_close(mass, FROM_ABSOLUTE.T @ theirs[0] @ FROM_ABSOLUTE)
        assert_close([*np.add(d.bias, p.crane_bias), *p.head_bias], FROM_ABSOLUTE.T @ theirs[1])

"""Appendix B of the thesis, misprints corrected, written out on its own: the coded plant's reference.

Nothing here comes from the packages under test. It follows Appendix B's arithmetic (long sums, the swing's
nested resistances of eq. 3.8), so that an error in the plant's shorter forms cannot repeat itself here.
"""

import numpy as np
from numpy import arccos, cos, pi, sign, sin, sqrt


def state_derivative(x, c_r, p_s):  # noqa: PLR0915
    """Return xdot for 18 states, six orifice resistances and the supply pressure [Pa], platform level."""
    x = np.concatenate(([0.0], np.asarray(x, dtype=float)))  # the thesis counts from 1
    cr1_sw, cr2_sw, cr1_bm, cr2_bm, cr1_sk, cr2_sk = c_r
    g = 9.81
    m3s, m4, m2, m1 = 544.32, 700.0, 635.04, 907.2
    m3 = m3s + m4
    x3s, y3s = 1.6971698, 0.193368
    l1, l2, l3 = 0.1524, 4.118356, 4.2991
    x3, y3 = (m3s * x3s + m4 * l3) / m3, m3s * y3s / m3
    x2, y2, x1 = 1.9882162, 0.1453077, 0.053975
    l1s, l2s, l1b, l2b = 1.933956, 0.884292, 0.5625397, 1.786382
    si1, si2, delta = 2.5 * pi / 180, 0.31 * pi / 180, 61.7 * pi / 180
    offset = sqrt((x3 - x3s) ** 2 + (y3 - y3s) ** 2)
    i3zz = 867.20018 + m3s * offset**2 + m4 * ((l3 - x3) ** 2 + y3**2)
    i3yy = 535.22412 + m3s * (x3 - x3s) ** 2 + m4 * (l3 - x3) ** 2
    i2zz, i2yy, i1zz = 833.6518, 756.0469, 27.524792

    s23, c23 = sin(x[7] + x[13]), cos(x[7] + x[13])
    s2, c2, s3, c3 = sin(x[7]), cos(x[7]), sin(x[13]), cos(x[13])
    m11 = (
        m3
        * (
            l1**2
            + l2**2 * c2**2
            + x3**2 * c23**2
            + y3**2 * s23**2
            + 2 * l1 * l2 * c2
            + 2 * l1 * x3 * c23
            - 2 * l1 * y3 * s23
            + 2 * l2 * x3 * c2 * c23
            - 2 * l2 * y3 * c2 * s23
            - 2 * x3 * y3 * s23 * c23
        )
        + m2
        * (
            l1**2
            + y2**2 * s2**2
            + x2**2 * c2**2
            + 2 * l1 * x2 * c2
            - 2 * x2 * y2 * s2 * c2
            - 2 * l1 * y2 * s2
        )
        + m1 * x1**2
        + i1zz
        + i2yy * c2**2
        + i3yy * c23**2
    )
    m22 = (
        m3 * (x3**2 + y3**2 + l2**2 + 2 * l2 * x3 * c3 - 2 * l2 * y3 * s3)
        + m2 * (x2**2 + y2**2)
        + i3zz
        + i2zz
    )
    m23 = m3 * (x3**2 + y3**2 + l2 * x3 * c3 - l2 * y3 * s3) + i3zz
    m33 = m3 * (x3**2 + y3**2) + i3zz
    mass = np.array([[m11, 0, 0], [0, m22, m23], [0, m23, m33]])
    g2 = (m3 * (l2 * c2 + x3 * c23 - y3 * s23) + m2 * (x2 * c2 - y2 * s2)) * g
    g3 = m3 * (x3 * c23 - y3 * s23) * g
    a = l1 * x3 * s23 + l1 * y3 * c23 + l2 * y3 * c2 * c23 + x3 * y3 * (c23**2 - s23**2) + l2 * x3 * c2 * s23
    a = a + (x3**2 - y3**2) * s23 * c23
    v1_boom = -2 * m3 * (a + l1 * l2 * s2 + l2**2 * s2 * c2 + l2 * x3 * s2 * c23 - l2 * y3 * s2 * s23)
    v1_boom += -2 * m2 * (l1 * x2 * s2 + l1 * y2 * c2 + x2 * y2 * (c2**2 - s2**2) + (x2**2 - y2**2) * s2 * c2)
    v1_boom += -2 * i2yy * s2 * c2 - 2 * i3yy * s23 * c23
    v1_stick = -2 * m3 * a - 2 * i3yy * s23 * c23
    v1 = v1_boom * x[2] * x[8] + v1_stick * x[2] * x[14]
    turn = m3 * l2 * (x3 * s3 + y3 * c3)
    v2 = -v1_boom / 2 * x[2] ** 2 - 2 * turn * x[8] * x[14] - turn * x[14] ** 2
    v3 = -v1_stick / 2 * x[2] ** 2 + turn * x[8] ** 2

    r_sw, c_sw, i_sw = 3.0329e8 / 4, 1.585e-12 / 4, 3.062e7 / 4
    d_m, n = 4.5064e-5 / (2 * pi), 35.16 * 82 / 13
    ri, re1, re2 = 8.035e11, 2.119e12, 2.119e12
    big_a = 1 / (1 / r_sw + 1 / r_sw + 1 / re1 + 1 / re2)
    big_b = 1 / (1 / ri + 1 / r_sw + 1 / re1)
    big_c = (x[3] - x[4]) / r_sw - x[4] / re1 - n * d_m * x[2]
    big_d = 1 / (1 / big_b - big_a * (1 / r_sw + 1 / re1) ** 2)
    pr1 = big_d * (big_c - big_a * (1 / r_sw + 1 / re1) * ((x[3] - x[4]) / r_sw - x[4] / re1 - x[4] / re2))
    pr2 = big_a * ((x[3] - pr1 - x[4]) / r_sw - (pr1 + x[4]) / re1 - x[4] / re2)
    t_sw = n * d_m * pr1 - 2.4964e4 * x[2]

    gy1, gy2, b = 1.824e-2, 1.368e-2, 1.0303e5
    xb = sqrt(l1b**2 + l2b**2 - 2 * l1b * l2b * cos(x[7] + delta + si2))
    arm_bm = l1b * sin(arccos((l1b**2 + xb**2 - l2b**2) / (2 * l1b * xb)))
    xs = sqrt(l1s**2 + l2s**2 + 2 * l1s * l2s * cos(x[13] + si1))
    arm_sk = l1s * sin(arccos((l1s**2 + xs**2 - l2s**2) / (2 * l1s * xs)))
    r = 4.987e5**2
    ratios = {"bm": (1.6 / 4, 2.2 / 4), "sk": (3.8 / 4, 4.9 / 4)}

    def cylinder_torque(arm, rate, p1, p2, ratio):
        v = arm * rate
        force = gy1 * (p1 - r * ratio[0] * (gy1 * v) ** 2 * sign(v))
        return arm * (force - gy2 * (r * ratio[1] * (gy2 * v) ** 2 * sign(v) + p2) - b * v)

    t_bm = cylinder_torque(arm_bm, x[8], x[9], x[10], ratios["bm"])
    t_sk = cylinder_torque(arm_sk, x[14], x[15], x[16], ratios["sk"])
    acceleration = np.linalg.solve(mass, [t_sw - v1, t_bm - v2 - g2, t_sk - v3 - g3])

    def cylinder_rates(at, arm, rate, ratio, power, cr1, cr2):
        v, (k1, k2) = arm * rate, (ratio[0] ** power, ratio[1] ** power)
        p1, p2, q1, q2 = x[at : at + 4]
        return [
            (q1 - gy1 * v) / (1.585e-12 * k1),
            (gy2 * v - q2) / (1.585e-12 * k2),
            (p_s - cr1 * q1**2 * sign(q1) - p1) / (3.062e7 * k1),
            (p2 - cr2 * q2**2 * sign(q2)) / (3.062e7 * k2),
        ]

    inner = (x[3] - pr1 - pr2 - x[4]) / r_sw
    swing = [
        (x[5] - inner) / c_sw,
        (inner - (pr1 + pr2 + x[4]) / re1 - (x[4] + pr2) / re2 - x[6]) / c_sw,
        (p_s - cr1_sw * x[5] ** 2 * sign(x[5]) - x[3]) / i_sw,
        (x[4] - cr2_sw * x[6] ** 2 * sign(x[6])) / i_sw,
    ]
    boom = cylinder_rates(9, arm_bm, x[8], ratios["bm"], 1, cr1_bm, cr2_bm)
    stick = cylinder_rates(15, arm_sk, x[14], ratios["sk"], 2, cr1_sk, cr2_sk)
    return np.array(
        [x[2], acceleration[0], *swing, x[8], acceleration[1], *boom, x[14], acceleration[2], *stick]
    )

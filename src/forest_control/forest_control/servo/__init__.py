"""The schemes' loops: from a tip velocity to joint rates, closed on the tip's position.

- `schemes`: The control laws: joint rates, inverse kinematics, resolved rates (Jacobian), coordinated.
- `coordinated_servo`: What `coordinated` adds to its law: reference, integral, joints that hold.
- `gain_rule`: Its gains from the machine file.
- `swing_feedforward`, `arm_feedforward`: Rates that the compression of the oil costs, fed forward.
- `inching`: Short valve openings that bring a joint at rest to its reference.
- `stalled_joints`: Joints that stand all at once keep their references near.
- `overspeed_limit`: A bound on the command of a joint that is faster than its reference.
- `joint_angle_filter`: The measured angles: resolvers, corrected by the cylinders' lengths.
- `link_bending`: The angles of links that bend.
- `anti_sway`: A filter of the tip's velocity that leaves the hanging head at rest.

The Jacobian is in `forest_description.geometry.kinematics`.
"""

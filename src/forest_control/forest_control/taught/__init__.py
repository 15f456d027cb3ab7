"""Taught work: poses and paths of the tip that a person taught by driving, and that the crane repeats.

**What the person keeps.** The deadman on /joy must be held all the time: only a person moves the crane. Any
stick that moves pauses at once, and a run that was broken off goes on only when a person says so.

**How a command reaches the valves.** The player does not imitate a joystick: then the deadman would pass
through a program. It publishes on `tip/taught_command` a piece of the path near the tip: a place, the
direction and the curvature there, a speed, and the way left. The controller's command stage follows that
piece instead of centred levers (`operator.taught_command`). All that comes after it is as for levers: walls,
limits, scheme, stop. `safety.taught_watch` says when a command counts.

**Why the path is kept and the time gives.** The command holds no time. The controller looks up where its own
reference is beside the path, goes along it, and back to it. A limit that slows the tip slows it along the
path. Delays do not count either: a place that is said late is still a place of the path.

**Why services and no action.** An action needs interfaces of its own, which the ROS wheels do not have.
Trigger services, the parameter `cycle` and the topic `cycle/status` do without. Only for a program's joint
trajectory there is a standard one; it is offered where its package, control_msgs, is installed.

**The grapple.** The player does not move it. A step of the grapple is published on /events, and waits for a
person's confirmation, or for a time. In the simulator a person grasps and drops logs by its services.

In the order in which data passes:

- `tip_path`: A curve through waypoints, and the speed that it allows.
- `cycle`: A cycle: poses, paths and steps of the grapple, each with a name.
- `cycle_file`: The file of a cycle, for people to edit.
- `teaching`: A path that was driven becomes one of few waypoints.
- `plan`: What the crane will do, from where it is; what is out of its reach is refused here.
- `joint_trajectory`: A program's joint trajectory becomes a leg of that plan.
- `player`: Leads the tip through the plan, piece by piece.
- `editing`: Segments of a cycle are changed, moved and deleted.
- `taught_status`: Where the player is, and what a person is waited for.
- `taught_work`: What a person does with all that: teach, play, pause, resume.
- `trajectory_goals`: A program's trajectories: heard on the topic, or goals of the action.
- `twist_follower`: Beside the player: a program's tip velocity, under the same deadman.

May import: `pipeline` and the rooms below it.
"""

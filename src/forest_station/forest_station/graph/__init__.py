"""The ROS side of the station: signals, parameters, services, the joystick's messages."""

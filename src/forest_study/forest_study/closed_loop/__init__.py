"""Machine, controller and driver in one loop without ROS, interpreted or compiled."""

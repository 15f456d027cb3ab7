"""What the crane is: parameters, cylinder linkage, tip kinematics, valve law, limits and URDF."""

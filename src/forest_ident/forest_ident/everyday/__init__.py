"""What an hour of everyday work tells of the machine, without experiments: has it drifted?"""

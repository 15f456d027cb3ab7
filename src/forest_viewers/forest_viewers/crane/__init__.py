"""The crane as a viewer draws it: all joints, frames, trails, work area; pure."""

// The driven joints, in the order of every array that has one number per axis.

export const AXES = ["swing", "boom", "stick"];

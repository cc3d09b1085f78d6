"""Inverse kinematics: closed forms where the geometry has one, else from many starts; inverse rates; singularities."""

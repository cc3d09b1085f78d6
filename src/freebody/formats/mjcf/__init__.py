"""MJCF, the format of MuJoCo, read through MuJoCo's own parser (the extra freebody[mjcf])."""

"""The robot itself: parameters, joints, inertias and the frozen `Model` made of them."""

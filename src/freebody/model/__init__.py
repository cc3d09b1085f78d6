"""What a robot is: parameters, joints, inertias and the frozen `Model` made of them."""

"""States at which claims are compared in numbers: loops closed, the equations of motion obeyed."""

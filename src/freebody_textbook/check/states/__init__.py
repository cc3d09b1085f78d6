"""States for numeric comparison of claims: loops closed, equations of motion satisfied."""

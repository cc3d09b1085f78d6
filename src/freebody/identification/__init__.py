"""Identification: from the logs of a real robot to the numbers of its model."""

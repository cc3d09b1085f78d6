"""The fastest motions along paths."""

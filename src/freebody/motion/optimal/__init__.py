"""The quickest motions along paths."""

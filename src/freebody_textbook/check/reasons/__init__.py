"""Explanations of wrong answers: misconceptions, misreadings, small changes that would correct
them."""

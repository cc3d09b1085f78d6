"""Why an answer is wrong: misconceptions, misreadings, small changes and what mends them."""

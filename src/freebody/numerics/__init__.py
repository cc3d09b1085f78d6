"""The public numeric functions: validate, fetch the compiled kernel, call it."""

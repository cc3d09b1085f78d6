"""Control laws and observers over scalars, a file each. None keeps a state: what one remembers from
call to call is an input and an output."""

"""Motors, gears and bearings: what they must give over a duty cycle, how long they live, and which
of a catalogue to choose."""

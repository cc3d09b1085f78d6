"""Machine code for this CPU: programs as LLVM vector code, compiled, kept on disk, loaded and
called."""

"""Machine code for this CPU: programs as LLVM vector code, compiled, cached on disk, loaded and
called."""

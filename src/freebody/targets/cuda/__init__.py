"""NVIDIA's GPUs: programs as PTX by LLVM, a sample a thread; what launches it needs the driver and
nothing else."""

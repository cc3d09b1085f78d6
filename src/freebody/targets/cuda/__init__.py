"""NVIDIA's GPUs: programs as PTX by LLVM, with a thread for each sample; launching them needs only
the driver."""

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Status codes of a GPU, a block of the numbers of `ellgran.h`.

/// Block 300 to 399, GPUs: the library of NVIDIA's driver (libcuda.so.1) is not to be found.
pub const ELLGRAN_GPU_ERROR_NO_DRIVER: i32 = 300;
/// The driver is older than the kernels need.
pub const ELLGRAN_GPU_ERROR_OLD_DRIVER: i32 = 301;
/// There is no such device, or none at all.
pub const ELLGRAN_GPU_ERROR_NO_DEVICE: i32 = 302;
/// The device is of an older generation than the kernels are for.
pub const ELLGRAN_GPU_ERROR_OLD_DEVICE: i32 = 303;
/// The driver's assembler refuses the kernels; the message has its words.
pub const ELLGRAN_GPU_ERROR_ASSEMBLER: i32 = 304;
/// The device has too little memory.
pub const ELLGRAN_GPU_ERROR_MEMORY: i32 = 305;
/// A kernel has been ended by the device, which then has lost all that was in its memory: an index out of range, a pointer to something
/// else than the device's memory, or a scene that was changed in a way that is not allowed.
pub const ELLGRAN_GPU_ERROR_KERNEL: i32 = 306;
/// No kernel serves these laws.
pub const ELLGRAN_GPU_ERROR_LAWS: i32 = 307;
/// A pointer is not one to the device's memory.
pub const ELLGRAN_GPU_ERROR_POINTER: i32 = 308;
/// Another failure of the driver; the message has its name.
pub const ELLGRAN_GPU_ERROR_DRIVER: i32 = 309;

//! How the memory allocator of the system treats memory that is freed.
//!
//! Structures come one after the other, and each needs grids of a few megabytes. glibc gives such memory
//! back to the system every time it is freed, and the system clears it at every allocation: 8 % of
//! the CPU time of `voxelize`. So the command tells glibc to keep up to 64 MB of freed memory.
//! A program that calls protomer from Python keeps its own settings.

/// Keeps freed memory for the next structure, unless `GLIBC_TUNABLES` is set: then the user decides.
/// Only glibc needs to be told. Call it before there are other threads.
pub fn keep_freed_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    if std::env::var_os("GLIBC_TUNABLES").is_none() {
        glibc::keep_freed_memory();
    }
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod glibc {
    /// Size from which blocks are given back when they are freed, bytes.
    const LARGE_BLOCK_BYTES: i32 = 4 << 20;
    /// Free memory that is kept per arena, bytes.
    const KEPT_BYTES: i32 = 64 << 20;

    pub fn keep_freed_memory() {
        // SAFETY: mallopt only stores numbers in the allocator's settings, and refuses a value out of
        // range. It must not run while other threads do: `main` calls this before there are any.
        unsafe {
            libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE_BLOCK_BYTES);
            libc::mallopt(libc::M_TRIM_THRESHOLD, KEPT_BYTES);
        }
    }
}

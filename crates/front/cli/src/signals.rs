//! Signals that would end the process without a word.

/// Lets a write beyond the limit of the size of files (`ulimit -f`) fail with an error, which names the file and what to
/// do, instead of the signal SIGXFSZ, which ends the process. Python does the same.
pub fn report_large_files() {
    #[cfg(unix)]
    // SAFETY: `signal` with SIG_IGN only changes how the process takes this signal; no handler of ours runs. `main`
    // calls this before there are other threads.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}

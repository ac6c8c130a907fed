//! Tests of what the system counts for a whole process: its memory, and the bytes that it reads.

use std::process::Command;

/// Set in the process of one test.
const ALONE: &str = "DCB_TEST_ALONE";

/// Runs a test's body in a process of its own: this program again, for this test only. The test has to give its body as a closure
/// that is written in it: that's how it is found.
///
/// # Panics
/// The test fails there, or isn't found there.
pub fn alone<F: FnOnce()>(body: F) {
    run(body, || ());
}

/// The same, in a process that must not have had this much memory when the test ends, bytes.
///
/// # Panics
/// The test fails there, or isn't found there.
pub fn alone_within<F: FnOnce()>(memory: u64, body: F) {
    run(body, || {
        let taken = peak_memory();
        assert!(taken < memory, "{taken} bytes");
    });
}

fn run<F: FnOnce()>(body: F, finally: impl FnOnce()) {
    if std::env::var_os(ALONE).is_some() {
        body();
        return finally();
    }
    let place = std::any::type_name::<F>().trim_end_matches("::{{closure}}");
    let (_, test) = place.split_once("::").expect("a path within its program");
    let output = Command::new(std::env::current_exe().expect("this program's path"))
        .env(ALONE, "1")
        .args([test, "--exact", "--nocapture", "--include-ignored"])
        .output()
        .expect("this program starts again");
    let said = String::from_utf8_lossy(&output.stdout);
    print!("{said}");
    assert!(
        output.status.success() && said.contains("test result: ok. 1 passed"),
        "{test}, alone: {said}{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

/// The most memory that this process has had, bytes.
///
/// # Panics
/// The system doesn't tell.
pub fn peak_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("the system tells");
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    let kibibytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<u64>().ok());
    kibibytes.expect("a number of kB") << 10
}

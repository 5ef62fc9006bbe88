//! Whether there is room in memory for what will be held: a sentence before the work begins, in place of a machine that swaps or a process that
//! the system ends.

use crate::memory::held;
use crate::number;
use anyhow::{Result, bail};
use prt_transfer::{Extent, Footprint, LightBasis, Method, Shape};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// What helps where a matrix is too large.
pub const SMALLER_MATRIX: &str =
    "fewer vertices, responses or texels of light make it smaller (precompute --vertices, --basis cubemap:16 or sh:5)";
/// What helps where a method is too much for a matrix.
pub const OTHER_METHOD: &str =
    "other methods need less (prt methods --limits BYTES lists them), and so does a smaller matrix";

/// What `--max-memory` leaves to the program.
static LIMIT: OnceLock<u64> = OnceLock::new();
/// See [`leave_out`].
static LEFT_OUT: AtomicU64 = AtomicU64::new(0);

/// Sets the most that the program may hold, in place of what the system has; the first call counts.
pub fn limit(bytes: u64) {
    LIMIT.get_or_init(|| bytes);
}

/// Leaves bytes out of what `--max-memory` counts: what a library keeps for each thread is no choice of a matrix or a method.
pub fn leave_out(bytes: u64) {
    LEFT_OUT.fetch_add(bytes, Relaxed);
}

/// Bytes that can still be asked for: what `--max-memory` leaves, or what the system and its control group have. `None` where neither says.
pub fn free() -> Option<u64> {
    match LIMIT.get() {
        Some(limit) => Some(limit.saturating_sub((held() as u64).saturating_sub(LEFT_OUT.load(Relaxed)))),
        None => [available(), of_group()].into_iter().flatten().min(),
    }
}

/// Refuses what needs more than is free. `what` needs it, `instead` says what helps.
pub fn check(what: &str, needed: u64, instead: &str) -> Result<()> {
    match free() {
        Some(free) if needed > free => {
            let [needed, free] = [needed, free].map(number::bytes);
            bail!("{what} needs about {needed} of memory, and {free} are free: {instead}")
        }
        _ => Ok(()),
    }
}

/// What compressing takes beside the matrix, its file included: the result is in memory in up to three forms while it is written.
pub fn of_encoding(footprint: Footprint) -> u64 {
    footprint.peak.max(3 * footprint.result)
}

/// Refuses a method that needs more than is free, on a matrix that is there or, where it still has to be read, with it.
///
/// # Errors
/// A basis that the method's light transform is not defined on.
pub fn check_method(method: &Method, extent: &Extent, basis: &LightBasis, matrix: u64) -> Result<()> {
    let Some(footprint) = method.footprint(extent, basis)? else { return Ok(()) };
    let Shape { samples, responses, lights } = extent.shape;
    let what = format!("{} on {samples} x {responses} x {lights}", method.label());
    check(&what, matrix.saturating_add(of_encoding(footprint)), OTHER_METHOD)
}

/// What Linux would give without swapping.
fn available() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(1024 * line.trim().strip_suffix(" kB")?.parse::<u64>().ok()?)
}

/// What the control group and those above it leave: the least of their limits, each less what is used and cannot be reclaimed.
fn of_group() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let group = groups.lines().find_map(|line| line.strip_prefix("0::/"))?;
    let root = Path::new("/sys/fs/cgroup");
    let own: PathBuf = root.join(group);
    own.ancestors().take_while(|path| path.starts_with(root)).filter_map(left_of).min()
}

fn left_of(group: &Path) -> Option<u64> {
    let number = |name: &str| std::fs::read_to_string(group.join(name)).ok()?.trim().parse::<u64>().ok();
    let cached = std::fs::read_to_string(group.join("memory.stat")).unwrap_or_default();
    let cached = cached.lines().find_map(|line| line.strip_prefix("inactive_file ")?.parse::<u64>().ok());
    // "max" is no number, and no limit.
    let used = number("memory.current")?.saturating_sub(cached.unwrap_or(0));
    Some(number("memory.max")?.saturating_sub(used))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_control_group_leaves_is_its_limit_less_what_cannot_be_reclaimed() {
        let group = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(group.path().join(name), text).unwrap();
        assert_eq!(left_of(group.path()), None);
        write("memory.max", "max\n");
        write("memory.current", "700\n");
        assert_eq!(left_of(group.path()), None);
        write("memory.max", "1000\n");
        assert_eq!(left_of(group.path()), Some(300));
        write("memory.stat", "anon 5\ninactive_file 200\n");
        assert_eq!(left_of(group.path()), Some(500));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_system_says_what_is_free_and_only_more_than_that_is_refused() {
        let free = free().unwrap();
        assert!(free > 1 << 20 && check("nothing", 0, "").is_ok());
        let message = check("a wish", u64::MAX, "ask for less").unwrap_err().to_string();
        assert!(
            message.starts_with("a wish needs about ") && message.ends_with(" are free: ask for less"),
            "{message}"
        );
    }
}

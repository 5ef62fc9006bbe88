//! Ctrl-C: the first one stops the work at its next step, as [`Progress`] promises; a second one ends the program at once.

use crate::terminal;
use anyhow::anyhow;
use prt_transfer::{Error, Progress, Result};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, OnceLock};

/// What the program ends with after an interruption: 128 and the number of SIGINT, as shells expect it.
pub const EXIT_CODE: u8 = 130;

/// Set by a signal.
static ASKED: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Listens from now on. Where the system has no such signals, Ctrl-C ends the program as it always did.
pub fn listen() -> std::io::Result<()> {
    let asked = ASKED.get_or_init(Arc::default);
    for signal in [SIGINT, SIGTERM] {
        // In this order: the first signal finds the flag down and raises it, the second finds it up and ends the program.
        flag::register_conditional_shutdown(signal, EXIT_CODE.into(), Arc::clone(asked))?;
        flag::register(signal, Arc::clone(asked))?;
    }
    Ok(())
}

/// [`Error::Cancelled`] where the user has asked to stop.
pub fn check() -> Result<()> {
    match ASKED.get().is_some_and(|asked| asked.load(Relaxed)) {
        true => Err(Error::Cancelled),
        false => Ok(()),
    }
}

/// Shows nothing, and stops when the user asks for it.
pub struct Unseen;

impl Progress for Unseen {
    fn advance(&self, _: u64) -> Result<()> {
        check()
    }
}

/// Whether a failure is an interruption.
pub fn is_cause_of(error: &anyhow::Error) -> bool {
    let is = |cause: &(dyn std::error::Error + 'static)| matches!(cause.downcast_ref(), Some(Error::Cancelled));
    error.chain().any(is)
}

/// Where a failure is an interruption, it says what is kept and how to go on.
pub fn keeping<T>(result: anyhow::Result<T>, kept: impl FnOnce() -> String) -> anyhow::Result<T> {
    result.map_err(|error| if is_cause_of(&error) { anyhow!(Error::Cancelled).context(kept()) } else { error })
}

/// What is kept of parts that are finished in their order, so many of them, and which are not there.
pub fn parts(names: &[&str], finished: usize, what: &str, folder: &Path) -> String {
    let (all, missing) = (names.len(), names[finished.min(names.len())..].join(", "));
    format!("{finished} of {all} {what} are in {}; missing: {missing}", folder.display())
}

/// What is kept where a command writes one file.
pub fn whole(output: &Path) -> String {
    format!("{} is as it was; the same command begins anew", output.display())
}

/// Tells of an interruption, in one sentence.
pub fn tell(error: &anyhow::Error) {
    let usual = "files that were finished are kept, and no other was changed".to_string();
    let kept = if error.chain().len() > 1 { error.to_string() } else { usual };
    terminal::remark(format!("prt: interrupted: {kept}"));
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context;

    #[test]
    fn an_interruption_is_known_under_any_context_and_nothing_else_is_taken_for_one() {
        let cancelled = || anyhow!(Error::Cancelled);
        assert!(is_cause_of(&cancelled().context("a").context("b")) && !is_cause_of(&anyhow!("cancelled")));
        let kept = keeping::<()>(Err(cancelled()).context("a detail"), || "3 of 4".into()).unwrap_err();
        assert!(is_cause_of(&kept) && kept.to_string() == "3 of 4");
        let failed = keeping::<()>(Err(anyhow!("disk full")), || "3 of 4".into()).unwrap_err();
        assert_eq!(failed.to_string(), "disk full");
        assert_eq!(parts(&["a", "b", "c"], 1, "parts", Path::new("d")), "1 of 3 parts are in d; missing: b, c");
    }
}

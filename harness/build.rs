//! Captures what every figure must name: the compiler and the commit.

use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    for name in ["HEAD", "logs/HEAD"] {
        if let Some(path) = output("git", &["rev-parse", "--git-path", name]) {
            // Relative to the folder of this script, where cargo runs it and git answers.
            println!("cargo:rerun-if-changed={path}");
        }
    }
    let compiler = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let unknown = || "unknown".to_string();
    println!("cargo:rustc-env=PRT_COMPILER={}", output(&compiler, &["--version"]).unwrap_or_else(unknown));
    println!(
        "cargo:rustc-env=PRT_COMMIT={}",
        output("git", &["describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]).unwrap_or_else(unknown)
    );
}

/// The first line that a command prints; `None` where it cannot run or fails.
fn output(command: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(command).args(arguments).output().ok().filter(|o| o.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.lines().next()?.trim().to_string())
}

//! `prt bench --verify`: errors and sizes of a finished bench, computed anew from its files by a decoder that shares no code
//! with this program (`benches/peers/decode.py`).

mod check;
mod decoder;
mod findings;
mod plan;

use crate::bench::Group;
use crate::progress::Steps;
use crate::row::Row;
use crate::terminal;
use anyhow::{bail, ensure};
use clap::Args;
use findings::{Finding, Findings};
use plan::{Plan, Work};
use std::path::{Path, PathBuf};

/// What `prt bench` is told of it.
#[derive(Args, Debug)]
pub struct Verify {
    /// Compute errors and sizes anew from the files, by an independent decoder in Python (NumPy, zstd); verified.csv says how they compare
    #[arg(long)]
    pub verify: bool,
    /// The Python that runs the decoder
    #[arg(long, value_name = "PATH", default_value = "python3", requires = "verify")]
    pub python: PathBuf,
}

impl Verify {
    /// Compares `rows`, those of results.csv, with what the files of `groups` in `out` say, in so many processes. The table goes to standard error
    /// where `json` has standard output.
    ///
    /// # Errors
    /// The first row that disagrees, by name; a decoder that does not run; nothing to verify.
    pub fn run(&self, out: &Path, groups: &[Group], rows: &[Row], threads: usize, json: bool) -> anyhow::Result<()> {
        let plan = Plan::new(out, groups, rows);
        ensure!(!plan.works.is_empty(), "no row of {} can be verified: {}", out.display(), plan.first_reason());
        let findings = Findings { rows: self.findings(&plan, threads)?, left_out: plan.left_out };
        let path = out.join("verified.csv");
        findings.write(&path)?;
        match json {
            true => terminal::remark(findings.text()),
            false => terminal::say(findings.text())?,
        }
        match findings.first_disagreement() {
            Some(sentence) => bail!("{sentence}; {} has every figure", path.display()),
            None => Ok(()),
        }
    }

    /// What the decoder finds for each work, in their order.
    fn findings(&self, plan: &Plan, threads: usize) -> anyhow::Result<Vec<Finding>> {
        let steps = Steps::new(plan.works.len());
        steps.show("verify");
        let mut found: Vec<Option<Finding>> = plan.works.iter().map(|_| None).collect();
        let ran = decoder::run(&self.python, &plan.works, threads, |answer| {
            let Some(Work { row, .. }) = plan.works.get(answer.job) else {
                bail!("decode.py answered for job {}, of {}", answer.job, plan.works.len());
            };
            found[answer.job] = Some(Finding::new(row, &answer)?);
            steps.show(&format!("verify {} {} {}", row.scene, row.signal, row.method));
            steps.done(1);
            Ok(())
        });
        steps.finish();
        ran?;
        let of = |(work, finding): (&Work, Option<Finding>)| {
            finding.ok_or_else(|| anyhow::anyhow!("decode.py said nothing of {}", work.row.method))
        };
        plan.works.iter().zip(found).map(of).collect()
    }
}

//! The command line: exit 0 done, 1 failed with one sentence, 2 wrong usage, 130 interrupted.

use crate::{
    bench, coherence, decode, encode, figures, fit_light, info, interchange, interrupt, light_field, list, number,
};
use crate::{precompute, relight, render, room, select, stability, tables, terminal};
use anyhow::Context;
use clap::{Parser, Subcommand};
use std::path::Path;
use std::process::ExitCode;

/// Measures, compresses and relights precomputed radiance transfer.
#[derive(Parser, Debug)]
#[command(
    name = "prt",
    version,
    after_help = "Examples:\n  prt bench --quick\n  prt bench --scene teapot --method csr --method haar+truncate:terms=64"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Threads to work on [default: all]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Refuse what needs more memory than this, such as 8GB, matrix included [default: what the system has free]
    #[arg(long, global = true, value_name = "BYTES", value_parser = number::parse_bytes)]
    max_memory: Option<u64>,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Measures every method on every scene: a table, results.csv, charts and a report
    Bench(bench::Bench),
    /// Computes the transfer matrix of a scene
    Precompute(precompute::Precompute),
    /// Finds the smallest model that keeps an error, or the best within so many bytes or ms
    Select(Box<select::Select>),
    /// Compresses a transfer matrix
    Encode(encode::Encode),
    /// Reconstructs a transfer matrix
    Decode(decode::Decode),
    /// Writes a compressed matrix in a format of others: .pca, the compressed PRT buffer of D3DX
    Export(interchange::Export),
    /// Reads a compressed matrix from a format of others: .pca, the compressed PRT buffer of D3DX
    Import(interchange::Import),
    /// Relights a compressed matrix
    Relight(relight::Relight),
    /// Fits a sum of scattered lobes to a light
    FitLight(fit_light::FitLight),
    /// Rearranges clusters so that fewer triangles straddle them
    Coherence(coherence::Coherence),
    /// Traces and compresses the surface light field of each shape of a world
    Slf(Box<light_field::LightField>),
    /// Draws a scene: relit from a matrix, looked up in surface light fields, or traced
    Render(Box<render::Render>),
    /// Tells what a compressed matrix is and costs
    Info(info::InfoArguments),
    /// Measures the tables of a paper anew, beside what it prints
    Tables(tables::Tables),
    /// Measures the figures of a paper anew, and draws them
    Figures(figures::Figures),
    /// Finds where methods fail: sweeps over one parameter of a matrix, with charts
    Stability(stability::Stability),
    /// Lists the built-in scenes and lights, and the BRDFs with their parameters
    Scenes(list::Scenes),
    /// Lists the light transforms and codecs with their parameters
    Methods(list::Methods),
}

/// Runs the program on the process's arguments.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    match run(&cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if interrupt::is_cause_of(&error) => {
            interrupt::tell(&error);
            interrupt::EXIT_CODE.into()
        }
        Err(error) => {
            // One line, whatever the causes brought with them.
            terminal::remark(format!("prt: {error:#}").replace('\n', " "));
            ExitCode::FAILURE
        }
    }
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    if let Some(bytes) = cli.max_memory {
        room::limit(bytes);
    }
    interrupt::listen().context("cannot listen for Ctrl-C")?;
    let threads = cli.threads.map_or_else(|| std::thread::available_parallelism().map_or(1, |n| n.get()), usize::from);
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    match &cli.command {
        Command::Bench(arguments) => bench::run(arguments, threads),
        Command::Precompute(arguments) => whole(&arguments.output, precompute::run(arguments)),
        Command::Select(arguments) => select::run(arguments, threads),
        Command::Encode(arguments) => whole(&arguments.output, encode::run(arguments)),
        Command::Decode(arguments) => whole(&arguments.output, decode::run(arguments)),
        Command::Export(arguments) => interchange::export(arguments),
        Command::Import(arguments) => interchange::import(arguments),
        Command::Relight(arguments) => relight::run(arguments),
        Command::FitLight(arguments) => fit_light::run(arguments),
        Command::Coherence(arguments) => coherence::run(arguments),
        Command::Slf(arguments) => light_field::run(arguments, threads),
        Command::Render(arguments) => whole(&arguments.output, render::run(arguments)),
        Command::Info(arguments) => info::run(arguments),
        Command::Tables(arguments) => tables::run(arguments, threads),
        Command::Figures(arguments) => figures::run(arguments, threads),
        Command::Stability(arguments) => stability::run(arguments, threads),
        Command::Scenes(arguments) => list::scenes(arguments),
        Command::Methods(arguments) => list::methods(arguments),
    }
}

/// The outcome of a command that writes one file, which an interruption leaves as it was.
fn whole(output: &Path, outcome: anyhow::Result<()>) -> anyhow::Result<()> {
    interrupt::keeping(outcome, || interrupt::whole(output))
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory;
        super::Cli::command().debug_assert();
    }
}

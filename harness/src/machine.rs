//! Where a figure was measured.

use serde::Serialize;
use std::time::{SystemTime, UNIX_EPOCH};

/// Machine, compiler, commit and threads: written beside every chart and table.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// CPU model.
    pub cpu: String,
    /// Processors that the operating system offers.
    pub processors: usize,
    /// Threads of the measurements "on all threads".
    pub threads: usize,
    /// Operating system and architecture.
    pub system: String,
    /// The compiler that built the program.
    pub compiler: &'static str,
    /// Version of the program.
    pub version: &'static str,
    /// Commit of the program, or `unknown`.
    pub commit: &'static str,
    /// Day of the measurement, UTC.
    pub date: String,
}

impl Machine {
    /// This machine, now.
    pub fn here(threads: usize) -> Machine {
        Machine {
            cpu: cpu_model().unwrap_or_else(|| "unknown".into()),
            processors: std::thread::available_parallelism().map_or(1, |n| n.get()),
            threads,
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            compiler: env!("PRT_COMPILER"),
            version: env!("CARGO_PKG_VERSION"),
            commit: env!("PRT_COMMIT"),
            date: today(),
        }
    }

    /// In one line, as it stands under a chart.
    pub fn line(&self) -> String {
        let Machine { cpu, threads, compiler, version, commit, date, .. } = self;
        // "rustc 1.95.0 (59807616e 2026-04-14)" without its hash
        let compiler = compiler.split(" (").next().unwrap_or(compiler);
        format!("{cpu}, {threads} threads · {compiler} · prt {version} {commit} · {date}")
    }
}

fn cpu_model() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|l| l.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_string())
}

fn today() -> String {
    let days = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |t| t.as_secs() / 86_400);
    let (year, month, day) = civil(days as i64);
    format!("{year:04}-{month:02}-{day:02}")
}

/// The Gregorian date of a day counted from 1970-01-01 (H. Hinnant, "chrono-compatible low-level date algorithms", §civil_from_days).
fn civil(days: i64) -> (i64, i64, i64) {
    // Years begin in March, so that the leap day comes last; eras are 400 years.
    let days = days + 719_468;
    let (era, day_of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    (year_of_era + era * 400 + i64::from(month <= 2), month, day)
}

#[cfg(test)]
mod tests {
    use super::civil;

    #[test]
    fn days_become_dates_in_order_over_four_centuries() {
        assert_eq!(civil(0), (1970, 1, 1));
        let leap = |y: i64| y % 4 == 0 && (y % 100 != 0 || y % 400 == 0);
        let (mut day, mut expected) = (0, (1970, 1, 1));
        while expected.0 < 2370 {
            assert_eq!(civil(day), expected);
            let length = match expected.1 {
                2 => 28 + i64::from(leap(expected.0)),
                4 | 6 | 9 | 11 => 30,
                _ => 31,
            };
            expected.2 += 1;
            if expected.2 > length {
                expected = (expected.0, expected.1 + 1, 1);
            }
            if expected.1 > 12 {
                expected = (expected.0 + 1, 1, 1);
            }
            day += 1;
        }
    }
}

//! Numbers as a person reads them.

/// Three significant digits, two where there is an exponent: `0`, `1.5e-3`, `0.0331`, `12.3`, `4520`.
pub fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".into()
    } else if !(1e-2..1e5).contains(&size) {
        format!("{value:.1e}")
    } else {
        // Digits before the point, rounded first, since 9.999 has three digits as 10.0.
        let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
        let digits = rounded.abs().log10().floor() as i32;
        format!("{rounded:.*}", (2 - digits).max(0) as usize)
    }
}

/// Bytes with a decimal unit: `512 B`, `3.20 MB`.
pub fn bytes(count: u64) -> String {
    scaled(count, &["B", "kB", "MB", "GB", "TB"], " ")
}

/// A count with a decimal unit: `512`, `9.40M`.
pub fn count(count: u64) -> String {
    scaled(count, &["", "k", "M", "G", "T"], "")
}

/// Bytes as `200kB`, `1.5MB` or `4096`.
pub fn parse_bytes(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let digits = text.find(|c: char| c.is_ascii_alphabetic() && !"eE".contains(c)).unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let scale = match unit.to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "k" | "kb" => 1e3,
        "m" | "mb" => 1e6,
        "g" | "gb" => 1e9,
        "t" | "tb" => 1e12,
        _ => f64::NAN,
    };
    let count = number.trim().parse::<f64>().map_or(f64::NAN, |number| (number * scale).round());
    match (1.0..1e18).contains(&count) {
        true => Ok(count as u64),
        false => Err("expected bytes, such as 200kB, 1.5MB or 4096".into()),
    }
}

fn scaled(count: u64, units: &[&str], gap: &str) -> String {
    let mut value = count as f64;
    let mut unit = 0;
    // 999.5 would print as 1000
    while value >= 999.5 && unit + 1 < units.len() {
        value /= 1e3;
        unit += 1;
    }
    let number = if unit == 0 { count.to_string() } else { short(value) };
    format!("{number}{gap}{}", units[unit])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (1.4749e-5, "1.5e-5"),
            (0.03312, "0.0331"),
            (9.999, "10.0"),
            (123.4, "123"),
            (4520.0, "4520"),
            (1e5, "1.0e5"),
            (-2.5, "-2.50"),
        ] {
            assert_eq!(short(value), text);
        }
        for (value, text) in
            [(0, "0 B"), (999, "999 B"), (1000, "1.00 kB"), (999_999, "1.00 MB"), (3_204_000, "3.20 MB")]
        {
            assert_eq!(bytes(value), text);
        }
        assert_eq!(count(9_400_000), "9.40M");
    }

    #[test]
    fn bytes_are_read_with_and_without_a_unit() {
        for (text, count) in [("200kB", 200_000), ("1.5MB", 1_500_000), ("4096", 4096), ("2 GB", 2_000_000_000)] {
            assert_eq!(parse_bytes(text), Ok(count), "{text}");
        }
        assert_eq!(parse_bytes("1e3"), Ok(1000));
        for text in ["", "kB", "-3", "0", "5 apples", "nan", "1e30"] {
            assert!(parse_bytes(text).is_err(), "{text}");
        }
    }
}

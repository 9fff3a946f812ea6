//! Numbers for people.

/// `value` with four significant digits, in powers of ten where it is very small or very large.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    if !(1e-4..1e7).contains(&size) {
        let text = format!("{value:.3e}");
        let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{power}", trimmed(digits));
    }
    let decimals = (3 - size.log10().floor() as i64).max(0) as usize;
    trimmed(&format!("{value:.decimals$}")).to_string()
}

/// Without zeros that end a decimal fraction.
fn trimmed(digits: &str) -> &str {
    match digits.contains('.') {
        true => digits.trim_end_matches('0').trim_end_matches('.'),
        false => digits,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.123456, "0.1235"),
            (-12.3456, "-12.35"),
            (123456.0, "123456"),
            (1.2341e-9, "1.234e-9"),
            (1e-6, "1e-6"),
            (3e8, "3e8"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}

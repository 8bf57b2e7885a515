//! Numbers as text, and text as numbers.

/// A number with three significant digits, or more where it is large.
pub fn significant(v: f64) -> String {
    if v.is_infinite() {
        return "∞".into();
    }
    let digits = if v == 0.0 { 0 } else { (2.0 - v.abs().log10().floor()).clamp(0.0, 6.0) as usize };
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_significant_digits() {
        let cases = [(0.0, "0"), (0.012345, "0.0123"), (1.5, "1.5"), (2.0, "2"), (17.36, "17.4"), (3000.0, "3000")];
        for (value, text) in cases {
            assert_eq!(significant(value), text);
        }
    }
}

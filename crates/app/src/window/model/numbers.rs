//! Numbers as text, and text with its unit as numbers.

use defocus::methods::{Quantity, Scale};

/// A number with three significant digits, or more where it is large.
pub fn significant(v: f64) -> String {
    if v.is_infinite() {
        return "∞".into();
    }
    let digits = if v == 0.0 { 0 } else { (2.0 - v.abs().log10().floor()).clamp(0.0, 6.0) as usize };
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A stored value as a number with its unit, or as the name of its class.
pub fn quantity_text(quantity: &Quantity, value: f32) -> String {
    if let Scale::Classes(classes) = quantity.scale
        && let Some((_, name)) = classes.iter().find(|(known, _)| *known == value)
    {
        return (*name).to_owned();
    }
    let shown = f64::from(value * quantity.one);
    let sign = if shown < 0.0 { "−" } else { "" };
    format!("{sign}{}{}", significant(shown.abs()), quantity.unit)
}

/// Lengths by their units, metres.
const LENGTHS_M: [(&str, f64); 7] =
    [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("km", 1e3), ("ft", 0.3048), ("in", 0.0254), ("µm", 1e-6)];

/// What reciprocal metres are called.
const DIOPTRES: [&str; 4] = ["dpt", "d", "dioptre", "dioptres"];

/// A unit that a field understands besides its own, with the value in the field's unit of a
/// number given in it.
#[derive(Clone, Copy)]
pub struct OtherUnit<'a> {
    /// What is typed after the number.
    pub name: &'a str,
    /// The number in the field's own unit.
    pub converted: &'a dyn Fn(f64) -> f64,
}

/// The number that `text` means in a field whose unit is `unit`: with no unit, with the
/// field's own, with another length where that is one (dioptres included), or with one of
/// `others`.
///
/// # Errors
///
/// A sentence that says what is understood.
pub fn parsed(text: &str, unit: &str, others: &[OtherUnit<'_>]) -> Result<f64, String> {
    let (unit, typed) = (unit.trim(), text.trim());
    let typed = typed.strip_prefix("f/").or(typed.strip_prefix("F/")).unwrap_or(typed);
    let (number, suffix) = split(typed);
    let value = number.ok_or_else(|| misunderstood(text, unit, others))?;
    let lower = suffix.to_lowercase();
    if suffix.is_empty() || lower == unit.to_lowercase() || (unit == "°" && lower == "deg") {
        return Ok(value);
    }
    if let Some(other) = others.iter().find(|other| other.name.eq_ignore_ascii_case(suffix)) {
        return Ok((other.converted)(value));
    }
    let length_m = |name: &str| LENGTHS_M.iter().find(|(known, _)| *known == name).map(|(_, metres)| *metres);
    let is_dioptres = |name: &str| DIOPTRES.contains(&name);
    let metres = match (length_m(&lower), is_dioptres(&lower)) {
        (Some(metres), _) => value * metres,
        (None, true) => 1.0 / value,
        (None, false) => return Err(misunderstood(text, unit, others)),
    };
    match (length_m(unit), is_dioptres(unit)) {
        (Some(own), _) => Ok(metres / own),
        (None, true) => Ok(1.0 / metres),
        (None, false) => Err(misunderstood(text, unit, others)),
    }
}

/// A number and what follows it; a comma may stand for the point.
fn split(text: &str) -> (Option<f64>, &str) {
    for infinite in ["∞", "infinity", "inf"] {
        if let Some(rest) = text.strip_prefix(infinite) {
            return (Some(f64::INFINITY), rest.trim());
        }
    }
    let is_part = |(i, c): &(usize, char)| match c {
        '0'..='9' | '.' | ',' | '-' | '+' | '−' => true,
        // An exponent, and not the beginning of a unit.
        'e' | 'E' => text[i + 1..].starts_with(|next: char| next.is_ascii_digit() || next == '-' || next == '+'),
        _ => false,
    };
    let end = text.char_indices().find(|part| !is_part(part)).map_or(text.len(), |(i, _)| i);
    let number = text[..end].replace('−', "-");
    let number = if number.contains('.') { number } else { number.replacen(',', ".", 1) };
    (number.parse().ok(), text[end..].trim())
}

fn misunderstood(text: &str, unit: &str, others: &[OtherUnit<'_>]) -> String {
    let is_length = LENGTHS_M.iter().any(|(known, _)| *known == unit) || DIOPTRES.contains(&unit);
    let lengths: &[&str] = if is_length { &["mm", "cm", "m", "ft", "in", "D"] } else { &[] };
    let own = Some(unit).filter(|unit| !unit.is_empty() && !lengths.contains(unit));
    let known: Vec<&str> =
        own.into_iter().chain(lengths.iter().copied()).chain(others.iter().map(|o| o.name)).collect();
    let units = if known.is_empty() { String::new() } else { format!(", alone or with {}", known.join(", ")) };
    format!("“{}” is not understood: type a number{units}.", text.trim())
}

/// The least of 1, 2 and 5 times a power of ten that is not below `v`: an end for a scale
/// that does not change with every hair. 1 for what is not positive.
pub fn round_above(v: f64) -> f64 {
    if !(v > 0.0 && v.is_finite()) {
        return 1.0;
    }
    let power = 10_f64.powf(v.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
    // Powers are rounded: what equals a step but for that is that step.
    steps.into_iter().find(|step| *step >= v * (1.0 - 1e-9)).unwrap_or(v)
}

/// A number with all of its digits: what is parsed from it is the number.
pub fn exact(v: f64) -> String {
    if v.is_infinite() { significant(v) } else { v.to_string() }
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

    #[test]
    fn ends_of_scales_are_round() {
        for (v, end) in [(6.6, 10.0), (1.0, 1.0), (0.012, 0.02), (2.0, 2.0), (21.0, 50.0), (0.0, 1.0), (f64::NAN, 1.0)]
        {
            assert!((round_above(v) - end).abs() <= 1e-9 * end, "{v}: {}", round_above(v));
        }
    }

    #[test]
    fn text_with_a_unit_is_a_number_of_the_fields_unit() {
        let in_metres = [
            ("60 cm", 0.6),
            ("60cm", 0.6),
            ("0.6", 0.6),
            ("0,6 m", 0.6),
            ("600 mm", 0.6),
            ("2 D", 0.5),
            ("2 dpt", 0.5),
            ("2 ft", 0.6096),
            ("6e-1 m", 0.6),
            ("∞", f64::INFINITY),
            ("inf m", f64::INFINITY),
            ("−2", -2.0),
        ];
        for (text, metres) in in_metres {
            let value = parsed(text, " m", &[]).unwrap_or_else(|e| panic!("{text}: {e}"));
            assert!(value == metres || (value - metres).abs() < 1e-12, "{text}: {value}");
        }
        assert_eq!(parsed("50 cm", " dpt", &[]), Ok(2.0));
        assert_eq!(parsed("0 D", " m", &[]), Ok(f64::INFINITY));
        assert_eq!(parsed("f/2.8", "", &[]), Ok(2.8));
        assert_eq!(parsed("40 deg", " °", &[]), Ok(40.0));
        let doubled = OtherUnit { name: "px/deg", converted: &|v| 2.0 * v };
        assert_eq!(parsed("25 px/deg", " px/mm", &[doubled]), Ok(50.0));
    }

    #[test]
    fn what_is_no_number_is_said_to_be_none() {
        for (text, unit) in
            [("apples", " m"), ("3 apples", " m"), ("", " m"), ("3 cm", " px"), ("nan", ""), ("1.2.3", "")]
        {
            let error = parsed(text, unit, &[]).expect_err(text);
            assert!(error.contains("is not understood: type a number"), "{error}");
        }
        assert!(parsed("x", " m", &[]).is_err_and(|e| e.contains("mm, cm, m, ft, in, D")));
    }

    #[test]
    fn every_value_survives_being_edited() {
        for value in [9.438_990_123_456_7, 1e-9, 0.1 + 0.2, 123_456.789, f64::INFINITY, -0.0625] {
            assert_eq!(parsed(&exact(value), " mm", &[]), Ok(value), "{value}");
        }
    }
}

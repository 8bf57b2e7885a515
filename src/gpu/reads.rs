//! Counting texture reads: each call of `textureLoad`, `textureSample...` or
//! `textureGather...` is multiplied by a 1 whose computation counts it. Shaders that are
//! not compiled this way contain none of it.

/// Name of the counter in shaders that count.
pub(super) const READS_BINDING: &str = "texture_reads";

// Shared shader functions bind in groups of their own, from 0 on.
const COUNTER: &str = "
@group(1) @binding(99) var<storage, read_write> texture_reads: array<atomic<u32>, 2>;
fn counted_read() -> f32 {
    return f32(counted_read_u32());
}
fn counted_read_u32() -> u32 {
    // Whoever takes the low word over its end carries: the high word counts exactly.
    if atomicAdd(&texture_reads[0], 1u) == 0xffffffffu {
        atomicAdd(&texture_reads[1], 1u);
    }
    return 1u;
}
";

/// The source with every texture read counted.
pub(super) fn counting_reads(source: &str) -> String {
    let mut text = String::with_capacity(2 * source.len());
    copy_counting(source, source, &mut text);
    text + COUNTER
}

/// Appends `part` of `source` to `text`.
fn copy_counting(source: &str, mut part: &str, text: &mut String) {
    while let Some(at) = part.find("texture") {
        let comment = part.find("//").filter(|c| *c < at);
        if let Some(comment) = comment {
            let end = part[comment..].find('\n').map_or(part.len(), |length| comment + length);
            text.push_str(&part[..end]);
            part = &part[end..];
            continue;
        }
        let word = part[at..].find(|c: char| !is_word(c)).unwrap_or(part.len() - at);
        let (before, after) = (&part[..at], &part[at + word..]);
        text.push_str(before);
        let name = &part[at..at + word];
        part = after;
        let starts_word = !before.ends_with(is_word);
        let arguments = after.strip_prefix('(').and_then(|inner| Some(&inner[..closing(inner)?]));
        let Some(arguments) = arguments.filter(|_| starts_word && is_read(name)) else {
            text.push_str(name);
            continue;
        };
        let texture = arguments.split(',').next().unwrap_or_default().trim();
        let one = if holds_u32(source, texture) { "counted_read_u32" } else { "counted_read" };
        text.push_str(&format!("({one}() * {name}("));
        copy_counting(source, arguments, text);
        text.push_str("))");
        part = &after[arguments.len() + 2..];
    }
    text.push_str(part);
}

fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

fn is_read(name: &str) -> bool {
    name == "textureLoad" || name.starts_with("textureSample") || name.starts_with("textureGather")
}

/// Whether the texture variable called `name` holds unsigned integers.
fn holds_u32(source: &str, name: &str) -> bool {
    let declared = source.find(&format!("var {name}: "));
    declared.and_then(|at| source[at..].lines().next()).is_some_and(|line| line.contains("<u32>"))
}

/// Where the parenthesis closes that was opened just before `text`.
fn closing(text: &str) -> Option<usize> {
    let mut depth = 1;
    text.char_indices().find_map(|(at, c)| {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ => {}
        }
        (depth == 0).then_some(at)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_are_wrapped_wherever_they_stand() {
        let source =
            "let a = f(1.0 / textureLoad(t, clamp(p, q), 0).r); // textureLoad(\nlet s = textureDimensions(t);\n";
        let counted = counting_reads(source);
        let wanted = "f(1.0 / (counted_read() * textureLoad(t, clamp(p, q), 0)).r); // textureLoad(\n";
        assert!(counted.contains(wanted) && counted.contains("= textureDimensions(t);"), "{counted}");
    }

    #[test]
    fn reads_within_reads_and_of_integers_are_counted_too() {
        let source = "var ids: texture_2d<u32>;\nlet a = textureLoad(t, textureLoad(ids, p, 0).xy, 0);\n";
        let wanted = "(counted_read() * textureLoad(t, (counted_read_u32() * textureLoad(ids, p, 0)).xy, 0))";
        assert!(counting_reads(source).contains(wanted), "{}", counting_reads(source));
    }
}

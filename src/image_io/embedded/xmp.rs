//! Properties out of XMP: attributes, and elements that hold nothing but text. Namespaces are told by
//! their customary prefixes.

/// Properties in the order of the text, by prefix and name.
#[derive(Clone, Debug, Default)]
pub(super) struct Properties {
    all: Vec<(String, String)>,
    /// Where items of a list begin, as indices into `all`.
    starts: Vec<usize>,
}

impl Properties {
    /// Of one packet, or of several one behind the other.
    pub(super) fn of(text: &str) -> Self {
        let mut found = Self::default();
        let mut open: Option<&str> = None;
        let mut rest = text;
        while let Some((before, behind)) = rest.split_once('<') {
            // Text between an element's start and its end is the property of that name.
            if let Some(name) = open.take()
                && behind.starts_with('/')
                && !before.trim().is_empty()
            {
                found.all.push((name.to_owned(), before.trim().to_owned()));
            }
            let Some((tag, after)) = behind.split_once('>') else { break };
            rest = after;
            if tag.starts_with(['/', '?', '!']) {
                continue;
            }
            let name = tag.split(|c: char| c.is_whitespace() || c == '/').next().unwrap_or_default();
            if name == "rdf:li" {
                found.starts.push(found.all.len());
            }
            found.attributes(&tag[name.len()..]);
            open = (!tag.ends_with('/')).then_some(name);
        }
        found
    }

    /// `name="value"` or `name='value'`, as often as they come.
    fn attributes(&mut self, mut tag: &str) {
        while let Some((name, rest)) = tag.split_once('=') {
            let rest = rest.trim_start();
            let Some(quote) = rest.chars().next().filter(|c| ['"', '\''].contains(c)) else { return };
            let Some((value, after)) = rest[1..].split_once(quote) else { return };
            self.all.push((name.trim().to_owned(), value.to_owned()));
            tag = after;
        }
    }

    /// The first property of a name such as `GDepth:Near`.
    pub(super) fn get(&self, name: &str) -> Option<&str> {
        self.all.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    /// The properties of each item of lists.
    pub(super) fn items(&self) -> Vec<Self> {
        let ends = self.starts.iter().skip(1).copied().chain([self.all.len()]);
        let item = |(&start, end): (&usize, usize)| Self { all: self.all[start..end].to_vec(), starts: Vec::new() };
        self.starts.iter().zip(ends).map(item).collect()
    }
}

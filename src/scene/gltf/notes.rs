//! Remarks gathered while loading, one sentence a topic.

/// Names shown per topic; a scene may have thousands of nodes.
const SHOWN_NAMES: usize = 4;

/// Topics in the order of their first appearance, each with what it applies to.
#[derive(Default)]
pub(super) struct Notes {
    topics: Vec<(String, Vec<String>)>,
}

impl Notes {
    /// Notes `topic` about `name`; an empty name stands for the file as a whole.
    pub(super) fn add(&mut self, topic: impl Into<String>, name: impl Into<String>) {
        let (topic, name) = (topic.into(), name.into());
        let found = self.topics.iter().position(|(known, _)| *known == topic);
        let index = found.unwrap_or_else(|| {
            self.topics.push((topic, Vec::new()));
            self.topics.len() - 1
        });
        let names = &mut self.topics[index].1;
        if !name.is_empty() && !names.contains(&name) {
            names.push(name);
        }
    }

    /// One sentence a topic.
    pub(super) fn into_sentences(self) -> Vec<String> {
        self.topics.into_iter().map(|(topic, names)| sentence(&topic, &names)).collect()
    }
}

fn sentence(topic: &str, names: &[String]) -> String {
    if names.is_empty() {
        return topic.to_owned();
    }
    let shown = names[..names.len().min(SHOWN_NAMES)].join(", ");
    match names.len().saturating_sub(SHOWN_NAMES) {
        0 => format!("{topic}: {shown}"),
        more => format!("{topic}: {shown} and {more} more"),
    }
}

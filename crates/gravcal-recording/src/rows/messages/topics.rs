//! The topics of a bag: which of them hold joint states, in which encoding, and how much of them could be read.

use std::collections::{BTreeMap, HashMap};

use crate::rows;

/// How a message is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// Common Data Representation.
    Cdr,
    /// JSON.
    Json,
}

/// The names under which types of joint states go.
pub(crate) const JOINT_STATE: [&str; 3] =
    ["sensor_msgs/msg/JointState", "sensor_msgs/JointState", "sensor_msgs::msg::dds_::JointState_"];

/// Topics in the order of their first appearance.
#[derive(Default)]
pub(crate) struct Topics {
    names: Vec<String>,
    topics: Vec<Topic>,
    places: HashMap<String, usize>,
}

/// What is known of a topic.
#[derive(Default)]
struct Topic {
    kind: String,
    encoding: String,
    messages: u64,
    /// Why messages could not be read, how many of each, and the first.
    malformed: BTreeMap<String, (u64, u64)>,
}

impl Topic {
    fn is_joint_state(&self) -> bool {
        JOINT_STATE.contains(&self.kind.as_str())
    }

    /// Its damaged messages.
    fn damaged(&self, name: &str) -> impl Iterator<Item = String> {
        self.malformed.iter().map(move |(what, (count, first))| {
            let of = self.messages;
            format!("{name}: {count} of {of} messages are damaged and left out ({what}), the first is message {first}")
        })
    }
}

impl Topics {
    /// Notes a topic with the type and the encoding of its messages. Gives its place, and the encoding if they are joint states that can
    /// be read.
    pub(crate) fn add(&mut self, name: &str, kind: String, encoding: &str) -> (usize, Option<Encoding>) {
        let read = match encoding {
            "cdr" => Some(Encoding::Cdr),
            "json" => Some(Encoding::Json),
            _ => None,
        };
        let place = self.places.get(name).copied().unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.topics.push(Topic::default());
            self.places.insert(name.to_owned(), self.topics.len() - 1);
            self.topics.len() - 1
        });
        let topic = &mut self.topics[place];
        topic.kind = kind;
        topic.encoding = encoding.to_owned();
        (place, read.filter(|_| topic.is_joint_state()))
    }

    /// Names of all topics so far.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// Counts a message.
    pub(crate) fn count(&mut self, topic: usize) {
        self.topics[topic].messages += 1;
    }

    /// Notes a message that could not be read.
    pub(crate) fn malformed(&mut self, topic: usize, what: String, message: u64) {
        self.topics[topic].malformed.entry(what).or_insert((0, message)).0 += 1;
    }

    /// All of them.
    pub(crate) fn found(&self) -> Vec<rows::Topic> {
        let found = self.names.iter().zip(&self.topics).map(|(name, topic)| rows::Topic {
            name: name.clone(),
            kind: topic.kind.clone(),
            encoding: topic.encoding.clone(),
            messages: topic.messages,
        });
        found.collect()
    }

    /// The topics with their types.
    pub(crate) fn described(&self) -> Vec<String> {
        let described = |(name, topic): (&String, &Topic)| match (topic.kind.as_str(), topic.encoding.as_str()) {
            ("", "") => name.clone(),
            ("", encoding) => format!("{name} ({encoding})"),
            (kind, "") => format!("{name} ({kind})"),
            (kind, encoding) => format!("{name} ({kind} in {encoding})"),
        };
        self.names.iter().zip(&self.topics).map(described).collect()
    }

    /// The damaged messages of topics where these are more than a hundredth of all.
    pub(crate) fn lost(&self) -> impl Iterator<Item = String> + '_ {
        let many = |(_, topic): &(&String, &Topic)| {
            let damaged: u64 = topic.malformed.values().map(|(count, _)| count).sum();
            100 * damaged > topic.messages
        };
        self.names.iter().zip(&self.topics).filter(many).flat_map(|(name, topic)| topic.damaged(name))
    }

    /// What of them could not be read.
    pub(crate) fn remarks(&self) -> impl Iterator<Item = String> + '_ {
        let unread = self
            .names
            .iter()
            .zip(&self.topics)
            .filter(|(_, topic)| topic.is_joint_state() && !["cdr", "json"].contains(&topic.encoding.as_str()));
        let unread = unread.map(|(name, topic)| {
            format!("{name}: joint states in the encoding `{}` are not read, only cdr and json", topic.encoding)
        });
        unread.chain(self.names.iter().zip(&self.topics).flat_map(|(name, topic)| topic.damaged(name)))
    }
}

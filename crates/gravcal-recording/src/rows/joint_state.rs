//! `sensor_msgs/JointState`: names, and positions, velocities and efforts of as many joints, or none of a quantity.

pub(crate) mod cdr;

use std::fmt;

/// The three numbers that a message says of a joint, in the order of the message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Quantity {
    /// rad or m.
    Position,
    /// rad/s or m/s.
    Velocity,
    /// N·m or N.
    Effort,
}

impl Quantity {
    /// In the order of the message.
    pub(crate) const ALL: [Quantity; 3] = [Quantity::Position, Quantity::Velocity, Quantity::Effort];

    /// Its name in messages and columns.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Quantity::Position => "position",
            Quantity::Velocity => "velocity",
            Quantity::Effort => "effort",
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Name of the column with the time in seconds.
pub(crate) const TIME: &str = "time_s";

/// What the name of a column says: a number of a joint, perhaps of a certain topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ColumnName<'a> {
    pub(crate) topic: Option<&'a str>,
    pub(crate) joint: &'a str,
    pub(crate) quantity: Quantity,
}

impl<'a> ColumnName<'a> {
    /// Takes `[<topic>:]<joint>.<quantity>` apart; a topic begins with a slash, and a joint may have dots in its name.
    pub(crate) fn parse(column: &'a str) -> Option<ColumnName<'a>> {
        let (topic, rest) = match column.split_once(':').filter(|(topic, _)| topic.starts_with('/')) {
            Some((topic, rest)) => (Some(topic), rest),
            None => (None, column),
        };
        let (joint, quantity) = rest.rsplit_once('.')?;
        let quantity = Quantity::ALL.into_iter().find(|known| known.name() == quantity)?;
        (!joint.is_empty()).then_some(ColumnName { topic, joint, quantity })
    }
}

impl fmt::Display for ColumnName<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(topic) = self.topic {
            write!(f, "{topic}:")?;
        }
        write!(f, "{}.{}", self.joint, self.quantity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_columns_are_read_as_they_are_written() {
        for (column, joint, topic) in [
            ("a.position", "a", None),
            ("left.arm.effort", "left.arm", None),
            ("/arm/js:a.velocity", "a", Some("/arm/js")),
        ] {
            let name = ColumnName::parse(column).unwrap();
            assert_eq!((name.joint, name.topic, name.to_string().as_str()), (joint, topic, column));
        }
        for other in ["time_s", "q1", ".position", "a.temperature"] {
            assert_eq!(ColumnName::parse(other), None);
        }
    }
}

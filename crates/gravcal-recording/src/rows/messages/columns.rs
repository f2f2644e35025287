//! The columns that the messages of several topics fill, and their names.

use std::collections::{HashMap, HashSet};

use crate::rows::MOST_COLUMNS;
use crate::rows::joint_state::{ColumnName, Quantity, TIME};
use crate::rows::missing::{Missing, report_missing};

/// More joints than any message names: each may have three columns.
pub(super) const MOST_JOINTS: usize = (MOST_COLUMNS - 1) / 3;
/// A longer name of a joint is damage, bytes.
const LONGEST_NAME: usize = 1 << 12;
/// Orders of joints are known as long as they take about so many bytes; then all are forgotten, and found again as they come.
const KNOWN: usize = 1 << 24;

/// Columns in the order of their first appearance; the first is the time.
#[derive(Default)]
pub(super) struct Columns {
    columns: Vec<Column>,
    /// Of each joint its columns, whatever the topic.
    of_joint: HashMap<String, Vec<usize>>,
    /// Names of the first of them; the others have none yet.
    names: Vec<String>,
    /// Of each topic the orders of joints.
    layouts: Vec<Layouts>,
    /// Bytes that they take, about.
    known: usize,
    remarks: Vec<String>,
}

/// A number of a joint as a topic says it.
struct Column {
    topic: usize,
    joint: String,
    quantity: Quantity,
    /// How many numbers are infinite or none.
    not_finite: u64,
}

/// The orders of joints in a topic's messages: more than one, where several nodes take turns on it.
#[derive(Default)]
struct Layouts {
    known: Vec<Layout>,
    /// Of each its place, by the bytes of the names.
    places: HashMap<Vec<u8>, usize>,
    /// That of the last message.
    present: usize,
}

/// An order of joints.
#[derive(Default)]
struct Layout {
    /// The bytes of the names.
    bytes: Vec<u8>,
    joints: Vec<String>,
    /// Place among the columns, of each quantity and joint; empty as long as no message has said the quantity.
    places: [Vec<usize>; 3],
}

/// Why a message is no row.
pub(super) enum Unread {
    /// It is damaged, so.
    Damaged(String),
    /// It names so many joints, more than any recording has.
    TooManyJoints(usize),
}

/// The first name that was there before: which of its numbers holds, nobody can tell.
fn named_twice<'n>(names: &[&'n str]) -> Option<&'n str> {
    let mut known = HashSet::with_capacity(names.len());
    names.iter().copied().find(|name| !known.insert(*name))
}

impl Columns {
    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    pub(super) fn remarks(&self) -> impl Iterator<Item = String> + '_ {
        let columns = self.columns.iter().zip(&self.names[1.min(self.names.len())..]);
        let bad = columns.map(|(column, name)| Missing { column: name, count: column.not_finite, first: None });
        self.remarks.iter().cloned().chain(report_missing("readings that are no finite numbers", bad))
    }

    /// Whether an order of joints in the topic's messages is known; it is that of the present message then.
    pub(super) fn is_layout(&mut self, topic: usize, bytes: &[u8], joints: usize) -> bool {
        let Some(layouts) = self.layouts.get_mut(topic) else { return false };
        let is = |layout: &Layout| layout.joints.len() == joints && layout.bytes == bytes;
        if layouts.known.get(layouts.present).is_some_and(is) {
            return true;
        }
        let found = layouts.places.get(bytes).copied().filter(|place| is(&layouts.known[*place]));
        layouts.present = found.unwrap_or(layouts.present);
        found.is_some()
    }

    /// Notes the names of a message; refuses more than any recording has.
    pub(super) fn lay_out(&mut self, topic: usize, bytes: &[u8], names: &[&str]) -> Result<(), Unread> {
        if names.len() > MOST_JOINTS {
            return Err(Unread::TooManyJoints(names.len()));
        }
        if names.iter().any(|name| name.len() > LONGEST_NAME) {
            return Err(Unread::Damaged("the name of a joint is longer than any".to_owned()));
        }
        if let Some(twice) = named_twice(names) {
            return Err(Unread::Damaged(format!("it names joint `{twice}` twice")));
        }
        let new = names.iter().filter(|name| !self.is_known(topic, name)).count();
        // Names that change from message to message are damage.
        if 1 + self.columns.len() + Quantity::ALL.len() * new > MOST_COLUMNS {
            return Err(Unread::Damaged(format!("with its joints there are more than {MOST_COLUMNS} columns")));
        }
        let size = 4 * bytes.len() + 64 * names.len();
        self.known += size;
        if self.known > KNOWN {
            self.layouts.clear();
            self.known = size;
        }
        if self.layouts.len() <= topic {
            self.layouts.resize_with(topic + 1, Layouts::default);
        }
        let joints = names.iter().map(|name| (*name).to_owned()).collect();
        let layouts = &mut self.layouts[topic];
        layouts.present = layouts.known.len();
        layouts.places.insert(bytes.to_owned(), layouts.present);
        layouts.known.push(Layout { bytes: bytes.to_owned(), joints, places: Default::default() });
        Ok(())
    }

    /// Whether a topic has spoken of a joint.
    fn is_known(&self, topic: usize, joint: &str) -> bool {
        self.of_joint
            .get(joint)
            .is_some_and(|columns| columns.iter().any(|column| self.columns[*column].topic == topic))
    }

    /// Forgets the orders of joints and the counts of what is no number, to read the same messages again.
    pub(super) fn forget_layouts(&mut self) {
        self.layouts.clear();
        self.known = 0;
        self.columns.iter_mut().for_each(|column| column.not_finite = 0);
    }

    /// The column of a joint of the topic's last message.
    pub(super) fn place(&self, topic: usize, quantity: Quantity, joint: usize) -> Option<usize> {
        self.present(topic)?.places[quantity as usize].get(joint).map(|place| 1 + place)
    }

    /// The order of joints in the topic's last message.
    fn present(&self, topic: usize) -> Option<&Layout> {
        let layouts = self.layouts.get(topic)?;
        layouts.known.get(layouts.present)
    }

    /// Begins a row.
    pub(super) fn begin(&self, cells: &mut Vec<f64>, time: f64) {
        cells.clear();
        cells.push(time);
        cells.resize(1 + self.columns.len(), f64::NAN);
    }

    /// Fills in the numbers of a quantity: one for each joint of the topic's layout, or none.
    pub(super) fn fill(
        &mut self,
        cells: &mut Vec<f64>,
        topic: usize,
        quantity: Quantity,
        mut numbers: impl Iterator<Item = f64>,
    ) {
        let Some(first) = numbers.next() else { return };
        self.find_places(topic, quantity);
        cells.resize(1 + self.columns.len(), f64::NAN);
        let Some(layouts) = self.layouts.get(topic) else { return };
        let places = &layouts.known[layouts.present].places[quantity as usize];
        for (place, number) in places.iter().zip(std::iter::once(first).chain(numbers)) {
            match number.is_finite() {
                true => cells[1 + place] = number,
                false => self.columns[*place].not_finite += 1,
            }
        }
    }

    /// Finds or makes the columns of a quantity of the joints in the topic's last message, where that was not done.
    fn find_places(&mut self, topic: usize, quantity: Quantity) {
        let Some(layouts) = self.layouts.get_mut(topic) else { return };
        let Layout { joints, places, .. } = &mut layouts.known[layouts.present];
        if !places[quantity as usize].is_empty() {
            return;
        }
        let (columns, of_joint) = (&mut self.columns, &mut self.of_joint);
        let place = |joint: &String| {
            let of_joint = of_joint.entry(joint.clone()).or_default();
            let is = |place: &usize| columns[*place].topic == topic && columns[*place].quantity == quantity;
            of_joint.iter().copied().find(is).unwrap_or_else(|| {
                columns.push(Column { topic, joint: joint.clone(), quantity, not_finite: 0 });
                of_joint.push(columns.len() - 1);
                columns.len() - 1
            })
        };
        places[quantity as usize] = joints.iter().map(place).collect();
    }

    /// Names the columns that have no names yet; `topics` are the names of the topics.
    pub(super) fn name(&mut self, topics: &[String]) {
        let named = self.names.len();
        if named == 1 + self.columns.len() {
            return;
        }
        if named == 0 {
            self.names.push(TIME.to_owned());
        }
        for index in self.names.len() - 1..self.columns.len() {
            let Column { topic, joint, quantity, .. } = &self.columns[index];
            // Those that have a name already keep it.
            let of_joint = self.of_joint.get(joint).map_or(&[][..], Vec::as_slice);
            let elsewhere = of_joint.iter().copied().find(|other| self.columns[*other].topic != *topic);
            let topic = elsewhere.map(|_| topics[*topic].as_str());
            let name = ColumnName { topic, joint, quantity: *quantity }.to_string();
            if let Some(other) = elsewhere.filter(|other| 1 + other < named && !self.names[1 + other].starts_with('/'))
            {
                self.remarks.push(format!(
                    "{} speaks of joint `{joint}` too, long after {}: its column is `{name}`, and `{}` stays that of the \
                     other topic",
                    topics[self.columns[index].topic], topics[self.columns[other].topic], self.names[1 + other]
                ));
            }
            self.names.push(name);
        }
    }
}

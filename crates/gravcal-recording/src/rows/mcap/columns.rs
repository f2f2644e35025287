//! The columns that the messages of several topics fill, and their names.

use crate::rows::joint_state::{ColumnName, Quantity, TIME};

/// More columns than any recording has: names that change from message to message are damage.
const MOST: usize = 10_000;

/// Columns in the order of their first appearance; the first is the time.
#[derive(Default)]
pub(crate) struct Columns {
    columns: Vec<Column>,
    /// Names of the first of them; the others have none yet.
    names: Vec<String>,
    /// Where the numbers of the last message of each topic went.
    layouts: Vec<Layout>,
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

/// The order of joints in a topic's messages.
#[derive(Default)]
struct Layout {
    /// The bytes of the names.
    bytes: Vec<u8>,
    joints: Vec<String>,
    /// Place among the columns, of each quantity and joint; empty as long as no message has said the quantity. Of a joint that
    /// stands twice in a message the last number counts.
    places: [Vec<usize>; 3],
}

impl Columns {
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    pub(crate) fn remarks(&self) -> impl Iterator<Item = String> + '_ {
        let bad = self.columns.iter().zip(&self.names[1.min(self.names.len())..]);
        let bad = bad.filter(|(column, _)| column.not_finite > 0).map(|(column, name)| {
            format!(
                "column `{name}`: {} of its readings are no finite numbers, and count as missing",
                column.not_finite
            )
        });
        self.remarks.iter().cloned().chain(bad)
    }

    /// Whether the last message of the topic had the same names.
    pub(crate) fn is_layout(&self, topic: usize, bytes: &[u8], joints: usize) -> bool {
        self.layouts.get(topic).is_some_and(|layout| layout.joints.len() == joints && layout.bytes == bytes)
    }

    /// Notes the names of a message; refuses more than any recording has.
    pub(crate) fn lay_out(&mut self, topic: usize, bytes: &[u8], names: &[&str]) -> Result<(), String> {
        if self.columns.len() + 3 * names.len() > MOST {
            return Err(format!("with its joints there are more than {MOST} columns"));
        }
        while self.layouts.len() <= topic {
            self.layouts.push(Layout::default());
        }
        let joints = names.iter().map(|name| (*name).to_owned()).collect();
        self.layouts[topic] = Layout { bytes: bytes.to_owned(), joints, places: Default::default() };
        Ok(())
    }

    /// Forgets the orders of joints and the counts of what is no number, to read the same messages again.
    pub(crate) fn forget_layouts(&mut self) {
        self.layouts.clear();
        self.columns.iter_mut().for_each(|column| column.not_finite = 0);
    }

    /// The column of a joint of the topic's last message.
    pub(crate) fn place(&self, topic: usize, quantity: Quantity, joint: usize) -> Option<usize> {
        self.layouts.get(topic)?.places[quantity as usize].get(joint).map(|place| 1 + place)
    }

    /// Begins a row.
    pub(crate) fn begin(&self, cells: &mut Vec<f64>, time: f64) {
        cells.clear();
        cells.push(time);
        cells.resize(1 + self.columns.len(), f64::NAN);
    }

    /// Fills in the numbers of a quantity: one for each joint of the topic's layout, or none.
    pub(crate) fn fill(
        &mut self,
        cells: &mut Vec<f64>,
        topic: usize,
        quantity: Quantity,
        mut numbers: impl Iterator<Item = f64>,
    ) {
        let Some(first) = numbers.next() else { return };
        if self.layouts[topic].places[quantity as usize].is_empty() {
            self.find_places(topic, quantity);
            cells.resize(1 + self.columns.len(), f64::NAN);
        }
        let places = &self.layouts[topic].places[quantity as usize];
        for (place, number) in places.iter().zip(std::iter::once(first).chain(numbers)) {
            match number.is_finite() {
                true => cells[1 + place] = number,
                false => self.columns[*place].not_finite += 1,
            }
        }
    }

    /// Finds or makes the columns of a quantity of the topic's joints.
    fn find_places(&mut self, topic: usize, quantity: Quantity) {
        let layout = &mut self.layouts[topic];
        let columns = &mut self.columns;
        let place = |joint: &String| {
            let known =
                |column: &Column| column.topic == topic && column.quantity == quantity && column.joint == *joint;
            columns.iter().position(known).unwrap_or_else(|| {
                columns.push(Column { topic, joint: joint.clone(), quantity, not_finite: 0 });
                columns.len() - 1
            })
        };
        layout.places[quantity as usize] = layout.joints.iter().map(place).collect();
    }

    /// Names the columns that have no names yet; `topics` are the names of the topics.
    pub(crate) fn name(&mut self, topics: &[String]) {
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
            let elsewhere = self.columns.iter().position(|other| other.joint == *joint && other.topic != *topic);
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

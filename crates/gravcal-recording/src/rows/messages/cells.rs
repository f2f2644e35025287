//! One message as the cells of a row.

use serde::Deserialize;

use super::Message;
use super::columns::{Columns, Unread};
use crate::rows::joint_state::{Quantity, cdr};

/// Time of a message, s.
fn time(stamp: (i64, u64), log_time: u64) -> f64 {
    match stamp {
        (0, 0) => (log_time / 1_000_000_000) as f64 + (log_time % 1_000_000_000) as f64 * 1e-9,
        (seconds, nanoseconds) => seconds as f64 + nanoseconds as f64 * 1e-9,
    }
}

/// Reads a message in Common Data Representation; says what is wrong with it if it is none.
pub(super) fn cdr(sent: &Message<'_>, columns: &mut Columns, cells: &mut Vec<f64>) -> Result<(), Unread> {
    let message = cdr::Message::read(sent.data).map_err(|malformed| Unread::Damaged(malformed.to_string()))?;
    let topic = sent.topic;
    if !columns.is_layout(topic, message.names_bytes(), message.joints()) {
        let names = message.names().map_err(|malformed| Unread::Damaged(malformed.to_string()))?;
        columns.lay_out(topic, message.names_bytes(), &names)?;
    }
    let stamp = (i64::from(message.stamp.0), u64::from(message.stamp.1));
    columns.begin(cells, time(stamp, sent.log_time));
    for quantity in Quantity::ALL {
        columns.fill(cells, topic, quantity, message.numbers(quantity));
    }
    Ok(())
}

/// The same message in JSON.
#[derive(Deserialize)]
struct JointState {
    #[serde(default)]
    header: JsonHeader,
    #[serde(default)]
    name: Vec<String>,
    /// JSON has no NaN; writers put null in its place.
    #[serde(default)]
    position: Vec<Option<f64>>,
    #[serde(default)]
    velocity: Vec<Option<f64>>,
    #[serde(default)]
    effort: Vec<Option<f64>>,
}

#[derive(Default, Deserialize)]
struct JsonHeader {
    #[serde(default)]
    stamp: Stamp,
}

#[derive(Default, Deserialize)]
struct Stamp {
    #[serde(default, alias = "secs")]
    sec: i64,
    #[serde(default, alias = "nsec", alias = "nsecs")]
    nanosec: u64,
}

/// Reads a message in JSON; says what is wrong with it if it is none.
pub(super) fn json(sent: &Message<'_>, columns: &mut Columns, cells: &mut Vec<f64>) -> Result<(), Unread> {
    let no_message = |_| Unread::Damaged("no such message in JSON".to_owned());
    let message: JointState = serde_json::from_slice(sent.data).map_err(no_message)?;
    let topic = sent.topic;
    let numbers = [message.position, message.velocity, message.effort];
    for (numbers, quantity) in numbers.iter().zip(Quantity::ALL) {
        if !numbers.is_empty() && numbers.len() != message.name.len() {
            return Err(Unread::Damaged(cdr::Malformed::Count(quantity).to_string()));
        }
    }
    // Names with their ends, so that equal bytes are equal names.
    let names: Vec<u8> = message.name.iter().flat_map(|name| name.bytes().chain([0xFF])).collect();
    if !columns.is_layout(topic, &names, message.name.len()) {
        let texts: Vec<&str> = message.name.iter().map(String::as_str).collect();
        columns.lay_out(topic, &names, &texts)?;
    }
    let stamp = message.header.stamp;
    columns.begin(cells, time((stamp.sec, stamp.nanosec), sent.log_time));
    for (numbers, quantity) in numbers.iter().zip(Quantity::ALL) {
        columns.fill(cells, topic, quantity, numbers.iter().map(|number| number.unwrap_or(f64::NAN)));
    }
    Ok(())
}

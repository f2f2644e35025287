//! Numbers of a message changed where they stand.

use serde_json::Value;

use crate::rows::joint_state::{Quantity, cdr};

/// Gives the new number of a quantity of a joint, by its place in the message, where it changes.
type Changed<'a> = dyn Fn(Quantity, usize) -> Option<f64> + 'a;

/// Changes a message in Common Data Representation, whose length stays.
pub(crate) fn cdr(data: &mut [u8], changed: &Changed<'_>) {
    let Ok(message) = cdr::Message::read(data) else { return };
    let mut changes = Vec::new();
    for quantity in Quantity::ALL {
        for joint in 0..message.joints() {
            if let (Some(place), Some(number)) = (message.place(quantity, joint), changed(quantity, joint)) {
                changes.push((place, number));
            }
        }
    }
    for ((at, big_endian), number) in changes {
        let bytes = if big_endian { number.to_be_bytes() } else { number.to_le_bytes() };
        data[at..at + 8].copy_from_slice(&bytes);
    }
}

/// Changes a message in JSON, where NaN is null.
pub(crate) fn json(data: &mut Vec<u8>, changed: &Changed<'_>) {
    let Ok(mut message) = serde_json::from_slice::<Value>(data) else { return };
    for quantity in Quantity::ALL {
        let Some(numbers) = message.get_mut(quantity.name()).and_then(Value::as_array_mut) else { continue };
        for (joint, number) in numbers.iter_mut().enumerate() {
            if let Some(new) = changed(quantity, joint) {
                *number = serde_json::Number::from_f64(new).map_or(Value::Null, Value::Number);
            }
        }
    }
    if let Ok(bytes) = serde_json::to_vec(&message) {
        *data = bytes;
    }
}

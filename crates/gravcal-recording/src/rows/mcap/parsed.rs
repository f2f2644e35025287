//! A record's bytes taken apart.
//!
//! The `mcap` crate makes room for a string before it looks whether the record is so long, up to 4 GiB. So lengths are checked here
//! against what is left of the record before it is asked.

use mcap::parse_record;
use mcap::records::{Record, op};

use crate::rows::shield::shielded;

/// What a record says; none where it is damaged, or of a kind that nobody here asks for.
pub(crate) fn parsed(opcode: u8, body: &[u8]) -> Option<Record<'_>> {
    check(opcode, &mut Fields(body))?;
    shielded(|| parse_record(opcode, body)).ok()?.ok()
}

/// None where a length is more than is left.
fn check(opcode: u8, fields: &mut Fields<'_>) -> Option<()> {
    match opcode {
        op::HEADER => fields.strings(2),
        // Identifier; the length of its definition the crate checks itself.
        op::SCHEMA => fields.numbers(2)?.strings(2),
        // Identifiers of itself and of its schema.
        op::CHANNEL => fields.numbers(2 + 2)?.strings(2)?.map(),
        op::METADATA => fields.strings(1)?.map(),
        // Place and length.
        op::METADATA_INDEX => fields.numbers(8 + 8)?.strings(1),
        op::MESSAGE | op::FOOTER => Some(fields),
        // On a damaged attachment the crate panics.
        _ => None,
    }
    .map(|_| ())
}

/// What is left of a record.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    /// Numbers of so many bytes in all.
    fn numbers(&mut self, bytes: usize) -> Option<&mut Self> {
        self.0 = self.0.get(bytes..)?;
        Some(self)
    }

    fn strings(&mut self, count: usize) -> Option<&mut Self> {
        for _ in 0..count {
            let length = self.length()?;
            self.numbers(length)?;
        }
        Some(self)
    }

    /// Pairs of strings, with the length of all before them.
    fn map(&mut self) -> Option<&mut Self> {
        let length = self.length()?;
        let mut pairs = Fields(self.0.get(..length)?);
        while !pairs.0.is_empty() {
            pairs.strings(2)?;
        }
        self.numbers(length)
    }

    fn length(&mut self) -> Option<usize> {
        let (length, left) = self.0.split_first_chunk::<4>()?;
        self.0 = left;
        Some(u32::from_le_bytes(*length) as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(text: &str) -> Vec<u8> {
        [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
    }

    fn map(pairs: &[&str]) -> Vec<u8> {
        let pairs: Vec<u8> = pairs.iter().flat_map(|part| text(part)).collect();
        [&(pairs.len() as u32).to_le_bytes()[..], &pairs].concat()
    }

    /// One of each kind, and where in it lengths stand.
    fn records() -> Vec<(u8, Vec<u8>, Vec<usize>)> {
        vec![
            (op::HEADER, [text("ros2"), text("lib")].concat(), vec![0, 8]),
            (op::SCHEMA, [vec![1, 0], text("name"), text("enc"), text("data")].concat(), vec![2, 10, 17]),
            (
                op::CHANNEL,
                [vec![1, 0, 1, 0], text("/js"), text("cdr"), map(&["a", "b", "c", "d"])].concat(),
                vec![4, 11, 18, 22, 27, 32, 37],
            ),
            (op::METADATA, [text("gravcal"), map(&["load", "plate"])].concat(), vec![0, 11, 15, 23]),
            (op::METADATA_INDEX, [vec![0; 16], text("gravcal")].concat(), vec![16]),
        ]
    }

    #[test]
    fn no_length_goes_on_over_the_end() {
        for (opcode, body, lengths) in records() {
            assert!(parsed(opcode, &body).is_some(), "{opcode}");
            for at in lengths {
                for length in [u32::MAX, i32::MAX as u32, body.len() as u32] {
                    let mut damaged = body.clone();
                    damaged[at..at + 4].copy_from_slice(&length.to_le_bytes());
                    // The definition of a schema is the one that the crate itself checks.
                    let is_definition = (opcode, at) == (op::SCHEMA, 17);
                    assert_eq!(check(opcode, &mut Fields(&damaged)), is_definition.then_some(()), "{opcode} at {at}");
                    assert!(parsed(opcode, &damaged).is_none(), "{opcode} at {at}");
                }
            }
            for cut in 0..body.len() {
                assert!(parsed(opcode, &body[..cut]).is_none(), "{opcode} cut at {cut}");
            }
        }
    }
}

//! A `sensor_msgs/JointState` in Common Data Representation, as ROS 2 sends and rosbag2 keeps it.
//!
//! ```text
//! 00 01 00 00            plain CDR, little-endian (00 00: big-endian); offsets count from after these four bytes
//! i32 u32                header.stamp: s, ns
//! string                 header.frame_id: length with the final zero byte, bytes, zero
//! u32 string*            name
//! u32 f64* (three times) position, velocity, effort; numbers of 8 bytes at multiples of 8
//! ```
//!
//! Source: OMG, *DDS Interoperability Wire Protocol 2.5*, section 10; OMG, *CORBA 3.3 part 2*, section 9.3. The decoder borrows: a
//! message at 1 kHz is read without a copy of its names, which a general one (by serde) makes a vector of strings of.

use super::Quantity;

/// A message in its bytes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Message<'a> {
    /// header.stamp, s and ns.
    pub(crate) stamp: (i32, u32),
    /// Names of the joints, each without its length and final zero.
    names: Strings<'a>,
    /// Of each quantity its numbers, and where they stand in the message.
    numbers: [Numbers<'a>; 3],
}

/// Numbers in their bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Numbers<'a> {
    bytes: &'a [u8],
    offset: usize,
    big_endian: bool,
}

/// A sequence of strings in its bytes, checked.
#[derive(Clone, Debug, PartialEq)]
struct Strings<'a> {
    reader: Reader<'a>,
    count: usize,
    /// The bytes of all of them, which are equal where the names are.
    bytes: &'a [u8],
}

/// What is wrong with a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Malformed {
    /// It is in a representation other than plain CDR.
    Representation(u8),
    /// It ends before its last field does.
    Short,
    /// A name is no UTF-8 text with a final zero byte.
    Name,
    /// There are other numbers of a quantity than names, but not none.
    Count(Quantity),
}

impl std::fmt::Display for Malformed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Malformed::Representation(found) => write!(f, "not plain CDR (representation {found})"),
            Malformed::Short => f.write_str("shorter than it says"),
            Malformed::Name => f.write_str("a name that is no text"),
            Malformed::Count(quantity) => write!(f, "not as many numbers of {quantity} as names"),
        }
    }
}

impl<'a> Message<'a> {
    /// Reads a message; bytes after it do not count.
    pub(crate) fn read(bytes: &'a [u8]) -> Result<Message<'a>, Malformed> {
        let representation = *bytes.get(1).ok_or(Malformed::Short)?;
        let big_endian = match (bytes[0], representation) {
            (0, 0) => true,
            (0, 1) => false,
            _ => return Err(Malformed::Representation(representation)),
        };
        let body = bytes.get(4..).ok_or(Malformed::Short)?;
        let mut reader = Reader { body, at: 0, big_endian };
        let stamp = (reader.u32()? as i32, reader.u32()?);
        reader.string()?;
        let names = reader.strings()?;
        let mut numbers = [Numbers::default(); 3];
        for (numbers, quantity) in numbers.iter_mut().zip(Quantity::ALL) {
            *numbers = reader.numbers()?;
            if !numbers.bytes.is_empty() && numbers.bytes.len() / 8 != names.count {
                return Err(Malformed::Count(quantity));
            }
        }
        Ok(Message { stamp, names, numbers })
    }

    /// Number of joints.
    pub(crate) fn joints(&self) -> usize {
        self.names.count
    }

    /// The bytes of all names: equal where the names are.
    pub(crate) fn names_bytes(&self) -> &'a [u8] {
        self.names.bytes
    }

    /// Names of the joints.
    pub(crate) fn names(&self) -> Result<Vec<&'a str>, Malformed> {
        let mut reader = self.names.reader.clone();
        (0..self.names.count).map(|_| std::str::from_utf8(reader.string()?).map_err(|_| Malformed::Name)).collect()
    }

    /// Numbers of a quantity: one for each joint, or none.
    pub(crate) fn numbers(&self, quantity: Quantity) -> impl Iterator<Item = f64> + 'a {
        let Numbers { bytes, big_endian, .. } = self.numbers[quantity as usize];
        bytes.as_chunks::<8>().0.iter().map(move |eight| match big_endian {
            true => f64::from_be_bytes(*eight),
            false => f64::from_le_bytes(*eight),
        })
    }

    /// Where in the message a joint's number of a quantity stands, and whether it is big-endian.
    pub(crate) fn place(&self, quantity: Quantity, joint: usize) -> Option<(usize, bool)> {
        let numbers = self.numbers[quantity as usize];
        (8 * joint < numbers.bytes.len()).then_some((numbers.offset + 8 * joint, numbers.big_endian))
    }
}

/// Reads field after field.
#[derive(Clone, Debug, PartialEq)]
struct Reader<'a> {
    body: &'a [u8],
    at: usize,
    big_endian: bool,
}

impl<'a> Reader<'a> {
    fn take(&mut self, length: usize) -> Result<&'a [u8], Malformed> {
        let end = self.at.checked_add(length).ok_or(Malformed::Short)?;
        let bytes = self.body.get(self.at..end).ok_or(Malformed::Short)?;
        self.at = end;
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32, Malformed> {
        self.at = self.at.next_multiple_of(4);
        let four = self.take(4)?.try_into().map_err(|_| Malformed::Short)?;
        Ok(if self.big_endian { u32::from_be_bytes(four) } else { u32::from_le_bytes(four) })
    }

    fn length(&mut self) -> Result<usize, Malformed> {
        self.u32().map(|length| length as usize)
    }

    /// The bytes of a string, without its final zero.
    fn string(&mut self) -> Result<&'a [u8], Malformed> {
        let length = self.length()?;
        match self.take(length)?.split_last() {
            Some((0, text)) => Ok(text),
            // Some writers send an empty string as nothing at all.
            None => Ok(&[]),
            Some(_) => Err(Malformed::Name),
        }
    }

    fn strings(&mut self) -> Result<Strings<'a>, Malformed> {
        let count = self.length()?;
        let start = self.at;
        let reader = self.clone();
        for _ in 0..count {
            self.string()?;
        }
        Ok(Strings { reader, count, bytes: &self.body[start..self.at] })
    }

    fn numbers(&mut self) -> Result<Numbers<'a>, Malformed> {
        let count = self.length()?;
        if count == 0 {
            return Ok(Numbers::default());
        }
        self.at = self.at.next_multiple_of(8);
        let offset = 4 + self.at;
        let bytes = self.take(count.checked_mul(8).ok_or(Malformed::Short)?)?;
        Ok(Numbers { bytes, offset, big_endian: self.big_endian })
    }
}

/// Writes a message, little-endian, into `bytes`. Numbers of a quantity are one for each name, or none.
pub(crate) fn write(bytes: &mut Vec<u8>, stamp: (i32, u32), names: &[&str], numbers: [&[f64]; 3]) {
    bytes.clear();
    bytes.extend([0, 1, 0, 0]);
    bytes.extend(stamp.0.to_le_bytes());
    bytes.extend(stamp.1.to_le_bytes());
    write_string(bytes, "");
    write_length(bytes, names.len());
    names.iter().for_each(|name| write_string(bytes, name));
    for numbers in numbers {
        write_length(bytes, numbers.len());
        if !numbers.is_empty() {
            pad(bytes, 8);
            numbers.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        }
    }
}

/// Zeros up to a multiple of `size`, counted from after the first four bytes.
fn pad(bytes: &mut Vec<u8>, size: usize) {
    bytes.resize(4 + (bytes.len() - 4).next_multiple_of(size), 0);
}

fn write_length(bytes: &mut Vec<u8>, length: usize) {
    pad(bytes, 4);
    bytes.extend(u32::try_from(length).unwrap_or(u32::MAX).to_le_bytes());
}

fn write_string(bytes: &mut Vec<u8>, text: &str) {
    write_length(bytes, text.len() + 1);
    bytes.extend(text.as_bytes());
    bytes.push(0);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn written(names: &[&str], numbers: [&[f64]; 3]) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(&mut bytes, (5, 6), names, numbers);
        bytes
    }

    fn numbers(message: &Message<'_>, quantity: Quantity) -> Vec<f64> {
        message.numbers(quantity).collect()
    }

    #[test]
    fn the_bytes_are_as_documented() {
        let bytes = written(&["ab"], [&[1.0], &[], &[-2.0]]);
        let expected = [
            &[0, 1, 0, 0, 5, 0, 0, 0, 6, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0][..],
            &[1, 0, 0, 0, 3, 0, 0, 0, b'a', b'b', 0, 0, 1, 0, 0, 0],
            &1.0_f64.to_le_bytes(),
            &[0, 0, 0, 0, 1, 0, 0, 0],
            &(-2.0_f64).to_le_bytes(),
        ]
        .concat();
        assert_eq!(bytes, expected);
        let message = Message::read(&bytes).unwrap();
        assert_eq!((message.stamp, message.names().unwrap()), ((5, 6), vec!["ab"]));
        assert_eq!(Quantity::ALL.map(|quantity| numbers(&message, quantity)), [vec![1.0], vec![], vec![-2.0]]);
        let (at, big_endian) = message.place(Quantity::Effort, 0).unwrap();
        assert_eq!((&bytes[at..at + 8], big_endian), (&(-2.0_f64).to_le_bytes()[..], false));
        assert_eq!((message.place(Quantity::Velocity, 0), message.place(Quantity::Effort, 1)), (None, None));
    }

    #[test]
    fn big_endian_is_read_too() {
        let bytes = [
            &[0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0, 6, 0, 0, 0, 1, 0, 0, 0, 0][..],
            &[0, 0, 0, 1, 0, 0, 0, 2, b'a', 0, 0, 0, 0, 0, 0, 1],
            &1.5_f64.to_be_bytes(),
            &[0; 8],
        ]
        .concat();
        let message = Message::read(&bytes).unwrap();
        assert_eq!((message.stamp, message.names().unwrap()), ((5, 6), vec!["a"]));
        assert_eq!(numbers(&message, Quantity::Position), [1.5]);
    }

    #[test]
    fn what_is_wrong_is_reported() {
        let bytes = written(&["a", "b"], [&[1.0, 2.0], &[], &[]]);
        for length in 0..bytes.len() {
            assert_eq!(Message::read(&bytes[..length]), Err(Malformed::Short), "{length}");
        }
        let change = |at: usize, to: u8| {
            let mut bytes = bytes.clone();
            bytes[at] = to;
            Message::read(&bytes).unwrap_err()
        };
        assert_eq!(change(1, 7), Malformed::Representation(7));
        assert_eq!(change(29, 1), Malformed::Name);
        assert_eq!(change(27, 255), Malformed::Short);
        let one = written(&["a", "b"], [&[1.0, 2.0], &[], &[3.0]]);
        assert_eq!(Message::read(&one), Err(Malformed::Count(Quantity::Effort)));
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(
            joints in proptest::collection::vec(("[a-zé_]{0,9}", any::<[u64; 3]>()), 0..9),
            said: [bool; 3],
            stamp: (i32, u32),
        ) {
            let names: Vec<&str> = joints.iter().map(|(name, _)| name.as_str()).collect();
            let of = |quantity: usize| -> Vec<f64> {
                joints.iter().filter(|_| said[quantity]).map(|(_, bits)| f64::from_bits(bits[quantity])).collect()
            };
            let sent = [of(0), of(1), of(2)];
            let mut bytes = Vec::new();
            write(&mut bytes, stamp, &names, [&sent[0], &sent[1], &sent[2]]);
            let message = Message::read(&bytes).unwrap();
            prop_assert_eq!((message.stamp, message.joints(), message.names().unwrap()), (stamp, names.len(), names));
            for (quantity, sent) in Quantity::ALL.into_iter().zip(&sent) {
                let bits = |numbers: &[f64]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
                prop_assert_eq!(bits(&numbers(&message, quantity)), bits(sent));
            }
        }

        #[test]
        fn arbitrary_bytes_do_not_panic(mut bytes in proptest::collection::vec(0_u8..8, 0..200)) {
            bytes.splice(0..0, [0, 1, 0, 0]);
            let _ = Message::read(&bytes).map(|message| message.names().is_ok());
        }
    }
}

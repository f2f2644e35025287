//! Numbers for a script: base64 of little-endian 32-bit floats, NaN where there is none.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

pub(super) fn base64(numbers: impl IntoIterator<Item = f64>) -> String {
    let bytes: Vec<u8> = numbers.into_iter().flat_map(|number| (number as f32).to_le_bytes()).collect();
    STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_are_little_endian() {
        assert_eq!(base64([1.0, -2.0]), "AACAPwAAAMA=");
    }
}

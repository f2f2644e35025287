//! Counts in words of a message.

/// A count with the words that follow it: the first of them for one, the second for any other.
pub fn counted(count: u64, [one, many]: [&str; 2]) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_singular() {
        let rows = [0, 1, 2].map(|count| counted(count, ["row has", "rows have"]));
        assert_eq!(rows, ["0 rows have", "1 row has", "2 rows have"]);
    }
}

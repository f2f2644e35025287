//! "Did you mean": the known name nearest to a misspelt one.

/// The one name with the fewest edits to `wanted`, if these are at most a third of its letters; none if several are
/// equally near, as `joint1` is no likelier a slip for `joint2` than for `joint3`.
pub(super) fn nearest<'a>(wanted: &str, known: &[&'a str]) -> Option<&'a str> {
    let least = known.iter().map(|name| edits(wanted, name)).min()?;
    let mut near = known.iter().filter(|name| edits(wanted, name) == least);
    let name = near.next()?;
    (least <= wanted.chars().count() / 3 && near.next().is_none()).then_some(name)
}

/// Levenshtein's distance, upper and lower case alike.
fn edits(left: &str, right: &str) -> usize {
    let right: Vec<char> = right.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=right.len()).collect();
    for (i, letter) in left.to_lowercase().chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, other) in right.iter().enumerate() {
            let replaced = diagonal + usize::from(letter != *other);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[right.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_of_well_known_pairs() {
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("", "abc"), 3);
        assert_eq!(edits("Link", "link"), 0);
    }

    #[test]
    fn only_what_is_near_and_alone_is_offered() {
        assert_eq!(nearest("shuolder", &["shoulder", "elbow"]), Some("shoulder"));
        assert_eq!(nearest("wrist", &["shoulder", "elbow"]), None);
        assert_eq!(nearest("joint9", &["joint1", "joint2"]), None);
        assert_eq!(nearest("wrist", &[]), None);
    }
}

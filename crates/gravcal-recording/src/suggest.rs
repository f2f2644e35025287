//! "Did you mean": the known name nearest to an unknown one.

/// The one name that is nearest to `wanted`: at most one edit for every three characters, upper and lower case
/// alike. None if there is no such name, or if several are equally near: `tau1` is no likelier a slip for `tau2`
/// than for `tau3`.
pub(crate) fn nearest<'a>(wanted: &str, known: &'a [String]) -> Option<&'a str> {
    let wanted = folded(wanted);
    let distances: Vec<usize> = known.iter().map(|name| edit_distance(&wanted, &folded(name))).collect();
    let least = *distances.iter().min()?;
    let mut nearest = known.iter().zip(&distances).filter(|(_, distance)| **distance == least);
    let (name, _) = nearest.next()?;
    (least <= wanted.len() / 3 && nearest.next().is_none()).then_some(name)
}

fn folded(name: &str) -> Vec<char> {
    name.to_lowercase().chars().collect()
}

/// Levenshtein's distance: the least number of characters inserted, deleted or replaced to turn `a` into `b`.
fn edit_distance(a: &[char], b: &[char]) -> usize {
    // `row[j]` is the distance between what has been seen of `a` and the first j characters of `b`.
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(a: &str, b: &str) -> usize {
        edit_distance(&folded(a), &folded(b))
    }

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| name.to_string()).collect()
    }

    #[test]
    fn distances_of_well_known_pairs() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("saturday", "sunday"), 3);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("abc", ""), 3);
        assert_eq!(distance("tau", "tau"), 0);
    }

    #[test]
    fn a_slip_of_the_finger_is_found() {
        let known = names(&["q1_deg", "tau_1", "sweep"]);
        assert_eq!(nearest("tau1", &known), Some("tau_1"));
        assert_eq!(nearest("Sweep", &known), Some("sweep"));
        assert_eq!(nearest("q1_dge", &known), Some("q1_deg"));
    }

    #[test]
    fn what_is_far_or_ambiguous_is_not_suggested() {
        assert_eq!(nearest("temperature", &names(&["tau1", "q1"])), None);
        assert_eq!(nearest("tau1", &names(&["tau2", "tau3"])), None);
        assert_eq!(nearest("q1", &names(&["q2"])), None);
        assert_eq!(nearest("anything", &[]), None);
    }
}

//! "Did you mean": the known name nearest to an unknown one.

/// The one known name that is near enough to `wanted` to be a slip of the finger: at most a third of its letters
/// differ (upper and lower case do not), and no other name is as near.
pub fn nearest_name<'a>(wanted: &str, known: &[&'a str]) -> Option<&'a str> {
    let distance = |name: &str| strsim::levenshtein(&wanted.to_lowercase(), &name.to_lowercase());
    let least = known.iter().map(|name| distance(name)).min()?;
    let mut near = known.iter().filter(|name| distance(name) == least);
    let name = near.next()?;
    (least <= wanted.chars().count() / 3 && near.next().is_none()).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_finger_is_found() {
        let known = ["q1_deg", "tau_1", "sweep"];
        assert_eq!(nearest_name("tau1", &known), Some("tau_1"));
        assert_eq!(nearest_name("Sweep", &known), Some("sweep"));
        assert_eq!(nearest_name("q1_dge", &known), Some("q1_deg"));
    }

    #[test]
    fn what_is_far_or_ambiguous_is_not_suggested() {
        assert_eq!(nearest_name("temperature", &["tau1", "q1"]), None);
        assert_eq!(nearest_name("tau1", &["tau2", "tau3"]), None);
        assert_eq!(nearest_name("q1", &["q2"]), None);
        assert_eq!(nearest_name("anything", &[]), None);
    }
}

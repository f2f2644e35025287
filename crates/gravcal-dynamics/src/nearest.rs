//! The nearest name, for messages about a misspelt one.

/// The candidate with the fewest edits to `name`, if that is at most a third of its letters (and one at least).
pub(crate) fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let allowed = (name.chars().count() / 3).max(1);
    candidates
        .into_iter()
        .map(|candidate| (strsim::levenshtein(&name.to_lowercase(), &candidate.to_lowercase()), candidate))
        .filter(|(distance, _)| *distance <= allowed)
        .min()
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_near_name_is_offered() {
        let links = ["panda_link0", "panda_hand"];
        assert_eq!(nearest("panda_lnk0", links), Some("panda_link0"));
        assert_eq!(nearest("tool0", links), None);
    }
}

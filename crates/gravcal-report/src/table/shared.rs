//! What several estimators say alike is told once.

use gravcal_calibration::result::EstimatorResult;

/// Something that one or more estimators say.
#[derive(Clone, Debug)]
pub(super) struct Shared<'a, T> {
    /// What.
    pub item: &'a T,
    /// Who, separated by commas.
    pub names: String,
    /// Whether all of them do.
    pub everyone: bool,
}

/// The items of all results, equal ones together, in the order of their first appearance.
pub(super) fn by_content<'a, T: PartialEq>(
    results: &'a [EstimatorResult],
    items: impl Fn(&'a EstimatorResult) -> &'a Vec<T>,
) -> Vec<Shared<'a, T>> {
    let mut different: Vec<&T> = Vec::new();
    for item in results.iter().flat_map(&items) {
        if !different.contains(&item) {
            different.push(item);
        }
    }
    let report = |item| {
        let saying = results.iter().filter(|result| items(result).contains(item));
        let names: Vec<&str> = saying.map(|result| result.name.as_str()).collect();
        Shared { item, everyone: names.len() == results.len(), names: names.join(", ") }
    };
    different.into_iter().map(report).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::result;

    #[test]
    fn equal_items_are_reported_once() {
        let (mut first, mut second) = (result("sequential"), result("joint"));
        first.notes = vec!["frozen".into(), "frame".into()];
        second.notes = vec!["frame".into(), "mirror".into()];
        let results = [first, second];
        let reported: Vec<(String, bool)> = by_content(&results, |r| &r.notes)
            .into_iter()
            .map(|shared| (format!("{}: {}", shared.names, shared.item), shared.everyone))
            .collect();
        assert_eq!(
            reported,
            [
                ("sequential: frozen".to_owned(), false),
                ("sequential, joint: frame".to_owned(), true),
                ("joint: mirror".to_owned(), false)
            ]
        );
    }
}

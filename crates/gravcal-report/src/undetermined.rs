//! What cannot be known: which combination, why, and which pose or load would cure it.

use gravcal_calibration::result::Undetermined;

use crate::text::wrapped;

/// A combination that is not determined, and by whom, if that needs saying.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry<'a> {
    pub undetermined: &'a Undetermined,
    pub whose: Option<String>,
    /// What would cure it, in the order of effort.
    pub cures: Vec<String>,
}

/// Lines for all of them. Those that one cure helps stand together above it, those with one reason above that.
pub(crate) fn report_undetermined(entries: &[Entry<'_>]) -> String {
    let mut text = String::new();
    for cured_alike in grouped(entries.iter().collect(), |a, b| a.cures == b.cures && a.whose == b.whose) {
        let cures = cured_alike.first().map_or(&[][..], |entry| &entry.cures);
        for for_one_reason in grouped(cured_alike, |a, b| a.why() == b.why()) {
            text += &for_one_reason.iter().map(|entry| entry.names()).collect::<String>();
            text += &labelled("why", for_one_reason.first().map_or("", |entry| entry.why()));
        }
        let labels = std::iter::once("cure").chain(std::iter::repeat("or"));
        text += &labels.zip(cures).map(|(label, cure)| labelled(label, cure)).collect::<String>();
    }
    text
}

impl<'a> Entry<'a> {
    /// With the one cure that it names itself.
    pub fn of(undetermined: &'a Undetermined, whose: Option<String>) -> Entry<'a> {
        Entry { undetermined, whose, cures: vec![undetermined.cure.clone()] }
    }

    fn why(&self) -> &str {
        &self.undetermined.why
    }

    /// The combination, and its parameters where it does not name them itself.
    fn names(&self) -> String {
        let Undetermined { combination, parameters, .. } = self.undetermined;
        let whose = self.whose.as_ref().map_or_else(String::new, |names| format!(" ({names})"));
        let combined = wrapped("  ", "    ", &format!("{combination}{whose}"));
        let parameters = parameters.join(", ");
        if parameters == *combination { combined } else { combined + &labelled("of", &parameters) }
    }
}

/// Items in groups of those that are alike, in the order of the first of each.
fn grouped<T>(items: Vec<T>, alike: impl Fn(&T, &T) -> bool) -> Vec<Vec<T>> {
    let mut groups: Vec<Vec<T>> = Vec::new();
    for item in items {
        match groups.iter_mut().find(|group| group.iter().any(|other| alike(other, &item))) {
            Some(group) => group.push(item),
            None => groups.push(vec![item]),
        }
    }
    groups
}

fn labelled(label: &str, words: &str) -> String {
    if words.is_empty() { String::new() } else { wrapped(&format!("    {label:<5}"), &" ".repeat(9), words) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn undetermined(combination: &str, why: &str, cure: &str) -> Undetermined {
        let parameters = vec!["joint1.torque_gain".into(), "joint2.torque_gain".into()];
        Undetermined { combination: combination.into(), parameters, why: why.into(), cure: cure.into() }
    }

    fn reported(all: &[Undetermined], whose: Option<&str>) -> String {
        let entry = |undetermined| Entry::of(undetermined, whose.map(str::to_owned));
        report_undetermined(&all.iter().map(entry).collect::<Vec<_>>())
    }

    #[test]
    fn parameters_stand_where_the_combination_does_not_name_them() {
        let scale = undetermined("common scale of all torque gains", "all masses are unknown", "attach a load");
        assert_eq!(
            reported(&[scale], Some("joint")),
            "  common scale of all torque gains (joint)
    of   joint1.torque_gain, joint2.torque_gain
    why  all masses are unknown
    cure attach a load
"
        );
        let named = undetermined("joint1.torque_gain, joint2.torque_gain", "no torque is read", "");
        assert_eq!(reported(&[named], None), "  joint1.torque_gain, joint2.torque_gain\n    why  no torque is read\n");
    }

    #[test]
    fn one_cure_is_reported_once() {
        let mut all = [("a", "axis", "tilt"), ("b", "range", "move"), ("c", "weak", "tilt"), ("d", "axis", "tilt")]
            .map(|(combination, why, cure)| undetermined(combination, why, cure));
        for one in &mut all {
            one.parameters = vec![one.combination.clone()];
        }
        assert_eq!(
            reported(&all, None),
            "  a
  d
    why  axis
  c
    why  weak
    cure tilt
  b
    why  range
    cure move
"
        );
    }
}

//! What a session says that can hardly be so, told before all else.

use crate::text::{plain, wrapped};

/// The doubts of a session as text of 80 columns; empty where there are none.
pub fn report_doubts(doubts: &[String]) -> String {
    report(HEADING, doubts)
}

/// The same of doubts that come after others, which were told.
pub fn report_further_doubts(doubts: &[String]) -> String {
    report("Look at this, too", doubts)
}

fn report(heading: &str, doubts: &[String]) -> String {
    if doubts.is_empty() {
        return String::new();
    }
    let reported: String = doubts.iter().map(|doubt| wrapped("  - ", "    ", doubt)).collect();
    plain(&format!("{heading}\n{reported}")).into_owned()
}

pub(crate) const HEADING: &str = "Look at this first";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubts_are_a_list_or_nothing() {
        assert_eq!(report_doubts(&[]), "");
        let reported = report_doubts(&["joint1 turns up to 170 rad.".to_owned(), "Each row is a pose.".to_owned()]);
        assert_eq!(reported, "Look at this first\n  - joint1 turns up to 170 rad.\n  - Each row is a pose.\n");
    }
}

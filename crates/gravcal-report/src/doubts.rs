//! What a session says that can hardly be so, told before all else.

use crate::text::{plain, wrapped};

/// The doubts of a session as text of 80 columns; empty where there are none.
pub fn tell_doubts(doubts: &[String]) -> String {
    tell(HEADING, doubts)
}

/// The same of doubts that come after others, which were told.
pub fn tell_further_doubts(doubts: &[String]) -> String {
    tell("Look at this, too", doubts)
}

fn tell(heading: &str, doubts: &[String]) -> String {
    if doubts.is_empty() {
        return String::new();
    }
    let told: String = doubts.iter().map(|doubt| wrapped("  - ", "    ", doubt)).collect();
    plain(&format!("{heading}\n{told}")).into_owned()
}

pub(crate) const HEADING: &str = "Look at this first";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubts_are_a_list_or_nothing() {
        assert_eq!(tell_doubts(&[]), "");
        let told = tell_doubts(&["joint1 turns up to 170 rad.".to_owned(), "Each row is a pose.".to_owned()]);
        assert_eq!(told, "Look at this first\n  - joint1 turns up to 170 rad.\n  - Each row is a pose.\n");
    }
}

//! Times in two columns of whole numbers, as messages of ROS have them: seconds, and nanoseconds of the present second.

use crate::rows::joint_state::TIME;

/// Ends of names of two columns that are one time.
const ENDS: [(&str, &str); 5] =
    [("sec", "nanosec"), ("sec", "nsec"), ("secs", "nsecs"), ("secs", "nanosecs"), ("seconds", "nanoseconds")];
/// Nanoseconds of a second.
const BILLION: f64 = 1e9;

/// The places of the two columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stamp {
    seconds: usize,
    nanoseconds: usize,
}

impl Stamp {
    /// The first two that belong together, by their names; `None` where there are no such, or a column is the clock already that this
    /// becomes.
    pub fn find(columns: &[String]) -> Option<Stamp> {
        let names: Vec<String> = columns.iter().map(|column| column.to_lowercase()).collect();
        let pair = |(place, name): (usize, &String)| {
            let of = |(seconds, nanoseconds): &(&str, &str)| {
                // What is before is whole words: `class` and `clans` are none.
                let before = name.strip_suffix(seconds).filter(|before| !before.ends_with(char::is_alphanumeric))?;
                let other = format!("{before}{nanoseconds}");
                let nanoseconds = names.iter().position(|name| *name == other)?;
                Some(Stamp { seconds: place, nanoseconds })
            };
            ENDS.iter().find_map(of)
        };
        let has_clock = columns.iter().any(|column| column == TIME);
        if has_clock { None } else { names.iter().enumerate().find_map(pair) }
    }

    /// Name of the column that they become.
    pub fn column() -> String {
        TIME.to_owned()
    }

    /// Places of both.
    pub fn parts(self) -> [usize; 2] {
        [self.seconds, self.nanoseconds]
    }

    /// The time of a row, s; NaN where one of the two says nothing, or the nanoseconds are not those of one second.
    pub fn time(self, cells: &[f64]) -> f64 {
        let nanoseconds = cells[self.nanoseconds];
        if (0.0..BILLION).contains(&nanoseconds) { cells[self.seconds] + nanoseconds / BILLION } else { f64::NAN }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_that_are_one_time_are_found_by_their_names() {
        let found = |columns: &[&str]| Stamp::find(&columns.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>());
        let stamp = |seconds, nanoseconds| Some(Stamp { seconds, nanoseconds });
        assert_eq!(found(&["q1", "sec", "nanosec"]), stamp(1, 2));
        assert_eq!(found(&["/js/header/stamp/nanosec", "/js/header/stamp/sec"]), stamp(1, 0));
        assert_eq!(found(&["header.stamp.secs", "header.stamp.nsecs"]), stamp(0, 1));
        for none in [&["sec", "q1"][..], &["a.sec", "b.nanosec"], &["time_s", "sec", "nanosec"], &["class", "clans"]] {
            assert_eq!(found(none), None, "{none:?}");
        }
        let time = Stamp { seconds: 1, nanoseconds: 0 }.time(&[250_000_000.0, 1_764_144_000.0]);
        assert_eq!(time, 1_764_144_000.25);
        assert!(Stamp { seconds: 1, nanoseconds: 0 }.time(&[1e9, 1.0]).is_nan());
    }
}

//! Files in which nothing is read, while others have readings: what they say of the arm counts for nothing.

use std::collections::BTreeMap;
use std::path::Path;

use gravcal_recording::file_name;

use crate::session::{ReadingId, Session};

/// One sentence or two for all such files.
pub(super) fn doubt(session: &Session) -> Option<String> {
    let is_read = |pose: usize| {
        (0..session.channel_count()).any(|channel| session.reading(ReadingId { pose, channel }).is_some())
    };
    // By file, of which tables may be parts: how many poses there are, and in how many a torque or an instrument is read.
    let mut counts: BTreeMap<&Path, [usize; 2]> = BTreeMap::new();
    for (pose, of) in session.poses.iter().enumerate() {
        let [poses, read] = counts.entry(session.tables[of.table].path.as_path()).or_default();
        *poses += 1;
        *read += usize::from(is_read(pose));
    }
    if counts.values().all(|[_, read]| *read == 0) {
        return None;
    }
    let unread = counts.iter().filter(|(_, [_, read])| *read == 0);
    let files: Vec<String> = unread.map(|(path, [poses, _])| format!("{} ({poses} poses)", file_name(path))).collect();
    (!files.is_empty()).then(|| {
        format!(
            "No torque counts of {}: cells are empty, no numbers, marked unusable or at an end of the sensor's range, or no joint moves where only motion \
             counts. The angles alone tell nothing. Look at the columns of torques, or leave out what has none.",
            files.join(", ")
        )
    })
}

//! Files in which no torque is read, while others have torques: what they say of the arm counts for nothing.

use gravcal_recording::file_name;

use crate::session::{ReadingId, Session};

/// One sentence for all such files.
pub(super) fn doubt(session: &Session) -> Option<String> {
    let is_read = |pose: usize| {
        (0..session.channel_count()).any(|channel| session.reading(ReadingId { pose, channel }).is_some())
    };
    // By table: how many poses there are, and in how many a torque or an instrument is read.
    let mut counts = vec![[0_usize; 2]; session.tables.len()];
    for (pose, of) in session.poses.iter().enumerate() {
        counts[of.table][0] += 1;
        counts[of.table][1] += usize::from(is_read(pose));
    }
    if counts.iter().all(|[_, read]| *read == 0) {
        return None;
    }
    let unread = session.tables.iter().zip(&counts).filter(|(_, [poses, read])| *poses > 0 && *read == 0);
    let files: Vec<String> =
        unread.map(|(table, [poses, _])| format!("{} ({poses} poses)", file_name(&table.path))).collect();
    (!files.is_empty()).then(|| {
        format!(
            "No torque of any joint counts in {}: its torque columns hold no numbers, or no joint moves where only motion counts. All the rest of it \
             counts for nothing. Look at the columns that readings.torque names, or leave the file out.",
            files.join(", ")
        )
    })
}

//! Rows that stand in two tables which are said to be of different loads: one of the files is a copy of the other.

use std::collections::{BTreeMap, HashMap};

use gravcal_recording::file_name;

use crate::session::{ReadingId, Session};

/// Fewer may agree by chance, with round readings.
const FEWEST: usize = 3;

/// One sentence for each two tables.
pub(super) fn doubts(session: &Session) -> Vec<String> {
    let mut first: HashMap<Vec<u64>, usize> = HashMap::new();
    let mut copied: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
    for place in 0..session.poses.len() {
        let own = &session.poses[place];
        let earlier = &session.poses[*first.entry(numbers(session, place)).or_insert(place)];
        if earlier.table != own.table && earlier.load != own.load {
            copied.entry([earlier.table, own.table]).or_default().push(place);
        }
    }
    let doubt = |([earlier, table], places): ([usize; 2], Vec<usize>)| {
        let name = |table: usize| file_name(&session.tables[table].path);
        let said = |table: usize| {
            let load = session.tables[table].load;
            load.map_or("no load".to_owned(), |load| format!("load {}", session.loads[load].name))
        };
        (places.len() >= FEWEST).then(|| {
            format!(
                "{} rows of {}, which is said to be of {}, are those of {}, of {}, in every number: one of the files is a copy of the other. Record both.",
                places.len(),
                name(table),
                said(table),
                name(earlier),
                said(earlier),
            )
        })
    };
    copied.into_iter().filter_map(doubt).collect()
}

/// Positions and readings of a pose, to the bit.
fn numbers(session: &Session, place: usize) -> Vec<u64> {
    let read = (0..session.channel_count()).map(|channel| session.reading(ReadingId { pose: place, channel }));
    let readings = read.map(|reading| reading.map_or(f64::NAN, |reading| reading.value));
    session.poses[place].position.iter().copied().chain(readings).map(f64::to_bits).collect()
}

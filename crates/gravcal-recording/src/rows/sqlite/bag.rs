//! The messages in one SQLite file of rosbag2, one after another.
//!
//! ```text
//! topics    id, name, type, serialization_format, …
//! messages  id, topic_id, timestamp (when it was received, ns), data
//! ```
//!
//! Source: rosbag2, rosbag2_storage_sqlite3. The file is neither changed nor locked, and nothing is written beside it. SQLite itself
//! looks whether lengths and pages are within the file. Of a file that is damaged or cut the messages are lost that stand on pages that
//! cannot be read; those behind are looked for.

use std::collections::{HashMap, VecDeque};
use std::path::Path;

use rusqlite::types::ValueRef;
use rusqlite::{Connection, OpenFlags, OptionalExtension, Result, Row, ffi, params};

use super::LONGEST_MESSAGE;
use crate::error::ReadError;
use crate::file::opened;
use crate::rows::messages::{Encoding, JOINT_STATE, Topics};

/// Messages that are fetched together, and the bytes after which no more are.
const BATCH: usize = 4096;
const BATCH_BYTES: usize = 1 << 22;

/// After a page that cannot be read so many numbers are tried one by one, and then by longer and longer steps.
const ONE_BY_ONE: i64 = 1 << 10;

/// Messages after a number, without the data of those that are not read.
const MESSAGES: &str = "
    SELECT rowid, topic_id, timestamp, CASE
        WHEN length(data) <= ?2 AND topic_id IN (SELECT id FROM topics WHERE type IN (?3, ?4, ?5)) THEN data
    END
    FROM messages WHERE rowid > ?1 ORDER BY rowid";

/// A file that is read message by message.
pub(super) struct Bag {
    database: Connection,
    /// Place and encoding of each topic, by its identifier.
    topics: HashMap<i64, (usize, Option<Encoding>)>,
    fetched: VecDeque<Fetched>,
    /// Numbers of the first message and of the last, and of the last that was fetched.
    first: i64,
    end: i64,
    last: i64,
    /// How many numbers were tried after a page that cannot be read; 0 where the last could.
    skipped: i64,
    /// How often pages could not be read, after which message they first could not, and why.
    lost: Option<(u64, i64, String)>,
    /// Messages of topics that nothing describes.
    unknown: u64,
}

/// A message as it stands in the file.
struct Fetched {
    number: i64,
    topic: i64,
    time: i64,
    data: Option<Vec<u8>>,
}

/// A message of joint states.
pub(super) struct Stored {
    pub topic: usize,
    pub encoding: Encoding,
    pub log_time: u64,
    pub data: Vec<u8>,
}

impl Bag {
    /// Opens a file, and adds its topics.
    pub(super) fn open(path: &Path, topics: &mut Topics) -> std::result::Result<Bag, ReadError> {
        opened(path).map_err(|cause| ReadError::opening(path, cause))?;
        let refused = |what: String| ReadError::NotRecording { path: path.to_owned(), what };
        let unreadable = |error| refused(format!("this SQLite file cannot be read, it seems to be damaged: {error}"));
        let database = connect(path).map_err(unreadable)?;
        for table in ["topics", "messages"] {
            if !is_table(&database, table).map_err(unreadable)? {
                let what = format!("it is a SQLite file, but no bag of ROS 2: it has no table `{table}`");
                return Err(refused(what));
            }
        }
        let topics = found_topics(&database, topics).map_err(unreadable)?;
        let first = ends(&database, "min").unwrap_or(0);
        // Where the last page is lost, all numbers are tried that there may be.
        let end = ends(&database, "max").unwrap_or(i64::MAX);
        let (fetched, last) = (VecDeque::new(), first.saturating_sub(1));
        Ok(Bag { database, topics, fetched, first, end, last, skipped: 0, lost: None, unknown: 0 })
    }

    /// The next message of joint states that can be read.
    pub(super) fn next(&mut self, topics: &mut Topics) -> Option<Stored> {
        loop {
            if self.fetched.is_empty() {
                self.fetch();
            }
            let Fetched { topic, time, data, .. } = self.fetched.pop_front()?;
            let Some((topic, encoding)) = self.topics.get(&topic).copied() else {
                self.unknown += 1;
                continue;
            };
            topics.count(topic);
            let Some(encoding) = encoding else { continue };
            // What is too long is as good as damaged: nothing of it is there to be read.
            let (log_time, data) = (u64::try_from(time).unwrap_or(0), data.unwrap_or_default());
            return Some(Stored { topic, encoding, log_time, data });
        }
    }

    /// What could not be read so far.
    pub(super) fn remarks(&self) -> impl Iterator<Item = String> + '_ {
        let lost = self.lost.as_ref().map(|(count, first, cause)| {
            format!(
                "the SQLite file is damaged ({cause}): {count} times messages are lost, the first time after \
                 number {first}"
            )
        });
        let unknown = (self.unknown > 0).then(|| {
            format!("{} messages are left out, because nothing in the file describes their topic", self.unknown)
        });
        lost.into_iter().chain(unknown)
    }

    /// Which share of the file is read.
    pub(super) fn progress(&self) -> f64 {
        let all = (i128::from(self.end) - i128::from(self.first) + 1).max(1);
        let read = i128::from(self.last) - i128::from(self.first) + 1;
        (read as f64 / all as f64).clamp(0.0, 1.0)
    }

    /// Fetches the next messages; none at the end.
    fn fetch(&mut self) {
        while self.fetched.is_empty() && self.last < self.end {
            let before = self.last;
            let Err(error) = self.fetch_batch() else {
                // All there are behind the last.
                if self.fetched.is_empty() {
                    self.last = self.end;
                }
                continue;
            };
            if self.skipped == 0 {
                let after = self.fetched.back().map_or(before, |fetched| fetched.number);
                let lost = self.lost.get_or_insert((0, after, error.to_string()));
                lost.0 += 1;
            }
            // How many messages are on the page that cannot be read is not known.
            self.skipped = if self.skipped < ONE_BY_ONE { self.skipped + 1 } else { self.skipped.saturating_mul(2) };
            self.last = self.last.saturating_add((self.skipped - ONE_BY_ONE).max(1));
        }
    }

    /// Fetches some messages after the last. Those before an error are kept.
    fn fetch_batch(&mut self) -> Result<()> {
        let mut statement = self.database.prepare(MESSAGES)?;
        let [a, b, c] = JOINT_STATE;
        let mut rows = statement.query(params![self.last, LONGEST_MESSAGE as i64, a, b, c])?;
        let mut bytes = 0;
        while let Some(row) = rows.next()? {
            let fetched = fetched(row)?;
            // On damaged pages numbers may go round in a circle.
            if fetched.number <= self.last {
                self.last = self.end;
                return Err(rusqlite::Error::SqliteFailure(ffi::Error::new(ffi::SQLITE_CORRUPT), None));
            }
            self.last = fetched.number;
            self.skipped = 0;
            bytes += fetched.data.as_ref().map_or(0, Vec::len);
            self.fetched.push_back(fetched);
            if self.fetched.len() == BATCH || bytes > BATCH_BYTES {
                break;
            }
        }
        Ok(())
    }
}

fn fetched(row: &Row<'_>) -> Result<Fetched> {
    let integer = |column: usize| -> Result<i64> { Ok(row.get_ref(column)?.as_i64().unwrap_or(-1)) };
    let data = match row.get_ref(3)? {
        ValueRef::Blob(data) | ValueRef::Text(data) => Some(data.to_owned()),
        _ => None,
    };
    Ok(Fetched { number: integer(0)?, topic: integer(1)?, time: integer(2)?, data })
}

/// When the first message of a file was received, ns; the end of time where there is none that can be read.
pub(in crate::rows) fn first_time(path: &Path) -> u64 {
    let first = || -> Result<i64> {
        connect(path)?.query_row("SELECT timestamp FROM messages ORDER BY rowid LIMIT 1", [], |row| row.get(0))
    };
    first().ok().and_then(|time| u64::try_from(time).ok()).unwrap_or(u64::MAX)
}

/// Opens a file to read it only. Where no journal of somebody who writes it lies beside it, it is said not to change, so that SQLite
/// needs no lock and writes nothing beside it.
fn connect(path: &Path) -> Result<Connection> {
    let beside = |ending: &str| {
        let mut name = path.as_os_str().to_owned();
        name.push(ending);
        std::fs::metadata(name).is_ok_and(|found| found.len() > 0)
    };
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let database = match uri(path).filter(|_| !beside("-wal") && !beside("-journal")) {
        Some(uri) => Connection::open_with_flags(uri, flags | OpenFlags::SQLITE_OPEN_URI)?,
        None => Connection::open_with_flags(path, flags)?,
    };
    // Nothing that the file itself defines is called; and a file that is cut is read as far as it goes.
    database.execute_batch("PRAGMA trusted_schema = OFF; PRAGMA writable_schema = ON; PRAGMA cell_size_check = ON")?;
    Ok(database)
}

/// A path as SQLite takes it with options behind; none where it is no text.
fn uri(path: &Path) -> Option<String> {
    let absolute = std::path::absolute(path).ok()?;
    let text = absolute.to_str()?.replace(std::path::MAIN_SEPARATOR, "/");
    let slash = if text.starts_with('/') { "" } else { "/" };
    let encoded: String = text.replace('%', "%25").replace('?', "%3f").replace('#', "%23");
    Some(format!("file://{slash}{encoded}?immutable=1"))
}

/// Whether there is a table of this name, which is no view: what a view says may have no end.
fn is_table(database: &Connection, name: &str) -> Result<bool> {
    let sql = "SELECT 1 FROM sqlite_master WHERE type = 'table' AND rootpage > 0 AND name = ?1";
    Ok(database.query_row(sql, [name], |_| Ok(())).optional()?.is_some())
}

/// Number of the first or last message.
fn ends(database: &Connection, which: &str) -> Option<i64> {
    database.query_row(&format!("SELECT {which}(rowid) FROM messages"), [], |row| row.get(0)).ok().flatten()
}

fn found_topics(database: &Connection, topics: &mut Topics) -> Result<HashMap<i64, (usize, Option<Encoding>)>> {
    let mut statement = database.prepare("SELECT id, name, type, serialization_format FROM topics ORDER BY id")?;
    let mut rows = statement.query([])?;
    let mut found = HashMap::new();
    while let Some(row) = rows.next()? {
        let text = |column: usize| -> Result<String> {
            Ok(String::from_utf8_lossy(row.get_ref(column)?.as_bytes().unwrap_or_default()).into_owned())
        };
        found.insert(row.get(0)?, topics.add(&text(1)?, text(2)?, &text(3)?));
    }
    Ok(found)
}

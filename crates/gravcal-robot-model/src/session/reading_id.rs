//! What tells a reading from all others of its session.

/// A reading of a session, by where it was read and by what.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ReadingId {
    /// Index into [`Session::poses`](super::Session::poses).
    pub pose: usize,
    /// Which of its channels: see [`Session::channel_name`](super::Session::channel_name).
    pub channel: usize,
}

//! Whose rows are whose, and in which order they were read.

use std::collections::BTreeMap;

use gravcal_estimation::statistics::ResidualMaker;
use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::Solved;

/// Degrees of freedom beyond which a scale is as good as known.
pub const MANY: f64 = 1e6;

/// A reading as a row of a problem.
#[derive(Clone, Copy, Debug)]
pub struct ReadingRow {
    pub row: usize,
    pub pose: usize,
    /// Its standard deviation, in its unit.
    pub std: f64,
}

/// Rows of a problem by what they read. Owners are the channels, and knowledge as the last one.
#[derive(Debug)]
pub struct Rows {
    owner: Vec<usize>,
    channels: usize,
    /// Place of each row's pose in the order of reading.
    place: Vec<usize>,
    poses: usize,
    of_channel: Vec<Vec<usize>>,
    pairs: Vec<Vec<(usize, usize)>>,
    /// Trace of the residual maker among an owner's rows.
    freedom: Vec<f64>,
    /// Whether the rows of a pose share errors beside their noise.
    share_errors: bool,
    /// How much each row tells of the noise: its weight under a loss; empty where all tell it fully.
    counts: Vec<f64>,
}

impl Rows {
    pub fn new(session: &Session, solved: &Solved, maker: &ResidualMaker) -> Rows {
        let rows = &solved.built.rows;
        let channels = session.channel_count();
        let mut owner = vec![channels; maker.residuals().len()];
        let mut of_channel = vec![Vec::new(); channels];
        for (row, ReadingId { channel, .. }) in rows.iter().enumerate() {
            owner[row] = *channel;
            of_channel[*channel].push(row);
        }
        let mut order: Vec<usize> = rows.iter().map(|id| id.pose).collect();
        order.dedup();
        // By table, and in it by time where that is told; a sort keeps the order of equals.
        let time = |pose: usize| session.poses[pose].conditions.time.unwrap_or(0.0);
        order.sort_by(|a, b| session.poses[*a].table.cmp(&session.poses[*b].table).then(time(*a).total_cmp(&time(*b))));
        let places: BTreeMap<usize, usize> = order.iter().enumerate().map(|(place, pose)| (*pose, place)).collect();
        let place: Vec<usize> = rows.iter().map(|id| places[&id.pose]).collect();
        let table = |row: usize| session.poses[rows[row].pose].table;
        let pairs = |own: &Vec<usize>| {
            let mut own = own.clone();
            own.sort_by_key(|row| place[*row]);
            own.windows(2).map(|pair| (pair[0], pair[1])).filter(|(a, b)| table(*a) == table(*b)).collect()
        };
        let pairs = of_channel.iter().map(pairs).collect();
        let (poses, freedom) = (order.len(), Vec::new());
        let (share_errors, counts) = (false, Vec::new());
        let mut rows = Rows { owner, channels, place, poses, of_channel, pairs, freedom, share_errors, counts };
        rows.count_freedom(maker);
        rows
    }

    /// The same where rows are weighted: what is taken for an outlier tells nothing of the noise.
    pub fn weighted(mut self, weights: &[f64], maker: &ResidualMaker) -> Rows {
        self.counts = weights.to_vec();
        self.count_freedom(maker);
        self
    }

    /// How much a row tells of the noise, from 0 to 1.
    pub fn count(&self, row: usize) -> f64 {
        self.counts.get(row).copied().unwrap_or(1.0)
    }

    /// The same where the rows of a pose share errors, or do not.
    pub fn sharing_errors(self, share_errors: bool) -> Rows {
        Rows { share_errors, ..self }
    }

    /// Whether the rows of a pose share errors beside their noise.
    pub fn share_errors(&self) -> bool {
        self.share_errors
    }

    /// Whether rows tell unlike much of the noise.
    pub fn are_weighted(&self) -> bool {
        !self.counts.is_empty()
    }

    /// To be done again where the residual maker is another.
    pub fn count_freedom(&mut self, maker: &ResidualMaker) {
        self.freedom = vec![0.0; self.owners()];
        for (row, entry) in maker.diagonal().into_iter().enumerate() {
            self.freedom[self.owner[row]] += self.count(row) * entry.max(0.0);
        }
    }

    /// Channels, and knowledge.
    pub fn owners(&self) -> usize {
        self.channels + 1
    }

    pub fn channels(&self) -> usize {
        self.channels
    }

    pub fn owner(&self, row: usize) -> usize {
        self.owner[row]
    }

    /// Degrees of freedom of each owner's residuals.
    pub fn freedom(&self) -> &[f64] {
        &self.freedom
    }

    pub fn of_channel(&self, channel: usize) -> &[usize] {
        &self.of_channel[channel]
    }

    /// Rows of neighbouring poses of one table.
    pub fn pairs(&self, channel: usize) -> &[(usize, usize)] {
        &self.pairs[channel]
    }

    /// Rows of a channel that follow each other, table by table; without tables of one row.
    pub fn sequences(&self, channel: usize) -> Vec<Vec<usize>> {
        let mut sequences: Vec<Vec<usize>> = Vec::new();
        for (first, second) in self.pairs(channel) {
            match sequences.last_mut().filter(|sequence| sequence.last() == Some(first)) {
                Some(sequence) => sequence.push(*second),
                None => sequences.push(vec![*first, *second]),
            }
        }
        sequences
    }

    /// Place of a row's pose in the order of reading; nothing for knowledge.
    pub fn place(&self, row: usize) -> Option<usize> {
        self.place.get(row).copied()
    }

    pub fn poses(&self) -> usize {
        self.poses
    }
}

#[cfg(test)]
impl Rows {
    /// One channel read once in each pose of one table.
    pub fn plain(count: usize, maker: &ResidualMaker) -> Rows {
        Rows::of_sweeps(1, count, maker)
    }

    /// One channel read once in each pose of some tables of as many poses each.
    pub fn of_sweeps(sweeps: usize, bins: usize, maker: &ResidualMaker) -> Rows {
        let count = sweeps * bins;
        let mut rows = Rows {
            owner: vec![0; count],
            channels: 1,
            place: (0..count).collect(),
            poses: count,
            of_channel: vec![(0..count).collect()],
            pairs: vec![(1..count).filter(|row| row % bins != 0).map(|row| (row - 1, row)).collect()],
            freedom: Vec::new(),
            share_errors: false,
            counts: Vec::new(),
        };
        rows.count_freedom(maker);
        rows
    }
}

//! A recording read back. The acceptance tests read this file, too.

use std::collections::BTreeMap;

use re_log_encoding::DecoderApp;
use re_sdk::StoreKind;
use re_sdk::external::arrow::array::ListArray;
use re_sdk::log::{Chunk, LogMsg};
use re_sdk_types::archetypes::Scalars;

/// The chunks of a recording.
pub struct ReadBack {
    chunks: Vec<Chunk>,
}

impl ReadBack {
    /// Of the bytes of a file, blueprints left out.
    pub fn of(bytes: &[u8]) -> ReadBack {
        let messages = DecoderApp::decode_eager(std::io::Cursor::new(bytes)).unwrap().map(Result::unwrap);
        let chunk = |message| match message {
            LogMsg::ArrowMsg(store, message) if store.kind() == StoreKind::Recording => {
                Some(Chunk::from_arrow_msg(&message).unwrap())
            }
            _ => None,
        };
        ReadBack { chunks: messages.filter_map(chunk).collect() }
    }

    /// How many rows each entity has on each timeline; `static` of those without one.
    pub fn rows(&self) -> BTreeMap<String, BTreeMap<String, usize>> {
        let mut rows: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
        for chunk in &self.chunks {
            let entity = rows.entry(chunk.entity_path().to_string()).or_default();
            for timeline in chunk.timelines().keys() {
                *entity.entry(timeline.to_string()).or_default() += chunk.num_rows();
            }
            if chunk.is_static() {
                *entity.entry("static".into()).or_default() += chunk.num_rows();
            }
        }
        rows
    }

    /// Times and numbers of everything, in an order of their own.
    pub fn contents(&self) -> Vec<Contents> {
        let mut contents: Vec<Contents> = self.chunks.iter().map(Contents::of).collect();
        contents.sort_by(|a, b| (&a.path, &a.timelines).cmp(&(&b.path, &b.timelines)));
        contents
    }

    /// The numbers of a series.
    pub fn scalars(&self, path: &str) -> Vec<f64> {
        let own = self.chunks.iter().filter(|chunk| chunk.entity_path().to_string() == path);
        let component = Scalars::descriptor_scalars().component;
        own.flat_map(|chunk| chunk.iter_slices::<f64>(component).flatten().copied().collect::<Vec<f64>>()).collect()
    }
}

/// What a chunk says, without the numbers that Rerun gives rows and chunks at random.
#[derive(PartialEq)]
pub struct Contents {
    pub path: String,
    timelines: Vec<(String, Vec<i64>)>,
    components: BTreeMap<String, ListArray>,
}

impl Contents {
    fn of(chunk: &Chunk) -> Contents {
        let times = chunk.timelines().iter().map(|(name, times)| (name.to_string(), times.times_raw().to_vec()));
        let mut timelines: Vec<(String, Vec<i64>)> = times.collect();
        timelines.sort();
        let columns = chunk.components().values();
        Contents {
            path: chunk.entity_path().to_string(),
            timelines,
            components: columns.map(|column| (column.descriptor.to_string(), column.list_array.clone())).collect(),
        }
    }
}

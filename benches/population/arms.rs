//! Which arms sessions are of.

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::arm::{self, Arm};

/// Which arms.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Arms {
    /// Those of URDFs of the shared data, and a random one in turn.
    All,
    /// Random ones alone, which need no files.
    Random,
}

impl Arms {
    /// The robots of the shared data, in `GRAVCAL_SHARED_DATA` or `../shared/data` beside the project; none where arms are random.
    ///
    /// # Errors
    /// Where there is no such folder, or a robot in it cannot be read.
    pub fn robots(self) -> Result<Vec<Arm>, String> {
        if self == Arms::Random {
            return Ok(Vec::new());
        }
        let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
        let folder = std::env::var_os("GRAVCAL_SHARED_DATA").map_or_else(beside, PathBuf::from).join("urdf");
        if !folder.is_dir() {
            let folder = folder.display();
            return Err(format!(
                "{folder}: there are no URDFs; GRAVCAL_SHARED_DATA names the folder of shared data, --arms random needs none"
            ));
        }
        arm::robots(&folder)
    }
}

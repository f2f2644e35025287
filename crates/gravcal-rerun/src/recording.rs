//! A calibration on its way into Rerun: into the bytes of a file, or to a viewer.

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use re_sdk::external::re_uri::ProxyUri;
use re_sdk::log::ChunkBatcherConfig;
use re_sdk::{RecordingStream, RecordingStreamBuilder, SpawnOptions};
use thiserror::Error;

use crate::contents::CalibrationRecording;
use crate::{arm, blueprint, gravity, identifiability, poses, residuals, series, spectra, sweeps, trace, verdict};

/// Under this name the viewer remembers what a user changed of the layout.
const APPLICATION: &str = "gravcal";
/// Where a viewer listens unless it is told otherwise.
pub const VIEWER_URL: &str = re_sdk::DEFAULT_CONNECT_URL;
/// How long a viewer may take to answer.
const PATIENCE_TO_CONNECT: Duration = Duration::from_secs(5);
/// How long a viewer may take to receive everything.
const PATIENCE: Duration = Duration::from_secs(60);

/// Why there is no recording.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// Rerun refuses what it is given.
    #[error("Rerun cannot take the recording")]
    Stream(#[from] re_sdk::RecordingStreamError),
    /// It cannot be put into bytes.
    #[error("Rerun cannot encode the recording")]
    Encode(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// What should name a viewer does not.
    #[error("`{url}` is no address of a Rerun viewer, such as {VIEWER_URL}")]
    Address {
        /// What was given.
        url: String,
    },
    /// No viewer listens, or it does not receive everything.
    #[error("no Rerun viewer receives the recording at {url}")]
    Unreachable {
        /// Where one was expected.
        url: String,
        /// What Rerun says.
        #[source]
        cause: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl CalibrationRecording<'_> {
    /// The contents of an `.rrd` file.
    ///
    /// # Errors
    /// Where Rerun refuses the data or cannot encode them.
    pub fn to_rrd(&self) -> Result<Vec<u8>, RecordingError> {
        let (stream, storage) = self.builder().memory()?;
        self.log(&stream)?;
        storage.drain_as_bytes().map_err(|error| RecordingError::Encode(Box::new(error)))
    }

    /// Sends everything to a viewer that is open, at `url` such as `rerun+http://127.0.0.1:9876/proxy`.
    ///
    /// # Errors
    /// Where `url` is none, or no viewer is there.
    pub fn connect(&self, url: &str) -> Result<(), RecordingError> {
        reach(url).map_err(|cause| RecordingError::Unreachable { url: url.to_owned(), cause })?;
        self.send(self.builder().connect_grpc_opts(url)?, url)
    }

    /// Opens a viewer (the program `rerun` of the search path) and sends everything to it.
    ///
    /// # Errors
    /// Where there is no such program, or it does not receive anything.
    pub fn spawn(&self) -> Result<(), RecordingError> {
        let options = SpawnOptions { wait_for_bind: true, ..SpawnOptions::default() };
        self.send(self.builder().spawn_opts(&options)?, &options.connect_addr().to_string())
    }

    fn send(&self, stream: RecordingStream, url: &str) -> Result<(), RecordingError> {
        self.log(&stream)?;
        stream.flush_with_timeout(PATIENCE).map_err(|error| {
            // What could not be sent would be waited for without end.
            std::mem::forget(stream);
            RecordingError::Unreachable { url: url.to_owned(), cause: Box::new(error) }
        })
    }

    /// Whatever the environment says of Rerun: who asked for a recording gets it, and nothing is cut by a clock.
    fn builder(&self) -> RecordingStreamBuilder {
        RecordingStreamBuilder::new(APPLICATION)
            .recording_id(self.id)
            .enabled(true)
            .send_properties(false)
            .batcher_config(ChunkBatcherConfig::NEVER)
            .with_blueprint(blueprint::blueprint(self))
    }

    fn log(&self, stream: &RecordingStream) -> Result<(), RecordingError> {
        stream.set_log_time_enabled(false);
        stream.set_log_tick_enabled(false);
        let poses = poses::PoseTimes::of(self.session);
        verdict::log(stream, self)?;
        arm::log(stream, self, &poses)?;
        gravity::log(stream, self)?;
        series::log(stream, self, &poses)?;
        residuals::log(stream, self, &poses)?;
        spectra::log(stream, self)?;
        sweeps::log(stream, self)?;
        poses::log(stream, self)?;
        trace::log(stream, self)?;
        identifiability::log(stream, self)?;
        Ok(())
    }
}

/// Sees to it that a text names a viewer, whether or not one listens there.
///
/// # Errors
/// It does not.
pub fn check_address(url: &str) -> Result<(), RecordingError> {
    match url.parse::<ProxyUri>() {
        Ok(_) => Ok(()),
        Err(_) => Err(RecordingError::Address { url: url.to_owned() }),
    }
}

/// Whether anybody listens at an address: Rerun's client waits without end where nobody does and there is much to send.
fn reach(url: &str) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let origin = url.parse::<ProxyUri>()?.origin;
    let mut failure = io::Error::from(io::ErrorKind::AddrNotAvailable);
    for address in format!("{}:{}", origin.host, origin.port).to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, PATIENCE_TO_CONNECT) {
            Ok(_) => return Ok(()),
            Err(error) => failure = error,
        }
    }
    Err(failure.into())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use gravcal_calibration::result::TorqueParts;

    use crate::testing::Calibrated;

    /// Paths of the table in the crate's documentation, in their parts; `None` stands for any name.
    fn documented() -> Vec<Vec<Option<&'static str>>> {
        let rows = include_str!("lib.rs").lines().filter_map(|line| line.strip_prefix("//! | `/"));
        let cells = rows.filter_map(|row| row.split('|').next());
        let paths = cells.flat_map(|cell| cell.split(", ")).map(|path| path.trim().trim_matches(['`', '/']));
        let part = |part: &'static str| (part.to_uppercase() != part).then_some(part);
        paths.map(|path| path.split('/').map(part).collect()).collect()
    }

    fn is_like(path: &str, pattern: &[Option<&str>]) -> bool {
        let parts: Vec<&str> = path.trim_start_matches('/').split('/').collect();
        parts.len() == pattern.len()
            && parts.iter().zip(pattern).all(|(part, like)| like.is_none_or(|like| like == *part))
    }

    #[test]
    fn what_torque_in_motion_is_made_of_is_logged() {
        let mut calibrated = Calibrated::sarcos_shoulder().clone();
        let fit = calibrated.results[1].fit.as_mut().unwrap();
        for row in fit.residuals.iter_mut().filter(|row| row.id.channel == 1) {
            row.torque = Some(TorqueParts { gravity: 3.0, inertia: 2.0, bias: 1.0 });
        }
        let rows = calibrated.read_back().rows();
        let logged = |path: &str| rows.get(path).and_then(|timelines| timelines.get("pose")).copied();
        for part in ["gravity", "inertia", "friction"] {
            let [of_first, of_second] = ["joint1", "joint2"].map(|joint| logged(&format!("/readings/{joint}/{part}")));
            assert!(of_first.is_none() && of_second.is_some_and(|count| count > 100), "{part} {of_second:?}");
        }
    }

    #[test]
    fn entities_and_their_counts_are_as_documented() {
        let calibrated = Calibrated::sarcos_shoulder();
        let rows = calibrated.read_back().rows();
        let documented = documented();
        for path in rows.keys().filter(|path| *path != "/") {
            assert!(documented.iter().any(|pattern| is_like(path, pattern)), "{path} is not documented");
        }
        let absent = |pattern: &&Vec<Option<&str>>| !rows.keys().any(|path| is_like(path, pattern));
        let absent: BTreeSet<_> = documented.iter().filter(absent).map(|pattern| pattern[0]).collect();
        // Its tables are no recordings in motion, and its readings have no parts.
        assert_eq!(
            absent,
            BTreeSet::from([Some("readings"), Some("slow_sweeps"), Some("spectra"), Some("standstills")])
        );

        let count = |path: &str, timeline: &str| rows[path].get(timeline).copied();
        for path in
            ["/arm/link3", "/readings/joint1/measured", "/readings/joint2/nominal", "/residuals/in_std/joint/joint3"]
        {
            assert_eq!((count(path, "pose"), count(path, "time")), (Some(407), None), "{path}");
        }
        assert_eq!((count("/sweeps/measured", "pose"), count("/sweeps/now", "pose")), (Some(11), Some(407)));
        let joint = &calibrated.results[1];
        assert_eq!(count("/trace/joint/log10_cost", "iteration"), Some(joint.iterations + 1));
        assert_eq!(count("/parameters/joint/torque_gain/joint3/value", "iteration"), Some(joint.iterations + 1));
        for path in ["/verdict", "/gravity/joint/cone95", "/identifiability/sequential/singular_values"] {
            assert_eq!(count(path, "static"), Some(1), "{path}");
        }
        assert!(rows.values().flat_map(|timelines| timelines.keys()).all(|name| !name.starts_with("log_")));
    }

    #[test]
    fn numbers_come_back() {
        let calibrated = Calibrated::sarcos_shoulder();
        let back = calibrated.read_back();
        let joint = &calibrated.results[1];
        let residuals = back.scalars("/residuals/in_unit/joint/joint2");
        let fit = joint.fit.as_ref().unwrap().joints.iter().find(|fit| fit.joint == "joint2").unwrap();
        let rms = (residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64).sqrt();
        assert!((rms / fit.rms - 1.0).abs() < 1e-9, "{rms} {}", fit.rms);

        for parameter in joint.parameters.iter().filter(|parameter| parameter.held.is_none()) {
            let (owner, quantity) = parameter.name.rsplit_once('.').unwrap();
            let series = |what: &str| back.scalars(&format!("/parameters/joint/{quantity}/{owner}/{what}"));
            let way = series("value");
            assert!(parameter.value.is_none_or(|value| way.last() == Some(&value)), "{} {way:?}", parameter.name);
            assert!(way.first() != way.last(), "{} {way:?}", parameter.name);
            let ends = parameter.ci95.map(|ends| ends.map(Some));
            assert_eq!(ends.unwrap_or_default(), ["low", "high"].map(|what| series(what).first().copied()));
        }

        // What nominal sensors explain is far off, and what is found is not.
        let off = |name: &str| {
            let predicted = back.scalars(&format!("/readings/joint1/{name}"));
            let read = back.scalars("/readings/joint1/measured");
            predicted.iter().zip(read).fold(0.0, |most: f64, (p, r)| most.max((p - r).abs()))
        };
        assert!(off("nominal") > 10.0 && off("joint") < 3.0, "{} {}", off("nominal"), off("joint"));
    }

    #[test]
    fn one_calibration_gives_one_recording() {
        let calibrated = Calibrated::sarcos_shoulder();
        let (a, b) = (calibrated.read_back().contents(), calibrated.read_back().contents());
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(&b) {
            assert!(a == b, "{} {}", a.path, b.path);
        }
    }

    #[test]
    fn a_failed_estimate_shows_its_residuals_and_no_values() {
        let session = &Calibrated::sarcos_shoulder().session;
        let mut reversed = session.clone();
        for pose in &mut reversed.poses {
            pose.torque[1].iter_mut().for_each(|reading| reading.value = 4096.0 - reading.value);
        }
        let calibrated = Calibrated::of(reversed);
        let rows = calibrated.read_back().rows();
        assert_eq!(rows["/residuals/in_std/joint/joint2"]["pose"], session.poses.len());
        assert!(!rows.keys().any(|path| path.starts_with("/parameters/joint") || path == "/gravity/joint"), "{rows:?}");
    }
}

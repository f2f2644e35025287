//! The moments of all windows of a session, and what would be read at them beyond joints that bend.

use std::collections::HashMap;
use std::sync::Arc;

use gravcal_recording::{Course, Kept, MotionSample, WeighedStretch};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;

use crate::joint::model_error::bending_in_motion::carried::{Carried, CarriedAt};
use crate::joint::variables::State;

const POSITION_GAIN: usize = SensorParameter::PositionGain as usize;

/// The moments of all windows of a session, each once.
pub(super) struct Moments {
    stretches: Vec<Arc<[MotionSample]>>,
    /// Of each stretch, the first pose that sees it, and the number of its first moment.
    poses: Vec<usize>,
    firsts: Vec<usize>,
    /// By pose, the numbers of the stretches that it sees.
    seen: Vec<Vec<usize>>,
    /// When each is, s.
    pub times: Vec<f64>,
    /// Those before which the load changes.
    pub changes: Vec<usize>,
}

impl Moments {
    pub fn of(session: &Session) -> Moments {
        let (mut stretches, mut poses, mut firsts, mut times) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut numbers: HashMap<*const MotionSample, usize> = HashMap::new();
        let mut seen = vec![Vec::new(); session.poses.len()];
        for (pose, seen) in seen.iter_mut().enumerate() {
            for WeighedStretch { moments, .. } in session.poses[pose].course.iter().flat_map(|course| &course.stretches)
            {
                let number = *numbers.entry(moments.as_ptr()).or_insert_with(|| {
                    stretches.push(Arc::clone(moments));
                    poses.push(pose);
                    firsts.push(times.len());
                    times.extend(moments.iter().map(|moment| moment.time));
                    stretches.len() - 1
                });
                seen.push(number);
            }
        }
        let load = |stretch: usize| session.poses[poses[stretch]].load;
        let changes = (1..stretches.len()).filter(|stretch| load(*stretch) != load(stretch - 1));
        let changes = changes.map(|stretch| firsts[stretch]).collect();
        Moments { stretches, poses, firsts, seen, times, changes }
    }

    /// Each moment with the pose that sees it first.
    pub fn all(&self) -> impl Iterator<Item = (usize, &MotionSample)> {
        self.stretches
            .iter()
            .zip(&self.poses)
            .flat_map(|(stretch, pose)| stretch.iter().map(move |moment| (*pose, moment)))
    }

    /// The session as if its positions had been read beyond joints that bend by these compliances under what they carry.
    pub fn session_read_beyond(
        &self,
        session: &Session,
        state: &State,
        compliances: &[f64],
        carried: &Carried,
    ) -> Session {
        let of_stretch = |(stretch, first): (&Arc<[MotionSample]>, &usize)| -> Arc<[MotionSample]> {
            let moments = stretch.iter().zip(&carried[*first..]);
            moments.map(|(moment, carried)| read_beyond(moment, state, compliances, carried)).collect()
        };
        let stretches: Vec<Arc<[MotionSample]>> = self.stretches.iter().zip(&self.firsts).map(of_stretch).collect();
        let mut session = session.clone();
        for (pose, seen) in session.poses.iter_mut().zip(&self.seen) {
            let Some(course) = &mut pose.course else { continue };
            let same = |(number, read): (&usize, &WeighedStretch)| WeighedStretch {
                moments: Arc::clone(&stretches[*number]),
                weights: read.weights.clone(),
            };
            let stretches = seen.iter().zip(&course.stretches).map(same).collect();
            *course = Arc::new(Course { stretches, kept: Kept::default() });
        }
        session
    }
}

/// What position sensors would read beyond joints that bend under what they carry.
pub(super) fn read_beyond(
    moment: &MotionSample,
    state: &State,
    compliances: &[f64],
    carried: &CarriedAt,
) -> MotionSample {
    let added = |read: &[f64], by: &[f64]| {
        let joints = read.iter().zip(by).zip(compliances.iter().zip(&state.sensors));
        joints.map(|((read, by), (compliance, sensor))| read + compliance * by / sensor[POSITION_GAIN]).collect()
    };
    let [torque, first, second] = carried;
    MotionSample {
        time: moment.time,
        position: added(&moment.position, torque),
        velocity: added(&moment.velocity, first),
        acceleration: added(&moment.acceleration, second),
    }
}

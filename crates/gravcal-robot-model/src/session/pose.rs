//! Static poses and the tables that they come from.

use std::path::PathBuf;
use std::sync::Arc;

use gravcal_dynamics::{Chain, Transform};
use gravcal_recording::{Conditions, Course, Kept, Orientation, Reading};

/// One `[[poses]]` or `[[validation]]` of the session.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseTable {
    /// The file.
    pub path: PathBuf,
    /// Index of the load attached, if any.
    pub load: Option<usize>,
    /// Index of the swept joint, where declared.
    pub swept: Option<usize>,
    /// The step of the sequential procedure that may read its sweeps; `None`: every step that can.
    pub step: Option<u8>,
}

/// One static pose, or a window of an arm in motion, of which these are the means.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Index into [`Session::tables`](crate::Session::tables).
    pub table: usize,
    /// Line of the file.
    pub line: u64,
    /// Label of the declared sweep, where a column gives one.
    pub sweep_label: Option<String>,
    /// Index of the load attached, if any.
    pub load: Option<usize>,
    /// Position readings (rad, m, or the sensor's own unit).
    pub position: Vec<f64>,
    /// Rotation of the body that carries the instruments in the base's frame, where there are no joints.
    pub orientation: Option<Orientation>,
    /// Torque readings, absent where missing or unusable.
    pub torque: Vec<Option<Reading>>,
    /// Readings of the axes of all instruments, absent where missing or unusable.
    pub instruments: Vec<Option<Reading>>,
    /// Under which conditions they were read; time counts from the session's first pose.
    pub conditions: Conditions,
    /// How the arm moved, where it did.
    pub course: Option<Arc<Course>>,
}

impl Pose {
    /// Takes the position of each of two joints for the other's; in a window with all that comes of positions. `gains`: nominal ones of both, by which
    /// velocities are those of coordinates.
    pub fn swap_positions(&mut self, [a, b]: [usize; 2], gains: [f64; 2]) {
        self.position.swap(a, b);
        let Some(course) = &mut self.course else { return };
        let course = Arc::make_mut(course);
        course.kept = Kept::default();
        for moment in course.stretches.iter_mut().flat_map(|stretch| Arc::make_mut(&mut stretch.moments)) {
            for list in [&mut moment.position, &mut moment.velocity, &mut moment.acceleration] {
                list.swap(a, b);
            }
        }
        let Conditions { velocity, acceleration, direction, presliding, .. } = &mut self.conditions;
        let ratio = gains[0] / gains[1];
        for (list, ratio) in [(velocity, ratio), (acceleration, ratio), (direction, ratio.signum())] {
            list.swap(a, b);
            list[a] *= ratio;
            list[b] /= ratio;
        }
        if !presliding.is_empty() {
            presliding.swap(a, b);
        }
    }

    /// Frames of all links in the base's, at these coordinates of the joints (rad or m), or as a body without joints stood.
    pub fn link_frames(&self, chain: &Chain, coordinates: &[f64]) -> Vec<Transform> {
        let frames = chain.forward(coordinates);
        // What was read is a rotation.
        let turned = self.orientation.and_then(|rotation| Transform::from_rotation(rotation, [0.0; 3]).ok());
        match turned {
            None => frames,
            Some(turned) => frames.iter().map(|frame| turned.compose(frame)).collect(),
        }
    }
}

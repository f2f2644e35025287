//! The session's columns among those of a recording.

use gravcal_recording::{MotionSource, PoseMapping};

/// Places of columns; `None` where the recording has none yet, or the session names none.
#[derive(Debug, Default)]
pub(super) struct Columns {
    /// How many columns the recording has.
    pub count: usize,
    /// By joint.
    pub positions: Vec<Option<usize>>,
    pub torques: Vec<Option<usize>>,
    pub time: Option<usize>,
    /// Those that the session names; else `<joint>.velocity` beside `<joint>.position`.
    pub velocities: Vec<Option<usize>>,
    pub temperature: Vec<Option<usize>>,
    pub direction: Vec<Option<usize>>,
    pub further: Vec<Option<usize>>,
}

impl Columns {
    /// Looks for them.
    pub fn find(mapping: &PoseMapping, columns: &[String]) -> Columns {
        let place = |name: &str| columns.iter().position(|column| column == name);
        let velocity = |joint: usize| match &mapping.conditions.velocity {
            MotionSource::Columns(mapped) => place(&mapped.get(joint)?.column),
            MotionSource::Unknown | MotionSource::Slope(_) => {
                place(&format!("{}.velocity", mapping.positions[joint].column.strip_suffix(".position")?))
            }
        };
        let joints = mapping.positions.len();
        Columns {
            count: columns.len(),
            positions: mapping.positions.iter().map(|mapped| place(&mapped.column)).collect(),
            torques: mapping.torques.iter().map(|mapped| place(&mapped.as_ref()?.0.column)).collect(),
            velocities: (0..joints).map(velocity).collect(),
            time: place(&mapping.conditions.clock().column),
            temperature: mapping.conditions.temperature.iter().map(|mapped| place(&mapped.column)).collect(),
            direction: mapping.conditions.direction.iter().map(|column| place(column)).collect(),
            further: mapping.conditions.further.iter().map(|mapped| place(&mapped.column)).collect(),
        }
    }

    /// The first column that the session names and the recording does not have.
    pub fn missing<'m>(&self, mapping: &'m PoseMapping) -> Option<&'m str> {
        let positions = mapping.positions.iter().map(|mapped| mapped.column.as_str()).zip(&self.positions);
        let torques = mapping.torques.iter().zip(&self.torques);
        let torques = torques.filter_map(|(mapped, place)| Some((mapped.as_ref()?.0.column.as_str(), place)));
        let temperature =
            mapping.conditions.temperature.iter().map(|mapped| mapped.column.as_str()).zip(&self.temperature);
        let direction = mapping.conditions.direction.iter().map(String::as_str).zip(&self.direction);
        let velocities = match &mapping.conditions.velocity {
            MotionSource::Columns(mapped) => mapped.as_slice(),
            MotionSource::Unknown | MotionSource::Slope(_) => &[],
        };
        let velocities = velocities.iter().map(|mapped| mapped.column.as_str()).zip(&self.velocities);
        // What may be empty is for residuals, and no recording needs it to be corrected.
        let further = mapping.conditions.further.iter().zip(&self.further);
        let further = further.filter(|(mapped, _)| !mapped.may_be_empty);
        let further = further.map(|(mapped, place)| (mapped.column.as_str(), place));
        let mut all = positions.chain(torques).chain(temperature).chain(direction).chain(velocities).chain(further);
        all.find(|(_, place)| place.is_none()).map(|(name, _)| name)
    }
}

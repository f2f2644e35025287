//! What disturbs the readings of a simulated experiment.

/// What disturbs the readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Disturbance {
    /// Standard deviation of the averaged torque reading of each joint, unit of the reading.
    pub torque_std: Vec<f64>,
    /// Standard deviation of the averaged position reading of each joint, unit of the reading (rad for an angle).
    pub position_std: Vec<f64>,
    /// Standard deviation of the averaged reading of each axis of the instruments, unit of the reading.
    pub instrument_std: Vec<f64>,
    /// Converter of the torque readings, if they pass through one.
    pub converter: Option<Converter>,
    /// Torque readings that are far off, if there are some.
    pub outliers: Option<Outliers>,
    /// Deflection of stationary joints.
    pub deflection: Deflection,
}

/// Torque readings that are far off: each with the same probability, by a normal error of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outliers {
    /// Probability of one, 0 to 1.
    pub share: f64,
    /// Standard deviation of its error, unit of the reading.
    pub std: f64,
}

impl Disturbance {
    /// Nothing but noise of the torque readings, by joint.
    pub fn noise(torque_std: Vec<f64>) -> Disturbance {
        let none = vec![0.0; torque_std.len()];
        let deflection = Deflection { hold_std: 0.0, pose_std: 0.0, compliance: none.clone(), seen: false };
        Disturbance {
            torque_std,
            instrument_std: Vec::new(),
            position_std: none,
            converter: None,
            outliers: None,
            deflection,
        }
    }
}

/// An analogue-to-digital converter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Converter {
    /// Number of bits.
    pub bits: u32,
    /// Reading at the lowest and, one step above, the highest code; unit of the reading.
    pub range: [f64; 2],
}

impl Converter {
    /// Width of one step, unit of the reading.
    pub fn step(&self) -> f64 {
        (self.range[1] - self.range[0]) / 2f64.powi(self.bits as i32)
    }

    /// The lowest and the highest reading it can give.
    pub fn ends(&self) -> [f64; 2] {
        [self.range[0], self.convert(self.range[1])]
    }

    /// The reading it gives: the nearest step within its range.
    pub fn convert(&self, value: f64) -> f64 {
        let code = ((value - self.range[0]) / self.step()).round();
        self.range[0] + self.step() * code.clamp(0.0, 2f64.powi(self.bits as i32) - 1.0)
    }
}

/// Deflection of joints that stand still: true coordinate less what the calibrated position sensor says.
#[derive(Clone, Debug, PartialEq)]
pub struct Deflection {
    /// Standard deviation of one draw for each joint and hold, rad: a hold is a sweep, or one random pose.
    pub hold_std: f64,
    /// Standard deviation of a further draw for each joint and pose, rad.
    pub pose_std: f64,
    /// `δ = c τ` of each joint, rad/(N·m).
    pub compliance: Vec<f64>,
    /// Whether the position sensors see it: their readings then say where the joints are, not where they were sent.
    pub seen: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn converter_rounds_and_saturates() {
        let converter = Converter { bits: 12, range: [0.0, 4096.0] };
        assert_eq!(converter.step(), 1.0);
        assert_eq!([2047.6, -5.0, 5000.0].map(|v| converter.convert(v)), [2048.0, 0.0, 4095.0]);
        let volts = Converter { bits: 12, range: [-10.0, 10.0] };
        assert!((volts.convert(0.001) - 0.0).abs() < 1e-12 && volts.convert(11.0) < 10.0);
    }
}

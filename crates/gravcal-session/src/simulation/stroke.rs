//! A slow stroke of one joint: it speeds up evenly, moves at one speed, and slows down evenly.

/// One way of a slow sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stroke {
    /// Its way, of either sign, rad.
    way: f64,
    /// Its speed between both ramps, rad/s.
    speed: f64,
    /// How long each ramp takes, s.
    ramp: f64,
}

impl Stroke {
    /// Over a way (rad, of either sign) at a speed (rad/s), which a short way never reaches.
    pub fn new(way: f64, speed: f64, ramp: f64) -> Stroke {
        Stroke { way, speed: speed.min(way.abs() / ramp), ramp }
    }

    /// How long it takes, s.
    pub fn duration(&self) -> f64 {
        if self.way == 0.0 { 0.0 } else { self.way.abs() / self.speed + self.ramp }
    }

    /// How far it is at a time since its beginning, s, with its velocity and acceleration: rad, rad/s, rad/s².
    pub fn at(&self, time: f64) -> [f64; 3] {
        let (sign, left) = (self.way.signum(), self.duration() - time);
        let acceleration = self.speed / self.ramp;
        let [far, speed, acceleration] = if time < self.ramp {
            [0.5 * acceleration * time * time, acceleration * time, acceleration]
        } else if left < self.ramp {
            [self.way.abs() - 0.5 * acceleration * left * left, acceleration * left, -acceleration]
        } else {
            [self.speed * (time - 0.5 * self.ramp), self.speed, 0.0]
        };
        [sign * far, sign * speed, sign * acceleration]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_arrives_and_its_rates_are_the_slopes_of_its_way() {
        for (way, speed) in [(1.5, 0.07), (-0.02, 0.07)] {
            let stroke = Stroke::new(way, speed, 0.5);
            let duration = stroke.duration();
            assert!((stroke.at(duration)[0] - way).abs() < 1e-12 && stroke.at(duration)[1].abs() < 1e-12);
            let step = 1e-5;
            for share in [0.003, 0.3, 0.45, 0.9, 0.999] {
                let [before, here, after] = [-step, 0.0, step].map(|by| stroke.at(share * duration + by));
                assert!((here[1] - (after[0] - before[0]) / (2.0 * step)).abs() < 1e-8, "{way} {share}");
                assert!((here[2] - (after[1] - before[1]) / (2.0 * step)).abs() < 1e-8, "{way} {share}");
                assert!(here[1].abs() <= speed * (1.0 + 1e-12));
            }
        }
    }
}

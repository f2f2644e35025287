//! Readings that are explained so much worse than their stated noise that they contradict the model.

use gravcal_robot_model::session::Session;

use crate::joint::error::EstimateError;
use crate::joint::mistakes::hypothesis::Mistake;
use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::findings::instruments::of_instruments;
use crate::judgement::explained;

/// Readings explained this many times worse than their stated noise contradict the model: no number can be relied on.
const CONTRADICTION: f64 = 3.0;
/// And where that is less probable than this: a single degree of freedom exceeds its noise three times in one session of four hundred.
const BEYOND_CHANCE: f64 = 1e-6;
/// So many channels are named.
const WORST: usize = 3;

impl Answer {
    /// How many times worse than their stated noise the readings are explained, where that is far beyond any chance.
    pub(in crate::joint::reporting) fn contradiction(&self, session: &Session) -> Result<Option<f64>, EstimateError> {
        let Some(misfit) = self.misfit.filter(|misfit| *misfit > CONTRADICTION) else { return Ok(None) };
        let p_value = explained(session, &self.solved, self.solved.least_chi_squared())?.p_value;
        Ok(p_value.is_some_and(|p| p < BEYOND_CHANCE).then_some(misfit))
    }

    /// The same as a finding.
    pub(in crate::joint::reporting) fn contradicted_noise(
        &self,
        session: &Session,
    ) -> Result<Option<Mistake>, EstimateError> {
        let Some(misfit) = self.contradiction(session)? else { return Ok(None) };
        Ok(Some(Mistake {
            what: format!("the model contradicts the readings: residuals {misfit:.0} times the stated noise"),
            advice: format!(
                "{}What to look at: the sign of a torque sensor (torque_sign = \"reversed\"), units, swapped \
                     columns, the hemisphere of gravity, the loads' masses and distances, values given as fixed, \
                     poses that are not static, single bad rows. If the model is known to be this rough, {}.{}",
                self.beyond_their_noise(session)?,
                allow_for_more(session),
                of_instruments(session)
            ),
        }))
    }

    /// Where residuals exceed their stated noise most, in a sentence.
    fn beyond_their_noise(&self, session: &Session) -> Result<String, EstimateError> {
        let mut of_channel = vec![(0.0, 0.0); session.channel_count()];
        for (channel, row) in self.solved.stated_residuals(session)? {
            of_channel[channel].0 += row.whitened * row.whitened;
            of_channel[channel].1 += (1.0 - row.leverage).max(0.0);
        }
        let times = of_channel.iter().map(|(squares, freedom): &(f64, f64)| (squares / freedom.max(1.0)).sqrt());
        let mut worst: Vec<(usize, f64)> = times.enumerate().collect();
        worst.sort_by(|a, b| b.1.total_cmp(&a.1));
        let named = worst.into_iter().take(WORST).filter(|(_, times)| *times > CONTRADICTION);
        let named = named.map(|(channel, times)| format!("{} ({times:.0} times)", session.channel_name(channel)));
        let named: Vec<String> = named.collect();
        Ok(if named.is_empty() {
            String::new()
        } else {
            format!("Residuals exceed their stated noise most at {}. ", named.join(", "))
        })
    }
}

/// How a session lets readings err by more than it says. The noise of standstills and sweeps is read from their recordings, where nothing is stated.
fn allow_for_more(session: &Session) -> &'static str {
    match session.searched.iter().any(|searched| searched.standstills.is_some() || searched.sweeps.is_some()) {
        true => {
            "say unexplained_std = \"estimated\" in [readings.torque]: what readings err by beyond their noise is then estimated from the residuals"
        }
        false => "leave std away: the noise is then estimated from the residuals",
    }
}

#[cfg(test)]
mod tests {
    use crate::joint::reporting::findings::testing::answer;
    use crate::testing::sarcos_shoulder;

    /// Three times the noise, and beyond chance: of few degrees of freedom the first is not enough.
    #[test]
    fn readings_contradict_the_model_three_times_beyond_noise_and_beyond_chance() {
        let session = sarcos_shoulder().session(0);
        let mut answer = answer(&session);
        let freedom = (answer.solved.judged_problem().rows() - answer.solved.analysis.rank()) as f64;
        let mut contradicts = |misfit: f64, chi_squared: f64| {
            answer.misfit = Some(misfit);
            (answer.solved.estimate.cost, answer.solved.growth_at_rest) = (0.5 * chi_squared, 0.0);
            answer.contradicted_noise(&session).unwrap().map(|mistake| mistake.what)
        };
        // So much has a probability of 1e-7, of 1e-5.
        let [beyond_chance, by_chance] = [5.2, 4.3].map(|z| freedom + z * (2.0 * freedom).sqrt() + 0.67 * z * z);
        assert!(contradicts(3.01, beyond_chance).unwrap().ends_with("residuals 3 times the stated noise"));
        assert_eq!([contradicts(2.99, beyond_chance), contradicts(3.01, by_chance)], [None, None]);
        answer.misfit = None;
        assert!(answer.contradiction(&session).unwrap().is_none());
    }
}

//! What the readings say at values near the estimate that may be the true ones.

use gravcal_estimation::{Reference, Spectrum, Values};

use super::EstimateError;
use super::reference::WITHIN_USE;
use super::solve::Solved;
use crate::judgement::{AT_LEAST, Judged, Judgement, MATTERS, least_informed_nearby, limits_of_use};
use crate::parameter::ParameterId;
use crate::session::Session;
use crate::workbench::Workbench;

/// Values that may be the true ones, and what the readings say there.
#[derive(Debug)]
pub(super) struct Nearby {
    pub values: Values,
    pub spectrum: Spectrum,
    /// Share of standard deviations there that is told at least.
    pub share: f64,
    /// Columns of which they say so little there that what they say at the estimate has no basis.
    pub open: Vec<usize>,
}

/// Values at which ½ χ² is larger by less are as good as the estimate: two standard deviations away.
const AS_LIKELY: f64 = 2.0;
/// Times by which a standard deviation is too small that has no basis.
const BASELESS: f64 = 10.0;
/// Iterations at most to where open parameters are at their nominal values.
const ITERATIONS: usize = 100;

impl Solved {
    /// The same with what of it rests on the estimate's own errors found out.
    ///
    /// # Errors
    /// Where the problem cannot be evaluated nearby.
    pub(super) fn with_nearby(self, session: &Session, workbench: &Workbench<'_>) -> Result<Solved, EstimateError> {
        let (problem, values) = (self.judged_problem(), &self.estimate.values);
        let Some(reference) = self.posed.problem.reference() else { return Ok(self) };
        let solution = Judged { problem, values, layout: &self.posed.layout, spectrum: &self.spectrum };
        let asked = limits_of_use(session, &solution, &self.readings.spreads);
        let known = self.spectrum.covariance();
        if asked.iter().all(|(column, limit)| known.std(*column) < MATTERS * limit) {
            return Ok(self); // no direction makes up more of a standard deviation than there is
        }
        let judgement = self.judge(session);
        let plausible = reference.times_as_firm(WITHIN_USE);
        let columns = |id: &ParameterId| problem.columns_of(self.posed.layout.block(*id));
        let determined: Vec<usize> =
            session.parameters().iter().filter(|id| judgement.determines(**id)).flat_map(columns).collect();
        let farther = least_informed_nearby((problem, values), &asked, &determined, &plausible)?;
        let farther = farther.into_iter().map(|values| (values, AT_LEAST));
        let nominal = self.nearest_to_nominal(session, &judgement, &plausible, workbench)?.map(|values| (values, 1.0));
        let mut factors = vec![1.0_f64; problem.columns().len()];
        let mut nearby = Vec::new();
        for (values, share) in farther.chain(nominal) {
            let spectrum = Spectrum::new(problem, &values)?;
            let (there, mut open) = (spectrum.covariance(), Vec::new());
            for (column, limit) in &asked {
                let (std, known) = (there.std(*column), known.std(*column).max(f64::MIN_POSITIVE));
                if std > (BASELESS * known).max(MATTERS * limit) {
                    open.push(*column);
                }
                // What is beyond its limit there is not determined.
                factors[*column] = factors[*column].max((share * std).min(*limit) / known);
            }
            nearby.push(Nearby { values, spectrum, share, open });
        }
        let uncertainty = self.uncertainty.widened(&factors);
        Ok(Solved { nearby, uncertainty, ..self })
    }

    /// Where parameters that are not determined have values nearer to their nominal ones, and the readings are explained as well: what is
    /// told must not depend on where the readings happened to leave these.
    fn nearest_to_nominal(
        &self,
        session: &Session,
        judgement: &Judgement,
        plausible: &Reference,
        workbench: &Workbench<'_>,
    ) -> Result<Option<Values>, EstimateError> {
        let (problem, layout) = (self.judged_problem(), &self.posed.layout);
        let mut center = self.estimate.values.clone();
        for id in session.parameters().into_iter().filter(|id| !judgement.determines(*id)) {
            center.set(layout.block(id), &[session.nominal(id)]);
        }
        let drawn = problem.with_reference(plausible.centered_at(&center));
        // What cannot be solved there says nothing.
        let Ok(there) = workbench.within(ITERATIONS).solve(&drawn, &self.estimate.values) else { return Ok(None) };
        let alone = problem.without_reference();
        let growth = alone.cost(&there.values)? - alone.cost(&self.estimate.values)?;
        Ok((growth < AS_LIKELY).then_some(there.values))
    }
}

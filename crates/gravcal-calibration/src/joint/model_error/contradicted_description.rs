//! What is stated of the robot, its links' masses, its lengths and its axes, where the readings contradict it.
//!
//! Of all that is stated of one kind, `N(m, S)` with a diagonal `S`, and what is found with the readings, `v` with the covariance `C`,
//!
//! ```text
//!     e = S^{-1/2} (v − m),   cov e = M = I − S^{-1/2} C S^{-1/2},   T = eᵀ M⁺ e  ~  χ²(rank M)
//! ```
//!
//! if the robot is as well known as is stated. Each number by itself may be near enough while together they are not; most of `M` is zero where the
//! readings say nothing. Where readings are explained worse than by their noise, `T` counts by as much less.

use gravcal_estimation::{BlockId, Covariance};
use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::{InertiaPrior, Session};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::joint::building::inertia_priors::{LinkPrior, inertia_priors};
use crate::joint::solved::Solved;
use crate::joint::variables::JointDisplacements;

/// Probability below which something is contradicted: one right session in a thousand.
const CONTRADICTED: f64 = 1e-3;
/// A combination of which the readings say less than this share is what was stated.
const SAID_BY_READINGS: f64 = 0.01;
/// By how much more than the readings ask for a larger standard deviation is proposed: more than two digits round away.
const ROOM: f64 = 1.2;

/// One number that is stated: of which link, `e`, and what it is in the problem's columns, in standard deviations.
struct Stated {
    link: usize,
    off: f64,
    function: Vec<(usize, f64)>,
}

/// What readings say of several stated numbers: `T` and the rank of `M`.
struct Strain {
    statistic: f64,
    freedom: f64,
}

impl Strain {
    /// How many times as far off as stated.
    fn times(&self) -> f64 {
        (self.statistic / self.freedom).sqrt()
    }
}

impl Solved {
    /// In a sentence each, with what would explain it; nothing where the readings agree.
    pub(in crate::joint) fn contradicted_description(&self, session: &Session) -> Vec<String> {
        let contradicted =
            [self.contradicted_inertia(session), self.contradicted_lengths(session), self.contradicted_axes(session)];
        contradicted.into_iter().flatten().collect()
    }

    fn contradicted_inertia(&self, session: &Session) -> Option<String> {
        let of_prior = |LinkPrior { link, block, expected, std }| self.stated(link, block, &expected, &std);
        let stated: Vec<Stated> =
            inertia_priors(session, &self.built.variables).into_iter().flat_map(of_prior).collect();
        let (strain, most) = self.contradicted(&stated)?;
        Some(format!(
            "The readings contradict what the robot's description says of the links' masses, centres and inertia: it is {} times as far off as stated, most of \
             all for {} (χ² {} of {} numbers). Numbers that rest on it are wrong by more than their intervals. Check whether the description is that of \
             the arm as it stood: was a tool mounted that it lacks, or not mounted that it has? Or say less of it: [inertia] relative_std{}, or \
             links = \"unknown\" with a load of known mass.",
            significant(strain.times(), 2),
            session.robot.chain.links()[most].name,
            significant(strain.statistic, 3),
            strain.freedom,
            less_well_known(session, strain.times()),
        ))
    }

    fn contradicted_lengths(&self, session: &Session) -> Option<String> {
        let lengths = self.built.variables.lengths.as_ref()?;
        let (strain, most) = self.contradicted(&self.stated_of_joints(lengths))?;
        Some(format!(
            "The readings contradict what the session says of the robot's lengths: joints are {} times as far from where the description has them as stated, \
             most of all {} (χ² {} of {} numbers). Check the description, and where loads are; or say [inertia] length_std_m = {}.",
            significant(strain.times(), 2),
            session.robot.chain.movers()[most].name,
            significant(strain.statistic, 3),
            strain.freedom,
            significant(ROOM * strain.times() * lengths.std, 2),
        ))
    }

    fn contradicted_axes(&self, session: &Session) -> Option<String> {
        let axes = self.built.variables.axes.as_ref()?;
        let (strain, most) = self.contradicted(&self.stated_of_joints(axes))?;
        Some(format!(
            "The readings contradict what the session says of the robot's axes: they are tilted {} times as far against the description as stated, most of all \
             {} (χ² {} of {} numbers). Check the description, and where loads are; or say [inertia] axis_std_deg = {}.",
            significant(strain.times(), 2),
            session.robot.chain.movers()[most].name,
            significant(strain.statistic, 3),
            strain.freedom,
            significant(ROOM * strain.times() * axes.std.to_degrees(), 2),
        ))
    }

    fn stated_of_joints(&self, unknown: &JointDisplacements) -> Vec<Stated> {
        let numbers = unknown.numbers();
        let mut stated = self.stated(0, unknown.block, &vec![0.0; numbers], &vec![unknown.std; numbers]);
        stated.iter_mut().enumerate().for_each(|(number, stated)| (stated.link, _) = unknown.link_of(number));
        stated
    }

    /// What is stated of a link in one block.
    fn stated(&self, link: usize, block: BlockId, expected: &[f64], std: &[f64]) -> Vec<Stated> {
        let found = self.estimate.values.get(block).iter();
        let numbers = self.judged_problem().columns_of(block).zip(found.zip(expected).zip(std));
        let stated = |(column, ((found, expected), std)): (usize, ((&f64, &f64), &f64))| Stated {
            link,
            off: (found - expected) / std,
            function: vec![(column, 1.0 / std)],
        };
        numbers.map(stated).collect()
    }

    /// How far it is off, and the link that is farthest off; nothing where that may be chance.
    fn contradicted(&self, stated: &[Stated]) -> Option<(Strain, usize)> {
        let (covariance, misfit) = (self.analysis.covariance(), self.misfit_of_noise());
        let all = strain(&stated.iter().collect::<Vec<_>>(), &covariance, misfit)?;
        if ChiSquared::new(all.freedom).ok()?.sf(all.statistic) >= CONTRADICTED {
            return None;
        }
        let of_link = |link: usize| {
            let own: Vec<&Stated> = stated.iter().filter(|stated| stated.link == link).collect();
            Some((link, strain(&own, &covariance, misfit)?.times()))
        };
        let mut links: Vec<usize> = stated.iter().map(|stated| stated.link).collect();
        links.dedup();
        let (most, _) = links.into_iter().filter_map(of_link).max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((all, most))
    }

    /// By how many times more than noise says readings are off, squared; at least 1.
    fn misfit_of_noise(&self) -> f64 {
        let freedom = self.judged_problem().rows().saturating_sub(self.analysis.rank()).max(1);
        (self.least_chi_squared() / freedom as f64).max(1.0)
    }
}

/// Nothing where the readings say nothing of them.
fn strain(stated: &[&Stated], covariance: &Covariance, misfit: f64) -> Option<Strain> {
    let functions: Vec<Vec<(usize, f64)>> = stated.iter().map(|stated| stated.function.clone()).collect();
    let found = DMatrix::from_row_slice(stated.len(), stated.len(), &covariance.of(&functions));
    of_errors(DVector::from_iterator(stated.len(), stated.iter().map(|stated| stated.off)), found, misfit)
}

/// `e`, and `S^{-1/2} C S^{-1/2}`.
fn of_errors(off: DVector<f64>, found: DMatrix<f64>, misfit: f64) -> Option<Strain> {
    // An empty matrix has no eigenvectors.
    if off.is_empty() {
        return None;
    }
    let told = (DMatrix::identity(off.len(), off.len()) - found).symmetric_eigen();
    let off = told.eigenvectors.transpose() * off;
    let said = |(value, off): (&f64, &f64)| (*value > SAID_BY_READINGS).then_some(off * off / value);
    let said: Vec<f64> = told.eigenvalues.iter().zip(off.iter()).filter_map(said).collect();
    let statistic = said.iter().sum::<f64>() / misfit;
    (!said.is_empty() && statistic.is_finite()).then_some(Strain { statistic, freedom: said.len() as f64 })
}

/// What to state of masses instead, where the same is stated of all links.
fn less_well_known(session: &Session, times: f64) -> String {
    let InertiaPrior::Model { relative_std } = &session.inertia else { return String::new() };
    // Where links are known to different shares, or exactly, each has its own.
    match relative_std.first() {
        Some(Some(first)) if relative_std.iter().all(|other| *other == Some(*first)) => {
            format!(" = {}", significant(ROOM * times * first, 2))
        }
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use gravcal_dynamics::{Chain, Link, LinkInertia};

    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// Of a shoulder whose links' masses are said to be known so well, and of which one is so many times what is said.
    fn contradicted(times: f64, relative_std: Option<f64>) -> Vec<String> {
        let simulation = sarcos_shoulder();
        let mut session = simulation.session(0);
        let chain = &session.robot.chain;
        let links = chain.links().iter().zip(&simulation.truth.inertia).enumerate();
        let stated = |(place, (link, [mass, x, y, z])): (usize, (&Link, &[f64; 4]))| {
            // Only moments are determined of most masses.
            let times = if place == 2 { times } else { 1.0 };
            let first_moment = [x, y, z].map(|moment| moment / times);
            Link { inertia: Some(LinkInertia { mass: mass / times, first_moment }), ..link.clone() }
        };
        let links = links.map(stated).collect();
        session.robot.chain = Chain::new(chain.base(), chain.joints().to_vec(), links).unwrap();
        session.inertia = InertiaPrior::Model { relative_std: vec![relative_std; 3] };
        let readings = select(&session, Signals::All);
        let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
        solved.contradicted_description(&session)
    }

    #[test]
    fn masses_that_the_readings_contradict_are_told_with_the_link() {
        assert_eq!(contradicted(1.0, Some(0.02)), Vec::<String>::new());
        let told = contradicted(1.5, Some(0.02));
        let link = sarcos_shoulder().template.robot.chain.links()[2].name.clone();
        assert!(told.len() == 1 && told[0].contains(&format!("most of all for {link} ")), "{told:?}");
        let proposed = told[0].split("relative_std = ").nth(1).and_then(|rest| rest.split(',').next()).unwrap();
        let proposed: f64 = proposed.parse().unwrap();
        assert!(contradicted(1.5, Some(proposed)).is_empty() && proposed > 0.02, "{proposed}");
    }

    /// One number is proposed where one is stated of all links.
    #[test]
    fn exact_links_stay_exact() {
        let mut session = sarcos_shoulder().session(0);
        let mut proposed = |relative_std: [Option<f64>; 3]| {
            session.inertia = InertiaPrior::Model { relative_std: relative_std.into() };
            less_well_known(&session, 2.0)
        };
        assert_eq!(proposed([Some(0.1); 3]), " = 0.24");
        assert_eq!(proposed([None, Some(0.1), Some(0.1)]), "");
        assert_eq!(proposed([Some(0.1), Some(0.2), Some(0.1)]), "");
    }

    /// Of three numbers one is not read.
    #[test]
    fn only_what_readings_say_counts() {
        let strain = |diagonal: &[f64], misfit: f64| {
            let off = DVector::from_element(diagonal.len(), 2.0);
            of_errors(off, DMatrix::from_diagonal(&DVector::from_column_slice(diagonal)), misfit)
        };
        let told = strain(&[0.0, 0.5, 1.0], 2.0).unwrap();
        // 4/1 + 4/0.5, halved.
        assert!((told.statistic - 6.0).abs() < 1e-9 && told.freedom == 2.0, "{} {}", told.statistic, told.freedom);
        assert!(strain(&[1.0; 3], 1.0).is_none() && strain(&[], 1.0).is_none());
    }
}

//! Loads that another link carries than the one that is stated.

use gravcal_robot_model::session::{Load, Session};

use super::hypothesis::{Hypothesis, Rival};

/// All loads of a link, as another link would carry them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OtherLink {
    /// The link that is stated.
    stated: usize,
    /// The other one.
    carries: usize,
}

impl OtherLink {
    /// Each link that loads are said to be on, with each other link.
    pub fn all(session: &Session) -> Vec<OtherLink> {
        let links = session.robot.chain.link_count();
        let mut stated: Vec<usize> =
            session.loads.iter().filter(|load| !load.is_unknown()).map(|load| load.link).collect();
        stated.sort_unstable();
        stated.dedup();
        let others = |stated: usize| {
            (0..links).filter(move |link| *link != stated).map(move |carries| OtherLink { stated, carries })
        };
        stated.into_iter().flat_map(others).collect()
    }

    /// The session with these loads anywhere on the link that is stated.
    fn anywhere(self, session: &Session) -> Session {
        let mut anywhere = session.clone();
        self.loads(&mut anywhere).for_each(|load| (load.position, load.position_std) = (None, None));
        anywhere
    }

    fn loads(self, session: &mut Session) -> impl Iterator<Item = &mut Load> {
        session.loads.iter_mut().filter(move |load| self.concerns(load))
    }

    fn concerns(self, load: &Load) -> bool {
        load.link == self.stated && !load.is_unknown()
    }
}

impl Hypothesis for OtherLink {
    /// What is stated of a load's place is of the link that is stated, and nothing of the other one.
    fn made(&self, session: &Session) -> Session {
        let mut made = self.anywhere(session);
        self.loads(&mut made).for_each(|load| load.link = self.carries);
        made
    }

    fn words(&self, session: &Session) -> (String, String) {
        let link = |link: usize| session.robot.chain.links()[link].name.as_str();
        let names = session.loads.iter().filter(|load| self.concerns(load));
        let names: Vec<&str> = names.map(|load| load.name.as_str()).collect();
        let (loads, whose) = match names.as_slice() {
            [only] => (format!("load {only}"), "its"),
            several => (format!("loads {}", several.join(", ")), "their"),
        };
        let (stated, carries) = (link(self.stated), link(self.carries));
        (
            format!("{loads} on another link than {stated}, which is stated: {carries}"),
            format!("Say link = \"{carries}\" in {whose} [[load]]; position_m is meant in the frame of that link."),
        )
    }
    /// Wrong places would explain the readings as well.
    fn rival(&self, session: &Session) -> Rival {
        Rival::AlsoWith(Box::new(self.anywhere(session)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::sarcos_shoulder;

    #[test]
    fn weighed_loads_of_a_link_go_to_each_other_link_and_their_places_are_not_known_there() {
        let mut session = sarcos_shoulder().session(0);
        session.loads.push(session.loads[0].clone());
        assert_eq!(session.loads.len(), 3);
        for load in &mut session.loads {
            (load.position, load.position_std) = (Some([0.1, 0.0, 0.2]), Some(1e-3));
        }
        session.loads[2].mass = f64::NAN;
        let said = |session: &Session| -> Vec<(usize, Option<[f64; 3]>)> {
            session.loads.iter().map(|load| (load.link, load.position)).collect()
        };
        let payload = (2, Some([0.1, 0.0, 0.2]));
        let made = OtherLink::all(&session).into_iter().map(|other| said(&other.made(&session)));
        assert_eq!(made.collect::<Vec<_>>(), [0, 1].map(|link| vec![(link, None), (link, None), payload]));
        let other = OtherLink::all(&session)[1];
        assert_eq!(said(&other.anywhere(&session)), [(2, None), (2, None), payload]);
        let (what, cure) = other.words(&session);
        let [stated, carries] = [2, 1].map(|link| session.robot.chain.links()[link].name.clone());
        assert!(what.ends_with(&format!("on another link than {stated}, which is stated: {carries}")), "{what}");
        assert!(cure.starts_with(&format!("Say link = \"{carries}\" in their [[load]]")), "{cure}");
    }
}

//! Loads that another link carries than the one that is stated.

use gravcal_robot_model::session::{Load, Session};

/// All loads of a link, as another link would carry them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::joint) struct OtherLink {
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

    /// The session as it would be right: what is stated of a load's place is of the other link, and nothing.
    pub fn made(self, session: &Session) -> Session {
        let mut made = self.anywhere(session);
        self.loads(&mut made).for_each(|load| load.link = self.carries);
        made
    }

    /// The session with these loads anywhere on the link that is stated, which wrong places would explain as well.
    pub fn anywhere(self, session: &Session) -> Session {
        let mut anywhere = session.clone();
        self.loads(&mut anywhere).for_each(|load| (load.position, load.position_std) = (None, None));
        anywhere
    }

    fn loads(self, session: &mut Session) -> impl Iterator<Item = &mut Load> {
        session.loads.iter_mut().filter(move |load| load.link == self.stated && !load.is_unknown())
    }

    /// What it is, and what to do about it.
    pub fn report(self, session: &Session) -> (String, String) {
        let link = |link: usize| session.robot.chain.links()[link].name.as_str();
        let names = session.loads.iter().filter(|load| load.link == self.stated && !load.is_unknown());
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
}
